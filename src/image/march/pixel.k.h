/* Rays of a pixel: their places in it, the offsets of their first steps, what they see behind the media. */
#ifndef TY_IMAGE_PIXEL_K_H
#define TY_IMAGE_PIXEL_K_H

#include "base/octahedral.k.h"
#include "image/march/reflect.k.h"

/* A golden-ratio lattice over the pixel; a single ray goes through the center. */
TY_FN void ty_pixel_place(int32_t sample, int32_t spp, float* dx, float* dy) {
    const float phase = 0.5f + 0.618033989f * (float)sample;
    *dx = ((float)sample + 0.5f) / (float)spp;
    *dy = phase - floorf(phase);
}

/* The same of a pixel at an edge, whose lattice is shifted from pixel to pixel: edges run along rows of them. */
TY_FN void ty_pixel_place_at_edge(int32_t x, int32_t y, int32_t sample, int32_t rays, float* dx, float* dy) {
    const double right = 0.7548776662466927 * x + 0.5698402909980532 * y;
    const double down = 0.5698402909980532 * x + 0.7548776662466927 * y;
    ty_pixel_place(sample, rays, dx, dy);
    *dx += (float)(right - floor(right));
    *dy += (float)(down - floor(down));
    *dx -= floorf(*dx);
    *dy -= floorf(*dy);
}

/* Number of rays through a pixel. */
TY_FN int32_t ty_pixel_rays(TY_GLOBAL const ty_march_request* request, int32_t x, int32_t y) {
    TY_GLOBAL const ty_edges_view* edges = &request->edges;
    if (edges->rays == 0 || edges->marked[(size_t)y * (size_t)edges->width + (size_t)x] == 0) return request->spp;
    return edges->rays;
}

/* Scales the sums over a pixel's rays. */
TY_FN void ty_pixel_scale(ty_march_pixel* pixel, float factor) {
    for (int c = 0; c < 3; ++c) {
        pixel->unscattered[c] *= factor;
        pixel->single[c] *= factor;
        pixel->multiple[c] *= factor;
        pixel->transmittance[c] *= factor;
    }
    pixel->depth *= factor;
    pixel->hits *= factor;
}

/* End of the first step of a pixel's ray, as a fraction of a step: maximally different between neighbours (R2, Roberts
 * 2018) and between the rays of a pixel. */
TY_FN float ty_pixel_offset(TY_GLOBAL const ty_march_request* request, int32_t x, int32_t y, int32_t sample,
                            int32_t rays) {
    const double lattice_position = 0.7548776662466927 * x + 0.5698402909980532 * y + (double)sample / rays;
    const float value = (float)(lattice_position - floor(lattice_position)) + request->step_offset;
    return 1.0f - (value - floorf(value));
}

/* The camera of a ray through a pixel, of those of a lens or a moving camera: points of the R3 sequence (Roberts 2018),
 * shifted from pixel to pixel. */
TY_FN ty_camera_view ty_pixel_camera(const ty_camera_view* camera, int32_t x, int32_t y, int32_t sample) {
    const double pixel = 0.7548776662466927 * x + 0.5698402909980532 * y, index = sample + 0.5;
    const double u = pixel + 0.8191725133961645 * index, v = 1.3247179572447460 * pixel + 0.6710436067037893 * index;
    const double time = 1.7548776662466927 * pixel + 0.5497004779019703 * index;
    return ty_camera_sample(camera, (float)(u - floor(u)), (float)(v - floor(v)), (float)(time - floor(time)));
}

TY_FN void ty_pixel_add_environment(TY_GLOBAL const ty_march_request* request, ty_vec direction,
                                    const float transmittance[3], float unscattered[3]) {
    TY_GLOBAL const ty_light_set* lights = &request->scene->lights;
    for (int32_t i = 0; i < lights->distant_count; ++i) {
        TY_GLOBAL const ty_light_view* light = &lights->lights[lights->distant[i]];
        float radiance[3];
        if (light->kind != TY_KIND_ENVIRONMENT) continue;
        ty_environment_radiance(&light->environment, direction, radiance);
        for (int c = 0; c < 3; ++c) unscattered[c] += transmittance[c] * radiance[c];
    }
}

/* Environments seen through media that scatter nearly straight on. */
TY_FN void ty_pixel_add_blurred(TY_GLOBAL const ty_march_request* request, ty_vec direction,
                                const ty_march_light* light, float multiple[3]) {
    int32_t cell[4];
    float weight[4];
    ty_octahedral_around(TY_MARCH_BLUR_CELLS, direction, cell, weight);
    for (int32_t k = 0; k < 4; ++k)
        for (int c = 0; c < 3; ++c)
            multiple[c] += (light->scaled[c] - light->transmittance[c]) * weight[k] * request->blurred[3 * cell[k] + c];
}

