/* Glass on the baker's rays: thin walls and solid dielectrics pass light straight on, with what Fresnel's reflectance
 * leaves, their colour and their absorption. Media that fill solids scatter the light that is solved in them. */
#ifndef TY_BAKE_GATHER_TRANSPARENT_K_H
#define TY_BAKE_GATHER_TRANSPARENT_K_H

#include "bake/gather/segment.k.h"
#include "direct/single/enclosed_field.k.h"
#include "method/path/trace/light_path.k.h"
#include "scene/bsdf/fresnel.k.h"
#include "scene/interior_list.k.h"

/* Surfaces that a ray passes at most, and the fraction of light below which what is behind a solid does not count. */
enum { TY_TRANSPARENT_MAX = 64 };
#define TY_TRANSPARENT_MIN 1e-3f

/* A ray through transparent surfaces. */
typedef struct ty_transparent_ray {
    const ty_scene_view* scene;
    const ty_enclosed_field* fields; /* of interiors, by number; NULL: none is solved */
    ty_interior_list inside;         /* the dielectrics where it is */
    float passed[3];                 /* fraction of light that passes from there to the origin */
    float scattered[3];              /* radiance that media in dielectrics scatter to the origin */
} ty_transparent_ray;

TY_FN void ty_transparent_begin(ty_transparent_ray* ray, const ty_scene_view* scene, const ty_enclosed_field* fields,
                                const ty_interior_list* inside) {
    ray->scene = scene;
    ray->fields = fields;
    ray->inside = *inside;
    for (int c = 0; c < 3; ++c) {
        ray->passed[c] = 1.0f;
        ray->scattered[c] = 0.0f;
    }
}

/* Fraction of light that crosses a surface, per channel, and of that which it reflects; what fills the space behind it.
 * False: it is opaque. */
TY_FN bool ty_transparent_fractions(const ty_transparent_ray* ray, const ty_hit* hit, const ty_surface_point* point,
                                    ty_vec direction, ty_interior_list* beyond, float crosses[3], float reflects[3]) {
    const ty_surface_gloss* gloss = ray->scene->surfaces[hit->surface].gloss;
    if (gloss == NULL) return false;
    const ty_dielectric* dielectric = &gloss->dielectric;
    float part = 1.0f - point->opaque, ior = gloss->factor.ior, returns = 0.0f;
    *beyond = ray->inside;
    if (dielectric->solid == 0) {
        part = gloss->factor.transmission * (1.0f - gloss->factor.metallic);
    } else {
        *beyond = ty_interior_list_beyond(ray->scene->interiors, &ray->inside, dielectric->interior, hit, direction);
        const float ratio = ray->scene->interiors[beyond->top].ior / ray->scene->interiors[ray->inside.top].ior;
        ior = ty_maxf(ratio, 1.0f / ratio);
        returns = part;
        if (beyond->top == ray->inside.top) part = returns = ior = 1.0f;
    }
    if (!(part > 0.0f)) return false;
    /* Light goes straight on, so its angle is that of the outside on both sides. */
    const float fresnel = ior > 1.0f ? ty_fresnel_dielectric(fabsf(ty_dot(hit->normal, direction)), ior) : 0.0f;
    for (int c = 0; c < 3; ++c) {
        crosses[c] = part * (1.0f - fresnel) *
                     (beyond->top == ray->inside.top && dielectric->solid != 0 ? 1.0f : point->tint[c]);
        reflects[c] = dielectric->solid != 0 ? returns * fresnel + (1.0f - returns) * point->albedo[c]
                                             : ty_maxf(point->albedo[c] - crosses[c], 0.0f);
    }
    return true;
}

/* Light that the medium of an interior scatters to the ray's origin at one sampled collision along a segment. */
TY_FN void ty_transparent_scatter(ty_transparent_ray* ray, const ty_segment* segment, ty_vec origin, ty_vec direction,
                                  float distance, ty_sampler* random) {
    const ty_enclosed_field* field = &ray->fields[ray->inside.top];
    const float ior = ray->scene->interiors[ray->inside.top].ior;
    float min_sigma = TY_FLOAT_MAX, radiance[3], sigma[3];
    for (int c = 0; c < 3; ++c) {
        sigma[c] = segment->depth[c] / distance;
        min_sigma = ty_minf(min_sigma, sigma[c]);
    }
    if (!(min_sigma > 0.0f)) return;
    const float t = -ty_logf(1.0f - ty_rng_uniform(random)) / min_sigma;
    if (!(t < distance)) return;
    ty_enclosed_radiance(field, ty_mad(origin, direction, t), ty_scale(direction, -1.0f), radiance);
    for (int c = 0; c < 3; ++c) {
        const float albedo = segment->depth[c] > 0.0f ? segment->scattering_depth[c] / segment->depth[c] : 0.0f;
        const float weight = sigma[c] / min_sigma * ty_expf((min_sigma - sigma[c]) * t);
        ray->scattered[c] += ray->passed[c] * weight * albedo * radiance[c] / (ior * ior);
    }
}

