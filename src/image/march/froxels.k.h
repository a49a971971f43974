/* Froxels (Wronski 2014; Hillaire 2015): the camera's frustum in columns, rows and slices. Rays through the columns
 * march one slice at a time, with the media sampled at a point of each, and leave the light from the camera to the end
 * of each slice; pixels interpolate it at the depth of their surface. */
#ifndef TY_IMAGE_FROXELS_K_H
#define TY_IMAGE_FROXELS_K_H

#include "image/march/pixel.k.h"

/* ---- depths ---- */

/* Length per depth along the camera's axis of the ray through an image point (x, y), in pixels. */
TY_FN float ty_froxel_stretch(const ty_camera_view* camera, float x, float y) {
    const ty_vec d = ty_mad(ty_mad(camera->corner, camera->dx, x), camera->dy, y);
    return sqrtf(ty_dot(d, d));
}

/* The position of a depth among the slices, 0..slices: the inverse of the slices' ends (Wronski 2014, with a first
 * depth of its own),
 *
 *     z(s) = near + (far - near) (r^(s / slices) - 1) / (r - 1)
 *
 * where r is the ratio of the thickness of the slice behind the last to that of the first. */
TY_FN float ty_froxel_slice(TY_GLOBAL const ty_froxel_view* grid, float depth) {
    const float within = ty_clampf((depth - grid->near) * grid->inverse_range, 0.0f, 1.0f);
    return (float)grid->size[2] * ty_logf(1.0f + within * (grid->growth - 1.0f)) / ty_logf(grid->growth);
}

/* The image point of a ray of a column, in pixels. */
TY_FN void ty_froxel_place(TY_GLOBAL const ty_march_request* request, int32_t column, int32_t row, int32_t sample,
                           float* x, float* y) {
    TY_GLOBAL const ty_froxel_view* grid = &request->froxels;
    float dx, dy;
    ty_pixel_place(sample, request->spp, &dx, &dy);
    *x = ((float)column + dx) * grid->pixels[0];
    *y = ((float)row + dy) * grid->pixels[1];
}

/* Widens the range of depths by the media along a ray: first and last, m. */
TY_FN void ty_froxel_add_range(TY_GLOBAL const ty_march_request* request, float x, float y, float range[2]) {
    const float per_length = 1.0f / ty_froxel_stretch(&request->camera, x, y);
    const ty_vec direction = ty_camera_direction(&request->camera, x, y);
    ty_spans spans;
    ty_spans_find(request->scene->media, request->scene->medium_count, request->camera.origin, direction, TY_FLOAT_MAX,
                  &spans);
    for (int32_t i = 0; i < spans.count; ++i) {
        range[0] = ty_minf(range[0], spans.enter[i] * per_length);
        range[1] = ty_maxf(range[1], spans.leave[i] * per_length);
    }
}

/* ---- columns ---- */

/* Samples the media between two distances, at a point of each of their intervals with density there, which stands for
 * it: at this fraction of its length. */
TY_FN void ty_froxel_sample(ty_march_ray* ray, float begin, float end, float fraction) {
    ray->begin = begin;
    ray->active_count = 0;
    for (int32_t i = 0; i < ray->count; ++i) {
        ty_track* track = &ray->tracks[i];
        while (track->leave <= begin) ty_track_next_run(track);
        while (track->enter < end) {
            const float enter = ty_maxf(begin, track->enter), leave = ty_minf(end, track->leave);
            const float at = ty_lerpf(enter, leave, fraction);
            const float column = ty_track_density_anywhere(track, at) * (leave - enter);
            track->column += column;
            track->moment += column * (at - begin);
            if (track->leave >= end) break;
            ty_track_next_run(track);
        }
        if (track->column > 0.0f) ray->active[ray->active_count++] = i;
    }
}

TY_FN void ty_froxel_add(ty_froxel* froxel, const ty_march_light* light, float weight) {
    for (int32_t c = 0; c < 3; ++c) {
        froxel->transmittance[c] += weight * light->transmittance[c];
        froxel->emission[c] += weight * light->emission[c];
        froxel->single[c] += weight * light->single[c];
        froxel->multiple[c] += weight * light->multiple[c];
    }
}

/* Marches one ray of a column through all slices, and adds `weight` of its light to the column's froxels. A step is a
 * slice: the light of its source is that of a constant one, S (1 - exp(-tau)) / tau (Hillaire 2015), by
 * ty_march_attenuate. fraction: where slices are sampled. */
TY_FN void ty_froxel_march(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, float x, float y,
                           float fraction, float weight, TY_GLOBAL ty_froxel* froxels) {
    TY_GLOBAL const ty_froxel_view* grid = &request->froxels;
    const float stretch = ty_froxel_stretch(&request->camera, x, y);
    bool visible = true;
    ty_march_begin(ray, request, request->camera.origin, ty_camera_direction(&request->camera, x, y), TY_FLOAT_MAX);
    ty_froxel_add(&froxels[0], &ray->light, weight);
    for (int32_t k = 0; k < grid->size[2]; ++k) {
        if (visible) {
            const float end = stretch * grid->ends[k + 1];
            ty_froxel_sample(ray, stretch * grid->ends[k], end, fraction);
            visible = ty_march_end_step(ray, end);
        }
        ty_froxel_add(&froxels[k + 1], &ray->light, weight);
    }
}

