/* Lights for kernels: sampling from a point, and the densities for MIS weights. */
#ifndef TY_SCENE_LIGHTS_LIGHT_K_H
#define TY_SCENE_LIGHTS_LIGHT_K_H

#include "scene/lights/environment.k.h"
#include "scene/surfaces/surface.k.h"

/* ty_light_kind, and emissive spheres and triangles, from shapes and meshes. */
enum {
    TY_KIND_DIRECTIONAL = 0,
    TY_KIND_POINT = 1,
    TY_KIND_SPOT = 2,
    TY_KIND_AREA = 3,
    TY_KIND_ENVIRONMENT = 4,
    TY_KIND_SPHERE = 5,
    TY_KIND_TRIANGLE = 6
};

typedef struct ty_light_view {
    int32_t kind;
    float color[3];    /* irradiance, intensity or radiance; the mean if textured */
    ty_vec position;   /* point, spot; area, triangle: corner; sphere: center */
    ty_vec direction;  /* directional, cone: direction of propagation; area, triangle: unit normal of the front */
    ty_vec u, v;       /* area, triangle: edges */
    float area;        /* area, triangle: m^2 */
    int32_t two_sided; /* triangle: emits on both sides, otherwise on its front */
    /* Triangle: surface for radiance lookups, alpha included; NULL: uniform color. */
    TY_GLOBAL const ty_surface* textured;
    int32_t primitive_id;       /* triangle: index in the mesh */
    float radius;               /* sphere */
    int32_t cone;               /* sphere: nonzero for that of a spot */
    float cos_outer, cos_inner; /* of a cone: smooth falloff from inner to outer */
    float typical;    /* unshadowed fluence at a typical distance, W m^-2; 0 for lights better hit than sampled */
    float reach2;     /* m^2; within this squared distance of a local light, media are bright */
    float chosen;     /* distant lights: probability of selection */
    float cumulative; /* cumulative sum of chosen, including this light and all positioned ones */
    ty_environment_view environment;
} ty_light_view;

/* Local lights: small against their distance and bright nearby, so that media sample them along rays. */
TY_FN bool ty_light_is_local(int32_t kind) {
    return kind == TY_KIND_POINT || kind == TY_KIND_SPOT || kind == TY_KIND_AREA || kind == TY_KIND_TRIANGLE;
}

/* Lamps: local lights without extent, which only sampling finds. */
TY_FN bool ty_light_is_point_or_spot(int32_t kind) {
    return kind == TY_KIND_POINT || kind == TY_KIND_SPOT;
}

/* Sample of a light from a point. */
typedef struct ty_light_sample {
    ty_vec wi;         /* unit, to the light */
    float distance;    /* distance to the light; TY_FLOAT_MAX at infinity */
    float radiance[3]; /* radiance / pdf, or for delta lights irradiance on a plane facing the light */
    float pdf;         /* 1/sr, given the light's selection; 0 for delta lights */
} ty_light_sample;

/* Light of a lamp at cosine mu from its axis, relative to the axis. */
TY_FN float ty_spot_falloff(TY_GLOBAL const ty_light_view* light, float mu) {
    return ty_cone_falloff(light->cos_outer, light->cos_inner, mu);
}

/* The same of a lamp that may shine in all directions, seen along wi. */
TY_FN float ty_light_falloff(TY_GLOBAL const ty_light_view* light, ty_vec wi) {
    const bool cone = light->kind == TY_KIND_SPOT || light->cone != 0;
    return cone ? ty_spot_falloff(light, -ty_dot(wi, light->direction)) : 1.0f;
}

/* Cosine of the half angle subtended by a sphere from outside, at squared distance d2. */
TY_FN float ty_sphere_cos_max(float radius, float d2) {
    return sqrtf(ty_maxf(0.0f, 1.0f - radius * radius / d2));
}

/* 1 - cos of that angle, without cancellation for small spheres. */
TY_FN float ty_sphere_cap(float radius, float d2) {
    const float s2 = ty_minf(1.0f, radius * radius / d2);
    return s2 / (1.0f + ty_sphere_cos_max(radius, d2));
}

TY_FN bool ty_light_set_rgb(float out[3], TY_GLOBAL const float in[3], float factor) {
    for (int c = 0; c < 3; ++c) out[c] = in[c] * factor;
    return factor > 0.0f;
}

