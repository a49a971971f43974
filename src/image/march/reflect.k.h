/* Reflection of scattered light by surfaces. */
#ifndef TY_IMAGE_REFLECT_K_H
#define TY_IMAGE_REFLECT_K_H

#include "image/march/march.k.h"

/* Number of rays of each of two kinds that gather light for a surface outside the field's box: for a point that pixels
 * are interpolated between, for a pixel that those around it do not represent, and for one of the rays of a ray_spacing
 * above 1; and their step scale. */
enum { TY_REFLECT_RAYS = 32, TY_REFLECT_RAYS_PIXEL = 16, TY_REFLECT_RAYS_SPACED = 4 };
#define TY_REFLECT_STEP 4.0f

/* Adds the light of media that the surface at the end of a gathering ray reflects, times `weight`. Never inlined, as
 * ty_march_add_octaves. */
static __attribute__((noinline)) void ty_reflect_add_surface(TY_GLOBAL const ty_march_request* request,
                                                             const ty_hit* hit, ty_vec direction,
                                                             const float transmittance[3], float weight,
                                                             float irradiance[3]) {
    ty_surface_point point;
    float reflected[3];
    ty_surface_evaluate(&request->scene->surfaces[hit->surface], hit, direction, &point);
    const ty_vec cells = ty_cell_coordinates(&request->surface_field.lattice, hit->position);
    if (ty_cell_inside(&request->surface_field.lattice, cells)) {
        ty_upsample_irradiance(&request->surface_field, cells, point.ns, reflected);
    } else {
        const int32_t at = ty_irradiance_find(&request->cache, ty_hit_leave(hit, point.ng), point.ng);
        if (at < 0) return;
        for (int c = 0; c < 3; ++c) reflected[c] = request->cache.irradiance[3 * at + c];
    }
    for (int c = 0; c < 3; ++c)
        irradiance[c] += weight * transmittance[c] * point.albedo[c] * (1.0f / TY_PI) * reflected[c];
}

/* The box of the media as a point outside of it sees it. */
typedef struct ty_reflect_box {
    ty_vec lower, upper; /* relative to the point, m */
    float area[3];       /* of the visible face across each axis, m^2; 0: none */
    float total;         /* of them */
} ty_reflect_box;

TY_FN float ty_reflect_side(float lower, float upper) {
    return lower > 0.0f ? lower : upper < 0.0f ? upper : 0.0f;
}

TY_FN void ty_reflect_find_box(const ty_cell_lattice* lattice, ty_vec point, ty_reflect_box* out) {
    const ty_vec edge =
        ty_vec_make((float)lattice->size[0] / lattice->per_cell.x, (float)lattice->size[1] / lattice->per_cell.y,
                    (float)lattice->size[2] / lattice->per_cell.z);
    out->lower = ty_sub(lattice->lower, point);
    out->upper = ty_add(out->lower, edge);
    out->area[0] = ty_reflect_side(out->lower.x, out->upper.x) != 0.0f ? edge.y * edge.z : 0.0f;
    out->area[1] = ty_reflect_side(out->lower.y, out->upper.y) != 0.0f ? edge.z * edge.x : 0.0f;
    out->area[2] = ty_reflect_side(out->lower.z, out->upper.z) != 0.0f ? edge.x * edge.y : 0.0f;
    out->total = out->area[0] + out->area[1] + out->area[2];
}

/* The direction to the place (u, v) on the visible faces, which are laid out along u by their areas; unit. */
TY_FN ty_vec ty_reflect_box_direction(const ty_reflect_box* box, float u, float v) {
    float along = u * box->total;
    const ty_vec low = box->lower, edge = ty_sub(box->upper, box->lower);
    ty_vec at;
    if (along < box->area[0]) {
        at = ty_vec_make(ty_reflect_side(low.x, box->upper.x), low.y + along / box->area[0] * edge.y,
                         low.z + v * edge.z);
    } else if ((along -= box->area[0]) < box->area[1]) {
        at = ty_vec_make(low.x + v * edge.x, ty_reflect_side(low.y, box->upper.y),
                         low.z + along / box->area[1] * edge.z);
    } else {
        along = ty_minf(along - box->area[1], box->area[2]);
        at = ty_vec_make(low.x + along / ty_maxf(box->area[2], 1e-30f) * edge.x, low.y + v * edge.y,
                         ty_reflect_side(low.z, box->upper.z));
    }
    return ty_normalize(at);
}

