#include "method/gradient/gradient.h"

#include "base/context.h"
#include "direct/uncollided/point_light_adjoint.h"
#include "scene/scene.h"

#include <string.h>

/* ---- making ---- */

ty_result ty_gradient_create(const ty_scene* scene, ty_grid_medium* medium, ty_gradient** out) {
    ty_context* context = medium->context;
    ty_gradient* gradient = ty_alloc_array(context, 1, sizeof *gradient, true);
    if (gradient == NULL) {
        ty_grid_medium_destroy(medium);
        return TY_ERROR_MEMORY;
    }
    gradient->context = context;
    gradient->medium = medium;
    gradient->light_count = ty_scene_get_view(scene)->lights.count;
    gradient->lights = ty_alloc_array(context, (size_t)gradient->light_count, sizeof *gradient->lights, true);
    const ty_result result = ty_medium_gradient_make(medium, &gradient->media);
    if (result != TY_OK || gradient->lights == NULL) {
        ty_gradient_destroy(gradient);
        return TY_ERROR_MEMORY;
    }
    *out = gradient;
    return TY_OK;
}

void ty_gradient_destroy(ty_gradient* gradient) {
    if (gradient == NULL) return;
    ty_medium_gradient_free(&gradient->media);
    ty_grid_medium_destroy(gradient->medium);
    ty_free_array(gradient->context, gradient->lights, (size_t)gradient->light_count, sizeof *gradient->lights);
    ty_free_array(gradient->context, gradient, 1, sizeof *gradient);
}

static ty_result check_scene(const ty_scene* scene, const char* method, bool points) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    if (view->mesh != NULL)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "gradient: %s is not differentiated in scenes with surfaces",
                       method);
    for (int32_t i = 0; i < view->lights.count; ++i)
        if (!points && view->lights.lights[i].kind != TY_KIND_DIRECTIONAL &&
            view->lights.lights[i].kind != TY_KIND_ENVIRONMENT)
            return ty_fail(scene->context, TY_ERROR_ARGUMENT,
                           "gradient: lights[%d]: %s is differentiated for directional lights and environments alone",
                           (int)i, method);
    for (int32_t m = 0; m < view->medium_count; ++m)
        if (view->media[m].emits != 0)
            return ty_fail(scene->context, TY_ERROR_ARGUMENT,
                           "gradient: media[%d].emission: %s is not differentiated for media that emit", (int)m,
                           method);
    return TY_OK;
}

ty_result ty_gradient_begin(const ty_scene* scene, const ty_volume_method* method, const void* def, void* own,
                            bool points, const ty_coverage_box* cells, const ty_gradient_stats* stats,
                            ty_gradient_stats* totals) {
    ty_context* context = ty_scene_context(scene);
    ty_result result = ty_volume_take_def(method, context, def, own);
    if (result == TY_OK) result = ty_take_stats(context, stats, "ty_default_gradient_stats", totals, sizeof *totals);
    if (result == TY_OK) result = check_scene(scene, method->name, points);
    if (result == TY_OK) result = ty_coverage_check(context, cells);
    return result;
}

/* True if a channel's weights are those of the first one. */
static bool has_first_weights(const double* weights, size_t cells, size_t channel) {
    size_t i = 0;
    while (i < cells && weights[3 * i + channel] == weights[3 * i]) ++i;
    return i == cells;
}

void ty_gradient_spread_weights(const ty_coverage_box* cells, const double* weights, const ty_grid_box* box,
                                float* const planes[3]) {
    const int32_t* size = cells->size;
    const size_t count = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    const bool gray = has_first_weights(weights, count, 1) && has_first_weights(weights, count, 2);
    size_t at = 0;
    for (int32_t k = 0; k < size[2]; ++k)
        for (int32_t j = 0; j < size[1]; ++j)
            for (int32_t i = 0; i < size[0]; ++i, at += 3) {
                const int32_t cell[3] = {i, j, k};
                ty_coverage axes[3];
                ty_coverage_of_cell(box, cells, cell, axes);
                for (size_t c = 0; c < (gray ? 1 : 3); ++c)
                    if (weights[at + c] != 0) ty_coverage_spread(box, axes, weights[at + c], planes[c]);
            }
    const size_t of_box = (size_t)box->size[0] * (size_t)box->size[1] * (size_t)box->size[2];
    for (int c = 1; c < 3 && gray; ++c) memcpy(planes[c], planes[0], sizeof(float) * of_box);
}

