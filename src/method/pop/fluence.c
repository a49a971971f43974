/* Fluence on a caller's grid, and radiance at a point. */
#include "base/constants.h"
#include "base/context.h"
#include "direct/media/coverage.h"
#include "direct/single/source_field.h"
#include "method/pop/solution.h"
#include "base/check.h"

#include <math.h>

/* Sample points per axis of a caller's cell for the ordinates' uncollided fluence. */
enum { POINTS = 2 };

typedef struct fluence_job {
    const ty_pop* light;
    ty_coverage_box cells;
    double *fluence, *uncollided;
} fluence_job;

/* Adds the fine-grid lights: fluence in their forward lobes, and uncollided fluence. */
static void add_fine_lights(const fluence_job* job, const int32_t cell[3], int c, double* fluence, double* uncollided) {
    const ty_pop* light = job->light;
    ty_coverage axes[3];
    ty_coverage_of_cell(&light->fine_box, &job->cells, cell, axes);
    for (int32_t l = 0; l < light->light_count; ++l) {
        const ty_light_fluence* single = &light->lights[l];
        const int32_t plane = single->shared != 0 ? 0 : c;
        const float* forward_fluence = single->fluence[plane];
        const float* uncollided_fluence = single->lobe_order != 0 ? single->unscattered[plane] : forward_fluence;
        ty_coverage_add(&light->fine_box, axes, &forward_fluence, 1, (double)single->color[c], fluence);
        ty_coverage_add(&light->fine_box, axes, &uncollided_fluence, 1, (double)single->color[c], uncollided);
    }
}

/* Adds the ordinates' uncollided fluence, averaged over sample points of the cell. */
static void add_uncollided(const fluence_job* job, const int32_t cell[3], double uncollided[3]) {
    const ty_pop* light = job->light;
    for (int p = 0; p < POINTS * POINTS * POINTS; ++p) {
        const int position[3] = {p % POINTS, p / POINTS % POINTS, p / (POINTS * POINTS)};
        float point[3], scattered[3] = {0}, uncollided_fluence[3] = {0};
        for (int a = 0; a < 3; ++a)
            point[a] = (float)(job->cells.lower[a] + (job->cells.upper[a] - job->cells.lower[a]) *
                                                         (cell[a] + (position[a] + 0.5) / POINTS) / job->cells.size[a]);
        for (int32_t i = 0; i < light->count; ++i)
            ty_pop_light_radiance(light->medium, &light->ordinates[i], ty_vec_load(point), ty_vec_make(0, 0, 1),
                                  scattered, uncollided_fluence);
        for (int c = 0; c < 3; ++c) uncollided[c] += (double)uncollided_fluence[c] / (POINTS * POINTS * POINTS);
    }
}

/* Adds one channel's light on merged cells: ordinates, residuum, diffusion. */
static void add_merged(const ty_pop* light, const ty_coverage axes[3], int c, double* fluence) {
    const float* planes[] = {light->merged.fluence[c], light->residuum.fluence[c]};
    for (int i = 0; i < 2; ++i)
        if (planes[i] != NULL) ty_coverage_add(&light->merged.box, axes, &planes[i], 1, 1, fluence);
    if (light->diffuse == NULL) return;
    const bool shared = light->diffuse->shared;
    const float* diffuse = light->diffuse->terms[shared ? 0 : c][0];
    ty_coverage_add(&light->merged.box, axes, &diffuse, 1,
                    4 * TY_PI_F64 * (shared ? (double)light->diffuse->color[c] : 1), fluence);
}

static void fill_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const fluence_job* job = user;
    const int32_t* size = job->cells.size;
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        double fluence[3] = {0}, uncollided[3] = {0};
        ty_coverage axes[3];
        ty_coverage_of_cell(&job->light->merged.box, &job->cells, cell, axes);
        for (int c = 0; c < 3; ++c) {
            add_merged(job->light, axes, c, &fluence[c]);
            add_fine_lights(job, cell, c, &fluence[c], &uncollided[c]);
        }
        if (job->uncollided != NULL) add_uncollided(job, cell, uncollided);
        const size_t index = 3 * ((size_t)row * (size_t)size[0] + (size_t)i);
        memcpy(job->fluence + index, fluence, sizeof fluence);
        if (job->uncollided != NULL) memcpy(job->uncollided + index, uncollided, sizeof uncollided);
    }
}