/* The point of slices at which a column's ray samples them, as a fraction: the center for a single ray; those of
 * several are spread evenly (a Kronecker sequence). */
TY_FN float ty_froxel_fraction(int32_t sample) {
    const float phase = 0.5f + 0.754877666f * (float)sample;
    return phase - floorf(phase);
}

/* Widens the range of depths by the media along the rays of a column: first and last, m. */
TY_FN void ty_froxel_add_column(TY_GLOBAL const ty_march_request* request, int32_t column, int32_t row,
                                float range[2]) {
    for (int32_t i = 0; i < request->spp; ++i) {
        float x, y;
        ty_froxel_place(request, column, row, i, &x, &y);
        ty_froxel_add_range(request, x, y, range);
    }
}

/* Fills a column; returns the number of steps. */
TY_FN uint32_t ty_froxel_fill(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, int32_t column,
                              int32_t row) {
    TY_GLOBAL const ty_froxel_view* grid = &request->froxels;
    const size_t nodes = (size_t)grid->size[2] + 1;
    TY_GLOBAL ty_froxel* froxels = grid->froxels + ((size_t)row * (size_t)grid->size[0] + (size_t)column) * nodes;
    const float weight = 1.0f / (float)request->spp;
    uint32_t steps = 0;
    memset(froxels, 0, nodes * sizeof *froxels);
    for (int32_t i = 0; i < request->spp; ++i) {
        float x, y;
        ty_froxel_place(request, column, row, i, &x, &y);
        ty_froxel_march(request, ray, x, y, ty_froxel_fraction(i), weight, froxels);
        steps += ray->steps;
    }
    return steps;
}

/* ---- pixels ---- */

/* The lower of two froxels around a position between 0 and count - 1, and the weight of the other. */
TY_FN int32_t ty_froxel_below(float position, int32_t count, float* weight) {
    const float clamped = ty_clampf(position, 0.0f, (float)(count - 1));
    int32_t below = (int32_t)clamped;
    if (below > count - 2) below = count > 1 ? count - 2 : 0;
    *weight = clamped - (float)below;
    return below;
}

/* The light from the camera to a depth behind an image point: trilinear interpolation between columns, rows and ends of
 * slices. */
TY_FN void ty_froxel_interpolate(TY_GLOBAL const ty_march_request* request, float x, float y, float depth,
                                 ty_march_light* light) {
    TY_GLOBAL const ty_froxel_view* grid = &request->froxels;
    float weight[3];
    const int32_t column = ty_froxel_below(x / grid->pixels[0] - 0.5f, grid->size[0], &weight[0]);
    const int32_t row = ty_froxel_below(y / grid->pixels[1] - 0.5f, grid->size[1], &weight[1]);
    const int32_t slice = ty_froxel_below(ty_froxel_slice(grid, depth), grid->size[2] + 1, &weight[2]);
    const size_t nodes = (size_t)grid->size[2] + 1, right = grid->size[0] > 1 ? 1 : 0;
    const size_t down = grid->size[1] > 1 ? (size_t)grid->size[0] : 0;
    const size_t first = (size_t)row * (size_t)grid->size[0] + (size_t)column;
    ty_froxel sum;
    memset(&sum, 0, sizeof sum);
    memset(light, 0, sizeof *light);
    for (size_t i = 0; i < 4; ++i) {
        TY_GLOBAL const ty_froxel* near = grid->froxels + (first + (i & 1) * right + (i >> 1) * down) * nodes + slice;
        const float corner_weight =
            ((i & 1) != 0 ? weight[0] : 1.0f - weight[0]) * ((i >> 1) != 0 ? weight[1] : 1.0f - weight[1]);
        for (int32_t c = 0; c < 3; ++c) {
            light->transmittance[c] +=
                corner_weight * ty_lerpf(near[0].transmittance[c], near[1].transmittance[c], weight[2]);
            light->emission[c] += corner_weight * ty_lerpf(near[0].emission[c], near[1].emission[c], weight[2]);
            light->single[c] += corner_weight * ty_lerpf(near[0].single[c], near[1].single[c], weight[2]);
            light->multiple[c] += corner_weight * ty_lerpf(near[0].multiple[c], near[1].multiple[c], weight[2]);
        }
    }
}

/* A pixel from filled froxels. */
TY_FN void ty_froxel_look_up(TY_GLOBAL const ty_march_request* request, int32_t x, int32_t y, ty_march_pixel* pixel) {
    const ty_accel* mesh = request->scene->mesh;
    memset(pixel, 0, sizeof *pixel);
    for (int32_t i = 0; i < request->spp; ++i) {
        float dx, dy;
        ty_hit hit;
        ty_march_light light;
        ty_pixel_place(i, request->spp, &dx, &dy);
        const float px = (float)x + dx, py = (float)y + dy;
        const ty_vec direction = ty_camera_direction(&request->camera, px, py);
        const bool hits =
            mesh != NULL && ty_accel_intersect(mesh, request->camera.origin, direction, TY_FLOAT_MAX, &hit);
        const float depth = hits ? hit.distance / ty_froxel_stretch(&request->camera, px, py) : TY_FLOAT_MAX;
        ty_froxel_interpolate(request, px, py, depth, &light);
        ty_pixel_add_light(request, &light, direction, hits ? &hit : NULL, pixel);
    }
}

#endif
