/* Rough dielectric interfaces: reflection and refraction at GGX microfacets (Walter et al. 2007), with the exact
 * Fresnel reflectance of each microfacet, directions sampled from visible normals (Heitz 2018), and energy
 * compensation.
 *
 * Radiance is taken as L / n^2, which refraction does not change: so the BSDF here is that of Walter et al. 2007 times
 * n_i^2 / n_o^2. Reflection has height-correlated masking and shadowing, refraction the product of both.
 *
 * Energy compensation (Kulla and Conty 2017): light that single scattering loses, l(wo) = 1 - E(wo), leaves by the
 * lobes l(wo) l(wi) / (pi l_mean), with l of the side where it leaves. A part x of it crosses the interface. With n_o^2
 * T_o = n_i^2 T_i, where T are the mean transmittances of the smooth interface, x_o = T_o l_i / (T_o l_i + T_i l_o) is
 * reciprocal. */
#ifndef TY_SCENE_BSDF_DIELECTRIC_K_H
#define TY_SCENE_BSDF_DIELECTRIC_K_H

#include "scene/bsdf/bsdf.k.h"
#include "scene/bsdf/fresnel.k.h"

/* A rough interface for one direction wo. */
typedef struct ty_rough_dielectric {
    TY_GLOBAL const ty_bsdf_tables* tables;
    ty_frame frame;
    ty_vec wo; /* in the frame */
    float roughness, alpha, eta;
    float tint[3];               /* colour of the light that crosses the interface */
    float lost;                  /* 1 - E(wo); 0 without energy compensation */
    float lost_mean, other_mean; /* means of it over cosine-weighted directions, on this and on the other side */
    float through;               /* part of the lost light that crosses */
} ty_rough_dielectric;

/* Part of the light that single scattering loses; eta as seen from the direction's own side. */
TY_FN float ty_dielectric_lost(TY_GLOBAL const ty_bsdf_tables* tables, float eta, float cosine, float roughness) {
    int32_t row;
    const float fraction = ty_dielectric_row(eta, &row);
    TY_GLOBAL const float* at = tables->dielectric + row * (TY_BSDF_ROUGHNESSES * TY_BSDF_COSINES);
    return 1.0f - ty_lerpf(ty_bsdf_albedo(at, cosine, roughness),
                           ty_bsdf_albedo(at + TY_BSDF_ROUGHNESSES * TY_BSDF_COSINES, cosine, roughness), fraction);
}

TY_FN float ty_dielectric_lost_mean(TY_GLOBAL const ty_bsdf_tables* tables, float eta, float roughness) {
    int32_t row;
    const float fraction = ty_dielectric_row(eta, &row);
    TY_GLOBAL const float* at = tables->dielectric_mean + row * TY_BSDF_ROUGHNESSES;
    return ty_maxf(
        1.0f - ty_lerpf(ty_bsdf_mean(at, roughness), ty_bsdf_mean(at + TY_BSDF_ROUGHNESSES, roughness), fraction),
        1e-6f);
}

/* Mean transmittance of a smooth interface over cosine-weighted directions, by Gauss-Legendre quadrature. */
TY_FN float ty_dielectric_mean_transmittance(float eta) {
    const float nodes[4] = {0.06943184f, 0.33000948f, 0.66999052f, 0.93056816f};
    const float weights[4] = {0.17392742f, 0.32607258f, 0.32607258f, 0.17392742f};
    /* From the denser side no light passes beyond the critical angle, and n_o^2 T_o = n_i^2 T_i. */
    const float above = eta > 1.0f ? eta : 1.0f / eta;
    float sum = 0.0f;
    for (int32_t i = 0; i < 4; ++i)
        sum += weights[i] * 2.0f * nodes[i] * (1.0f - ty_fresnel_dielectric(nodes[i], above));
    return eta > 1.0f ? sum : sum * eta * eta;
}

/* wo: unit, in front of the frame's normal. */
TY_FN void ty_rough_dielectric_prepare(ty_rough_dielectric* d, TY_GLOBAL const ty_bsdf_tables* tables,
                                       const ty_frame* frame, ty_vec wo, float eta, float roughness,
                                       const float tint[3], bool compensated) {
    d->tables = tables;
    d->frame = *frame;
    d->wo = ty_frame_local(frame, wo);
    d->roughness = roughness;
    d->alpha = ty_ggx_alpha(roughness);
    d->eta = eta;
    for (int c = 0; c < 3; ++c) d->tint[c] = tint[c];
    d->lost = compensated ? ty_maxf(ty_dielectric_lost(tables, eta, d->wo.z, roughness), 0.0f) : 0.0f;
    d->lost_mean = ty_dielectric_lost_mean(tables, eta, roughness);
    d->other_mean = ty_dielectric_lost_mean(tables, 1.0f / eta, roughness);
    const float own = ty_dielectric_mean_transmittance(eta), other = ty_dielectric_mean_transmittance(1.0f / eta);
    d->through = own * d->other_mean / (own * d->other_mean + other * d->lost_mean);
}

/* Density of a visible normal h: G1(wo) (wo.h) D(h) / cos_o (Heitz 2018), 1/sr. */
TY_FN float ty_ggx_visible_pdf(ty_vec wo, ty_vec h, float alpha) {
    return 2.0f * ty_ggx_ndf(h, alpha) * ty_dot(wo, h) / (wo.z + ty_ggx_smith_root(wo.z, alpha));
}

