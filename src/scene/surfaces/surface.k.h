/* Surfaces for kernels: hits, textures, emission. */
#ifndef TY_SCENE_SURFACES_SURFACE_K_H
#define TY_SCENE_SURFACES_SURFACE_K_H

#include "base/vector.k.h"
#include "scene/bsdf/state.k.h"
#include "scene/surfaces/texture.k.h"

/* Hit of a ray with a surface; laid out as ty_ray_hit. */
typedef struct ty_hit {
    float distance;
    int32_t surface;      /* index in the scene view */
    int32_t primitive_id; /* quad of a shape, or triangle of a mesh */
    float b1, b2;         /* triangles: barycentric weights of the second and third corner */
    ty_vec position;      /* on the surface to rounding, at any ray length */
    ty_vec normal;        /* unit, outwards (front), geometric */
    float margin;         /* self-intersection offset, m */
} ty_hit;

/* A solid dielectric that a closed surface bounds. */
typedef struct ty_dielectric {
    int32_t solid;    /* 0: the surface is opaque or a thin wall, and the rest has no meaning */
    int32_t interior; /* its number among the scene view's interiors; 0: none */
    int32_t priority;
    float ior;        /* at least 1 */
    float roughness;  /* of its surface, before textures */
    float sigma_a[3]; /* absorption, 1/m */
} ty_dielectric;

/* Textures of a glossy material: ty_gloss_texture. */
enum { TY_SURFACE_TEXTURES = 10 };

/* A glossy material; its base colour is the surface's albedo. */
typedef struct ty_surface_gloss {
    TY_GLOBAL const ty_bsdf_tables* tables;
    ty_bsdf_parameters factor;
    ty_dielectric dielectric;
    int32_t pane;          /* nonzero: a smooth thin wall, whose transmitted light goes straight on */
    float normal_scale[2]; /* of the base and of the clear coat */
    int32_t textured;      /* nonzero if there is any texture */
    ty_texture_view textures[TY_SURFACE_TEXTURES];
    int32_t uv[TY_SURFACE_TEXTURES];
    float map[TY_SURFACE_TEXTURES][6];
} ty_surface_gloss;

/* Texture coordinates of a face of a shape, as functions of the position: u[0] x + u[1] y + u[2] z + u[3], and the
 * direction of increasing u with the bitangent's sign. Spheres: axes u of azimuth 0, v upwards, tangent of a quarter
 * turn clockwise seen from above. */
typedef struct ty_shape_face {
    float u[4], v[4], tangent[4];
} ty_shape_face;

/* The directions of a spot. */
typedef struct ty_cone {
    int32_t exists; /* 0: all directions */
    ty_vec axis;    /* unit, the way the light travels */
    float cos_outer, cos_inner;
} ty_cone;

/* Radiance of a spot at cosine mu from its axis, relative to the axis: smoothstep in the cosine. */
TY_FN float ty_cone_falloff(float cos_outer, float cos_inner, float mu) {
    if (mu <= cos_outer) return 0.0f;
    if (mu >= cos_inner) return 1.0f;
    const float x = (mu - cos_outer) / (cos_inner - cos_outer);
    return x * x * (3.0f - 2.0f * x);
}

/* A shape, area light or mesh. */
typedef struct ty_surface {
    float albedo[3];
    float emission[3];   /* radiance, on the front */
    int32_t first_light; /* shapes: first index among the scene view's lights, one per quad; -1: no emission */
    int32_t two_sided;   /* emits on both sides */
    int32_t alpha_mode;  /* ty_alpha_mode */
    float alpha, cutoff;
    ty_texture_view albedo_texture, emission_texture;
    int32_t albedo_uv, emission_uv;
    float albedo_map[6], emission_map[6];
    /* Meshes only; NULL for shapes, and for missing attributes. */
    TY_GLOBAL const uint32_t* indices;
    TY_GLOBAL const float* positions;
    TY_GLOBAL const float* normals;
    TY_GLOBAL const float* uv[2];
    TY_GLOBAL const float* colors;
    TY_GLOBAL const int32_t* lights; /* per triangle, -1: not sampled; NULL: no emission */
    TY_GLOBAL const float* tangents;
    TY_GLOBAL const ty_shape_face* faces;    /* textured shapes: by primitive; NULL otherwise */
    int32_t round;                           /* nonzero: the face is that of a sphere */
    TY_GLOBAL const ty_surface_gloss* gloss; /* NULL: Lambertian */
    float curvature;                         /* shapes: 1 / radius of a sphere, 1/m; else 0 */
    ty_cone cone;                            /* shapes of lamps: of the emission */
} ty_surface;