ty_result ty_gradient_add_uncollided(ty_gradient* gradient, const ty_scene* scene, const ty_discrete_light_set* sources,
                                     float* const extinction[3], float* const weight[3], float* const by_extinction[3],
                                     ty_part_progress* progress) {
    const ty_grid_medium* medium = gradient->medium;
    const int32_t channels = medium->planes == 3 ? 1 : 3;
    ty_result result = TY_OK;
    for (int32_t p = 0; p < medium->planes && result == TY_OK; ++p) {
        ty_uncollided_loss loss = {.sources = sources->items,
                                   .count = sources->count,
                                   .extinction = extinction[p],
                                   .first = p,
                                   .channels = channels,
                                   .progress = progress};
        float multiples[3] = {1, 1, 1};
        for (int32_t c = 0; c < channels; ++c) loss.weight[c] = weight[p + c];
        if (channels == 3 && ty_is_multiple(weight[1], weight[0], medium->cells, &multiples[1]) &&
            ty_is_multiple(weight[2], weight[0], medium->cells, &multiples[2])) {
            loss.channels = 1;
            loss.multiples = multiples;
        }
        result = ty_collimated_adjoint(medium, &loss, by_extinction[p], gradient->lights);
        if (result == TY_OK)
            result =
                ty_point_light_adjoint(ty_scene_get_view(scene), medium, &loss, by_extinction[p], gradient->lights);
    }
    return result;
}

/* ---- reading ---- */

int32_t ty_gradient_planes(const ty_gradient* gradient) {
    return gradient->media.planes;
}

void ty_gradient_box(const ty_gradient* gradient, double lower[3], double upper[3], int32_t size[3]) {
    const ty_grid_box* box = &gradient->medium->box;
    memcpy(lower, box->lower, sizeof box->lower);
    memcpy(upper, box->upper, sizeof box->upper);
    memcpy(size, box->size, sizeof box->size);
}

/* The derivative by sigma_s of a cell at constant sigma_t and g. */
static double by_scattering(const ty_gradient* gradient, int32_t plane, size_t i) {
    return (double)gradient->media.scattering[plane][i] +
           (double)gradient->medium->g[plane][i] * (double)gradient->media.scattering_g[plane][i];
}

ty_result ty_gradient_cells(const ty_gradient* gradient, ty_gradient_coefficient coefficient, int32_t plane,
                            double* values) {
    const ty_grid_medium* medium = gradient->medium;
    if (plane < 0 || plane >= gradient->media.planes || coefficient < TY_GRADIENT_EXTINCTION ||
        coefficient > TY_GRADIENT_G)
        return ty_fail(gradient->context, TY_ERROR_ARGUMENT, "gradient: there is no plane %d of coefficient %d",
                       (int)plane, (int)coefficient);
    for (size_t i = 0; i < medium->cells; ++i) {
        const double extinction = (double)medium->extinction[plane][i],
                     scattering = (double)medium->scattering[plane][i];
        if (coefficient == TY_GRADIENT_EXTINCTION)
            values[i] = (double)gradient->media.extinction[plane][i] +
                        (extinction > 0 ? scattering / extinction * by_scattering(gradient, plane, i) : 0);
        if (coefficient == TY_GRADIENT_ALBEDO) values[i] = extinction * by_scattering(gradient, plane, i);
        if (coefficient == TY_GRADIENT_G) values[i] = scattering * (double)gradient->media.scattering_g[plane][i];
    }
    return TY_OK;
}