/* Density of these directions per solid angle for even (u, v); 0: the direction misses the box. */
TY_FN float ty_reflect_box_density(const ty_reflect_box* box, ty_vec direction) {
    const ty_vec inverse = ty_vec_make(1.0f / direction.x, 1.0f / direction.y, 1.0f / direction.z);
    float enter = 0.0f, leave = TY_FLOAT_MAX, cosine = 0.0f;
    const float lower[3] = {box->lower.x * inverse.x, box->lower.y * inverse.y, box->lower.z * inverse.z};
    const float upper[3] = {box->upper.x * inverse.x, box->upper.y * inverse.y, box->upper.z * inverse.z};
    const float along[3] = {fabsf(direction.x), fabsf(direction.y), fabsf(direction.z)};
    for (int a = 0; a < 3; ++a) {
        const float near = ty_minf(lower[a], upper[a]), far = ty_maxf(lower[a], upper[a]);
        if (near > enter) {
            enter = near;
            cosine = along[a];
        }
        leave = ty_minf(leave, far);
    }
    return enter < leave && cosine > 0.0f ? enter * enter / (cosine * box->total) : 0.0f;
}

/* Adds the light of media along a gathering ray, times `weight`, and that which the surface at its end reflects of
 * them, times `behind`. Returns the number of steps. */
TY_FN uint32_t ty_reflect_add_ray(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, ty_vec origin,
                                  ty_vec direction, float offset, float weight, float behind, float irradiance[3]) {
    ty_hit next;
    const bool hits = ty_accel_intersect(request->scene->mesh, origin, direction, TY_FLOAT_MAX, &next);
    ty_march_follow(ray, request, origin, direction, hits ? next.distance : TY_FLOAT_MAX, offset, TY_REFLECT_STEP);
    for (int c = 0; c < 3; ++c)
        irradiance[c] += weight * ((request->without_emission != 0 ? 0.0f : ray->light.emission[c]) +
                                   ray->light.single[c] + ray->light.multiple[c]);
    if (hits && behind > 0.0f && request->cache.count > 0)
        ty_reflect_add_surface(request, &next, direction, ray->light.transmittance, behind, irradiance);
    return ray->steps;
}

/* Irradiance from media on a surface in vacuum, whose normals are ng and ns: `rays` cosine-distributed rays, stratified
 * over the hemisphere, and as many to the box of the media, by the balance heuristic (Veach 1997), each up to the next
 * surface. origin: of the rays. phase, in (0, 1], rotates and shifts them. ray: scratch. Returns the number of steps.
 */
TY_FN uint32_t ty_reflect_gather(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, ty_vec origin, ty_vec ng,
                                 ty_vec ns, int32_t rays, float phase, float irradiance[3]) {
    const float part = 1.0f / (float)rays;
    const float shift = 61.8f * phase - floorf(61.8f * phase);
    ty_reflect_box box;
    uint32_t steps = 0;
    ty_reflect_find_box(&request->surface_field.lattice, origin, &box);
    for (int c = 0; c < 3; ++c) irradiance[c] = 0.0f;
    for (int32_t i = 0; i < 2 * rays; ++i) {
        const bool to_box = i >= rays;
        const float u = ((float)(to_box ? i - rays : i) + shift) * part, turn = phase + 0.618033989f * (float)i;
        const float step = phase + 0.7548776662f * (float)i, v = turn - floorf(turn);
        if (to_box && !(box.total > 0.0f)) break;
        const ty_vec direction =
            to_box ? ty_reflect_box_direction(&box, u, v) : ty_direction_about(ns, sqrtf(1.0f - u), v);
        const float cosine = ty_dot(direction, ns);
        if (ty_dot(direction, ng) <= 0.0f || !(cosine > 0.0f)) continue;
        const float density = (1.0f / TY_PI) * cosine + ty_reflect_box_density(&box, direction);
        steps += ty_reflect_add_ray(request, ray, origin, direction, 1.0f - (step - floorf(step)),
                                    part * cosine / density, to_box ? 0.0f : TY_PI * part, irradiance);
    }
    return steps;
}

