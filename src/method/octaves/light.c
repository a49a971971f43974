/* Fluence of the lights on the cells of a medium: uncollided in octave 0, attenuated by b^i sigma_t in octave i. */
#include "method/octaves/job.h"

#include "base/context.h"

#include <string.h>

/* b^i sigma_t on all cells. */
static void scale_extinction(const ty_grid_medium* medium, float scale, float* const extinction[3]) {
    for (int32_t p = 0; p < medium->planes; ++p)
        for (size_t i = 0; i < medium->cells; ++i) extinction[p][i] = scale * medium->extinction[p][i];
}

/* Attenuation by b^i sigma_t makes light vary less with direction, so each octave uses half as many environment
 * directions as the preceding one. */
enum { FEW_BEAMS = 8 };

static ty_discretize_def source_def(const ty_octaves_def* def, int32_t octave) {
    const int32_t all = def->environment_beams, beams = all >> octave;
    return (ty_discretize_def){.environment = beams >= FEW_BEAMS ? beams
                                              : all < FEW_BEAMS  ? all
                                                                 : FEW_BEAMS,
                               .surface = def->surface_points,
                               .seed = def->seed};
}

static ty_result light_octave(ty_octaves_job* job, float* const extinction[3], int32_t octave) {
    const ty_discretize_def def = source_def(job->def, octave);
    ty_octaves* light = job->light;
    ty_light_fluence lights[TY_OCTAVES_LIGHTS_MAX];
    ty_discrete_light_set sources;
    ty_result result = ty_discretize_lights(job->scene, &def, &sources);
    scale_extinction(job->medium, light->octaves.extinction[octave], extinction);
    if (result == TY_OK)
        result = ty_light_groups_solve(job->scene, job->medium, extinction, &sources, TY_OCTAVES_OWN_MAX,
                                       &job->progress, light->fields[octave], lights, &light->light_count);
    if (result == TY_OK)
        memcpy(light->lights + octave * light->light_count, lights, (size_t)light->light_count * sizeof *lights);
    ty_discrete_light_set_destroy(job->context, &sources);
    return result;
}

static double field_bytes(const ty_octaves* light) {
    double bytes = 0;
    for (int32_t i = 0; i < light->octaves.count; ++i)
        for (int32_t l = 0; l < TY_OCTAVES_LIGHTS_MAX; ++l) {
            const ty_light_field* field = light->fields[i][l];
            if (field == NULL) continue;
            const int32_t planes = field->planes * (field->flux[0][0] != NULL ? 4 : 1);
            bytes += (double)planes * (double)field->cells * sizeof(float);
        }
    return bytes;
}

ty_result ty_octaves_light(ty_octaves_job* job) {
    const ty_grid_medium* medium = job->medium;
    const int32_t count = job->light->octaves.count;
    const double from = job->progress.from, fraction = job->progress.span;
    float* extinction[3] = {0};
    ty_result result = TY_OK;
    for (int32_t p = 0; p < medium->planes && result == TY_OK; ++p) {
        extinction[p] = ty_alloc_array(job->context, medium->cells, sizeof(float), false);
        if (extinction[p] == NULL) result = TY_ERROR_MEMORY;
    }
    job->progress.span = 0; /* the progress span is divided among the octaves */
    for (int32_t i = 0; i < count && result == TY_OK; ++i) {
        result = ty_part_next(&job->progress, "direct light", from + fraction * (i + 1) / count);
        if (result == TY_OK) result = light_octave(job, extinction, i);
    }
    job->stats.lights = job->light->light_count;
    job->stats.memory_bytes = field_bytes(job->light);
    for (int32_t p = 0; p < medium->planes; ++p)
        ty_free_array(job->context, extinction[p], medium->cells, sizeof(float));
    return result;
}
