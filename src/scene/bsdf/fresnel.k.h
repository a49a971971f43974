/* Reflection and refraction at smooth dielectric interfaces. eta: index of refraction of the other side over that of
 * the side of wo. */
#ifndef TY_SCENE_BSDF_FRESNEL_K_H
#define TY_SCENE_BSDF_FRESNEL_K_H

#include "base/vector.k.h"

/* Squared cosine of the refracted direction by Snell's law; not positive: total internal reflection. */
TY_FN float ty_refracted_cosine2(float cosine, float eta) {
    return 1.0f - (1.0f - cosine * cosine) / (eta * eta);
}

/* Reflectance for unpolarised light (Fresnel's equations): the mean of both polarisations. */
TY_FN float ty_fresnel_dielectric(float cosine, float eta) {
    const float square = ty_refracted_cosine2(cosine, eta);
    if (!(square > 0.0f)) return 1.0f;
    const float refracted = sqrtf(square);
    const float parallel = (eta * cosine - refracted) / (eta * cosine + refracted);
    const float perpendicular = (cosine - eta * refracted) / (cosine + eta * refracted);
    return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

TY_FN ty_vec ty_reflect(ty_vec wo, ty_vec normal) {
    return ty_mad(ty_scale(wo, -1.0f), normal, 2.0f * ty_dot(wo, normal));
}

/* Direction of the light that is refracted towards wo, where there is one; normal: on the side of wo. */
TY_FN ty_vec ty_refract(ty_vec wo, ty_vec normal, float eta) {
    const float cosine = ty_dot(wo, normal), square = ty_refracted_cosine2(cosine, eta);
    const float along = cosine / eta - sqrtf(ty_maxf(square, 0.0f));
    return ty_normalize(ty_mad(ty_scale(wo, -1.0f / eta), normal, along));
}

#endif
