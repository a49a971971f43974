/* Uncollided light. Lights with one direction or one point have dedicated fields; all others share an aggregate field
 * and are computed sample by sample, as each has its own direction. */
#include "base/context.h"
#include "base/mapping.h"
#include "base/sh.k.h"
#include "method/dom/sources/sources.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* ---- fields ---- */

typedef struct direct_job {
    ty_dom_job* job;
    float* extinction[TY_FLUENCE_COUNT][3]; /* of fine cells, for each fluence of a light */
    ty_dom_scratch scratch;
    ty_light_field* field; /* of one sample without a dedicated field */
    float* coarse[3];      /* its means on coarse cells, per plane */
    ty_dom_collimated_batch batch;
    ty_transpose_scratch transpose_scratch[3];
    ty_light_group* groups;
    int32_t group_count;
} direct_job;

/* transpose_scratch: NULL: not kept. */
static ty_result light_field(direct_job* direct, int32_t fluence, const ty_discrete_light* sources, int32_t count,
                             ty_light_field* field, ty_transpose_scratch* transpose_scratch) {
    ty_dom_job* job = direct->job;
    return ty_uncollided_add_reusing(job->scene, job->fine, direct->extinction[fluence], sources, count, field,
                                     transpose_scratch, ty_part_report, &job->progress);
}

/* Attaches the fluences U and S to a light with a lobe. */
static void describe_lobe(const ty_dom* light, ty_light_field* const fields[TY_FLUENCE_COUNT],
                          ty_light_fluence* uncollided) {
    if (!light->has_lobes) return;
    uncollided->lobe_order = light->bands;
    uncollided->legendre = ty_dom_legendre(light);
    for (int c = 0; c < 3; ++c) {
        uncollided->unscattered[c] = fields[TY_FLUENCE_UNSCATTERED]->fluence[c];
        uncollided->next_order[c] = fields[TY_FLUENCE_NEXT_ORDER]->fluence[c];
    }
}

/* Averages a dedicated light's fluences over coarse cells. */
static ty_result average_dedicated(direct_job* direct, const ty_light_group* group, ty_light_field* const* fields,
                                   ty_light_field** out) {
    const ty_dom_job* job = direct->job;
    for (int32_t f = 0; f < TY_FLUENCE_COUNT; ++f) {
        if (ty_light_groups_field(job->sources.items, group, 1, true, job->coarse, false, &out[f]) != TY_OK)
            return TY_ERROR_MEMORY;
        for (int32_t p = 0; p < fields[f]->planes; ++p)
            ty_grid_average(job->context, fields[f]->fluence[p], job->fine->box.size, job->coarse->box.size,
                            out[f]->fluence[p]);
    }
    return TY_OK;
}

/* A light with extent spreads its directions; a sphere shines in all of them from its center. */
static void extend(const ty_dom_job* job, ty_light_fluence* uncollided) {
    const ty_light_view* light = &ty_scene_get_view(job->scene)->lights.lights[uncollided->sample.light];
    if (!job->is_narrow || uncollided->kind != TY_FLUENCE_POINT) return;
    if (light->kind == TY_KIND_AREA) uncollided->extent = light->area;
    if (light->kind != TY_KIND_SPHERE || light->cone != 0) return;
    uncollided->extent = TY_PI * light->radius * light->radius;
    uncollided->anchor = uncollided->sample.position = light->position;
    uncollided->sample.profile = TY_PROFILE_ISOTROPIC;
}