/* Adds the media's light along a ray of the camera up to the surface that it hits, with the environment behind; hit:
 * NULL for none. */
TY_FN void ty_pixel_add_light(TY_GLOBAL const ty_march_request* request, const ty_march_light* light, ty_vec direction,
                              const ty_hit* hit, ty_march_pixel* pixel) {
    for (int c = 0; c < 3; ++c) {
        pixel->unscattered[c] += light->emission[c];
        pixel->single[c] += light->single[c];
        pixel->multiple[c] += light->multiple[c];
        pixel->transmittance[c] += light->transmittance[c];
    }
    if (hit == NULL) {
        if (request->blurred != NULL) ty_pixel_add_blurred(request, direction, light, pixel->multiple);
        if (request->has_background != 0)
            ty_pixel_add_environment(request, direction, light->transmittance, pixel->unscattered);
        return;
    }
    pixel->depth += hit->distance;
    pixel->hits += 1.0f;
}

/* Marches a ray of the camera through (x, y) up to the surface that it hits, and adds it; hit: NULL for none. */
TY_FN void ty_pixel_add_ray(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, ty_vec origin,
                            ty_vec direction, const ty_hit* hit, float x, float y, float offset,
                            ty_march_pixel* pixel) {
    ty_march_follow(ray, request, origin, direction, hit != NULL ? hit->distance : TY_FLOAT_MAX, offset, 1.0f);
    const float transmittance[3] = {ray->light.transmittance[0], ray->light.transmittance[1],
                                    ray->light.transmittance[2]};
    ty_pixel_add_light(request, &ray->light, direction, hit, pixel);
    if (hit != NULL && request->has_field != 0)
        ty_reflect_media(request, ray, direction, hit, x, y, offset, transmittance, pixel->multiple);
}

/* All rays of a pixel. sampled: nonzero for a lens or a moving camera, each of whose rays has a camera of its own.
 * Returns the number of steps. */
TY_FN uint32_t ty_pixel_march(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, int32_t x, int32_t y,
                              int32_t sampled, ty_march_pixel* pixel) {
    const ty_accel* mesh = request->scene->mesh;
    const int32_t rays = ty_pixel_rays(request, x, y);
    uint32_t steps = 0;
    memset(pixel, 0, sizeof *pixel);
    for (int32_t i = 0; i < rays; ++i) {
        float dx, dy;
        ty_hit hit;
        if (rays == request->spp)
            ty_pixel_place(i, rays, &dx, &dy);
        else
            ty_pixel_place_at_edge(x, y, i, rays, &dx, &dy);
        const ty_camera_view camera = sampled != 0 ? ty_pixel_camera(&request->camera, x, y, i) : request->camera;
        const ty_vec direction = ty_camera_direction(&camera, (float)x + dx, (float)y + dy);
        const bool hits = mesh != NULL && ty_accel_intersect(mesh, camera.origin, direction, TY_FLOAT_MAX, &hit);
        ty_pixel_add_ray(request, ray, camera.origin, direction, hits ? &hit : NULL, (float)x + dx, (float)y + dy,
                         ty_pixel_offset(request, x, y, i, rays), pixel);
        steps += ray->steps;
    }
    if (rays != request->spp) ty_pixel_scale(pixel, (float)request->spp / (float)rays);
    return steps;
}

/* ---- points at which irradiance is gathered ---- */

/* Gathers at the point of a column and a row; returns the number of steps. */
TY_FN uint32_t ty_pixel_gather(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, int32_t column,
                               int32_t row) {
    TY_GLOBAL const ty_gathered_view* view = &request->gathered;
    TY_GLOBAL ty_gathered_point* point = &view->points[row * view->columns + column];
    const ty_vec direction = ty_camera_direction(&request->camera, (float)ty_gathered_pixel(column, view->width) + 0.5f,
                                                 (float)ty_gathered_pixel(row, view->height) + 0.5f);
    ty_surface_point surface;
    ty_hit hit;
    point->exists = 0;
    if (!ty_accel_intersect(request->scene->mesh, request->camera.origin, direction, TY_FLOAT_MAX, &hit)) return 0;
    const ty_vec cells = ty_cell_coordinates(&request->surface_field.lattice, hit.position);
    if (ty_cell_inside(&request->surface_field.lattice, cells)) return 0;
    ty_surface_evaluate(&request->scene->surfaces[hit.surface], &hit, direction, &surface);
    point->exists = 1;
    point->position = hit.position;
    point->normal = surface.ns;
    point->distance = hit.distance;
    return ty_reflect_gather(request, ray, ty_hit_leave(&hit, surface.ng), surface.ng, surface.ns, TY_REFLECT_RAYS,
                             ty_pixel_offset(request, column, row, 0, request->spp), point->irradiance);
}

#endif
