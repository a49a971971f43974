/* Uncollided light and its scattering source for diffusion: q of Eq. 6 (Koerner 2014), with the reduced beam by default
 * or as published. */
#include "method/fld/job.h"

#include "base/context.h"
#include "direct/uncollided/light_groups.h"
#include "direct/lights/discretize.h"
#include "direct/uncollided/first_collision_source.h"

/* Groups with dedicated fields, then all others in one aggregate field. */
static ty_result light_groups(ty_fld_job* job, float* const extinction[3], const ty_light_group* groups,
                              int32_t count) {
    ty_fld* light = job->light;
    const double from = job->progress.from, fraction = job->progress.share;
    ty_light_field** aggregate = &light->beam[TY_FLD_DEDICATED_FIELDS_MAX];
    ty_result result = TY_OK;
    job->progress.share = fraction / ty_maxf(1, (float)count);
    for (int32_t i = 0; i < count && result == TY_OK; ++i) {
        const ty_light_group* group = &groups[i];
        ty_light_field** field = group->dedicated ? &light->beam[light->light_count] : aggregate;
        result = ty_part_show(&job->progress, "direct light", 0);
        if (result == TY_OK && *field == NULL)
            result = ty_light_groups_field(job->sources.items, group->dedicated ? group : groups,
                                           group->dedicated ? 1 : count, group->dedicated, job->fine, !group->dedicated,
                                           field);
        if (result == TY_OK)
            result =
                ty_uncollided_add_with_progress(job->scene, job->fine, extinction, &job->sources.items[group->first],
                                                group->count, *field, ty_part_report, &job->progress);
        job->progress.from += job->progress.share;
        if (result == TY_OK && group->dedicated)
            light->lights[light->light_count++] = ty_light_group_fluence(job->sources.items, group, *field);
    }
    job->progress.from = from;
    job->progress.share = fraction;
    if (result == TY_OK && *aggregate != NULL)
        light->lights[light->light_count++] = ty_light_group_fluence(job->sources.items, NULL, *aggregate);
    return result;
}

/* Groups sources by light; at most TY_FLD_DEDICATED_FIELDS_MAX groups have dedicated fields. */
static ty_result light_sources(ty_fld_job* job, float* const extinction[3]) {
    ty_light_group* groups = ty_alloc_array(job->context, (size_t)job->sources.count, sizeof *groups, false);
    if (groups == NULL) return TY_ERROR_MEMORY;
    const int32_t count = ty_light_groups_find(job->scene, &job->fine->box, job->sources.items, job->sources.count,
                                               TY_FLD_DEDICATED_FIELDS_MAX, groups);
    const ty_result result = light_groups(job, extinction, groups, count);
    ty_free_array(job->context, groups, (size_t)job->sources.count, sizeof *groups);
    return result;
}

/* ---- first-collision source ---- */

ty_result ty_fld_find_sources(ty_fld_job* job, const ty_grid_medium* medium, float* source[3]) {
    float* fine = ty_alloc_array(job->context, job->fine->cells, sizeof *fine, false);
    if (fine == NULL) return TY_ERROR_MEMORY;
    ty_result result = TY_OK;
    for (int32_t c = 0; c < 3 && result == TY_OK; ++c) {
        source[c] = ty_alloc_array(job->context, medium->cells, sizeof(float), false);
        if (source[c] == NULL) {
            result = TY_ERROR_MEMORY;
            break;
        }
        ty_first_collision_source(job->fine, job->light->lights, job->light->light_count, c,
                                  job->def->beam == TY_FLD_BEAM_REDUCED, fine);
        ty_grid_average(job->context, fine, job->fine->box.size, medium->box.size, source[c]);
    }
    ty_free_array(job->context, fine, job->fine->cells, sizeof *fine);
    return result;
}

/* q_ri of Eq. 6 (Koerner 2014). */
ty_result ty_fld_direct_light(ty_fld_job* job) {
    const ty_discretize_def def = {
        .environment = job->def->environment_beams, .surface = job->def->surface_points, .seed = job->def->seed};
    const ty_grid_medium* fine = job->fine;
    float* extinction[3] = {0};
    ty_result result = ty_discretize_lights(job->scene, &def, &job->sources);
    for (int32_t p = 0; p < fine->planes && result == TY_OK; ++p) {
        extinction[p] = ty_alloc_array(job->context, fine->cells, sizeof(float), false);
        if (extinction[p] == NULL) result = TY_ERROR_MEMORY;
    }
    if (result == TY_OK) ty_scaled_extinction(fine, job->def->beam == TY_FLD_BEAM_REDUCED ? 1 : 0, extinction);
    if (result == TY_OK) result = light_sources(job, extinction);
    for (int32_t p = 0; p < fine->planes; ++p) ty_free_array(job->context, extinction[p], fine->cells, sizeof(float));
    return result == TY_OK ? ty_fld_find_sources(job, job->coarse, job->source) : result;
}
