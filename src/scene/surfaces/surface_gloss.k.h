/* Glossy surfaces for kernels: a material's numbers and normals at a hit, and its BSDF. */
#ifndef TY_SCENE_SURFACES_SURFACE_GLOSS_K_H
#define TY_SCENE_SURFACES_SURFACE_GLOSS_K_H

#include "scene/bsdf/bsdf.k.h"
#include "scene/surfaces/surface.k.h"

/* Texel of a glossy material's texture at a hit; false without that texture. */
TY_FN bool ty_surface_gloss_texture(TY_GLOBAL const ty_surface* surface, const ty_hit* hit, int32_t number,
                                    float rgba[4]) {
    TY_GLOBAL const ty_surface_gloss* gloss = surface->gloss;
    if (!ty_texture_exists(&gloss->textures[number])) return false;
    ty_surface_hit_texture(surface, &gloss->textures[number], gloss->uv[number], gloss->map[number], hit, rgba);
    return true;
}

/* A material's numbers at a hit. */
TY_FN ty_bsdf_parameters ty_surface_bsdf_parameters(TY_GLOBAL const ty_surface* surface, const ty_hit* hit,
                                                    const float base_color[3]) {
    ty_bsdf_parameters p = surface->gloss->factor;
    float rgba[4];
    for (int c = 0; c < 3; ++c) p.base_color[c] = base_color[c];
    if (surface->gloss->textured == 0) return p;
    if (ty_surface_gloss_texture(surface, hit, 0, rgba)) {
        p.roughness *= rgba[1];
        p.metallic *= rgba[2];
    }
    if (ty_surface_gloss_texture(surface, hit, 2, rgba)) p.specular *= rgba[3];
    if (ty_surface_gloss_texture(surface, hit, 3, rgba))
        for (int c = 0; c < 3; ++c) p.specular_color[c] *= rgba[c];
    if (ty_surface_gloss_texture(surface, hit, 4, rgba)) p.transmission *= rgba[0];
    if (ty_surface_gloss_texture(surface, hit, 5, rgba)) p.clearcoat *= rgba[0];
    if (ty_surface_gloss_texture(surface, hit, 6, rgba)) p.clearcoat_roughness *= rgba[1];
    if (ty_surface_gloss_texture(surface, hit, 7, rgba))
        for (int c = 0; c < 3; ++c) p.sheen_color[c] *= rgba[c];
    if (ty_surface_gloss_texture(surface, hit, 8, rgba)) p.sheen_roughness *= rgba[3];
    return p;
}

/* Direction in which u of a texture increases in a triangle, and the sign of the bitangent in glTF's sense, with v
 * downwards; 0 where texture coordinates, of a set and by a map, span no area. */
TY_FN ty_vec ty_surface_derive_tangent(TY_GLOBAL const ty_surface* surface, int32_t triangle, int32_t set,
                                       TY_GLOBAL const float* map, ty_vec normal, float* sign) {
    TY_GLOBAL const uint32_t* corners = surface->indices + 3 * (size_t)triangle;
    TY_GLOBAL const float* uv = surface->uv[set];
    const ty_vec a = ty_vec_load(surface->positions + 3 * (size_t)corners[0]);
    const ty_vec ab = ty_sub(ty_vec_load(surface->positions + 3 * (size_t)corners[1]), a);
    const ty_vec ac = ty_sub(ty_vec_load(surface->positions + 3 * (size_t)corners[2]), a);
    *sign = 0.0f;
    if (uv == NULL) return ab;
    TY_GLOBAL const float *uv_a = uv + 2 * (size_t)corners[0], *uv_b = uv + 2 * (size_t)corners[1],
                          *uv_c = uv + 2 * (size_t)corners[2];
    const float sb = uv_b[0] - uv_a[0], tb = uv_b[1] - uv_a[1], sc = uv_c[0] - uv_a[0], tc = uv_c[1] - uv_a[1];
    const float ub = map[0] * sb + map[1] * tb, vb = map[3] * sb + map[4] * tb;
    const float uc = map[0] * sc + map[1] * tc, vc = map[3] * sc + map[4] * tc;
    const float determinant = ub * vc - vb * uc;
    if (!(determinant != 0.0f)) return ab;
    const ty_vec along_u = ty_scale(ty_mad(ty_scale(ab, vc), ac, -vb), 1.0f / determinant);
    const ty_vec along_v = ty_scale(ty_mad(ty_scale(ac, ub), ab, -uc), 1.0f / determinant);
    /* The bitangent points upwards in the map, against v. */
    *sign = ty_dot(ty_cross(normal, along_u), along_v) > 0.0f ? -1.0f : 1.0f;
    return along_u;
}

/* Tangent and sign of the bitangent of a shape. */
TY_FN ty_vec ty_shape_tangent(TY_GLOBAL const ty_surface* surface, const ty_hit* hit, float* sign) {
    TY_GLOBAL const ty_shape_face* face = surface->faces + (surface->round != 0 ? 0 : hit->primitive_id);
    const ty_vec tangent = ty_vec_load(face->tangent);
    *sign = face->tangent[3];
    if (surface->round == 0) return tangent;
    const ty_vec axis = ty_vec_load(face->u);
    return ty_mad(ty_scale(axis, ty_dot(tangent, hit->normal)), tangent, -ty_dot(axis, hit->normal));
}

/* The normal of a texture of normals, 1 of the base or 9 of the clear coat, about a shading normal; front: the ray is
 * before the triangle's front. */
