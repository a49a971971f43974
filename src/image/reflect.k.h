/* Reflection of scattered light by surfaces. */
#ifndef TY_IMAGE_REFLECT_K_H
#define TY_IMAGE_REFLECT_K_H

#include "image/march.k.h"

/* Number of rays that gather light for a surface outside the field's box, for a pixel and for one of the rays that
 * pixels are interpolated between; and their step scale. */
enum { TY_REFLECT_RAYS = 16, TY_REFLECT_RAYS_SPACED = 4 };
#define TY_REFLECT_STEP 4.0f

/* Irradiance from media on a surface in vacuum: `rays` cosine-distributed rays, stratified over the hemisphere, each up
 * to the next surface. phase, in (0, 1], rotates them about the normal and shifts their elevation. ray: scratch. */
TY_FN uint32_t ty_reflect_gather(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, const ty_hit* hit,
                                 const ty_surface_point* point, int32_t rays, float phase, float irradiance[3]) {
    const float weight = 1.0f / (float)rays;
    const float shift = 61.8f * phase - floorf(61.8f * phase);
    uint32_t steps = 0;
    for (int c = 0; c < 3; ++c) irradiance[c] = 0.0f;
    for (int32_t i = 0; i < rays; ++i) {
        const float u = ((float)i + shift) * weight, v = phase + 0.618033989f * (float)i;
        const ty_vec direction = ty_direction_about(point->ns, sqrtf(1.0f - u), v - floorf(v));
        if (ty_dot(direction, point->ng) <= 0.0f) continue;
        const ty_vec origin = ty_hit_leave(hit, direction);
        ty_hit next;
        const bool hits = ty_accel_intersect(request->scene->mesh, origin, direction, TY_FLOAT_MAX, &next);
        ty_march_follow(ray, request, origin, direction, hits ? next.distance : TY_FLOAT_MAX, phase, TY_REFLECT_STEP);
        steps += ray->steps;
        for (int c = 0; c < 3; ++c)
            irradiance[c] +=
                (TY_PI * weight) * (ray->light.emission[c] + ray->light.single[c] + ray->light.multiple[c]);
    }
    return steps;
}

/* Irradiance from media on a surface that a camera ray hit: from the field, or gathered outside of its box. Adds to the
 * ray's steps. */
TY_FN void ty_reflect_irradiance(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, const ty_hit* hit,
                                 const ty_surface_point* point, float offset, float irradiance[3]) {
    const ty_vec cells = ty_cell_coordinates(&request->surface_field.lattice, hit->position);
    const uint32_t before = ray->steps;
    ray->steps = 0;
    if (ty_cell_inside(&request->surface_field.lattice, cells))
        ty_upsample_irradiance(&request->surface_field, cells, point->ns, irradiance);
    else
        ray->steps = ty_reflect_gather(request, ray, hit, point, TY_REFLECT_RAYS, offset, irradiance);
    ray->steps += before;
}

/* True if a surface's light is visible through this transmittance. */
TY_FN bool ty_reflect_is_visible(const ty_surface_point* point, const float transmittance[3]) {
    return ty_maxf(transmittance[0] * point->albedo[0],
                   ty_maxf(transmittance[1] * point->albedo[1], transmittance[2] * point->albedo[2])) > 0.0f;
}

/* Adds the media's light reflected by a surface that a camera ray hit, behind some transmittance. offset: (0, 1],
 * varies between rays. */
TY_FN void ty_reflect_media(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, ty_vec direction,
                            const ty_hit* hit, float offset, const float transmittance[3], float radiance[3]) {
    ty_surface_point point;
    float irradiance[3];
    ty_surface_evaluate(&request->scene->surfaces[hit->surface], hit, direction, &point);
    if (!ty_reflect_is_visible(&point, transmittance)) return;
    ty_reflect_irradiance(request, ray, hit, &point, offset, irradiance);
    for (int c = 0; c < 3; ++c) radiance[c] += transmittance[c] * point.albedo[c] * (1.0f / TY_PI) * irradiance[c];
}

#endif
