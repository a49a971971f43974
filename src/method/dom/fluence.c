/* Fluence on a caller's cells, and radiance at a point. */
#include "base/context.h"
#include "direct/cover.h"
#include "method/dom/job.h"
#include "scene/check.h"
#include "solve/angular/harmonics.h"

#include <string.h>

static const double sqrt_four_pi = 3.5449077018110318;

typedef struct fluence_job {
    const ty_dom* light;
    ty_cover_box cells;
    double *fluence, *uncollided;
} fluence_job;

static double uncollided_in(const ty_dom* light, const ty_cover axes[3], int c) {
    double sum = 0;
    for (int32_t l = 0; l < light->light_count; ++l) {
        float factor;
        const float* plane = ty_single_plane(&light->lights[l], c, &factor);
        ty_cover_add(&light->fine_box, axes, &plane, 1, (double)factor, &sum);
    }
    return sum;
}

/* Of moments of all channels: of what has scattered, or of what surfaces sent. */
static double moments_in(const ty_dom* light, float* const moments[3], const ty_cover axes[3], int c) {
    const float* plane = moments[light->shared ? 0 : c];
    double sum = 0;
    if (plane == NULL) return 0;
    ty_cover_add(&light->box, axes, &plane, 1, sqrt_four_pi * (double)light->color[c], &sum);
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
        ty_cover fine[3], coarse[3];
        ty_cover_cell(&light->fine_box, &job->cells, cell, fine);
        ty_cover_cell(&light->box, &job->cells, cell, coarse);
        for (int c = 0; c < 3; ++c) {
            const double uncollided = uncollided_in(light, fine, c) + moments_in(light, light->surfaces, coarse, c);
            job->fluence[at + (size_t)c] = uncollided + moments_in(light, light->moments, coarse, c);
            if (job->uncollided != NULL) job->uncollided[at + (size_t)c] = uncollided;
        }
    }
}

ty_result ty_dom_fluence(const ty_dom* light, const double lower[3], const double upper[3], const int32_t size[3],
                         double* fluence, double* uncollided) {
    const ty_cover_box cells = {lower, upper, size};
    const ty_result result = ty_cover_check(light->context, &cells);
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

static ty_cell_point locate(const ty_grid_box* box, const double point[3]) {
    float cells[3];
    for (int a = 0; a < 3; ++a)
        cells[a] = (float)((point[a] - box->lower[a]) * box->size[a] / (box->upper[a] - box->lower[a]));
    return ty_cell_locate(box->size, ty_vec_load(cells));
}

ty_result ty_dom_radiance(const ty_dom* light, const double point[3], const float* directions, int32_t count,
                          float* radiance) {
    const ty_result result = ty_check_point(light->context, "dom: point", point);
    const int32_t terms = light->kept * light->kept;
    float moments[3][TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX];
    if (result != TY_OK) return result;
    memset(radiance, 0, 3 * sizeof *radiance * (size_t)count);
    if (is_outside(&light->box, point)) return TY_OK;
    const ty_cell_point place = locate(&light->box, point);
    for (int32_t c = 0; c < ty_dom_channels(light); ++c)
        for (int32_t t = 0; t < terms; ++t)
            moments[c][t] = ty_cell_value(ty_dom_plane(light, light->moments[c], t), &place);
    for (int32_t d = 0; d < count; ++d) {
        const float* way = directions + 3 * d;
        const double w[3] = {(double)way[0], (double)way[1], (double)way[2]};
        double y[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX];
        ty_harmonics_at(w, light->kept, y);
        for (int32_t c = 0; c < 3; ++c) {
            const float* of = moments[light->shared ? 0 : c];
            double sum = 0;
            for (int32_t t = 0; t < terms; ++t) sum += (double)of[t] * y[t];
            radiance[3 * d + c] = (float)sum * light->color[c];
        }
    }
    return TY_OK;
}