static ty_result light_dedicated(direct_job* direct, const ty_light_group* group) {
    ty_dom_job* job = direct->job;
    ty_dom* light = job->light;
    ty_light_field** fields = light->fields[light->fluence_count];
    ty_light_fluence* uncollided = &light->fluences[light->fluence_count];
    ty_result result = TY_OK;
    for (int32_t f = 0; f < (light->has_lobes ? TY_FLUENCE_COUNT : 1) && result == TY_OK; ++f) {
        result = ty_light_groups_field(job->sources.items, group, 1, true, job->fine, false, &fields[f]);
        if (result == TY_OK)
            result = light_field(direct, f, &job->sources.items[group->first], group->count, fields[f], NULL);
    }
    if (result == TY_OK && light->has_lobes)
        result = average_dedicated(direct, group, fields, light->coarse_fields[light->fluence_count]);
    if (result != TY_OK) return result;
    *uncollided = ty_light_group_fluence(job->sources.items, group, fields[TY_FLUENCE_ORDER_L]);
    extend(job, uncollided);
    describe_lobe(light, fields, uncollided);
    ++light->fluence_count;
    const double begun = ty_wall_seconds();
    ty_dom_add_first_collisions(job, fields[TY_FLUENCE_ORDER_L], uncollided, 1, &direct->scratch);
    job->stats.source_seconds += ty_wall_seconds() - begun;
    return TY_OK;
}

enum { CHUNK = 1 << 15 };

typedef struct sum_job {
    const ty_light_field* field;
    ty_light_field* aggregate;
} sum_job;

static void sum_chunk(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const sum_job* sum = user;
    const size_t begin = (size_t)index * CHUNK, cells = sum->aggregate->cells;
    const size_t end = cells - begin < CHUNK ? cells : begin + CHUNK;
    const float *from = sum->field->color, *to = sum->aggregate->color;
    for (int32_t p = 0; p < sum->aggregate->planes; ++p) {
        const float* field = sum->field->fluence[sum->field->planes == 3 ? p : 0];
        float* aggregate = sum->aggregate->fluence[p];
        const float factor = sum->field->planes == 3       ? 1
                             : sum->aggregate->planes == 3 ? from[p]
                                                           : (from[0] + from[1] + from[2]) / (to[0] + to[1] + to[2]);
        for (size_t i = begin; i < end; ++i) aggregate[i] += factor * field[i];
    }
}

static void clear_field(ty_light_field* field) {
    for (int32_t p = 0; p < field->planes; ++p) memset(field->fluence[p], 0, field->cells * sizeof(float));
}

/* Adds a sample's first-collision source, and its fluence to its cluster. */
static void add_first_collisions(direct_job* direct, const ty_discrete_light* source) {
    ty_dom_job* job = direct->job;
    const ty_light_field* field = direct->field;
    const ty_light_group group = {.first = 0, .count = 1, .center = source->position};
    if (source->kind == TY_DISCRETE_DIRECTIONAL && ty_dom_collimated_batch_accepts(&direct->scratch, field)) {
        ty_dom_collimated_batch_take(job, &direct->batch, source, field, &direct->scratch, direct->coarse);
    } else {
        const ty_light_fluence uncollided = ty_light_group_fluence(source, &group, field);
        ty_dom_add_first_collisions(job, field, &uncollided, source->mean_cosine, &direct->scratch);
        for (int32_t p = 0; p < field->planes && direct->coarse[p] != NULL; ++p)
            ty_grid_average(job->context, field->fluence[p], job->fine->box.size, job->coarse->box.size,
                            direct->coarse[p]);
    }
    if (!job->light->isotropic) ty_dom_clusters_add(job, source, field->planes, direct->coarse);
}

/* Computes one sample of an aggregate light. */
static ty_result light_sample(direct_job* direct, const ty_discrete_light* source, ty_light_field* aggregate) {
    ty_dom_job* job = direct->job;
    ty_light_field* field = direct->field;
    clear_field(field);
    if (field->planes == 1) memcpy(field->color, source->color, sizeof field->color);
    const ty_result result = light_field(direct, TY_FLUENCE_ORDER_L, source, 1, field, direct->transpose_scratch);
    if (result != TY_OK) return result;
    sum_job sum = {field, aggregate};
    ty_parallel_for(job->context, (int64_t)((aggregate->cells + CHUNK - 1) / CHUNK), sum_chunk, &sum);
    const double begun = ty_wall_seconds();
    add_first_collisions(direct, source);
    job->stats.source_seconds += ty_wall_seconds() - begun;
    return TY_OK;
}

