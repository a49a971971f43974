/* Fine-grid lights: directional, point and spot lights on cells as fine as the medium's, with uncollided and
 * forward-scattered fluence. */
#include "base/context.h"
#include "direct/lights/discretize.h"
#include "direct/uncollided/first_collision_source.h"
#include "method/pop/job.h"

/* Order l of the scaled extinction sigma_t - g^l sigma_s of each fluence. */
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

static void set_single_light(const ty_discrete_light* source, ty_light_field* const fields[TY_FLUENCE_COUNT],
                             ty_light_fluence* out) {
    const ty_light_field* forward = fields[TY_FLUENCE_ORDER_L];
    *out = ty_light_fluence_of(source);
    out->shared = forward->planes == 1;
    out->lobe_order = fields[TY_FLUENCE_UNSCATTERED] != NULL;
    for (int c = 0; c < 3; ++c) {
        out->color[c] = forward->planes == 1 ? forward->color[c] : 1;
        out->fluence[c] = forward->fluence[c];
        out->unscattered[c] = out->lobe_order != 0 ? fields[TY_FLUENCE_UNSCATTERED]->fluence[c] : NULL;
        out->next_order[c] = out->lobe_order != 0 ? fields[TY_FLUENCE_NEXT_ORDER]->fluence[c] : NULL;
    }
}

/* Injects one light: its fluence with reduced extinction and, in forward-scattering media, the two others. */
static ty_result inject_light(ty_pop_job* job, const ty_discrete_light* source,
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
    if (result == TY_OK) set_single_light(source, fields, &light->lights[light->light_count]);
    ++light->light_count;
    return result;
}

static ty_result inject_lights(ty_pop_job* job, float* const extinction[TY_FLUENCE_COUNT][3], int32_t fluences) {
    const ty_discretize_def def = {.environment = 1, .surface = 1, .seed = job->def->seed};
    ty_discrete_light_set sources;
    ty_result result = ty_discretize_lights(job->scene, &def, &sources);
    for (int32_t i = 0; i < sources.count && result == TY_OK; ++i)
        if (ty_pop_uses_fine_grid(job->scene, job->def, sources.items[i].light))
            result = inject_light(job, &sources.items[i], extinction, fluences);
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

static bool has_delta_source(const ty_light_fluence* light) {
    return light->kind == TY_FLUENCE_DIRECTIONAL && light->lobe_order != 0;
}

/* Fraction of a beam's light that gets the delta-Eddington source; the rest gets the reduced-scattering source. At 1
 * the lit sides of narrow media are too dark, at 0 their far sides too bright (docs/method/pop.md). */
static const float delta_fraction = 0.7f;

static ty_light_fluence scaled_light(const ty_light_fluence* light, float fraction) {
    ty_light_fluence scaled = *light;
    for (int c = 0; c < 3; ++c) scaled.color[c] *= fraction;
    return scaled;
}

/* Adds the first-collision source with reduced scattering, averaged over merged cells: for beams with lobes the
 * fraction without a delta-Eddington source. */
static ty_result add_diffuse_sources(ty_pop_job* job) {
    ty_light_fluence remaining[TY_POP_FINE_LIGHTS_MAX];
    const int32_t count = job->light->light_count;
    for (int32_t l = 0; l < count; ++l) {
        const ty_light_fluence* light = &job->light->lights[l];
        remaining[l] = has_delta_source(light) ? scaled_light(light, 1 - delta_fraction) : *light;
    }
    if (count == 0) return TY_OK;
    float* fine = ty_alloc_array(job->context, job->fine->cells, sizeof *fine, false);
    if (fine == NULL) return TY_ERROR_MEMORY;
    for (int32_t c = 0; c < 3; ++c) {
        ty_first_collision_source(job->fine, remaining, count, c, true, fine);
        ty_grid_average(job->context, fine, job->fine->box.size, job->medium->box.size, job->source[c]);
    }
    ty_free_array(job->context, fine, job->fine->cells, sizeof *fine);
    return TY_OK;
}

/* Adds the delta-Eddington sources of beams with lobes. */
static ty_result add_delta_sources(ty_pop_job* job) {
    ty_result result = TY_OK;
    for (int32_t l = 0; l < job->light->light_count && result == TY_OK; ++l) {
        if (!has_delta_source(&job->light->lights[l])) continue;
        const ty_light_fluence scaled = scaled_light(&job->light->lights[l], delta_fraction);
        if (job->delta_source.cells == 0)
            result = ty_pop_delta_source_create(job->context, job->medium->cells, &job->delta_source);
        if (result == TY_OK)
            result = ty_pop_delta_source_add_light(job->fine, &scaled, job->medium, &job->delta_source);
    }
    return result;
}

ty_result ty_pop_inject_fine_grid(ty_pop_job* job) {
    float* extinction[TY_FLUENCE_COUNT][3] = {{NULL}};
    if (job->fine == NULL) return TY_OK;
    const int32_t fluences = scatters_forwards(job->fine) ? TY_FLUENCE_COUNT : 1;
    ty_result result = find_extinctions(job, extinction, fluences);
    if (result == TY_OK) result = inject_lights(job, extinction, fluences);
    for (int32_t f = 0; f < fluences; ++f)
        for (int32_t p = 0; p < job->fine->planes; ++p)
            ty_free_array(job->context, extinction[f][p], job->fine->cells, sizeof(float));
    if (result == TY_OK) result = add_diffuse_sources(job);
    return result == TY_OK ? add_delta_sources(job) : result;
}