/* A medium of the scene whose coefficients are in proportion to its density. */
static ty_result check_medium(const ty_gradient* gradient, const ty_scene* scene, int32_t medium,
                              const ty_medium_view** out) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    if (medium < 0 || medium >= view->medium_count)
        return ty_fail(gradient->context, TY_ERROR_ARGUMENT, "gradient: there is no media[%d]", (int)medium);
    *out = &view->media[medium];
    if ((*out)->albedo_fields != 0 || (*out)->transfer_albedo != 0 || (*out)->has_g_field != 0)
        return ty_fail(gradient->context, TY_ERROR_ARGUMENT,
                       "gradient: media[%d]: its albedo or g varies in space; there are derivatives of cells alone",
                       (int)medium);
    return TY_OK;
}

ty_result ty_gradient_density_size(const ty_scene* scene, int32_t medium, int32_t size[3]) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    for (int a = 0; a < 3; ++a) size[a] = 0;
    if (view == NULL) return TY_ERROR_ARGUMENT;
    if (medium < 0 || medium >= view->medium_count)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "gradient: there is no media[%d]", (int)medium);
    if (view->media[medium].has_grid != 0) memcpy(size, view->media[medium].grid.size, 3 * sizeof *size);
    return TY_OK;
}

ty_result ty_gradient_density(const ty_gradient* gradient, const ty_scene* scene, int32_t medium, double* voxels) {
    const ty_grid_medium* cells = gradient->medium;
    const ty_medium_view* view;
    ty_result result = check_medium(gradient, scene, medium, &view);
    if (result != TY_OK) return result;
    if (view->has_grid == 0)
        return ty_fail(gradient->context, TY_ERROR_ARGUMENT, "gradient: media[%d].density: it has no voxels",
                       (int)medium);
    double* by_density = ty_alloc_array(gradient->context, cells->cells, sizeof *by_density, true);
    if (by_density == NULL) return TY_ERROR_MEMORY;
    for (int32_t p = 0; p < cells->planes; ++p) {
        const double extinction = (double)view->sigma_t[p], scattering = (double)view->sigma_s[p];
        const double scattering_g = (double)(view->sigma_s[p] * view->g[p]);
        for (size_t i = 0; i < cells->cells; ++i)
            by_density[i] += extinction * (double)gradient->media.extinction[p][i] +
                             scattering * (double)gradient->media.scattering[p][i] +
                             scattering_g * (double)gradient->media.scattering_g[p][i];
    }
    const size_t count = (size_t)view->grid.size[0] * (size_t)view->grid.size[1] * (size_t)view->grid.size[2];
    memset(voxels, 0, count * sizeof *voxels);
    result = ty_grid_medium_spread_density(scene, medium, gradient->medium, by_density, voxels);
    ty_free_array(gradient->context, by_density, cells->cells, sizeof *by_density);
    return result;
}

ty_result ty_gradient_medium(const ty_gradient* gradient, const ty_scene* scene, int32_t medium, double sigma_s[3],
                             double sigma_a[3], double g[3]) {
    const ty_medium_view* view;
    ty_grid_medium* density = NULL;
    ty_result result = check_medium(gradient, scene, medium, &view);
    if (result == TY_OK) result = ty_grid_medium_density(scene, medium, &gradient->medium->box, &density);
    if (result != TY_OK) return result;
    const double factor = (double)scene->media[medium].scale;
    for (int32_t p = 0; p < gradient->media.planes; ++p) {
        double extinction = 0, scattering = 0, scattering_g = 0;
        for (size_t i = 0; i < density->cells; ++i) {
            const double here = (double)density->extinction[0][i];
            extinction += here * (double)gradient->media.extinction[p][i];
            scattering += here * (double)gradient->media.scattering[p][i];
            scattering_g += here * (double)gradient->media.scattering_g[p][i];
        }
        sigma_s[p] = factor * (extinction + scattering + (double)view->g[p] * scattering_g);
        sigma_a[p] = factor * extinction;
        g[p] = (double)view->sigma_s[p] * scattering_g;
    }
    ty_grid_medium_destroy(density);
    return TY_OK;
}

ty_result ty_gradient_light(const ty_gradient* gradient, int32_t light, double factor[3]) {
    if (light < 0 || light >= gradient->light_count)
        return ty_fail(gradient->context, TY_ERROR_ARGUMENT, "gradient: there is no lights[%d]", (int)light);
    memcpy(factor, gradient->lights[light], sizeof gradient->lights[light]);
    return TY_OK;
}