/* Point on an area light or triangle, uniform in area; b1, b2: barycentric weights of the edges. */
TY_FN ty_vec ty_light_point(TY_GLOBAL const ty_light_view* light, float u, float v, float* b1, float* b2) {
    const float root = light->kind == TY_KIND_TRIANGLE ? sqrtf(u) : 1.0f;
    *b1 = light->kind == TY_KIND_TRIANGLE ? 1.0f - root : u;
    *b2 = root * v;
    return ty_mad(ty_mad(light->position, light->u, *b1), light->v, *b2);
}

/* Cosine at a flat light's front for direction `wi` to the light: negative from behind, or positive there too for
 * two-sided lights. */
TY_FN float ty_light_facing(TY_GLOBAL const ty_light_view* light, ty_vec wi) {
    const float mu = -ty_dot(wi, light->direction);
    return light->two_sided != 0 ? fabsf(mu) : mu;
}

/* Samples a light from point `from`; false if the sample carries no light. */
TY_FN bool ty_light_sample_from(TY_GLOBAL const ty_light_view* light, ty_vec from, float u, float v,
                                ty_light_sample* out) {
    out->pdf = 0.0f;
    out->distance = TY_FLOAT_MAX;
    if (light->kind == TY_KIND_DIRECTIONAL) {
        out->wi = ty_scale(light->direction, -1.0f);
        return ty_light_set_rgb(out->radiance, light->color, 1.0f);
    }
    if (light->kind == TY_KIND_ENVIRONMENT) {
        float radiance[3];
        out->pdf = ty_environment_sample(&light->environment, u, v, &out->wi);
        ty_environment_radiance(&light->environment, out->wi, radiance);
        return out->pdf > 0.0f && ty_light_set_rgb(out->radiance, radiance, 1.0f / out->pdf);
    }
    const bool flat = light->kind == TY_KIND_AREA || light->kind == TY_KIND_TRIANGLE;
    float b1 = 0.0f, b2 = 0.0f;
    const ty_vec point = flat ? ty_light_point(light, u, v, &b1, &b2) : light->position;
    const ty_vec to = ty_sub(point, from);
    const float d2 = ty_dot(to, to);
    if (!(d2 > 0.0f)) return false;
    if (light->kind == TY_KIND_SPHERE) {
        if (d2 <= light->radius * light->radius) return false;
        const float cap = ty_sphere_cap(light->radius, d2), mu = 1.0f - u * cap;
        const float d = sqrtf(d2);
        out->wi = ty_direction_about(ty_scale(to, 1.0f / d), mu, v);
        const float off2 = d2 * (1.0f - mu) * (1.0f + mu);
        out->distance = d * mu - sqrtf(ty_maxf(0.0f, light->radius * light->radius - off2));
        out->pdf = 1.0f / (2.0f * TY_PI * cap);
        return ty_light_set_rgb(out->radiance, light->color, ty_light_falloff(light, out->wi) / out->pdf);
    }
    out->distance = sqrtf(d2);
    out->wi = ty_scale(to, 1.0f / out->distance);
    if (flat) {
        const float mu = ty_light_facing(light, out->wi);
        if (mu <= 0.0f) return false;
        out->pdf = d2 / (mu * light->area);
        if (light->textured == NULL) return ty_light_set_rgb(out->radiance, light->color, 1.0f / out->pdf);
        float emission[3];
        ty_surface_mean_emission(light->textured, light->primitive_id, b1, b2, emission);
        return ty_light_set_rgb(out->radiance, emission, 1.0f / out->pdf);
    }
    return ty_light_set_rgb(out->radiance, light->color, ty_light_falloff(light, out->wi) / d2);
}

/* Density of ty_light_sample_from, 1/sr, for the direction of a ray from `from` that hit a surface light (area,
 * triangle or sphere) at distance. */
TY_FN float ty_light_pdf(TY_GLOBAL const ty_light_view* light, ty_vec from, ty_vec wi, float distance) {
    if (light->kind == TY_KIND_SPHERE) {
        const ty_vec to = ty_sub(light->position, from);
        const float d2 = ty_dot(to, to);
        return d2 <= light->radius * light->radius ? 0.0f : 1.0f / (2.0f * TY_PI * ty_sphere_cap(light->radius, d2));
    }
    const float mu = ty_light_facing(light, wi);
    return mu > 0.0f ? distance * distance / (mu * light->area) : 0.0f;
}

#endif
