/* Directional, point and spot lights on cells as fine as the medium's: what goes straight through, and what scatters
 * and keeps its direction. */
#include "base/context.h"
#include "direct/lights/discretize.h"
#include "direct/uncollided/first_collision_source.h"
#include "method/pop/job.h"

#include <math.h>

/* Which scattering the extinction of each fluence leaves out. */
static const int32_t orders[TY_FLUENCE_COUNT] = {
    [TY_FLUENCE_ORDER_L] = 1, [TY_FLUENCE_UNSCATTERED] = 0, [TY_FLUENCE_NEXT_ORDER] = 2};

static bool scatters_forwards(const ty_grid_medium* medium) {
    for (int32_t p = 0; p < medium->planes; ++p)
        for (size_t i = 0; i < medium->cells; ++i)
            if (medium->g[p][i] > 0) return true;
    return false;
}

static ty_result make_field(const ty_grid_medium* medium, const ty_discrete_light* source, ty_light_field** out) {
    const float* color = source->color;
    return medium->planes == 1 ? ty_light_field_create_shared(medium, false, color, out)
                               : ty_light_field_create(medium, false, out);
}

static void describe(const ty_discrete_light* source, ty_light_field* const fields[TY_FLUENCE_COUNT],
                     ty_light_fluence* out) {
    const ty_light_field* kept = fields[TY_FLUENCE_ORDER_L];
    *out = ty_light_fluence_of(source);
    out->shared = kept->planes == 1;
    out->lobe_order = fields[TY_FLUENCE_UNSCATTERED] != NULL;
    for (int c = 0; c < 3; ++c) {
        out->color[c] = kept->planes == 1 ? kept->color[c] : 1;
        out->fluence[c] = kept->fluence[c];
        out->unscattered[c] = out->lobe_order != 0 ? fields[TY_FLUENCE_UNSCATTERED]->fluence[c] : NULL;
        out->next_order[c] = out->lobe_order != 0 ? fields[TY_FLUENCE_NEXT_ORDER]->fluence[c] : NULL;
    }
}

/* One light: its reduced beam, and where media scatter forwards its two others. */
static ty_result light_one(ty_pop_job* job, const ty_discrete_light* source,
                           float* const extinction[TY_FLUENCE_COUNT][3], int32_t fluences) {
    ty_pop* light = job->light;
    ty_light_field** fields = light->fields[light->light_count];
    ty_result result = TY_OK;
    for (int32_t f = 0; f < fluences && result == TY_OK; ++f) {
        result = make_field(job->fine, source, &fields[f]);
        if (result == TY_OK)
            result = ty_uncollided_add_with_progress(job->scene, job->fine, extinction[f], source, 1, fields[f],
                                                     ty_part_report, &job->progress);
    }
    if (result == TY_OK) describe(source, fields, &light->lights[light->light_count]);
    ++light->light_count;
    return result;
}

static ty_result light_all(ty_pop_job* job, float* const extinction[TY_FLUENCE_COUNT][3], int32_t fluences) {
    const ty_discretize_def def = {.environment = 1, .surface = 1, .seed = job->def->seed};
    ty_discrete_light_set sources;
    ty_result result = ty_discretize_lights(job->scene, &def, &sources);
    for (int32_t i = 0; i < sources.count && result == TY_OK; ++i)
        if (ty_pop_is_sharp(job->scene, job->def, sources.items[i].light))
            result = light_one(job, &sources.items[i], extinction, fluences);
    ty_discrete_light_set_destroy(job->context, &sources);
    return result;
}

static ty_result find_extinctions(ty_pop_job* job, float* extinction[TY_FLUENCE_COUNT][3], int32_t fluences) {
    for (int32_t f = 0; f < fluences; ++f) {
        for (int32_t p = 0; p < job->fine->planes; ++p) {
            extinction[f][p] = ty_alloc_array(job->context, job->fine->cells, sizeof(float), false);
            if (extinction[f][p] == NULL) return TY_ERROR_MEMORY;
        }
        ty_scaled_extinction(job->fine, orders[f], extinction[f]);
    }
    return TY_OK;
}

static bool is_carried(const ty_light_fluence* light) {
    return light->kind == TY_FLUENCE_DIRECTIONAL && light->lobe_order != 0;
}

/* How much of the light of sharp beams has a second moment; the rest has the first alone. All of it leaves too little
 * on the lit sides of narrow media, none of it too much on the others (docs/method/pop.md). */
static const float carried_share = 0.7f;

static ty_light_fluence part_of(const ty_light_fluence* light, float share) {
    ty_light_fluence part = *light;
    for (int c = 0; c < 3; ++c) part.color[c] *= share;
    return part;
}

/* What turns aside of lights, as means over merged cells: of beams with lobes what is not carried. */
static ty_result turn_aside(ty_pop_job* job) {
    ty_light_fluence rest[TY_POP_SHARP_MAX];
    const int32_t count = job->light->light_count;
    for (int32_t l = 0; l < count; ++l) {
        const ty_light_fluence* light = &job->light->lights[l];
        rest[l] = is_carried(light) ? part_of(light, 1 - carried_share) : *light;
    }
    if (count == 0) return TY_OK;
    float* fine = ty_alloc_array(job->context, job->fine->cells, sizeof *fine, false);
    if (fine == NULL) return TY_ERROR_MEMORY;
    for (int32_t c = 0; c < 3; ++c) {
        ty_first_collision_source(job->fine, rest, count, c, true, fine);
        ty_grid_average(job->context, fine, job->fine->box.size, job->medium->box.size, job->source[c]);
    }
    ty_free_array(job->context, fine, job->fine->cells, sizeof *fine);
    return TY_OK;
}

/* What is carried of beams with lobes. */
static ty_result carry(ty_pop_job* job) {
    ty_result result = TY_OK;
    for (int32_t l = 0; l < job->light->light_count && result == TY_OK; ++l) {
        if (!is_carried(&job->light->lights[l])) continue;
        const ty_light_fluence part = part_of(&job->light->lights[l], carried_share);
        if (job->carried.cells == 0) result = ty_pop_carried_create(job->context, job->medium->cells, &job->carried);
        if (result == TY_OK) result = ty_pop_carry(job->fine, &part, job->medium, &job->carried);
    }
    return result;
}

ty_result ty_pop_light_sharply(ty_pop_job* job) {
    float* extinction[TY_FLUENCE_COUNT][3] = {{NULL}};
    if (job->fine == NULL) return TY_OK;
    const int32_t fluences = scatters_forwards(job->fine) ? TY_FLUENCE_COUNT : 1;
    ty_result result = find_extinctions(job, extinction, fluences);
    if (result == TY_OK) result = light_all(job, extinction, fluences);
    for (int32_t f = 0; f < fluences; ++f)
        for (int32_t p = 0; p < job->fine->planes; ++p)
            ty_free_array(job->context, extinction[f][p], job->fine->cells, sizeof(float));
    if (result == TY_OK) result = turn_aside(job);
    return result == TY_OK ? carry(job) : result;
}
