/* Rays several pixels apart, and the pixels between them. */
#ifndef TY_IMAGE_SPACED_K_H
#define TY_IMAGE_SPACED_K_H

#include "image/march/pixel.k.h"
#include "image/march/similarity.k.h"
#include "image/march/spaced.h"

/* Range of the radiance of the rays around a pixel, relative to the pixel's, above which the pixel gets a ray of its
 * own. */
#define TY_SPACED_CONTRAST 0.25f
/* Error of the distance that is interpolated, relative to the distance and for opaque media, above which it gets one,
 * too. */
#define TY_SPACED_DISTANCE_ERROR 0.01f
/* Cosine between the normals of surfaces at which the irradiance of one no longer counts for the other. */
#define TY_SPACED_COSINE 0.7f

/* ---- rays ---- */

TY_FN int32_t ty_spaced_pixel(int32_t ray, int32_t spacing, int32_t pixels) {
    return ray * spacing < pixels ? ray * spacing : pixels - 1;
}

TY_FN ty_vec ty_spaced_direction(TY_GLOBAL const ty_march_request* request, int32_t x, int32_t y, int32_t sample) {
    float dx, dy;
    ty_pixel_place(sample, request->spp, &dx, &dy);
    return ty_camera_direction(&request->camera, (float)x + dx, (float)y + dy);
}

TY_FN uint32_t ty_spaced_follow(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, ty_vec direction,
                                float offset, ty_spaced_ray* out) {
    const ty_accel* mesh = request->scene->mesh;
    const ty_vec origin = request->camera.origin;
    ty_hit hit;
    const bool hits = mesh != NULL && ty_accel_intersect(mesh, origin, direction, TY_FLOAT_MAX, &hit);
    memset(out, 0, sizeof *out);
    out->distance = hits ? hit.distance : TY_FLOAT_MAX;
    ty_march_follow(ray, request, origin, direction, out->distance, offset, 1.0f);
    uint32_t steps = ray->steps;
    const ty_march_light* light = &ray->light;
    for (int c = 0; c < 3; ++c) {
        out->transmittance[c] = light->transmittance[c];
        out->emission[c] = light->emission[c];
        out->single[c] = light->single[c];
        out->multiple[c] = light->multiple[c];
    }
    if (!hits) {
        if (request->blurred != NULL) ty_pixel_add_blurred(request, direction, light, out->multiple);
        return steps;
    }
    const ty_vec cells = ty_cell_coordinates(&request->surface_field.lattice, hit.position);
    if (request->has_field == 0 || ty_cell_inside(&request->surface_field.lattice, cells)) return steps;
    ty_surface_point point;
    ty_surface_evaluate(&request->scene->surfaces[hit.surface], &hit, direction, &point);
    if (!ty_reflect_is_visible(&point, out->transmittance)) return steps;
    steps += ty_reflect_gather(request, ray, ty_hit_leave(&hit, point.ng), point.ng, point.ns, TY_REFLECT_RAYS_SPACED,
                               offset, out->irradiance);
    out->gathered = 1;
    out->normal = point.ns;
    return steps;
}

/* Marches ray `column` of row `row`, the sample-th of its pixel; returns the number of steps. */
TY_FN uint32_t ty_spaced_march(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray,
                               TY_GLOBAL const ty_spaced_rays* lattice, int32_t sample, int32_t column, int32_t row) {
    const int32_t x = ty_spaced_pixel(column, lattice->spacing, lattice->width);
    const int32_t y = ty_spaced_pixel(row, lattice->spacing, lattice->height);
    return ty_spaced_follow(request, ray, ty_spaced_direction(request, x, y, sample),
                            ty_pixel_offset(request, column, row, sample, request->spp),
                            &lattice->rays[(size_t)row * (size_t)lattice->columns + (size_t)column]);
}

/* ---- pixels ---- */

/* The four rays around a pixel, and their weights. */
typedef struct ty_spaced_neighbours {
    const ty_spaced_ray* rays[4];
    float weight[4];
} ty_spaced_neighbours;

