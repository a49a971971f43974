/* Paths that estimate the fluxes of columns: through levels, absorbed in the column, and radiance in a direction. */
#ifndef TY_METHOD_PATH_TRACE_COLUMN_K_H
#define TY_METHOD_PATH_TRACE_COLUMN_K_H

#include "method/path/trace/path.k.h"

/* Kernels without fluxes know no columns. */
#ifndef TY_PATH_FLUXES
#define TY_PATH_FLUXES 1
#endif

TY_FN bool ty_path_takes_columns(const ty_path_request* request) {
    return TY_PATH_FLUXES != 0 && request->kind == TY_PATH_COLUMNS;
}

/* The quantity of an item: those of all levels, then absorption, then the radiance of all views. */
TY_FN int32_t ty_column_quantity(const ty_path_columns* columns, int64_t item) {
    return (int32_t)(item / ((int64_t)columns->size[0] * columns->size[1]));
}

/* True if only light that nothing has scattered or reflected belongs to an item. */
TY_FN bool ty_column_is_direct(const ty_path_columns* columns, int64_t item) {
    const int32_t quantity = ty_column_quantity(columns, item);
    return quantity < TY_COLUMN_LEVEL_QUANTITIES * columns->level_count &&
           quantity % TY_COLUMN_LEVEL_QUANTITIES == TY_COLUMN_DOWN_DIRECT;
}

/* The request of paths for direct light: media only attenuate, and a reflection is the end. */
TY_FN void ty_column_request_direct(const ty_path_request* request, ty_path_request* out) {
    *out = *request;
    out->unscattered = 1;
    out->max_depth = 1;
}

TY_FN void ty_column_keep_direct(ty_path* path) {
    for (int32_t path_class = 0; path_class < TY_PATH_CLASS_COUNT; ++path_class)
        for (int c = 0; c < 3 && path_class != TY_PATH_UNCOLLIDED; ++c) path->radiance[path_class][c] = 0.0f;
}

/* A point, uniform over the cross section of an item's column, at a height. */
TY_FN ty_vec ty_column_point(ty_path* path, const ty_path_columns* columns, int64_t item, double height) {
    float point[3];
    int64_t rest = item;
    for (int i = 0; i < 2; ++i) {
        const int64_t index = rest % columns->size[i];
        rest /= columns->size[i];
        point[columns->axis[i]] =
            (float)(columns->lower[i] + columns->cell[i] * ((double)index + (double)ty_sobol_next(&path->random)));
    }
    point[columns->axis[2]] = (float)height;
    return ty_vec_make(point[0], point[1], point[2]);
}

/* Absorption coefficient of all media at a point, 1/m. along: any direction. */
TY_FN void ty_column_absorption(ty_path* path, ty_vec point, ty_vec along, float near, float sigma_a[3]) {
    ty_spans spans;
    for (int c = 0; c < 3; ++c) sigma_a[c] = 0.0f;
    ty_spans_find(path->media, path->medium_count, point, along, near, &spans);
    for (int32_t i = 0; i < spans.count; ++i) {
        const ty_medium_view* medium = &path->media[spans.medium[i]];
        float sigma_s[3];
        if (spans.enter[i] > 0.0f) continue;
        const float density = ty_medium_density(medium, point, &path->random);
        ty_medium_sigma_s(medium, point, sigma_s);
        for (int c = 0; c < 3; ++c) sigma_a[c] += density * ty_maxf(medium->sigma_t[c] - sigma_s[c], 0.0f);
    }
}

/* Starts a path that estimates the flux through a level from the side of `normal`, the integral of radiance times
 * cosine, W m^-2. pdf: density of sampled directions over cosine / pi, for the MIS weight of light samples: 0 or 1. */
TY_FN void ty_path_begin_flux(ty_path* path, ty_vec point, ty_vec normal, bool lit, float pdf) {
    ty_light_sample sample;
    float chosen;
    bool shines = false;
    path->origin = point;
    path->normal = normal;
    const int32_t light = lit ? ty_path_sample_light(path, point, &chosen, &sample, &shines) : -1;
    const float cosine = shines ? ty_dot(normal, sample.wi) : 0.0f;
    if (cosine > 0.0f) {
        const float factor[3] = {cosine, cosine, cosine};
        ty_path_add_vertex_light(path, &path->request->scene->lights.lights[light], chosen, &sample, factor,
                                 pdf * cosine * (1.0f / TY_PI), 0.0f);
    }
    ty_path_sample_cosine_hemisphere(path);
    for (int c = 0; c < 3; ++c) path->beta[c] = pdf > 0.0f ? TY_PI : 0.0f;
}

TY_FN_CALLED void ty_path_begin_column(ty_path* path, const ty_path_columns* columns, int64_t item) {
    const int32_t quantity = ty_column_quantity(columns, item);
    const int32_t level_quantities = TY_COLUMN_LEVEL_QUANTITIES * columns->level_count;
    const float up[3] = {0.0f, columns->axis[2] == 1 ? 1.0f : 0.0f, columns->axis[2] == 2 ? 1.0f : 0.0f};
    if (quantity < level_quantities) {
        const int32_t kind = quantity % TY_COLUMN_LEVEL_QUANTITIES;
        const ty_vec point =
            ty_column_point(path, columns, item, columns->levels[quantity / TY_COLUMN_LEVEL_QUANTITIES]);
        const ty_vec normal = ty_scale(ty_vec_load(up), kind == TY_COLUMN_UP ? -1.0f : 1.0f);
        /* Direct light of lights without extent is that of light samples alone. */
        const bool sampled = kind == TY_COLUMN_DOWN_DIRECT && columns->extended == 0;
        ty_path_begin_flux(path, point, normal, kind != TY_COLUMN_DOWN_DIFFUSE, sampled ? 0.0f : 1.0f);
        if (kind == TY_COLUMN_DOWN_DIFFUSE) path->found = TY_FOUND_ALL;
    } else if (quantity == level_quantities) {
        const double height = columns->absorbing[1] - columns->absorbing[0];
        const ty_vec at = ty_column_point(path, columns, item,
                                          columns->absorbing[0] + height * (double)ty_rng_uniform(&path->random));
        float sigma_a[3];
        const ty_vec point =
            path->request->scene->periodic.axes != 0 ? ty_periodic_point(&path->request->scene->periodic, at) : at;
        ty_column_absorption(path, point, ty_vec_load(up), 1e-4f * (float)height, sigma_a);
        for (int c = 0; c < 3; ++c) sigma_a[c] *= (float)height;
        ty_path_begin_fluence(path, point, sigma_a);
    } else {
        const int32_t view = quantity - level_quantities - 1;
        path->origin = ty_column_point(path, columns, item, columns->view_levels[view]);
        path->direction = ty_vec_load(columns->views + 3 * view);
    }
}

#endif
