/* Light on cells from a coarse solve. */
#include "method/cell_light.h"

#include "base/context.h"
#include "base/luminance.k.h"
#include "base/sh.k.h"
#include "direct/single/source_field.h"
#include "method/dom/solution.h"
#include "scene/scene.h"

#include <math.h>

/* Of the solve: cells of ordinates along the longest side, ordinates, and the product of cells of uncollided light and
 * samples of lights. */
static const double ordinates_cells = 20, ordinates = 24, direct_work = 1.6e7;

/* Cells of uncollided light along the longest side, fewer for many lights, each of which goes through all of them. */
static int32_t direct_cells(const ty_scene* scene, const ty_dom_def* def) {
    const ty_light_set* lights = &ty_scene_get_view(scene)->lights;
    double samples = 0;
    for (int32_t i = 0; i < lights->count; ++i) {
        const int32_t kind = lights->lights[i].kind;
        samples += kind == TY_KIND_ENVIRONMENT ? def->environment_beams
                   : kind >= TY_KIND_AREA      ? def->surface_points
                                               : 1;
    }
    return (int32_t)fmin(fmax(cbrt(direct_work / fmax(samples, 1)), 16), 48);
}

static ty_dom_def coarse_def(const ty_scene* scene, uint64_t seed) {
    ty_dom_def def = ty_default_dom_def();
    def.resolution = (int32_t)ordinates_cells;
    def.directions = (int32_t)ordinates;
    def.tolerance = 0.03;
    def.iterations = 12;
    def.environment_beams = 24;
    def.surface_points = ty_scene_get_view(scene)->lights.count > 32 ? 1 : 4;
    def.direct = direct_cells(scene, &def);
    def.seed = seed;
    def.interreflection = false;
    return def;
}

typedef struct flux_job {
    const ty_dom* light;
    const ty_grid_box* box;
    ty_cell_light* out;
} flux_job;

/* Luminance of a light's planes at a point. */
static float uncollided_luminance(const ty_light_fluence* light, TY_GLOBAL const float* const planes[3],
                                  const ty_cell_point* at) {
    float rgb[3];
    for (int c = 0; c < 3; ++c) {
        const float* plane = planes[light->shared != 0 ? 0 : c];
        rgb[c] = plane == NULL ? 0 : ty_cell_value(plane, at) * (light->shared != 0 ? light->color[c] : 1.0f);
    }
    return ty_luminance_of(rgb);
}

/* Adds the flux of a light's uncollided fluence at a point: along its direction, or of its own planes. */
static void add_uncollided(const ty_light_fluence* light, const ty_cell_point* at, ty_vec point, float flux[3]) {
    if (light->kind <= TY_FLUENCE_POINT) {
        const float* const planes[3] = {light->fluence[0], light->fluence[1], light->fluence[2]};
        const ty_vec off = light->kind == TY_FLUENCE_POINT ? ty_sub(point, light->anchor) : light->anchor;
        const float amount = uncollided_luminance(light, planes, at) / sqrtf(ty_maxf(ty_dot(off, off), 1e-30f));
        flux[0] += amount * off.x;
        flux[1] += amount * off.y;
        flux[2] += amount * off.z;
        return;
    }
    for (int a = 0; a < 3; ++a) {
        const float* const planes[3] = {light->flux[0][a], light->flux[1][a], light->flux[2][a]};
        flux[a] += uncollided_luminance(light, planes, at);
    }
}

/* Adds the flux of moments at a point. */
static void add_moments(const ty_dom* light, float* const moments[3], const ty_cell_point* at, float flux[3]) {
    static const int32_t harmonic[3] = {3, 1, 2};
    for (int a = 0; a < 3; ++a) {
        float rgb[3];
        for (int c = 0; c < 3; ++c) {
            float* planes = moments[light->shared ? 0 : c];
            rgb[c] = planes == NULL ? 0 : ty_cell_value(ty_dom_plane(light, planes, harmonic[a]), at) * light->color[c];
        }
        flux[a] += ty_luminance_of(rgb) / TY_SH_1;
    }
}

static void flux_of_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const flux_job* job = user;
    const ty_dom* light = job->light;
    const int32_t* size = job->box->size;
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        const size_t at = (size_t)row * (size_t)size[0] + (size_t)i;
        double point[3];
        float flux[3] = {0, 0, 0};
        for (int a = 0; a < 3; ++a)
            point[a] =
                job->box->lower[a] + (cell[a] + 0.5) * (job->box->upper[a] - job->box->lower[a]) / (double)size[a];
        const ty_cell_point fine = ty_coverage_locate(&light->fine_box, point);
        const ty_cell_point coarse = ty_coverage_locate(&light->box, point);
        const ty_vec place = ty_vec_make((float)point[0], (float)point[1], (float)point[2]);
        for (int32_t l = 0; l < light->fluence_count; ++l) add_uncollided(&light->fluences[l], &fine, place, flux);
        add_moments(light, light->moments, &coarse, flux);
        add_moments(light, light->wall_moments, &coarse, flux);
        for (int a = 0; a < 3; ++a) job->out->flux[a][at] = flux[a];
    }
}

static ty_result allocate(ty_context* context, size_t cells, ty_cell_light* out) {
    out->context = context;
    out->cells = cells;
    out->fluence = ty_alloc_array(context, cells, sizeof(float), true);
    bool all = out->fluence != NULL;
    for (int a = 0; a < 3; ++a) {
        out->flux[a] = ty_alloc_array(context, cells, sizeof(float), true);
        all = all && out->flux[a] != NULL;
    }
    return all ? TY_OK : TY_ERROR_MEMORY;
}

void ty_cell_light_free(ty_cell_light* light) {
    ty_free_array(light->context, light->fluence, light->cells, sizeof(float));
    for (int a = 0; a < 3; ++a) ty_free_array(light->context, light->flux[a], light->cells, sizeof(float));
    *light = (ty_cell_light){.context = light->context};
}

/* Fluence and flux of a solution. */
static ty_result fill(const ty_dom* light, const ty_grid_box* box, ty_cell_light* out) {
    double* fluence = ty_alloc_array(light->context, out->cells, 3 * sizeof(double), false);
    if (fluence == NULL) return TY_ERROR_MEMORY;
    const ty_result result = ty_dom_fluence(light, box->lower, box->upper, box->size, fluence, NULL);
    for (size_t i = 0; i < out->cells && result == TY_OK; ++i)
        out->fluence[i] = (float)ty_luminance_f64(fluence + 3 * i);
    ty_free_array(light->context, fluence, out->cells, 3 * sizeof(double));
    flux_job job = {light, box, out};
    if (result == TY_OK) ty_parallel_for(light->context, (int64_t)box->size[1] * box->size[2], flux_of_row, &job);
    return result;
}

ty_result ty_dom_cell_light(const ty_scene* scene, const ty_grid_box* box, uint64_t seed, ty_cell_light* out) {
    const ty_dom_def def = coarse_def(scene, seed);
    ty_dom* light = NULL;
    *out = (ty_cell_light){.context = scene->context};
    ty_result result = ty_dom_solve(scene, &def, &light, NULL);
    if (result != TY_OK) return result;
    result = allocate(scene->context, (size_t)box->size[0] * (size_t)box->size[1] * (size_t)box->size[2], out);
    if (result == TY_OK) result = fill(light, box, out);
    if (result != TY_OK) ty_cell_light_free(out);
    ty_dom_destroy(light);
    return result;
}