/* The ray before a pixel along one axis, and the weight of the next. */
TY_FN float ty_spaced_between(int32_t pixel, int32_t spacing, int32_t pixels, int32_t* first) {
    *first = pixel / spacing;
    const int32_t from = ty_spaced_pixel(*first, spacing, pixels), to = ty_spaced_pixel(*first + 1, spacing, pixels);
    return to > from ? (float)(pixel - from) / (float)(to - from) : 0.0f;
}

/* Bilinear weights; rays without weight are not read. */
TY_FN void ty_spaced_find(TY_GLOBAL const ty_spaced_rays* lattice, int32_t x, int32_t y, ty_spaced_neighbours* around) {
    int32_t column, row;
    const float along = ty_spaced_between(x, lattice->spacing, lattice->width, &column);
    const float down = ty_spaced_between(y, lattice->spacing, lattice->height, &row);
    const ty_spaced_ray* first = lattice->rays + (size_t)row * (size_t)lattice->columns + column;
    const size_t right = along > 0.0f ? 1 : 0, below = down > 0.0f ? (size_t)lattice->columns : 0;
    for (size_t i = 0; i < 4; ++i) {
        around->rays[i] = first + (i & 1) * right + (i >> 1) * below;
        around->weight[i] = ((i & 1) != 0 ? along : 1.0f - along) * ((i >> 1) != 0 ? down : 1.0f - down);
    }
}

/* Scales weights so that they sum to 1; false: the rays around the pixel do not represent it. */
TY_FN bool ty_spaced_normalise(float weight[4]) {
    const float sum = (weight[0] + weight[1]) + (weight[2] + weight[3]);
    if (!(sum >= TY_SIMILARITY_WEIGHT_MIN)) return false;
    for (int i = 0; i < 4; ++i) weight[i] *= 1.0f / sum;
    return true;
}

/* The media in front of a pixel. */
TY_FN bool ty_spaced_media(ty_spaced_neighbours* around, float distance, ty_spaced_ray* out) {
    for (int i = 0; i < 4; ++i)
        if (around->weight[i] > 0.0f) around->weight[i] *= ty_similarity(distance, around->rays[i]->distance);
    if (!ty_spaced_normalise(around->weight)) return false;
    out->distance = 0.0f;
    for (int c = 0; c < 3; ++c) out->transmittance[c] = out->emission[c] = out->single[c] = out->multiple[c] = 0.0f;
    for (int i = 0; i < 4; ++i) {
        if (around->weight[i] > 0.0f) out->distance += around->weight[i] * around->rays[i]->distance;
        for (int c = 0; c < 3; ++c) {
            const float weight = around->weight[i];
            out->transmittance[c] += weight * around->rays[i]->transmittance[c];
            out->emission[c] += weight * around->rays[i]->emission[c];
            out->single[c] += weight * around->rays[i]->single[c];
            out->multiple[c] += weight * around->rays[i]->multiple[c];
        }
    }
    const float* passed = out->transmittance;
    const float opacity = 1.0f - ty_minf(passed[0], ty_minf(passed[1], passed[2]));
    return !(distance < TY_FLOAT_MAX) ||
           opacity * fabsf(out->distance - distance) <= TY_SPACED_DISTANCE_ERROR * distance;
}

/* The media's irradiance on a surface outside of the field. */
TY_FN bool ty_spaced_irradiance(const ty_spaced_neighbours* around, ty_vec normal, float irradiance[3]) {
    float weight[4];
    for (int i = 0; i < 4; ++i) {
        const ty_spaced_ray* ray = around->rays[i];
        const float cosine = ray->gathered != 0 ? ty_dot(ray->normal, normal) : 0.0f;
        weight[i] = around->weight[i] * ty_maxf(0.0f, (cosine - TY_SPACED_COSINE) * (1.0f / (1.0f - TY_SPACED_COSINE)));
    }
    if (!ty_spaced_normalise(weight)) return false;
    for (int c = 0; c < 3; ++c) {
        irradiance[c] = 0.0f;
        for (int i = 0; i < 4; ++i) irradiance[c] += weight[i] * around->rays[i]->irradiance[c];
    }
    return true;
}

TY_FN float ty_spaced_sum(const float values[3]) {
    return values[0] + values[1] + values[2];
}

