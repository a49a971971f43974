/* Scattered light that surfaces reflect. */
#ifndef TY_IMAGE_REFLECT_K_H
#define TY_IMAGE_REFLECT_K_H

#include "image/march.k.h"

/* Rays that collect light for a surface outside of the field's box, and how much longer their steps are. */
enum { TY_REFLECT_RAYS = 16 };
#define TY_REFLECT_STEP 4.0f

/* What media bring to a surface in vacuum: rays by the cosine law, stratified over the hemisphere, each as far as the
 * next surface. turn, in (0, 1], turns them about the normal
 * and shifts them from it. The ray is there to work with. */
TY_FN uint32_t ty_reflect_gather(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, const ty_hit* hit,
                                 const ty_surface_point* point, float turn, float irradiance[3]) {
    const float shift = 61.8f * turn - floorf(61.8f * turn);
    uint32_t steps = 0;
    for (int c = 0; c < 3; ++c) irradiance[c] = 0.0f;
    for (int32_t i = 0; i < TY_REFLECT_RAYS; ++i) {
        const float u = ((float)i + shift) * (1.0f / TY_REFLECT_RAYS), v = turn + 0.618033989f * (float)i;
        const ty_vec direction = ty_direction_about(point->ns, sqrtf(1.0f - u), v - floorf(v));
        if (ty_dot(direction, point->ng) <= 0.0f) continue;
        const ty_vec origin = ty_hit_leave(hit, direction);
        ty_hit next;
        const bool hits = ty_accel_intersect(request->scene->mesh, origin, direction, TY_FLOAT_MAX, &next);
        ty_march_follow(ray, request, origin, direction, hits ? next.distance : TY_FLOAT_MAX, turn, TY_REFLECT_STEP);
        steps += ray->steps;
        for (int c = 0; c < 3; ++c)
            irradiance[c] +=
                (TY_PI / TY_REFLECT_RAYS) * (ray->light.glow[c] + ray->light.single[c] + ray->light.multiple[c]);
    }
    return steps;
}

/* Adds what a surface that a camera's ray hit sends back of the media's light, behind some transmittance. offset: (0,
 * 1], differs from ray to ray. */
TY_FN void ty_reflect(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, ty_vec direction, const ty_hit* hit,
                      float offset, const float transmittance[3], float radiance[3]) {
    ty_surface_point point;
    float irradiance[3];
    ty_surface_evaluate(&request->scene->surfaces[hit->surface], hit, direction, &point);
    const float most = ty_maxf(transmittance[0] * point.albedo[0],
                               ty_maxf(transmittance[1] * point.albedo[1], transmittance[2] * point.albedo[2]));
    if (!(most > 0.0f)) return;
    const ty_vec cells = ty_cell_coordinates(&request->surface_field.place, hit->position);
    const uint32_t before = ray->steps;
    ray->steps = 0;
    if (ty_cell_inside(&request->surface_field.place, cells))
        ty_upsample_irradiance(&request->surface_field, cells, point.ns, irradiance);
    else
        ray->steps = ty_reflect_gather(request, ray, hit, &point, offset, irradiance);
    ray->steps += before;
    for (int c = 0; c < 3; ++c) radiance[c] += transmittance[c] * point.albedo[c] * (1.0f / TY_PI) * irradiance[c];
}

#endif