/* Irradiance at a place (x, y) of the image, where a surface is hit; false: the points around do not represent it.
 * Never inlined, as ty_march_add_octaves. */
static __attribute__((noinline)) bool ty_gathered_interpolate(const ty_gathered_view* view, float x, float y,
                                                              ty_vec position, float distance, ty_vec normal,
                                                              float irradiance[3]) {
    if (view->columns < 2 || view->rows < 2) return false;
    float along, down, sum = 0.0f;
    const int32_t column = ty_gathered_between(x, view->columns, view->width, &along);
    const int32_t row = ty_gathered_between(y, view->rows, view->height, &down);
    for (int c = 0; c < 3; ++c) irradiance[c] = 0.0f;
    for (int32_t i = 0; i < 4; ++i) {
        const int32_t right = i & 1, below = i >> 1;
        TY_GLOBAL const ty_gathered_point* point = &view->points[(row + below) * view->columns + column + right];
        const float weight = (right != 0 ? along : 1.0f - along) * (below != 0 ? down : 1.0f - down) *
                             ty_gathered_weight(point, position, normal, distance);
        if (!(weight > 0.0f)) continue;
        sum += weight;
        for (int c = 0; c < 3; ++c) irradiance[c] += weight * point->irradiance[c];
    }
    if (!(sum >= TY_GATHERED_WEIGHT_MIN)) return false;
    for (int c = 0; c < 3; ++c) irradiance[c] *= 1.0f / sum;
    return true;
}

/* Irradiance from media on a surface outside of the field's box that a camera ray through (x, y) of the image hit: from
 * points around, or gathered. Adds to the ray's steps. Never inlined, as ty_march_add_octaves. */
static __attribute__((noinline)) void ty_reflect_outside(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray,
                                                         const ty_hit* hit, const ty_surface_point* point, float x,
                                                         float y, float offset, float irradiance[3]) {
    const uint32_t before = ray->steps;
    if (ty_gathered_interpolate(&request->gathered, x, y, hit->position, hit->distance, point->ns, irradiance)) return;
    ray->steps = before + ty_reflect_gather(request, ray, ty_hit_leave(hit, point->ng), point->ng, point->ns,
                                            TY_REFLECT_RAYS_PIXEL, offset, irradiance);
}

/* Irradiance from media on a surface that a camera ray through (x, y) of the image hit. */
TY_FN void ty_reflect_irradiance(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, const ty_hit* hit,
                                 const ty_surface_point* point, float x, float y, float offset, float irradiance[3]) {
    const ty_vec cells = ty_cell_coordinates(&request->surface_field.lattice, hit->position);
    if (ty_cell_inside(&request->surface_field.lattice, cells))
        ty_upsample_irradiance(&request->surface_field, cells, point->ns, irradiance);
    else
        ty_reflect_outside(request, ray, hit, point, x, y, offset, irradiance);
}

/* True if a surface's light is visible through this transmittance. */
TY_FN bool ty_reflect_is_visible(const ty_surface_point* point, const float transmittance[3]) {
    return ty_maxf(transmittance[0] * point->albedo[0],
                   ty_maxf(transmittance[1] * point->albedo[1], transmittance[2] * point->albedo[2])) > 0.0f;
}

/* Adds the media's light reflected by a surface that a camera ray through (x, y) hit, behind some transmittance.
 * offset: (0, 1], varies between rays. */
TY_FN void ty_reflect_media(TY_GLOBAL const ty_march_request* request, ty_march_ray* ray, ty_vec direction,
                            const ty_hit* hit, float x, float y, float offset, const float transmittance[3],
                            float radiance[3]) {
    ty_surface_point point;
    float irradiance[3];
    ty_surface_evaluate(&request->scene->surfaces[hit->surface], hit, direction, &point);
    if (!ty_reflect_is_visible(&point, transmittance)) return;
    ty_reflect_irradiance(request, ray, hit, &point, x, y, offset, irradiance);
    for (int c = 0; c < 3; ++c) radiance[c] += transmittance[c] * point.albedo[c] * (1.0f / TY_PI) * irradiance[c];
}

#endif