/* Memory of lights without dedicated fields. */
static ty_result allocate_aggregate(direct_job* direct) {
    ty_dom_job* job = direct->job;
    ty_dom* light = job->light;
    const float* any = job->sources.items[0].color;
    ty_result result = job->fine->planes == 1 ? ty_light_field_create_shared(job->fine, false, any, &direct->field)
                                              : ty_light_field_create(job->fine, false, &direct->field);
    if (result == TY_OK)
        result = ty_light_groups_field(job->sources.items, direct->groups, direct->group_count, false, job->fine, false,
                                       &light->aggregate);
    if (result == TY_OK) result = ty_dom_collimated_batch_create(job, &direct->batch);
    for (int32_t p = 0; p < job->fine->planes && result == TY_OK && !light->isotropic; ++p) {
        direct->coarse[p] = ty_alloc_array(job->context, light->cells, sizeof(float), false);
        if (direct->coarse[p] == NULL) result = TY_ERROR_MEMORY;
    }
    if (result == TY_OK && !light->isotropic) result = ty_dom_clusters_create(job, direct->groups, direct->group_count);
    return result;
}

static ty_result light_aggregate(direct_job* direct, const ty_light_group* group) {
    ty_dom_job* job = direct->job;
    ty_result result = job->light->aggregate == NULL ? allocate_aggregate(direct) : TY_OK;
    for (int32_t i = 0; i < group->count && result == TY_OK; ++i)
        result = light_sample(direct, &job->sources.items[group->first + i], job->light->aggregate);
    return result;
}

static ty_result light_all_groups(direct_job* direct) {
    ty_dom_job* job = direct->job;
    ty_dom* light = job->light;
    const double from = job->progress.from, fraction = job->progress.span;
    ty_result result = TY_OK;
    for (int32_t i = 0; i < direct->group_count && result == TY_OK; ++i) {
        const ty_light_group* group = &direct->groups[i];
        job->progress.span = fraction / ty_maxf(1, (float)direct->group_count);
        result = ty_part_show(&job->progress, "direct light", 0);
        if (result == TY_OK)
            result = group->dedicated ? light_dedicated(direct, group) : light_aggregate(direct, group);
        job->progress.from += job->progress.span;
    }
    job->progress.from = from;
    job->progress.span = fraction;
    if (result != TY_OK || light->aggregate == NULL) return result;
    ty_dom_collimated_batch_flush(job, &direct->batch, &direct->scratch);
    if (!light->isotropic) {
        ty_dom_clusters_end(job);
        result = ty_dom_environment_find(job);
        if (result != TY_OK) return result;
    }
    light->fluences[light->fluence_count++] = ty_light_group_fluence(job->sources.items, NULL, light->aggregate);
    return TY_OK;
}

/* ---- all ---- */

/* Adds the isotropic emission of media to q_00. */
static void add_emission(ty_dom_job* job) {
    const ty_dom* light = job->light;
    const ty_grid_medium* medium = job->coarse;
    const float total = light->color[0] + light->color[1] + light->color[2];
    for (int32_t c = 0; c < ty_dom_channels(light) && medium->emission[0] != NULL; ++c)
        for (size_t i = 0; i < light->cells; ++i) {
            float emission = medium->emission[c][i];
            if (light->shared)
                emission = (medium->emission[0][i] + medium->emission[1][i] + medium->emission[2][i]) / total;
            job->source[c][i] += TY_SH_0 * emission;
        }
}

void ty_dom_uncollided_extinction(const ty_dom_job* job, float* const planes[3]) {
    if (job->light->fit.bands > 0)
        ty_grid_medium_reduce_by(job->fine, job->light->fit.forward_fraction, planes);
    else
        ty_grid_medium_reduce(job->fine, job->light->bands, planes);
}