/* Colour, emission and normals at a hit, as in ty_surface_point. */
typedef struct ty_surface_look {
    float albedo[3], emission[3];
    ty_vec ng, ns;
    int32_t light;
} ty_surface_look;

/* Surface properties at a hit. */
typedef struct ty_surface_point {
    float albedo[3];   /* of the side that the ray hits; glossy surfaces: directional albedo towards the ray's origin */
    float emission[3]; /* radiance towards the ray's origin */
    ty_vec ng;         /* geometric unit normal on the ray's side */
    ty_vec ns;         /* shading normal on the ray's side */
    int32_t light;     /* in the scene view; -1: not sampled, counted fully when hit */
    int32_t glossy;    /* 0: Lambertian, without a BSDF */
    ty_bsdf bsdf;      /* boundaries of solid dielectrics: of the part that transmits nothing */
    float opaque;      /* boundaries: that part, 0..1 */
    float roughness;   /* boundaries: 0: smooth */
    float tint[3];     /* boundaries: colour of the light that crosses */
} ty_surface_point;

/* Origin of a ray that leaves a hit along direction without hitting the same surface again. */
TY_FN ty_vec ty_hit_leave(const ty_hit* hit, ty_vec direction) {
    return ty_mad(hit->position, hit->normal, ty_dot(hit->normal, direction) < 0.0f ? -hit->margin : hit->margin);
}

/* Unit normal of a triangle with edges ab and ac, at any scale, and its area; z, with area 0, for a degenerate
 * triangle. */
TY_FN ty_vec ty_triangle_normal(ty_vec ab, ty_vec ac, float* area) {
    const float ab_size = ty_maxf(fabsf(ab.x), ty_maxf(fabsf(ab.y), fabsf(ab.z)));
    const float size = ty_maxf(ab_size, ty_maxf(fabsf(ac.x), ty_maxf(fabsf(ac.y), fabsf(ac.z))));
    const ty_vec cross = ty_cross(ty_scale(ab, 1.0f / size), ty_scale(ac, 1.0f / size));
    const float length = sqrtf(ty_dot(cross, cross));
    const bool exists = length > 0.0f;
    *area = exists ? 0.5f * length * size * size : 0.0f;
    return exists ? ty_scale(cross, 1.0f / length) : ty_vec_make(0.0f, 0.0f, 1.0f);
}

/* Barycentric interpolation of `count` values per corner of a triangle. */
TY_FN void ty_surface_interpolate(TY_GLOBAL const float* values, int32_t count, TY_GLOBAL const uint32_t* corners,
                                  float b1, float b2, float* out) {
    TY_GLOBAL const float* a = values + (size_t)count * corners[0];
    TY_GLOBAL const float* b = values + (size_t)count * corners[1];
    TY_GLOBAL const float* c = values + (size_t)count * corners[2];
    for (int32_t i = 0; i < count; ++i) out[i] = (1.0f - b1 - b2) * a[i] + b1 * b[i] + b2 * c[i];
}

/* Texture of a mesh at a point of a triangle. */
TY_FN void ty_surface_texture(TY_GLOBAL const ty_surface* surface, TY_GLOBAL const ty_texture_view* texture,
                              int32_t set, TY_GLOBAL const float* map, int32_t triangle, float b1, float b2,
                              float rgba[4]) {
    float uv[2] = {0.0f, 0.0f};
    if (surface->uv[set] != NULL)
        ty_surface_interpolate(surface->uv[set], 2, surface->indices + 3 * (size_t)triangle, b1, b2, uv);
    ty_texture_lookup(texture, map[0] * uv[0] + map[1] * uv[1] + map[2], map[3] * uv[0] + map[4] * uv[1] + map[5],
                      rgba);
}

