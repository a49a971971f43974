/* GGX microfacets in a frame whose z axis is the normal: normal distribution, masking and shadowing by Smith, sampling
 * of visible normals. alpha: width of the distribution, the square of a material's roughness. */
#ifndef TY_SCENE_BSDF_MICROFACET_K_H
#define TY_SCENE_BSDF_MICROFACET_K_H

#include "base/vector.k.h"

/* Smallest alpha: reflections are blurred by a tenth of a degree, and densities stay within the range of floats. */
#define TY_ALPHA_MIN 1e-3f

TY_FN float ty_ggx_alpha(float roughness) {
    return ty_maxf(roughness * roughness, TY_ALPHA_MIN);
}

/* Normal distribution function D, Eq. 33 (Walter 2007), from the tangent components of h, which keep their
 * precision where those of 1 - h.z^2 are lost. */
TY_FN float ty_ggx_ndf(ty_vec h, float alpha) {
    const float a2 = alpha * alpha;
    const float stretched = (h.x * h.x + h.y * h.y) / a2 + h.z * h.z;
    return 1.0f / (TY_PI * a2 * stretched * stretched);
}

/* sqrt(alpha^2 (1 - c^2) + c^2): with it, Smith's masking G1 is 2 c / (c + this), Eq. 34 (Walter 2007). */
TY_FN float ty_ggx_smith_root(float cosine, float alpha) {
    const float a2 = alpha * alpha;
    return sqrtf(a2 + (1.0f - a2) * cosine * cosine);
}

/* G2 / (4 cos_i cos_o), with the height-correlated masking and shadowing G2 of Smith, Eq. 99 (Heitz 2014). */
TY_FN float ty_ggx_visibility(float cos_i, float cos_o, float alpha) {
    return 0.5f / (cos_i * ty_ggx_smith_root(cos_o, alpha) + cos_o * ty_ggx_smith_root(cos_i, alpha));
}

/* Factor k of bounded sampling of visible normals (Eto and Tokuyoshi 2023, listing 1): the part of the spherical cap
 * whose reflections stay above the horizon. wo.z > 0. */
TY_FN float ty_ggx_cap_bound(ty_vec wo, float alpha) {
    const float a2 = alpha * alpha, s = 1.0f + sqrtf(wo.x * wo.x + wo.y * wo.y), s2 = s * s;
    return (1.0f - a2) * s2 / (s2 + a2 * wo.z * wo.z);
}

/* Samples the normal of a visible microfacet whose reflection of wo is above the horizon, but for rounding and a small
 * part of wide distributions (Eto and Tokuyoshi 2023); wo.z > 0. */
TY_FN ty_vec ty_ggx_sample(ty_vec wo, float alpha, float u, float v) {
    const ty_vec stretched = ty_normalize(ty_vec_make(alpha * wo.x, alpha * wo.y, wo.z));
    const float b = ty_ggx_cap_bound(wo, alpha) * stretched.z;
    const float z = (1.0f - u) * (1.0f + b) - b;
    const float radius = sqrtf(ty_maxf(0.0f, 1.0f - z * z));
    float sine, cosine;
    ty_sincos_2pi(v, &sine, &cosine);
    const ty_vec cap = ty_add(ty_vec_make(radius * cosine, radius * sine, z), stretched);
    return ty_normalize(ty_vec_make(alpha * cap.x, alpha * cap.y, ty_maxf(cap.z, 1e-9f)));
}

/* Density of the reflection of wo at a normal h of ty_ggx_sample, 1/sr. */
TY_FN float ty_ggx_pdf(ty_vec wo, ty_vec h, float alpha) {
    const float root = ty_ggx_smith_root(wo.z, alpha);
    return ty_ggx_ndf(h, alpha) / (2.0f * (ty_ggx_cap_bound(wo, alpha) * wo.z + root));
}

/* The weight (1 - cosine)^5 of F90 in Schlick's Fresnel reflectance F0 + (F90 - F0) (1 - cosine)^5 (Schlick 1994). */
TY_FN float ty_schlick_weight(float cosine) {
    const float x = ty_clampf(1.0f - cosine, 0.0f, 1.0f), x2 = x * x;
    return x2 * x2 * x;
}

/* Reflectance of a dielectric surface at normal incidence. */
TY_FN float ty_dielectric_f0(float ior) {
    const float r = (ior - 1.0f) / (ior + 1.0f);
    return r * r;
}

#endif