static ty_result allocate_extinction(direct_job* direct, int32_t fluence, int32_t order) {
    ty_dom_job* job = direct->job;
    for (int32_t p = 0; p < job->fine->planes; ++p) {
        direct->extinction[fluence][p] = ty_alloc_large(job->context, job->fine->cells, sizeof(float), false);
        if (direct->extinction[fluence][p] == NULL) return TY_ERROR_MEMORY;
    }
    if (fluence == TY_FLUENCE_ORDER_L)
        ty_dom_uncollided_extinction(job, direct->extinction[fluence]);
    else
        ty_grid_medium_reduce(job->fine, order, direct->extinction[fluence]);
    return TY_OK;
}

static ty_result allocate_memory(direct_job* direct) {
    ty_dom_job* job = direct->job;
    const ty_dom* light = job->light;
    const size_t terms = (size_t)(light->bands * light->bands);
    for (int32_t c = 0; c < ty_dom_channels(light); ++c) {
        job->source[c] = ty_alloc_large(job->context, light->cells, terms * sizeof(float), true);
        if (job->source[c] == NULL) return TY_ERROR_MEMORY;
    }
    for (int32_t p = 0; p < job->fine->planes; ++p)
        direct->extinction[TY_FLUENCE_UNSCATTERED][p] = job->fine->extinction[p];
    const ty_result result = allocate_extinction(direct, TY_FLUENCE_ORDER_L, light->bands);
    if (result != TY_OK ||
        (light->has_lobes && allocate_extinction(direct, TY_FLUENCE_NEXT_ORDER, light->bands + 1) != TY_OK))
        return TY_ERROR_MEMORY;
    direct->groups = ty_alloc_array(job->context, (size_t)job->sources.count, sizeof *direct->groups, false);
    return direct->groups != NULL ? ty_dom_scratch_create(job, &direct->scratch) : TY_ERROR_MEMORY;
}

static void free_memory(direct_job* direct) {
    ty_dom_job* job = direct->job;
    ty_dom_scratch_destroy(job, &direct->scratch);
    ty_free_array(job->context, direct->groups, (size_t)job->sources.count, sizeof *direct->groups);
    for (int32_t p = 0; p < job->fine->planes; ++p) {
        ty_free_large(job->context, direct->extinction[TY_FLUENCE_ORDER_L][p], job->fine->cells, sizeof(float));
        ty_free_large(job->context, direct->extinction[TY_FLUENCE_NEXT_ORDER][p], job->fine->cells, sizeof(float));
    }
    for (int c = 0; c < 3; ++c) {
        ty_free_array(job->context, direct->coarse[c], job->light->cells, sizeof(float));
        ty_transpose_scratch_free(job->context, &direct->transpose_scratch[c]);
    }
    ty_dom_collimated_batch_destroy(job, &direct->batch);
    ty_light_field_destroy(direct->field);
}

/* Radius up to which lights with extent count as points near and within media: a cell of the ordinates, within which
 * the directions of other lights are one. It matters where phase functions are narrow. */
static float point_radius(const ty_dom_job* job) {
    const double* cell = job->coarse->cell;
    return !job->is_narrow ? 0 : (float)fmax(cell[0], fmax(cell[1], cell[2]));
}

ty_result ty_dom_find_uncollided(ty_dom_job* job) {
    direct_job direct = {.job = job};
    ty_result result = allocate_memory(&direct);
    if (result == TY_OK) {
        direct.group_count = ty_light_groups_find(job->scene, &job->fine->box, job->sources.items, job->sources.count,
                                                  TY_DOM_DEDICATED_MAX, point_radius(job), direct.groups);
        result = light_all_groups(&direct);
    }
    if (result == TY_OK) result = ty_dom_find_centers(job);
    if (result == TY_OK) add_emission(job);
    free_memory(&direct);
    return result;
}
