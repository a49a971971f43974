/* Uncollided light: lights that can be met from one direction, or one point, on fields of their own, and all others
 * together, one beam or lamp after the other, because each has its own direction. */
#include "base/context.h"
#include "method/dom/job.h"

#include <string.h>

/* ---- fields ---- */

typedef struct direct_job {
    ty_dom_job* job;
    float* extinction[TY_SINGLE_FLUENCES][3]; /* of fine cells, for each fluence of a light */
    ty_dom_scratch scratch;
    ty_light_field* one; /* of one source that has no field of its own */
    float* coarse[3];    /* its means on the cells of ordinates, as many as it has planes */
    ty_dom_beams beams;
    ty_beam_room room[3];
    ty_source_group* groups;
    int32_t group_count;
} direct_job;

/* room: NULL: none is kept. */
static ty_result light_field(direct_job* direct, int32_t fluence, const ty_source* sources, int32_t count,
                             ty_light_field* field, ty_beam_room* room) {
    ty_dom_job* job = direct->job;
    return ty_uncollided_add_next(job->scene, job->fine, direct->extinction[fluence], sources, count, field, room,
                                  ty_part_report, &job->progress);
}

/* Fluences beside the one that counts as uncollided. */
static void describe_lobes(const ty_dom* light, ty_light_field* const fields[TY_SINGLE_FLUENCES],
                           ty_single_light* single) {
    if (!light->lobes) return;
    single->lobes = light->bands;
    for (int c = 0; c < 3; ++c) {
        single->straight[c] = fields[TY_SINGLE_STRAIGHT]->fluence[c];
        single->bent[c] = fields[TY_SINGLE_BENT]->fluence[c];
    }
}

/* A light's fluences on the cells of ordinates. */
static ty_result average_own(direct_job* direct, const ty_source_group* group, ty_light_field* const* fields,
                             ty_light_field** out) {
    const ty_dom_job* job = direct->job;
    for (int32_t f = 0; f < TY_SINGLE_FLUENCES; ++f) {
        if (ty_source_groups_field(job->sources, group, 1, true, job->coarse, false, &out[f]) != TY_OK)
            return TY_ERROR_MEMORY;
        for (int32_t p = 0; p < fields[f]->planes; ++p)
            ty_grid_average(job->context, fields[f]->fluence[p], job->fine->box.size, job->coarse->box.size,
                            out[f]->fluence[p]);
    }
    return TY_OK;
}

static ty_result light_own(direct_job* direct, const ty_source_group* group) {
    ty_dom_job* job = direct->job;
    ty_dom* light = job->light;
    ty_light_field** fields = light->fields[light->light_count];
    ty_single_light* single = &light->lights[light->light_count];
    ty_result result = TY_OK;
    for (int32_t f = 0; f < (light->lobes ? TY_SINGLE_FLUENCES : 1) && result == TY_OK; ++f) {
        result = ty_source_groups_field(job->sources, group, 1, true, job->fine, false, &fields[f]);
        if (result == TY_OK)
            result = light_field(direct, f, &job->sources[group->first], group->count, fields[f], NULL);
    }
    if (result == TY_OK && light->lobes) result = average_own(direct, group, fields, light->coarse[light->light_count]);
    if (result != TY_OK) return result;
    *single = ty_source_group_light(job->sources, group, fields[TY_SINGLE_KEPT]);
    describe_lobes(light, fields, single);
    ++light->light_count;
    const double begun = ty_wall_seconds();
    ty_dom_add_source(job, fields[TY_SINGLE_KEPT], single, &job->sources[group->first], 1, &direct->scratch);
    job->stats.source_seconds += ty_wall_seconds() - begun;
    return TY_OK;
}

enum { CHUNK = 1 << 15 };

typedef struct sum_job {
    const ty_light_field* one;
    ty_light_field* all;
} sum_job;

static void sum_chunk(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const sum_job* sum = user;
    const size_t begin = (size_t)index * CHUNK, cells = sum->all->cells;
    const size_t end = cells - begin < CHUNK ? cells : begin + CHUNK;
    const float *from = sum->one->color, *to = sum->all->color;
    for (int32_t p = 0; p < sum->all->planes; ++p) {
        const float* one = sum->one->fluence[sum->one->planes == 3 ? p : 0];
        float* all = sum->all->fluence[p];
        const float factor = sum->one->planes == 3   ? 1
                             : sum->all->planes == 3 ? from[p]
                                                     : (from[0] + from[1] + from[2]) / (to[0] + to[1] + to[2]);
        for (size_t i = begin; i < end; ++i) all[i] += factor * one[i];
    }
}

