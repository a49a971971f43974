/* Collided light that still travels in the forward lobe of a beam, and its next scattering.
 *
 * Unscattered light falls off as U = e^-tau, tau being the integral of sigma_t. After n collisions the l-th Legendre
 * moment of the radiance about the beam is g^(n l); the Poisson mean over n gives e^-tau_l with tau_l the integral of
 * sigma_t - g^l sigma_s (exact form of Eq. 4 (Elek 2014), which holds for g -> 1). Diffusion solves for two moments. It
 * stays exact in both if the light that is withheld from its source is the reduced beam R = e^-tau_1, as fluence and as
 * flux (similarity; Joseph, Wiscombe and Weinman 1976). So the collided light in the forward lobe has the moments R -
 * U, R - U, S - U, ... with S = e^-tau_2. With b = (S - U) / (R - U), moment l is taken as (R - U) b^(l - 1): the lobe
 * ((R - U) / b) (HG(b) - (1 - b) / (4 pi)). */
#ifndef TY_DIRECT_SINGLE_FORWARD_K_H
#define TY_DIRECT_SINGLE_FORWARD_K_H

#include "base/legendre.k.h"
#include "scene/media/phase.k.h"

/* Fluences U, R and S of a beam, in a common unit, and the mean cosine of the light before the medium. */
typedef struct ty_forward {
    float phi_unscattered, phi_order_l, phi_next_order;
    float mean_cosine; /* 0..1; 1: a line */
} ty_forward;

/* Delta-fit of a phase function (Hu et al. 2000): a forward fraction f counts as unscattered, and Legendre moments c_l,
 * l < bands, fit the phase function outside of its peak. */
enum { TY_FORWARD_BANDS_MAX = 12 };
typedef struct ty_forward_fit {
    int32_t bands; /* 0: no fit; phase functions are truncated after L bands (delta-M, Wiscombe 1977) */
    float forward_fraction;
    float moments[TY_FORWARD_BANDS_MAX];
} ty_forward_fit;

/* Mean number of collisions after which hardly any light is left in the peak; e to this power fits a float. */
#define TY_FORWARD_MAX_COLLISIONS 80.0f

/* Cosines at which the weight of the peak begins to rise, and at which it is 1. */
#define TY_FORWARD_PEAK_BEGIN 0.7f
#define TY_FORWARD_PEAK_FULL 0.9f

/* (4 pi HG(x) - 1) / x, which is 3 mu at x = 0. */
TY_FN float ty_hg_slope(float mu, float x) {
    const float base = ty_maxf((1.0f - x) * (1.0f - x) + 2.0f * x * (1.0f - mu), 1e-10f);
    const float u = sqrtf(base), cube = base * u;
    return ((2.0f * mu - x) * (1.0f + u + base) - x * (1.0f + u)) / ((1.0f + u) * cube);
}

/* Mean cosine b = (S - U) / (R - U) of the collided light in the lobe; u, r, s are U, R, S. */
TY_FN float ty_forward_lobe_cosine(float u, float r, float s) {
    return ty_clampf((s - u) / ty_maxf(r - u, 1e-20f), 0.0f, 1.0f);
}

/* Radiance of the lobe at cosine mu, after one more scattering with mean cosine `spread` (of the phase function, of the
 * incident light, or their product). Its first moments are exact; far from the axis it may be slightly negative, which
 * the diffuse light compensates. */
TY_FN float ty_forward_lobe(float mu, float u, float r, float s, float spread) {
    const float x = ty_forward_lobe_cosine(u, r, s) * spread;
    return ty_maxf(0.0f, r - u) * TY_INV_4PI * (1.0f + spread * ty_hg_slope(mu, x));
}

/* Lobe light scattered once more in a medium of mean cosine g at cosine mu, per scattering coefficient. It may be
 * negative, as the diffuse light that it belongs to is larger. */
TY_FN float ty_forward_scattered(ty_forward light, float mu, float g) {
    return ty_forward_lobe(mu, light.phi_unscattered, light.phi_order_l, light.phi_next_order, light.mean_cosine * g);
}

/* Number of terms of the slowly convergent series, and the smallest b^L for which its closed form keeps its digits. */
enum { TY_FORWARD_SERIES_TERMS = 16 };
#define TY_FORWARD_MIN_POWER 1e-2f

/* 4 pi times the scattering at cosine mu, by mean cosine g, of a lobe with moments 1 for l <= L and b^(l - L) above.
 * below: the sum over l < L. L = order >= 1. */
TY_FN float ty_forward_tail(float b, float mu, float g, int32_t order, float* below) {
    const float x = g * b;
    float p_before = 0.0f, p_l = 1.0f, g_l = 1.0f, x_l = 1.0f, b_l = 1.0f, low_sum = 0.0f, tail = 0.0f;
    int32_t l = 0;
    *below = 0.0f;
    for (; l < order; ++l) {
        const float weight = (float)(2 * l + 1) * p_l;
        const float p_next = ty_legendre_next(l, mu, p_l, p_before);
        *below += weight * g_l;
        low_sum += weight * x_l;
        p_before = p_l;
        p_l = p_next;
        g_l *= g;
        x_l *= x;
        b_l *= b;
    }
    if (b_l > TY_FORWARD_MIN_POWER) return (4.0f * TY_PI * ty_hg(mu, x) - low_sum) / b_l;
    for (; l < order + TY_FORWARD_SERIES_TERMS; ++l) {
        const float p_next = ty_legendre_next(l, mu, p_l, p_before);
        tail += (float)(2 * l + 1) * p_l * g_l;
        p_before = p_l;
        p_l = p_next;
        g_l *= x;
    }
    return tail;
}