/* Samples the normal of a visible microfacet, on a spherical cap (Dupuy and Benyoub 2023). */
TY_FN ty_vec ty_ggx_sample_visible(ty_vec wo, float alpha, float u, float v) {
    const ty_vec stretched = ty_normalize(ty_vec_make(alpha * wo.x, alpha * wo.y, wo.z));
    const float z = (1.0f - u) * (1.0f + stretched.z) - stretched.z;
    const float radius = sqrtf(ty_maxf(0.0f, 1.0f - z * z));
    float sine, cosine;
    ty_sincos_2pi(v, &sine, &cosine);
    const ty_vec cap = ty_add(ty_vec_make(radius * cosine, radius * sine, z), stretched);
    return ty_normalize(ty_vec_make(alpha * cap.x, alpha * cap.y, ty_maxf(cap.z, 1e-9f)));
}

/* Single reflection for wi above the interface; returns its density. */
TY_FN float ty_rough_reflection(const ty_rough_dielectric* d, ty_vec wi, float* value) {
    const ty_vec h = ty_normalize(ty_add(wi, d->wo));
    const float projected = ty_dot(d->wo, h), fresnel = ty_fresnel_dielectric(projected, d->eta);
    *value = fresnel * ty_ggx_ndf(h, d->alpha) * ty_ggx_visibility(wi.z, d->wo.z, d->alpha) * wi.z;
    return fresnel * ty_ggx_visible_pdf(d->wo, h, d->alpha) / (4.0f * projected);
}

/* Single refraction for wi below the interface, Eq. 16, 17 and 21 (Walter 2007); returns its density. */
TY_FN float ty_rough_refraction(const ty_rough_dielectric* d, ty_vec wi, float* value) {
    ty_vec h = ty_mad(d->wo, wi, d->eta);
    const float square = ty_dot(h, h);
    *value = 0.0f;
    if (!(square > 0.0f)) return 0.0f;
    h = ty_scale(h, (h.z < 0.0f ? -1.0f : 1.0f) / sqrtf(square));
    const float out = ty_dot(d->wo, h), in = ty_dot(wi, h);
    if (!(out > 0.0f) || !(in < 0.0f)) return 0.0f;
    const float both = out + d->eta * in;
    const float passed = 1.0f - ty_fresnel_dielectric(out, d->eta);
    const float density =
        passed * ty_ggx_visible_pdf(d->wo, h, d->alpha) * d->eta * d->eta * -in / ty_maxf(both * both, 1e-20f);
    *value = density * 2.0f * -wi.z / (ty_ggx_smith_root(wi.z, d->alpha) - wi.z);
    return density;
}

/* BSDF times cosine for light from `direction`; returns the density of ty_rough_dielectric_sample there, 1/sr. */
TY_FN float ty_rough_dielectric_evaluate(const ty_rough_dielectric* d, ty_vec direction, float factor[3]) {
    const ty_vec wi = ty_frame_local(&d->frame, direction);
    const bool through = wi.z < 0.0f;
    const float cosine = fabsf(wi.z);
    float value = 0.0f;
    for (int c = 0; c < 3; ++c) factor[c] = 0.0f;
    if (!(cosine > 0.0f) || !(d->wo.z > 0.0f)) return 0.0f;
    float pdf = through ? ty_rough_refraction(d, wi, &value) : ty_rough_reflection(d, wi, &value);
    if (d->lost > 0.0f) {
        const float part = d->lost * (through ? d->through : 1.0f - d->through);
        const float lost = ty_dielectric_lost(d->tables, through ? 1.0f / d->eta : d->eta, cosine, d->roughness);
        value += part * lost / (through ? d->other_mean : d->lost_mean) * cosine * (1.0f / TY_PI);
        pdf = (1.0f - d->lost) * pdf + part * ty_bsdf_power_pdf(d->roughness, cosine);
    }
    for (int c = 0; c < 3; ++c) factor[c] = value * (through ? d->tint[c] : 1.0f);
    return pdf;
}

/* Samples a direction towards the light; pick, u, v: uniform in [0, 1). False: the sample carries no light. */
TY_FN bool ty_rough_dielectric_sample(const ty_rough_dielectric* d, float pick, float u, float v, ty_vec* direction) {
    ty_vec wi;
    if (!(d->wo.z > 0.0f)) return false;
    if (pick < d->lost) {
        const bool through = pick < d->lost * d->through;
        wi = ty_direction_about(ty_vec_make(0.0f, 0.0f, 1.0f),
                                ty_expf(ty_logf(ty_maxf(1.0f - u, 1e-30f)) / (d->roughness + 1.0f)), v);
        if (through) wi.z = -wi.z;
    } else {
        pick = (pick - d->lost) / (1.0f - d->lost);
        const ty_vec h = ty_ggx_sample_visible(d->wo, d->alpha, u, v);
        const float projected = ty_dot(d->wo, h);
        const bool reflects = pick < ty_fresnel_dielectric(projected, d->eta);
        wi = reflects ? ty_normalize(ty_reflect(d->wo, h)) : ty_refract(d->wo, h, d->eta);
        if (reflects ? !(wi.z > 0.0f) : !(wi.z < 0.0f)) return false;
    }
    *direction = ty_frame_world(&d->frame, wi);
    return true;
}

#endif