static void clear_field(ty_light_field* field) {
    for (int32_t p = 0; p < field->planes; ++p) memset(field->fluence[p], 0, field->cells * sizeof(float));
}

/* What one source of many brings to ordinates, and to the parts that are seen. */
static void spread_one(direct_job* direct, const ty_source* source) {
    ty_dom_job* job = direct->job;
    const ty_light_field* one = direct->one;
    const ty_source_group group = {.first = 0, .count = 1, .middle = source->position};
    if (source->kind == TY_SOURCE_BEAM && ty_dom_beams_can(&direct->scratch, one)) {
        ty_dom_beams_take(job, &direct->beams, source, one, &direct->scratch, direct->coarse);
    } else {
        const ty_single_light single = ty_source_group_light(source, &group, one);
        ty_dom_add_source(job, one, &single, source, source->cosine, &direct->scratch);
        for (int32_t p = 0; p < one->planes && direct->coarse[p] != NULL; ++p)
            ty_grid_average(job->context, one->fluence[p], job->fine->box.size, job->coarse->box.size,
                            direct->coarse[p]);
    }
    if (!job->light->even) ty_dom_parts_add(job, source, one->planes, direct->coarse);
}

/* One source of many. */
static ty_result light_one(direct_job* direct, const ty_source* source, ty_light_field* all) {
    ty_dom_job* job = direct->job;
    ty_light_field* one = direct->one;
    clear_field(one);
    if (one->planes == 1) memcpy(one->color, source->color, sizeof one->color);
    const ty_result result = light_field(direct, TY_SINGLE_KEPT, source, 1, one, direct->room);
    if (result != TY_OK) return result;
    sum_job sum = {one, all};
    ty_parallel_for(job->context, (int64_t)((all->cells + CHUNK - 1) / CHUNK), sum_chunk, &sum);
    const double begun = ty_wall_seconds();
    spread_one(direct, source);
    job->stats.source_seconds += ty_wall_seconds() - begun;
    return TY_OK;
}

/* Memory of lights that have no field of their own. */
static ty_result take_many(direct_job* direct) {
    ty_dom_job* job = direct->job;
    ty_dom* light = job->light;
    const float* any = job->sources[0].color;
    ty_result result = job->fine->planes == 1 ? ty_light_field_create_shared(job->fine, false, any, &direct->one)
                                              : ty_light_field_create(job->fine, false, &direct->one);
    if (result == TY_OK)
        result = ty_source_groups_field(job->sources, direct->groups, direct->group_count, false, job->fine, false,
                                        &light->many);
    if (result == TY_OK) result = ty_dom_beams_create(job, &direct->beams);
    for (int32_t p = 0; p < job->fine->planes && result == TY_OK && !light->even; ++p) {
        direct->coarse[p] = ty_alloc_array(job->context, light->cells, sizeof(float), false);
        if (direct->coarse[p] == NULL) result = TY_ERROR_MEMORY;
    }
    if (result == TY_OK && !light->even) result = ty_dom_parts_create(job, direct->groups, direct->group_count);
    return result;
}

static ty_result light_many(direct_job* direct, const ty_source_group* group) {
    ty_dom_job* job = direct->job;
    ty_result result = job->light->many == NULL ? take_many(direct) : TY_OK;
    for (int32_t i = 0; i < group->count && result == TY_OK; ++i)
        result = light_one(direct, &job->sources[group->first + i], job->light->many);
    return result;
}

static ty_result light_groups(direct_job* direct) {
    ty_dom_job* job = direct->job;
    ty_dom* light = job->light;
    const double from = job->progress.from, share = job->progress.share;
    ty_result result = TY_OK;
    for (int32_t i = 0; i < direct->group_count && result == TY_OK; ++i) {
        const ty_source_group* group = &direct->groups[i];
        job->progress.share = share / ty_maxf(1, (float)direct->group_count);
        result = ty_part_show(&job->progress, "direct light");
        if (result == TY_OK) result = group->own ? light_own(direct, group) : light_many(direct, group);
        job->progress.from += job->progress.share;
    }
    job->progress.from = from;
    job->progress.share = share;
    if (result != TY_OK || light->many == NULL) return result;
    ty_dom_beams_add(job, &direct->beams, &direct->scratch);
    if (!light->even) {
        ty_dom_parts_end(job);
        result = ty_dom_sky_find(job);
        if (result != TY_OK) return result;
    }
    light->lights[light->light_count++] = ty_source_group_light(job->sources, NULL, light->many);
    return TY_OK;
}