/* Texture coordinates of a shape at a hit. */
TY_FN void ty_shape_coordinates(TY_GLOBAL const ty_surface* surface, const ty_hit* hit, float uv[2]) {
    TY_GLOBAL const ty_shape_face* face = surface->faces + (surface->round != 0 ? 0 : hit->primitive_id);
    const ty_vec p = surface->round != 0 ? hit->normal : hit->position;
    const float u = ty_dot(ty_vec_load(face->u), p), v = ty_dot(ty_vec_load(face->v), p);
    uv[0] = u + face->u[3];
    uv[1] = v + face->v[3];
    if (surface->round == 0) return;
    uv[0] = 0.5f - ty_atan2_over_2pi(ty_dot(ty_vec_load(face->tangent), p), u);
    uv[1] = 2.0f * ty_atan2_over_2pi(sqrtf(ty_maxf(0.0f, 1.0f - v * v)), v);
}

/* Texture of a surface at a hit. */
TY_FN void ty_surface_hit_texture(TY_GLOBAL const ty_surface* surface, TY_GLOBAL const ty_texture_view* texture,
                                  int32_t set, TY_GLOBAL const float* map, const ty_hit* hit, float rgba[4]) {
    float uv[2];
    if (surface->faces == NULL) {
        ty_surface_texture(surface, texture, set, map, hit->primitive_id, hit->b1, hit->b2, rgba);
        return;
    }
    ty_shape_coordinates(surface, hit, uv);
    ty_texture_lookup(texture, map[0] * uv[0] + map[1] * uv[1] + map[2], map[3] * uv[0] + map[4] * uv[1] + map[5],
                      rgba);
}

/* Emitted radiance at a point of a triangle. */
TY_FN void ty_surface_emission(TY_GLOBAL const ty_surface* surface, int32_t triangle, float b1, float b2,
                               float emission[3]) {
    for (int c = 0; c < 3; ++c) emission[c] = surface->emission[c];
    if (!ty_texture_exists(&surface->emission_texture)) return;
    float rgba[4];
    ty_surface_texture(surface, &surface->emission_texture, surface->emission_uv, surface->emission_map, triangle, b1,
                       b2, rgba);
    for (int c = 0; c < 3; ++c) emission[c] *= rgba[c];
}

/* Albedo and alpha at a point of a triangle. */
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

/* Probability of a hit at a point of a triangle, by its alpha. */
TY_FN float ty_surface_presence(TY_GLOBAL const ty_surface* surface, int32_t triangle, float b1, float b2) {
    float rgba[4];
    if (surface->alpha_mode == 0) return 1.0f;
    ty_surface_color(surface, triangle, b1, b2, rgba);
    if (surface->alpha_mode == 1) return rgba[3] >= surface->cutoff ? 1.0f : 0.0f;
    return ty_minf(rgba[3], 1.0f);
}

/* Emitted radiance at a point of a triangle times the probability of a hit. */
TY_FN void ty_surface_mean_emission(TY_GLOBAL const ty_surface* surface, int32_t triangle, float b1, float b2,
                                    float emission[3]) {
    const float presence = ty_surface_presence(surface, triangle, b1, b2);
    ty_surface_emission(surface, triangle, b1, b2, emission);
    for (int c = 0; c < 3; ++c) emission[c] *= presence;
}

