/* Surfaces as kernels see them: what a ray finds where it meets one. */
#ifndef TY_SCENE_SURFACE_K_H
#define TY_SCENE_SURFACE_K_H

#include "base/vector.k.h"
#include "scene/texture.k.h"

/* Where a ray meets a surface; laid out as ty_ray_hit. */
typedef struct ty_hit {
    float distance;
    int32_t surface; /* in the scene view */
    int32_t part;    /* which quad of a shape, which triangle of a mesh */
    float b1, b2;    /* of triangles: weights of the second and third corner */
    ty_vec position; /* on the surface to rounding, however long the ray was */
    ty_vec normal;   /* unit, outwards (front), of the flat face or of the sphere */
    float margin;    /* off the surface by this much, rounding cannot lead back to it */
} ty_hit;

/* One shape, area light or mesh. */
typedef struct ty_surface {
    float albedo[3];
    float emission[3];   /* radiance, on the front */
    int32_t first_light; /* of shapes: among the scene view's lights, one per quad; -1: does not emit */
    int32_t two_sided;   /* emits on both sides */
    int32_t alpha_mode;  /* ty_alpha_mode */
    float alpha, cutoff;
    ty_texture_view albedo_texture, emission_texture;
    int32_t albedo_uv, emission_uv;
    float albedo_map[6], emission_map[6];
    /* Of meshes; NULL for shapes, and where a mesh has none. */
    TY_GLOBAL const uint32_t* indices;
    TY_GLOBAL const float* positions;
    TY_GLOBAL const float* normals;
    TY_GLOBAL const float* uv[2];
    TY_GLOBAL const float* colors;
    TY_GLOBAL const int32_t* lights; /* per triangle, -1: is not sampled; NULL: none glows */
} ty_surface;

/* What light does at a hit. */
typedef struct ty_surface_point {
    float albedo[3];
    float emission[3]; /* towards where the ray came from */
    ty_vec ng;         /* the face's unit normal on that side */
    ty_vec ns;         /* the same, smoothed: what cosines are taken with */
    int32_t light;     /* in the scene view; -1: is not sampled, and all it sends is met */
} ty_surface_point;

/* Where a ray that leaves a hit towards direction may start without hitting the same surface again. */
TY_FN ty_vec ty_hit_leave(const ty_hit* hit, ty_vec direction) {
    return ty_mad(hit->position, hit->normal, ty_dot(hit->normal, direction) < 0.0f ? -hit->margin : hit->margin);
}

/* The unit normal of a triangle with edges ab and ac, of whatever size, and its area; along z, with area 0, where it
 * has none. */
TY_FN ty_vec ty_triangle_normal(ty_vec ab, ty_vec ac, float* area) {
    const float of_ab = ty_maxf(fabsf(ab.x), ty_maxf(fabsf(ab.y), fabsf(ab.z)));
    const float size = ty_maxf(of_ab, ty_maxf(fabsf(ac.x), ty_maxf(fabsf(ac.y), fabsf(ac.z))));
    const ty_vec cross = ty_cross(ty_scale(ab, 1.0f / size), ty_scale(ac, 1.0f / size));
    const float length = sqrtf(ty_dot(cross, cross));
    const bool exists = length > 0.0f;
    *area = exists ? 0.5f * length * size * size : 0.0f;
    return exists ? ty_scale(cross, 1.0f / length) : ty_vec_make(0.0f, 0.0f, 1.0f);
}

/* Values per corner, count each, between the corners of a triangle. */
TY_FN void ty_surface_interpolate(TY_GLOBAL const float* values, int32_t count, TY_GLOBAL const uint32_t* corners,
                                  float b1, float b2, float* out) {
    TY_GLOBAL const float* a = values + (size_t)count * corners[0];
    TY_GLOBAL const float* b = values + (size_t)count * corners[1];
    TY_GLOBAL const float* c = values + (size_t)count * corners[2];
    for (int32_t i = 0; i < count; ++i) out[i] = (1.0f - b1 - b2) * a[i] + b1 * b[i] + b2 * c[i];
}

/* A texture of a mesh at a point of a triangle. */
TY_FN void ty_surface_texture(TY_GLOBAL const ty_surface* surface, TY_GLOBAL const ty_texture_view* texture,
                              int32_t set, TY_GLOBAL const float* map, int32_t triangle, float b1, float b2,
                              float rgba[4]) {
    float uv[2] = {0.0f, 0.0f};
    if (surface->uv[set] != NULL)
        ty_surface_interpolate(surface->uv[set], 2, surface->indices + 3 * (size_t)triangle, b1, b2, uv);
    ty_texture_lookup(texture, map[0] * uv[0] + map[1] * uv[1] + map[2], map[3] * uv[0] + map[4] * uv[1] + map[5],
                      rgba);
}