/* 4 pi times the same scattering by a phase function of Legendre moments 0 .. L + 1 in place of g^l: those above L + 1
 * are taken as a geometric sequence. */
TY_FN float ty_forward_tail_of(float b, float mu, TY_GLOBAL const float* legendre, int32_t order, float* below) {
    float p_before = 0.0f, p_l = 1.0f, sum = 0.0f, unused, power = 1.0f;
    const float g = ty_clampf(legendre[order + 1] / ty_maxf(legendre[order], 1e-6f), 0.05f, 0.999f);
    for (int32_t l = 0; l < order; ++l) {
        const float p_next = ty_legendre_next(l, mu, p_l, p_before);
        sum += (float)(2 * l + 1) * p_l * legendre[l];
        p_before = p_l;
        p_l = p_next;
        power *= g;
    }
    *below = sum;
    return ty_forward_tail(b, mu, g, order, &unused) * ty_maxf(0.0f, legendre[order]) / power;
}

/* Like ty_forward_scattered, for a solver of L moments that is given R with tau of sigma_t - g^L sigma_s in full
 * (delta-M); S has order L + 1. legendre: NULL: g^l. The collided light in the lobe has the moments R - U for l <= L,
 * and (R - U) b^(l - L) above, with b = (S - U) / (R - U). */
TY_FN float ty_forward_scattered_order(ty_forward light, float mu, float g, TY_GLOBAL const float* legendre,
                                       int32_t order) {
    float below;
    const float b = ty_forward_lobe_cosine(light.phi_unscattered, light.phi_order_l, light.phi_next_order);
    const float tail = legendre != NULL ? ty_forward_tail_of(b, mu, legendre, order, &below)
                                        : ty_forward_tail(b, mu, g, order, &below);
    return ty_maxf(0.0f, light.phi_order_l - light.phi_unscattered) * TY_INV_4PI * (below + tail);
}

/* Weight of the peak at cosine mu. */
TY_FN float ty_forward_peak_weight(float mu) {
    const float x =
        ty_clampf((mu - TY_FORWARD_PEAK_BEGIN) * (1.0f / (TY_FORWARD_PEAK_FULL - TY_FORWARD_PEAK_BEGIN)), 0.0f, 1.0f);
    return x * x * (3.0f - 2.0f * x);
}

/* The fitted phase function: sum of (2 l + 1) c_l P_l(mu) / (4 pi). */
TY_FN float ty_forward_fitted(TY_GLOBAL const ty_forward_fit* fit, float mu) {
    float p_before = 0.0f, p_l = 1.0f, sum = 0.0f;
    for (int32_t l = 0; l < fit->bands; ++l) {
        sum += (float)(2 * l + 1) * fit->moments[l] * p_l;
        const float p_next = ty_legendre_next(l, mu, p_l, p_before);
        p_before = p_l;
        p_l = p_next;
    }
    return TY_INV_4PI * sum;
}

/* The phase function outside of the peak, blended into the fit within it. */
TY_FN float ty_forward_blended_phase(TY_GLOBAL const ty_forward_fit* fit, float mu, float g) {
    const float phase = ty_hg(mu, g);
    return phase + ty_forward_peak_weight(mu) * (ty_forward_fitted(fit, mu) - phase);
}

/* Scattering of a beam at cosine mu that the fit lacks, per scattering coefficient. After n collisions on average the
 * l-th moment of the radiance along the beam is U e^(g^l n). The fit gives U e^(d_l n) with d_l = c_l + f. Of this, R =
 * U e^(f n) counts as unscattered and is carried separately, so only the difference reaches the eye from the fit.
 * Moments from l = L on are those of ty_forward_scattered_order. */
TY_FN float ty_forward_fit_deficit(ty_forward light, float mu, float g, TY_GLOBAL const ty_forward_fit* fit) {
    const float ratio = light.phi_order_l / ty_maxf(light.phi_unscattered, 1e-30f);
    const float n = ty_minf(TY_FORWARD_MAX_COLLISIONS, logf(ty_maxf(1.0f, ratio)) / fit->forward_fraction);
    float p_before = 0.0f, p_l = 1.0f, g_l = 1.0f, sum = 0.0f, below;
    for (int32_t l = 0; l < fit->bands; ++l) {
        const float d = fit->moments[l] + fit->forward_fraction, weight = (float)(2 * l + 1) * p_l;
        sum += weight * (g_l * (expf(n * g_l) - 1.0f) - d * expf(n * d) +
                         fit->forward_fraction * expf(n * fit->forward_fraction));
        const float p_next = ty_legendre_next(l, mu, p_l, p_before);
        p_before = p_l;
        p_l = p_next;
        g_l *= g;
    }
    const float r = expf(n * g_l) - 1.0f, s = expf(n * g_l * g) - 1.0f;
    const float tail = ty_forward_tail(r > 0.0f ? s / r : g, mu, g, fit->bands, &below);
    return light.phi_unscattered * (ty_hg(mu, g) + TY_INV_4PI * (sum + r * tail));
}

/* Unscattered light, scattered for the first time at cosine mu. */
TY_FN float ty_forward_unscattered(ty_forward light, float mu, float g) {
    return light.phi_unscattered * ty_hg(mu, light.mean_cosine * g);
}

#endif
