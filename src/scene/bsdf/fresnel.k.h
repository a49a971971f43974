/* Reflectance of a smooth interface between two dielectrics. */
#ifndef TY_SCENE_BSDF_FRESNEL_K_H
#define TY_SCENE_BSDF_FRESNEL_K_H

#include "base/kernel.h"

/* Fresnel's reflectance for unpolarised light that arrives at the cosine `cosine`, 0..1, within the index n relative
 * to the other side; 1 beyond the critical angle (total internal reflection). *transmitted: cosine of the refracted
 * direction (Snell's law), 0 there. */
TY_FN float ty_fresnel_dielectric(float cosine, float n, float* transmitted) {
    const float sine2 = n * n * (1.0f - cosine * cosine);
    *transmitted = 0.0f;
    if (sine2 >= 1.0f) return 1.0f;
    const float t = sqrtf(1.0f - sine2);
    const float s = (n * cosine - t) / (n * cosine + t), p = (cosine - n * t) / (cosine + n * t);
    *transmitted = t;
    return 0.5f * (s * s + p * p);
}

#endif