/* True if the rays around a pixel ty_spaced_differ too much to be interpolated; behind: radiance behind the media. */
TY_FN bool ty_spaced_differ(const ty_spaced_neighbours* around, const ty_spaced_ray* mean, const float behind[3]) {
    float min = TY_FLOAT_MAX, max = 0.0f, level = 0.0f;
    for (int i = -1; i < 4; ++i) {
        const ty_spaced_ray* ray = i < 0 ? mean : around->rays[i];
        float light = ty_spaced_sum(ray->emission) + ty_spaced_sum(ray->single) + ty_spaced_sum(ray->multiple);
        for (int c = 0; c < 3; ++c) light += ray->transmittance[c] * behind[c];
        if (i < 0) {
            level = light;
        } else if (around->weight[i] > 0.0f) {
            min = ty_minf(min, light);
            max = ty_maxf(max, light);
        }
    }
    return max - min > TY_SPACED_CONTRAST * level;
}

/* Radiance behind the media: of the environment, or reflected by the surface. False: the rays around do not tell. */
TY_FN bool ty_spaced_behind(TY_GLOBAL const ty_march_request* request, const ty_spaced_neighbours* around,
                            ty_vec direction, const ty_hit* hit, float behind[3]) {
    static const float clear[3] = {1.0f, 1.0f, 1.0f};
    for (int c = 0; c < 3; ++c) behind[c] = 0.0f;
    if (hit == NULL) {
        if (request->has_background != 0) ty_pixel_add_environment(request, direction, clear, behind);
        return true;
    }
    ty_surface_point point;
    float irradiance[3];
    if (request->has_field == 0) return true;
    ty_surface_evaluate(&request->scene->surfaces[hit->surface], hit, direction, &point);
    if (!ty_reflect_is_visible(&point, clear)) return true;
    const ty_vec cells = ty_cell_coordinates(&request->surface_field.lattice, hit->position);
    if (ty_cell_inside(&request->surface_field.lattice, cells))
        ty_upsample_irradiance(&request->surface_field, cells, point.ns, irradiance);
    else if (!ty_spaced_irradiance(around, point.ns, irradiance))
        return false;
    for (int c = 0; c < 3; ++c) behind[c] = point.albedo[c] * (1.0f / TY_PI) * irradiance[c];
    return true;
}

/* Adds a pixel from the rays around it; false: it needs one of its own. */
TY_FN bool ty_spaced_interpolate(TY_GLOBAL const ty_march_request* request, TY_GLOBAL const ty_spaced_rays* lattice,
                                 int32_t x, int32_t y, ty_vec direction, const ty_hit* hit, ty_march_pixel* pixel) {
    ty_spaced_neighbours around;
    ty_spaced_ray mean;
    float behind[3];
    ty_spaced_find(lattice, x, y, &around);
    if (!ty_spaced_media(&around, hit != NULL ? hit->distance : TY_FLOAT_MAX, &mean)) return false;
    if (!ty_spaced_behind(request, &around, direction, hit, behind) || ty_spaced_differ(&around, &mean, behind))
        return false;
    for (int c = 0; c < 3; ++c) {
        const float passed = mean.transmittance[c] * behind[c];
        pixel->unscattered[c] += mean.emission[c] + (hit == NULL ? passed : 0.0f);
        pixel->single[c] += mean.single[c];
        pixel->multiple[c] += mean.multiple[c] + (hit != NULL ? passed : 0.0f);
        pixel->transmittance[c] += mean.transmittance[c];
    }
    if (hit != NULL) {
        pixel->depth += hit->distance;
        pixel->hits += 1.0f;
    }
    return true;
}

/* Adds the sample-th ray of a pixel, or what those around it tell of it; hit: the surface that it sees, NULL for none.
 * Returns the number of further steps. */
TY_FN uint32_t ty_spaced_fill(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray,
                              TY_GLOBAL const ty_spaced_rays* lattice, int32_t sample, int32_t x, int32_t y,
                              ty_vec direction, const ty_hit* hit, ty_march_pixel* pixel) {
    if (ty_spaced_interpolate(request, lattice, x, y, direction, hit, pixel)) return 0;
    ty_pixel_add_ray(request, ray, request->camera.origin, direction, hit, (float)x, (float)y,
                     ty_pixel_offset(request, x, y, sample, request->spp), pixel);
    return ray->steps;
}

#endif
