/* Light that keeps the direction it came in with, and what of it scatters once more.
 *
 * Of a beam e^-tau goes straight through, tau the integral of sigma_t. What has scattered n times has the moments
 * g^(n l) about the beam; over the Poisson number of scatterings the l-th is e^-tau_l, tau_l of sigma_t - g^l sigma_s
 * (the exact form of what Elek et al. 2014, Eq. 4, have for g -> 1). Diffusion, which knows two moments, is exact to
 * them if what it is not given stays with the beam as both fluence and flux: R = e^-tau_1, the reduced beam. So light
 * that has scattered and kept its direction is R - U (U = e^-tau) with the moments (R - U), (R - U), S - U, ...,
 * S = e^-tau_2: of b = (S - U) / (R - U) to the power l - 1, the lobe ((R - U) / b) (HG(b) - (1 - b) / (4 pi)). */
#ifndef TY_DIRECT_FORWARD_K_H
#define TY_DIRECT_FORWARD_K_H

#include "scene/phase.k.h"

/* Fluences U, R and S of a beam (or what is proportional to them), and the mean cosine of what came in. */
typedef struct ty_forward {
    float straight, kept, bent;
    float cosine; /* 1: a line; 0..1 */
} ty_forward;

/* Mean cosine below which a lobe counts as linear in the cosine. */
#define TY_FORWARD_BROAD 0.01f

TY_FN float ty_forward_scattered_share(float mu, float b, float g) {
    if (b < TY_FORWARD_BROAD) return TY_INV_4PI * (1.0f + 3.0f * g * mu);
    return (ty_hg(mu, b * g) - TY_INV_4PI) / b + TY_INV_4PI;
}

/* What of the light that has scattered and kept its direction scatters once more in a medium of mean cosine g at cosine
 * mu, per scattering coefficient; below 0 where the diffuse light, to which it belongs, is more. */
TY_FN float ty_forward_scattered(ty_forward light, float mu, float g) {
    const float lobe = ty_maxf(0.0f, light.kept - light.straight);
    const float bent = ty_clampf(light.bent - light.straight, 0.0f, lobe);
    return lobe * ty_forward_scattered_share(mu, bent / ty_maxf(lobe, 1e-30f), light.cosine * g);
}

/* What of the light that has not scattered does so, the same. */
TY_FN float ty_forward_straight(ty_forward light, float mu, float g) {
    return light.straight * ty_hg(mu, light.cosine * g);
}

#endif