TY_FN ty_vec ty_surface_mapped_normal(TY_GLOBAL const ty_surface* surface, const ty_hit* hit, int32_t number,
                                      float scale, ty_vec ns, bool front) {
    float rgba[4], at[4], sign;
    if (!ty_surface_gloss_texture(surface, hit, number, rgba)) return ns;
    const ty_vec normal = front ? ns : ty_scale(ns, -1.0f);
    ty_vec tangent;
    if (surface->faces != NULL) {
        tangent = ty_shape_tangent(surface, hit, &sign);
    } else if (surface->tangents != NULL) {
        ty_surface_interpolate(surface->tangents, 4, surface->indices + 3 * (size_t)hit->primitive_id, hit->b1, hit->b2,
                               at);
        tangent = ty_vec_make(at[0], at[1], at[2]);
        sign = at[3] < 0.0f ? -1.0f : 1.0f;
    } else {
        tangent = ty_surface_derive_tangent(surface, hit->primitive_id, surface->gloss->uv[number],
                                            surface->gloss->map[number], normal, &sign);
    }
    tangent = ty_mad(tangent, normal, -ty_dot(tangent, normal));
    const float length2 = ty_dot(tangent, tangent);
    if (!(length2 > 1e-30f) || sign == 0.0f) return ns;
    tangent = ty_scale(tangent, 1.0f / sqrtf(length2));
    const ty_vec bitangent = ty_scale(ty_cross(normal, tangent), sign);
    const ty_vec mapped =
        ty_mad(ty_mad(ty_scale(tangent, (2.0f * rgba[0] - 1.0f) * scale), bitangent, (2.0f * rgba[1] - 1.0f) * scale),
               normal, 2.0f * rgba[2] - 1.0f);
    const float square = ty_dot(mapped, mapped);
    return square > 1e-12f ? ty_scale(mapped, (front ? 1.0f : -1.0f) / sqrtf(square)) : ns;
}

/* The normal nearest to `normal` whose mirror direction of wo leaves the surface: shading normals may turn it, or wo,
 * behind the triangle. ng: on the side of wo. */
TY_FN ty_vec ty_surface_reflecting_normal(ty_vec normal, ty_vec ng, ty_vec wo) {
    const float cosine = ty_dot(wo, ng), min_height = ty_minf(0.9f * cosine, 0.01f);
    ty_vec mirrored = ty_mad(ty_scale(wo, -1.0f), normal, 2.0f * ty_dot(normal, wo));
    const float height = ty_dot(mirrored, ng);
    if (height >= min_height && ty_dot(normal, wo) > 0.0f) return normal;
    mirrored = ty_mad(mirrored, ng, min_height - height);
    const float square = ty_dot(mirrored, mirrored);
    const ty_vec half = ty_mad(wo, mirrored, 1.0f / sqrtf(ty_maxf(square, 1e-30f)));
    const float half2 = ty_dot(half, half);
    return half2 > 1e-12f ? ty_scale(half, 1.0f / sqrtf(half2)) : ng;
}

TY_FN_APART void ty_surface_evaluate_gloss(TY_GLOBAL const ty_surface* surface, const ty_hit* hit, ty_vec direction,
                                           ty_surface_point* out) {
    ty_bsdf_parameters p = ty_surface_bsdf_parameters(surface, hit, out->albedo);
    const bool solid = surface->gloss->dielectric.solid != 0;
    out->opaque = solid ? 1.0f - p.transmission * (1.0f - p.metallic) : 1.0f;
    out->roughness = p.roughness;
    for (int c = 0; c < 3; ++c) out->tint[c] = p.base_color[c];
    if (solid) p.transmission = 0.0f;
    const ty_vec wo = ty_scale(direction, -1.0f);
    const bool front = ty_dot(hit->normal, direction) < 0.0f;
    ty_vec coat = out->ns;
    if (surface->gloss->textured != 0) {
        coat = ty_surface_mapped_normal(surface, hit, 9, surface->gloss->normal_scale[1], coat, front);
        out->ns = ty_surface_mapped_normal(surface, hit, 1, surface->gloss->normal_scale[0], out->ns, front);
    }
    ty_bsdf_prepare(&out->bsdf, &p, surface->gloss->tables, ty_surface_reflecting_normal(out->ns, out->ng, wo),
                    ty_surface_reflecting_normal(coat, out->ng, wo), wo);
    for (int c = 0; c < 3; ++c)
        out->albedo[c] = solid ? ty_lerpf(out->bsdf.film, out->bsdf.albedo[c], out->opaque) : out->bsdf.albedo[c];
}

TY_FN_APART float ty_surface_evaluate_bsdf(const ty_surface_point* point, ty_vec direction, float factor[3]) {
    const bool before = ty_dot(point->ng, direction) > 0.0f;
    if (before != (ty_dot(point->bsdf.frame.n, direction) > 0.0f)) return 0.0f;
    return ty_bsdf_evaluate(&point->bsdf, direction, factor);
}

TY_FN_APART float ty_surface_sample_bsdf(const ty_surface_point* point, float pick, float u, float v, ty_vec* direction,
                                         float factor[3]) {
    if (!ty_bsdf_sample(&point->bsdf, pick, u, v, direction)) return 0.0f;
    return ty_surface_evaluate_bsdf(point, *direction, factor);
}

TY_FN_APART void ty_surface_drop_compensation(ty_surface_point* point) {
    ty_bsdf_drop_compensation(&point->bsdf);
}

#endif
