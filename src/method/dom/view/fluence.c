/* Fluence on a caller's cells, and radiance at a point. */
#include "base/constants.h"
#include "base/context.h"
#include "direct/media/coverage.h"
#include "direct/single/source_field.h"
#include "method/dom/solution.h"
#include "base/check.h"
#include "solve/angular/harmonics.h"

#include <math.h>

typedef struct fluence_job {
    const ty_dom* light;
    ty_coverage_box cells;
    double *fluence, *uncollided;
} fluence_job;

static double uncollided_in(const ty_dom* light, const ty_coverage axes[3], int c) {
    double sum = 0;
    for (int32_t l = 0; l < light->fluence_count; ++l) {
        float factor;
        const float* plane = ty_light_fluence_plane(&light->fluences[l], c, &factor);
        ty_coverage_add(&light->fine_box, axes, &plane, 1, (double)factor, &sum);
    }
    return sum;
}

/* Fluence of moments: of collided light, or of light from surfaces. */
static double moments_in(const ty_dom* light, float* const moments[3], const ty_coverage axes[3], int c) {
    const float* plane = moments[light->shared ? 0 : c];
    double sum = 0;
    if (plane == NULL) return 0;
    ty_coverage_add(&light->box, axes, &plane, 1, TY_SQRT_4PI_F64 * (double)light->color[c], &sum);
    return sum;
}

static void fill_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const fluence_job* job = user;
    const ty_dom* light = job->light;
    const int32_t* size = job->cells.size;
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        const size_t at = 3 * ((size_t)row * (size_t)size[0] + (size_t)i);
        ty_coverage fine[3], coarse[3];
        ty_coverage_of_cell(&light->fine_box, &job->cells, cell, fine);
        ty_coverage_of_cell(&light->box, &job->cells, cell, coarse);
        for (int c = 0; c < 3; ++c) {
            const double uncollided = uncollided_in(light, fine, c) + moments_in(light, light->wall_moments, coarse, c);
            job->fluence[at + (size_t)c] = uncollided + moments_in(light, light->moments, coarse, c);
            if (job->uncollided != NULL) job->uncollided[at + (size_t)c] = uncollided;
        }
    }
}

ty_result ty_dom_fluence(const ty_dom* light, const double lower[3], const double upper[3], const int32_t size[3],
                         double* fluence, double* uncollided) {
    const ty_coverage_box cells = {lower, upper, size};
    const ty_result result = ty_coverage_check(light->context, &cells);
    if (result != TY_OK) return result;
    fluence_job job = {light, cells, fluence, uncollided};
    ty_parallel_for(light->context, (int64_t)size[1] * size[2], fill_row, &job);
    return TY_OK;
}

/* ---- radiance ---- */

static bool is_outside(const ty_grid_box* box, const double point[3]) {
    for (int a = 0; a < 3; ++a)
        if (point[a] < box->lower[a] || point[a] > box->upper[a]) return true;
    return false;
}

/* Adds up the moments at a point along a unit direction. */
static void radiance_along(const ty_dom* light, const double point[3], const double direction[3], double radiance[3]) {
    const int32_t terms = light->output_bands * light->output_bands;
    const ty_cell_point position = ty_coverage_locate(&light->box, point);
    double y[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX];
    ty_harmonics_at(direction, light->output_bands, y);
    for (int32_t c = 0; c < 3; ++c) {
        float* moments = light->moments[light->shared ? 0 : c];
        double sum = 0;
        for (int32_t t = 0; t < terms; ++t)
            sum += (double)ty_cell_value(ty_dom_plane(light, moments, t), &position) * y[t];
        radiance[c] = (double)((float)sum * light->color[c]);
    }
}

ty_result ty_dom_radiance(const ty_dom* light, const double* rays, int64_t count, double* radiance) {
    const ty_result result = ty_check_rays(light->context, rays, count, radiance);
    if (result != TY_OK) return result;
    for (int64_t i = 0; i < count; ++i) {
        const double *point = rays + 6 * i, *w = point + 3;
        const double length = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
        const double direction[3] = {w[0] / length, w[1] / length, w[2] / length};
        double* out = radiance + 3 * i;
        out[0] = out[1] = out[2] = 0;
        if (!is_outside(&light->box, point)) radiance_along(light, point, direction, out);
    }
    return TY_OK;
}
