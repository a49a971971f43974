/* Uncollided light, and the source that it is for diffusion: q of Eq. 6, from the reduced beam unless the paper's is
 * asked for. */
#include "method/fld/job.h"

#include "base/context.h"
#include "direct/group.h"
#include "direct/turned.h"

/* The groups that have fields of their own, then all others together. */
static ty_result light_groups(ty_fld_job* job, float* const extinction[3], const ty_source_group* groups,
                              int32_t count) {
    ty_fld* light = job->light;
    const double from = job->progress.from, share = job->progress.share;
    ty_light_field** many = &light->beam[TY_FLD_OWN_MAX];
    ty_result result = TY_OK;
    job->progress.share = share / ty_maxf(1, (float)count);
    for (int32_t i = 0; i < count && result == TY_OK; ++i) {
        const ty_source_group* group = &groups[i];
        ty_light_field** field = group->own ? &light->beam[light->light_count] : many;
        result = ty_part_show(&job->progress, "direct light");
        if (result == TY_OK && *field == NULL)
            result = ty_source_groups_field(job->sources, group->own ? group : groups, group->own ? 1 : count,
                                            group->own, job->fine, !group->own, field);
        if (result == TY_OK)
            result = ty_uncollided_add_watched(job->scene, job->fine, extinction, &job->sources[group->first],
                                               group->count, *field, ty_part_report, &job->progress);
        job->progress.from += job->progress.share;
        if (result == TY_OK && group->own)
            light->lights[light->light_count++] = ty_source_group_light(job->sources, group, *field);
    }
    job->progress.from = from;
    job->progress.share = share;
    if (result == TY_OK && *many != NULL)
        light->lights[light->light_count++] = ty_source_group_light(job->sources, NULL, *many);
    return result;
}

/* Sources by light; at most TY_FLD_OWN_MAX keep fields of their own. */
static ty_result light_all(ty_fld_job* job, float* const extinction[3]) {
    ty_source_group* groups = ty_alloc_array(job->context, (size_t)job->source_count, sizeof *groups, false);
    if (groups == NULL) return TY_ERROR_MEMORY;
    const int32_t count =
        ty_source_groups_find(job->scene, &job->fine->box, job->sources, job->source_count, TY_FLD_OWN_MAX, groups);
    const ty_result result = light_groups(job, extinction, groups, count);
    ty_free_array(job->context, groups, (size_t)job->source_count, sizeof *groups);
    return result;
}

/* ---- what scatters of it ---- */

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
        ty_turned_find(job->fine, job->light->lights, job->light->light_count, c, job->def->beam == TY_FLD_BEAM_REDUCED,
                       fine);
        ty_grid_average(job->context, fine, job->fine->box.size, medium->box.size, source[c]);
    }
    ty_free_array(job->context, fine, job->fine->cells, sizeof *fine);
    return result;
}

/* q_ri of Eq. 6 (Koerner 2014). */
ty_result ty_fld_light_directly(ty_fld_job* job) {
    const ty_source_def def = {
        .environment = job->def->environment_beams, .surface = job->def->surface_points, .seed = job->def->seed};
    const ty_grid_medium* fine = job->fine;
    float* extinction[3] = {0};
    ty_result result = ty_sources_create(job->scene, &def, &job->sources, &job->source_count);
    for (int32_t p = 0; p < fine->planes && result == TY_OK; ++p) {
        extinction[p] = ty_alloc_array(job->context, fine->cells, sizeof(float), false);
        if (extinction[p] == NULL) result = TY_ERROR_MEMORY;
    }
    if (result == TY_OK) ty_turned_extinction(fine, job->def->beam == TY_FLD_BEAM_REDUCED ? 1 : 0, extinction);
    if (result == TY_OK) result = light_all(job, extinction);
    for (int32_t p = 0; p < fine->planes; ++p) ty_free_array(job->context, extinction[p], fine->cells, sizeof(float));
    return result == TY_OK ? ty_fld_find_sources(job, job->coarse, job->source) : result;
}
