/* Sheen of cloth: the "Charlie" distribution of fibres and its masking (Estevez and Kulla 2017), as in
 * KHR_materials_sheen. Frame and cosines as in microfacet.k.h. */
#ifndef TY_SCENE_BSDF_SHEEN_K_H
#define TY_SCENE_BSDF_SHEEN_K_H

#include "base/vector.k.h"

/* Smallest roughness of sheen; alpha is its square. */
#define TY_SHEEN_ROUGHNESS_MIN 0.1f

TY_FN float ty_sheen_alpha(float roughness) {
    const float r = ty_maxf(roughness, TY_SHEEN_ROUGHNESS_MIN);
    return r * r;
}

/* D = (2 + 1 / alpha) sin(theta_h)^(1 / alpha) / (2 pi), Eq. 2 (Estevez 2017). */
TY_FN float ty_sheen_ndf(float cos_h, float alpha) {
    const float inverse = 1.0f / alpha, sine2 = ty_maxf(1.0f - cos_h * cos_h, 1e-12f);
    return (2.0f + inverse) * ty_expf(0.5f * inverse * ty_logf(sine2)) * (0.5f / TY_PI);
}

/* The fitted curve L(x) = a / (1 + b x^c) + d x + e, Eq. 3 (Estevez 2017), with the constants of Table 1 (Estevez 2017)
 * for alpha 0 and 1. */
TY_FN float ty_sheen_curve(float x, float alpha) {
    const float t = (1.0f - alpha) * (1.0f - alpha);
    const float a = ty_lerpf(21.5473f, 25.3245f, t), b = ty_lerpf(3.82987f, 3.32435f, t);
    const float c = ty_lerpf(0.19823f, 0.16801f, t), d = ty_lerpf(-1.97760f, -1.27393f, t);
    const float e = ty_lerpf(-4.32054f, -4.85967f, t);
    return a / (1.0f + b * ty_expf(c * ty_logf(ty_maxf(x, 1e-6f)))) + d * x + e;
}

/* Smith's Lambda of the fibres. */
TY_FN float ty_sheen_lambda(float cosine, float alpha) {
    if (cosine < 0.5f) return ty_expf(ty_sheen_curve(cosine, alpha));
    return ty_expf(2.0f * ty_sheen_curve(0.5f, alpha) - ty_sheen_curve(1.0f - cosine, alpha));
}

/* BRDF of white sheen. */
TY_FN float ty_sheen_brdf(ty_vec wi, ty_vec wo, float alpha) {
    const ty_vec h = ty_normalize(ty_add(wi, wo));
    const float shadowing = 1.0f + ty_sheen_lambda(wi.z, alpha) + ty_sheen_lambda(wo.z, alpha);
    return ty_sheen_ndf(h.z, alpha) / (4.0f * wi.z * wo.z * shadowing);
}

#endif