/* Radiance that a triangle sends from a point. */
TY_FN void ty_surface_emission(TY_GLOBAL const ty_surface* surface, int32_t triangle, float b1, float b2,
                               float emission[3]) {
    for (int c = 0; c < 3; ++c) emission[c] = surface->emission[c];
    if (!ty_texture_exists(&surface->emission_texture)) return;
    float rgba[4];
    ty_surface_texture(surface, &surface->emission_texture, surface->emission_uv, surface->emission_map, triangle, b1,
                       b2, rgba);
    for (int c = 0; c < 3; ++c) emission[c] *= rgba[c];
}

/* Albedo and alpha of a triangle at a point. */
TY_FN void ty_surface_color(TY_GLOBAL const ty_surface* surface, int32_t triangle, float b1, float b2, float rgba[4]) {
    float factor[4];
    for (int c = 0; c < 3; ++c) rgba[c] = surface->albedo[c];
    rgba[3] = surface->alpha;
    if (ty_texture_exists(&surface->albedo_texture)) {
        ty_surface_texture(surface, &surface->albedo_texture, surface->albedo_uv, surface->albedo_map, triangle, b1, b2,
                           factor);
        for (int c = 0; c < 4; ++c) rgba[c] *= factor[c];
    }
    if (surface->colors == NULL) return;
    ty_surface_interpolate(surface->colors, 4, surface->indices + 3 * (size_t)triangle, b1, b2, factor);
    for (int c = 0; c < 4; ++c) rgba[c] *= factor[c];
}

/* The fraction of rays for which a point of a triangle is there, by its alpha. */
TY_FN float ty_surface_presence(TY_GLOBAL const ty_surface* surface, int32_t triangle, float b1, float b2) {
    float rgba[4];
    if (surface->alpha_mode == 0) return 1.0f;
    ty_surface_color(surface, triangle, b1, b2, rgba);
    if (surface->alpha_mode == 1) return rgba[3] >= surface->cutoff ? 1.0f : 0.0f;
    return ty_minf(rgba[3], 1.0f);
}

/* Radiance that a triangle sends from a point, in the mean over rays. */
TY_FN void ty_surface_mean_emission(TY_GLOBAL const ty_surface* surface, int32_t triangle, float b1, float b2,
                                    float sent[3]) {
    const float presence = ty_surface_presence(surface, triangle, b1, b2);
    ty_surface_emission(surface, triangle, b1, b2, sent);
    for (int c = 0; c < 3; ++c) sent[c] *= presence;
}

/* What a ray along direction meets at hit. */
TY_FN void ty_surface_evaluate(TY_GLOBAL const ty_surface* surface, const ty_hit* hit, ty_vec direction,
                               ty_surface_point* out) {
    const bool front = ty_dot(hit->normal, direction) < 0.0f;
    out->ng = front ? hit->normal : ty_scale(hit->normal, -1.0f);
    out->ns = out->ng;
    for (int c = 0; c < 3; ++c) {
        out->albedo[c] = surface->albedo[c];
        out->emission[c] = 0.0f;
    }
    const bool glows = front || surface->two_sided != 0;
    if (surface->indices == NULL) {
        out->light = surface->first_light >= 0 && glows ? surface->first_light + hit->part : -1;
        for (int c = 0; c < 3 && out->light >= 0; ++c) out->emission[c] = surface->emission[c];
        return;
    }
    float rgba[4], smooth[3];
    ty_surface_color(surface, hit->part, hit->b1, hit->b2, rgba);
    for (int c = 0; c < 3; ++c) out->albedo[c] = ty_minf(rgba[c], 1.0f);
    out->light = surface->lights != NULL && glows ? surface->lights[hit->part] : -1;
    if (surface->lights != NULL && glows) ty_surface_emission(surface, hit->part, hit->b1, hit->b2, out->emission);
    if (surface->normals == NULL) return;
    ty_surface_interpolate(surface->normals, 3, surface->indices + 3 * (size_t)hit->part, hit->b1, hit->b2, smooth);
    const ty_vec normal = ty_vec_make(smooth[0], smooth[1], smooth[2]);
    const float square = ty_dot(normal, normal), along = ty_dot(normal, hit->normal);
    if (!(square > 1e-12f) || along == 0.0f) return;
    out->ns = ty_scale(normal, ((along < 0.0f) == front ? -1.0f : 1.0f) / sqrtf(square));
}

#endif