/* Colour, emission and normals at a hit of a ray along direction. */
TY_FN void ty_surface_evaluate_color(TY_GLOBAL const ty_surface* surface, const ty_hit* hit, ty_vec direction,
                                     ty_surface_look* out) {
    const bool front = ty_dot(hit->normal, direction) < 0.0f;
    float rgba[4], smooth[3];
    out->ng = front ? hit->normal : ty_scale(hit->normal, -1.0f);
    out->ns = out->ng;
    for (int c = 0; c < 3; ++c) {
        out->albedo[c] = surface->albedo[c];
        out->emission[c] = 0.0f;
    }
    const bool emits = front || surface->two_sided != 0;
    if (surface->indices == NULL) {
        out->light = surface->first_light >= 0 && emits ? surface->first_light + hit->primitive_id : -1;
        const float falloff = surface->cone.exists != 0
                                  ? ty_cone_falloff(surface->cone.cos_outer, surface->cone.cos_inner,
                                                    -ty_dot(surface->cone.axis, direction))
                                  : 1.0f;
        for (int c = 0; c < 3 && out->light >= 0; ++c) out->emission[c] = surface->emission[c] * falloff;
        if (surface->faces == NULL || !ty_texture_exists(&surface->albedo_texture)) return;
        ty_surface_hit_texture(surface, &surface->albedo_texture, 0, surface->albedo_map, hit, rgba);
        for (int c = 0; c < 3; ++c) out->albedo[c] = ty_minf(out->albedo[c] * rgba[c], 1.0f);
        return;
    }
    ty_surface_color(surface, hit->primitive_id, hit->b1, hit->b2, rgba);
    for (int c = 0; c < 3; ++c) out->albedo[c] = ty_minf(rgba[c], 1.0f);
    out->light = surface->lights != NULL && emits ? surface->lights[hit->primitive_id] : -1;
    if (surface->lights != NULL && emits)
        ty_surface_emission(surface, hit->primitive_id, hit->b1, hit->b2, out->emission);
    if (surface->normals == NULL) return;
    ty_surface_interpolate(surface->normals, 3, surface->indices + 3 * (size_t)hit->primitive_id, hit->b1, hit->b2,
                           smooth);
    const ty_vec normal = ty_vec_make(smooth[0], smooth[1], smooth[2]);
    const float square = ty_dot(normal, normal), cosine = ty_dot(normal, hit->normal);
    if (!(square > 1e-12f) || cosine == 0.0f) return;
    out->ns = ty_scale(normal, ((cosine < 0.0f) == front ? -1.0f : 1.0f) / sqrtf(square));
}

/* The same as a part of the surface's properties. */
TY_FN void ty_surface_point_look(TY_GLOBAL const ty_surface* surface, const ty_hit* hit, ty_vec direction,
                                 ty_surface_point* out) {
    ty_surface_look look;
    ty_surface_evaluate_color(surface, hit, direction, &look);
    for (int c = 0; c < 3; ++c) {
        out->albedo[c] = look.albedo[c];
        out->emission[c] = look.emission[c];
    }
    out->ng = look.ng;
    out->ns = look.ns;
    out->light = look.light;
}

/* ---- glossy surfaces: scene/surfaces/gloss.c, or on other devices the text of surface_gloss.k.h ---- */

/* The BSDF of a glossy surface, and its directional albedo in place of the base colour. */
TY_FN_APART void ty_surface_evaluate_gloss(TY_GLOBAL const ty_surface* surface, const ty_hit* hit, ty_vec direction,
                                           ty_surface_point* out);
/* ty_bsdf_evaluate at a point, for directions that the shading normal and the triangle have on the same side. */
TY_FN_APART float ty_surface_evaluate_bsdf(const ty_surface_point* point, ty_vec direction, float factor[3]);
/* ty_bsdf_sample at a point; returns the density of the direction, 1/sr, or 0 for a sample that carries no light. */
TY_FN_APART float ty_surface_sample_bsdf(const ty_surface_point* point, float pick, float u, float v, ty_vec* direction,
                                         float factor[3]);
/* Turns a point's BSDF to single scattering at microfacets. */
TY_FN_APART void ty_surface_drop_compensation(ty_surface_point* point);

/* Surface properties at a hit of a ray along direction. */
TY_FN_CALLED void ty_surface_evaluate(TY_GLOBAL const ty_surface* surface, const ty_hit* hit, ty_vec direction,
                                      ty_surface_point* out) {
    ty_surface_point_look(surface, hit, direction, out);
    out->glossy = surface->gloss != NULL;
    if (out->glossy != 0) ty_surface_evaluate_gloss(surface, hit, direction, out);
}

#endif