/* Follows the ray through the interior that it is in, over a distance. entry: where it was entered, from where the
 * light that is scattered or absorbed goes along the refracted ray; NULL: the ray began there. random: for light that
 * is scattered; NULL: none. */
TY_FN void ty_transparent_cross(ty_transparent_ray* ray, const ty_hit* entry, ty_vec origin, ty_vec direction,
                                float distance, ty_sampler* random) {
    const ty_interior* interior = &ray->scene->interiors[ray->inside.top];
    const bool solved = ray->inside.top > 0 && ray->fields != NULL && ray->fields[ray->inside.top].bands > 0;
    const int32_t count = solved ? interior->medium_count : interior->absorbs;
    ty_segment segment;
    if (ray->inside.top == 0 || count == 0) return;
    if (entry != NULL) {
        const ty_vec normal = ty_scale(entry->normal, ty_dot(entry->normal, direction) < 0.0f ? 1.0f : -1.0f);
        ty_hit beyond;
        direction = ty_refract(ty_scale(direction, -1.0f), normal, interior->ior);
        origin = ty_hit_leave(entry, direction);
        if (ty_accel_intersect(ray->scene->mesh, origin, direction, TY_FLOAT_MAX, &beyond)) distance = beyond.distance;
    }
    segment.point = NULL;
    ty_segment_find(&segment, interior->media, count, origin, direction, distance);
    if (random != NULL && entry != NULL && solved)
        ty_transparent_scatter(ray, &segment, origin, direction, distance, random);
    for (int c = 0; c < 3; ++c) ray->passed[c] *= segment.transmittance[c];
}

/* Fraction of light that passes between two points; 0 in all channels behind an opaque surface. */
TY_FN bool ty_transparent_passes(ty_transparent_ray* ray, ty_vec origin, ty_vec direction, float distance) {
    float left = distance < TY_FLOAT_MAX ? distance * 0.9999f : TY_FLOAT_MAX;
    ty_hit hit, entry;
    for (int32_t i = 0; i < TY_TRANSPARENT_MAX; ++i) {
        ty_surface_point point;
        ty_interior_list beyond;
        float crosses[3], reflects[3];
        if (!ty_accel_intersect(ray->scene->mesh, origin, direction, left, &hit)) {
            ty_transparent_cross(ray, i > 0 ? &entry : NULL, origin, direction, ty_minf(left, 1e6f), NULL);
            return true;
        }
        if (ray->scene->surfaces[hit.surface].gloss == NULL) return false;
        ty_surface_evaluate(&ray->scene->surfaces[hit.surface], &hit, direction, &point);
        if (!ty_transparent_fractions(ray, &hit, &point, direction, &beyond, crosses, reflects)) return false;
        ty_transparent_cross(ray, i > 0 ? &entry : NULL, origin, direction, hit.distance, NULL);
        entry = hit;
        for (int c = 0; c < 3; ++c) ray->passed[c] *= crosses[c];
        if (ty_max3(ray->passed) < TY_TRANSPARENT_MIN) return false;
        ray->inside = beyond;
        origin = ty_hit_leave(&hit, direction);
        if (left < TY_FLOAT_MAX) left -= hit.distance;
    }
    return false;
}

/* Traces a ray to the surface where it ends, which reflects by chance where light also crosses it: *end with its
 * distance from the ray's origin. False: it hits none. */
TY_FN bool ty_transparent_trace(ty_transparent_ray* ray, ty_vec origin, ty_vec direction, ty_sampler* random,
                                ty_intersection* end) {
    float before = 0.0f;
    ty_hit entry;
    for (int32_t i = 0; i < TY_TRANSPARENT_MAX; ++i) {
        ty_interior_list beyond;
        float crosses[3], reflects[3];
        if (!ty_accel_intersect(ray->scene->mesh, origin, direction, TY_FLOAT_MAX, &end->hit)) return false;
        ty_surface_evaluate(&ray->scene->surfaces[end->hit.surface], &end->hit, direction, &end->point);
        ty_transparent_cross(ray, i > 0 ? &entry : NULL, origin, direction, end->hit.distance, random);
        before += end->hit.distance;
        end->hit.distance = before;
        const bool dark = ty_max3(ray->passed) < TY_TRANSPARENT_MIN;
        if (dark || !ty_transparent_fractions(ray, &end->hit, &end->point, direction, &beyond, crosses, reflects)) {
            for (int c = 0; c < 3 && dark; ++c) end->point.albedo[c] = end->point.emission[c] = 0.0f;
            return true;
        }
        const float crossing = ty_max3(crosses), all = crossing + ty_max3(reflects);
        if (ty_rng_uniform(random) * all >= crossing) {
            for (int c = 0; c < 3; ++c) end->point.albedo[c] = reflects[c] * all / (all - crossing);
            return true;
        }
        for (int c = 0; c < 3; ++c) ray->passed[c] *= crosses[c] * all / crossing;
        ray->inside = beyond;
        entry = end->hit;
        origin = ty_hit_leave(&end->hit, direction);
    }
    for (int c = 0; c < 3; ++c) end->point.albedo[c] = end->point.emission[c] = 0.0f;
    return true;
}

#endif