static ty_result check_lobes(const ty_pop* light, const char* what) {
    if (light->def.keep_lobes || light->count == 0) return TY_OK;
    return ty_fail(light->context, TY_ERROR_ARGUMENT, "pop: %s needs lobes, and they were not kept (keep_lobes)", what);
}

ty_result ty_pop_fluence(const ty_pop* light, const double lower[3], const double upper[3], const int32_t size[3],
                         double* fluence, double* uncollided) {
    const ty_coverage_box cells = {lower, upper, size};
    ty_result result = ty_coverage_check(light->context, &cells);
    if (result == TY_OK && uncollided != NULL) result = check_lobes(light, "uncollided fluence");
    if (result != TY_OK) return result;
    fluence_job job = {light, cells, fluence, uncollided};
    ty_parallel_for(light->context, (int64_t)size[1] * size[2], fill_row, &job);
    return TY_OK;
}

/* ---- radiance ---- */

static ty_cell_point locate(const ty_grid_box* box, ty_vec point) {
    const double position[3] = {(double)point.x, (double)point.y, (double)point.z};
    return ty_coverage_locate(box, position);
}

/* Adds the forward-scattered radiance of fine-grid lights. */
static void add_fine_radiance(const ty_pop* light, ty_vec point, ty_vec direction, float radiance[3]) {
    static const float ones[TY_FLUENCE_COUNT][3] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
    /* A phase function of unit moments leaves the lobe's own radiance. */
    static const float unit_lobe[3] = {1, 1, 1};
    static const ty_forward_fit none = {.bands = 0};
    const ty_cell_point position = locate(&light->fine_box, point);
    for (int32_t l = 0; l < light->light_count; ++l) {
        ty_single_radiance sent = {{0}, {0}, {0}};
        if (light->lights[l].lobe_order == 0) continue;
        ty_single_with_lobe(&light->lights[l], &position, ty_light_fluence_cosine(&light->lights[l], point, direction),
                            1.0f, ones, unit_lobe, NULL, &none, &sent);
        for (int c = 0; c < 3; ++c) radiance[c] += sent.again[c];
    }
}

static void add_diffuse_radiance(const ty_pop* light, ty_vec point, ty_vec direction, float radiance[3]) {
    const ty_diffuse_light* diffuse = light->diffuse;
    const ty_cell_point position = locate(&diffuse->box, point);
    for (int c = 0; c < 3; ++c) {
        float* const* terms = diffuse->terms[diffuse->shared ? 0 : c];
        const float factor = diffuse->shared ? diffuse->color[c] : 1;
        radiance[c] += factor * (ty_cell_value(terms[0], &position) + ty_cell_value(terms[1], &position) * direction.x +
                                 ty_cell_value(terms[2], &position) * direction.y +
                                 ty_cell_value(terms[3], &position) * direction.z);
    }
}

static void add_residuum(const ty_pop* light, ty_vec point, float radiance[3]) {
    const ty_cell_point position = locate(&light->residuum.box, point);
    for (int c = 0; c < 3; ++c) radiance[c] += ty_cell_value(light->residuum.accumulated_radiance[c], &position);
}

ty_result ty_pop_radiance(const ty_pop* light, const double* rays, int64_t count, double* radiance) {
    ty_result result = check_lobes(light, "radiance");
    if (result == TY_OK) result = ty_check_rays(light->context, rays, count, radiance);
    if (result != TY_OK) return result;
    for (int64_t i = 0; i < count; ++i) {
        const double *point = rays + 6 * i, *w = point + 3;
        const double length = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
        const ty_vec position = ty_vec_make((float)point[0], (float)point[1], (float)point[2]);
        const ty_vec direction = ty_vec_make((float)(w[0] / length), (float)(w[1] / length), (float)(w[2] / length));
        float out[3] = {0, 0, 0};
        for (int32_t o = 0; o < light->count; ++o)
            ty_pop_light_radiance(light->medium, &light->ordinates[o], position, direction, out, NULL);
        add_fine_radiance(light, position, direction, out);
        if (light->diffuse != NULL) add_diffuse_radiance(light, position, direction, out);
        if (light->residuum.accumulated_radiance[0] != NULL) add_residuum(light, position, out);
        for (int c = 0; c < 3; ++c) radiance[3 * i + c] = (double)ty_maxf(0, out[c]);
    }
    return TY_OK;
}