/* ---- all ---- */

/* What media send by themselves. */
static void add_emission(ty_dom_job* job) {
    static const float to_harmonic = 0.28209479177f; /* 1 / sqrt(4 pi) */
    const ty_dom* light = job->light;
    const ty_grid_medium* medium = job->coarse;
    const float total = light->color[0] + light->color[1] + light->color[2];
    for (int32_t c = 0; c < ty_dom_channels(light) && medium->emission[0] != NULL; ++c)
        for (size_t i = 0; i < light->cells; ++i) {
            float emission = medium->emission[c][i];
            if (light->shared)
                emission = (medium->emission[0][i] + medium->emission[1][i] + medium->emission[2][i]) / total;
            job->source[c][i] += to_harmonic * emission;
        }
}

static ty_result take_extinction(direct_job* direct, int32_t fluence, int32_t order) {
    ty_dom_job* job = direct->job;
    for (int32_t p = 0; p < job->fine->planes; ++p) {
        direct->extinction[fluence][p] = ty_alloc_array(job->context, job->fine->cells, sizeof(float), false);
        if (direct->extinction[fluence][p] == NULL) return TY_ERROR_MEMORY;
    }
    if (fluence == TY_SINGLE_KEPT && job->light->fit.bands > 0)
        ty_grid_medium_reduce_by(job->fine, job->light->fit.straight, direct->extinction[fluence]);
    else
        ty_grid_medium_reduce(job->fine, order, direct->extinction[fluence]);
    return TY_OK;
}

static ty_result take_memory(direct_job* direct) {
    ty_dom_job* job = direct->job;
    const ty_dom* light = job->light;
    const size_t terms = (size_t)(light->bands * light->bands);
    for (int32_t c = 0; c < ty_dom_channels(light); ++c) {
        job->source[c] = ty_alloc_array(job->context, light->cells, terms * sizeof(float), true);
        if (job->source[c] == NULL) return TY_ERROR_MEMORY;
    }
    for (int32_t p = 0; p < job->fine->planes; ++p)
        direct->extinction[TY_SINGLE_STRAIGHT][p] = job->fine->extinction[p];
    const ty_result result = take_extinction(direct, TY_SINGLE_KEPT, light->bands);
    if (result != TY_OK || (light->lobes && take_extinction(direct, TY_SINGLE_BENT, light->bands + 1) != TY_OK))
        return TY_ERROR_MEMORY;
    direct->groups = ty_alloc_array(job->context, (size_t)job->source_count, sizeof *direct->groups, false);
    return direct->groups != NULL ? ty_dom_scratch_create(job, &direct->scratch) : TY_ERROR_MEMORY;
}

static void free_memory(direct_job* direct) {
    ty_dom_job* job = direct->job;
    ty_dom_scratch_destroy(job, &direct->scratch);
    ty_free_array(job->context, direct->groups, (size_t)job->source_count, sizeof *direct->groups);
    for (int32_t p = 0; p < job->fine->planes; ++p) {
        ty_free_array(job->context, direct->extinction[TY_SINGLE_KEPT][p], job->fine->cells, sizeof(float));
        ty_free_array(job->context, direct->extinction[TY_SINGLE_BENT][p], job->fine->cells, sizeof(float));
    }
    for (int c = 0; c < 3; ++c) {
        ty_free_array(job->context, direct->coarse[c], job->light->cells, sizeof(float));
        ty_beam_room_free(job->context, &direct->room[c]);
    }
    ty_dom_beams_destroy(job, &direct->beams);
    ty_light_field_destroy(direct->one);
}

ty_result ty_dom_light_directly(ty_dom_job* job) {
    direct_job direct = {.job = job};
    ty_result result = take_memory(&direct);
    if (result == TY_OK) {
        direct.group_count = ty_source_groups_find(job->scene, &job->fine->box, job->sources, job->source_count,
                                                   TY_DOM_OWN_MAX, direct.groups);
        result = light_groups(&direct);
    }
    if (result == TY_OK) add_emission(job);
    free_memory(&direct);
    return result;
}
