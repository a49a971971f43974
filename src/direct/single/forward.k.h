/* Light that keeps the direction it came in with, and what of it scatters once more.
 *
 * Of a beam e^-tau goes straight through, tau the integral of sigma_t. What has scattered n times has the moments
 * g^(n l) about the beam; over the Poisson number of scatterings the l-th is e^-tau_l, tau_l of sigma_t - g^l sigma_s
 * (the exact form of what Elek et al. 2014, Eq. 4, have for g -> 1). Diffusion, which knows two moments, is exact to
 * them if what it is not given stays with the beam as both fluence and flux: R = e^-tau_1, the reduced beam. So light
 * that has scattered and kept its direction is R - U (U = e^-tau) with the moments (R - U), (R - U), S - U, ...,
 * S = e^-tau_2: of b = (S - U) / (R - U) to the power l - 1, the lobe ((R - U) / b) (HG(b) - (1 - b) / (4 pi)). */
#ifndef TY_DIRECT_SINGLE_FORWARD_K_H
#define TY_DIRECT_SINGLE_FORWARD_K_H

#include "scene/phase.k.h"

/* Fluences U, R and S of a beam (or what is proportional to them), and the mean cosine of what came in. */
typedef struct ty_forward {
    float phi_unscattered, phi_order_l, phi_next_order;
    float mean_cosine; /* 1: a line; 0..1 */
} ty_forward;

/* A phase function whose peak counts as light that goes straight on, outside of which its first Legendre moments are
 * fitted to it: c_l, l < bands. */
enum { TY_FORWARD_BANDS_MAX = 12 };
typedef struct ty_forward_fit {
    int32_t bands; /* 0: none, phase functions are cut after L bands instead (delta-M) */
    float forward_fraction;
    float moments[TY_FORWARD_BANDS_MAX];
} ty_forward_fit;

/* Scatterings in the mean after which hardly any light goes about straight, and whose power floats still hold. */
#define TY_FORWARD_MAX_COLLISIONS 80.0f

/* Cosines up to which there is nothing of a peak, and from which all of it is. */
#define TY_FORWARD_PEAK_BEGIN 0.7f
#define TY_FORWARD_PEAK_FULL 0.9f

/* (4 pi HG(x) - 1) / x, which is 3 mu at x = 0. */
TY_FN float ty_hg_slope(float mu, float x) {
    const float base = ty_maxf((1.0f - x) * (1.0f - x) + 2.0f * x * (1.0f - mu), 1e-10f);
    const float u = sqrtf(base), cube = base * u;
    return ((2.0f * mu - x) * (1.0f + u + base) - x * (1.0f + u)) / ((1.0f + u) * cube);
}

/* The mean cosine of light that has scattered and kept its direction (above): u, r, s are U, R, S. */
TY_FN float ty_forward_lobe_cosine(float u, float r, float s) {
    return ty_clampf((s - u) / ty_maxf(r - u, 1e-20f), 0.0f, 1.0f);
}

/* Its radiance at cosine mu about the direction, scattered once more by `spread` (a phase function's mean cosine, or of
 * the light that comes in, or their product). Its moments are right; far from the direction it may be a little below 0,
 * which the diffusion's light makes up for. */
TY_FN float ty_forward_lobe(float mu, float u, float r, float s, float spread) {
    const float x = ty_forward_lobe_cosine(u, r, s) * spread;
    return ty_maxf(0.0f, r - u) * TY_INV_4PI * (1.0f + spread * ty_hg_slope(mu, x));
}

/* What of the light that has scattered and kept its direction scatters once more in a medium of mean cosine g at cosine
 * mu, per scattering coefficient; below 0 where the diffuse light, to which it belongs, is more. */
TY_FN float ty_forward_scattered(ty_forward light, float mu, float g) {
    return ty_forward_lobe(mu, light.phi_unscattered, light.phi_order_l, light.phi_next_order, light.mean_cosine * g);
}

/* Terms of a series that falls off slowly at worst, and what b^L must be for its closed form to keep its digits. */
enum { TY_FORWARD_SERIES_TERMS = 16 };
#define TY_FORWARD_MIN_POWER 1e-2f

/* Moments of 1 up to l = L and b^(l - L) from there on, scattered once by a mean cosine g at cosine mu, times 4 pi;
 * below: the part of l < L. L = order >= 1. */
TY_FN float ty_forward_tail(float b, float mu, float g, int32_t order, float* below) {
    const float x = g * b;
    float p_before = 0.0f, p_l = 1.0f, g_l = 1.0f, x_l = 1.0f, b_l = 1.0f, low_sum = 0.0f, tail = 0.0f;
    int32_t l = 0;
    *below = 0.0f;
    for (; l < order; ++l) {
        const float weight = (float)(2 * l + 1) * p_l;
        const float p_next = ((float)(2 * l + 1) * mu * p_l - (float)l * p_before) / (float)(l + 1);
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
        const float p_next = ((float)(2 * l + 1) * mu * p_l - (float)l * p_before) / (float)(l + 1);
        tail += (float)(2 * l + 1) * p_l * g_l;
        p_before = p_l;
        p_l = p_next;
        g_l *= x;
    }
    return tail;
}

/* As ty_forward_scattered, of a line of light where others know not one moment but those of l < L, to which R, of
 * sigma_t - g^L sigma_s, is given in full (delta-M); S is that of L + 1. Light that has scattered and kept its
 * direction then has the moments R - U up to l = L and, as it has b = (S - U) / (R - U) of that at the next, (R - U)
 * b^(l - L) from there on. */
TY_FN float ty_forward_scattered_order(ty_forward light, float mu, float g, int32_t order) {
    float below;
    const float tail = ty_forward_tail(
        ty_forward_lobe_cosine(light.phi_unscattered, light.phi_order_l, light.phi_next_order), mu, g, order, &below);
    return ty_maxf(0.0f, light.phi_order_l - light.phi_unscattered) * TY_INV_4PI * (below + tail);
}

/* How much of what is at cosine mu belongs to the peak. */
TY_FN float ty_forward_peak_weight(float mu) {
    const float x =
        ty_clampf((mu - TY_FORWARD_PEAK_BEGIN) * (1.0f / (TY_FORWARD_PEAK_FULL - TY_FORWARD_PEAK_BEGIN)), 0.0f, 1.0f);
    return x * x * (3.0f - 2.0f * x);
}

/* The fitted phase function. */
TY_FN float ty_forward_fitted(TY_GLOBAL const ty_forward_fit* fit, float mu) {
    float p_before = 0.0f, p_l = 1.0f, sum = 0.0f;
    for (int32_t l = 0; l < fit->bands; ++l) {
        sum += (float)(2 * l + 1) * fit->moments[l] * p_l;
        const float p_next = ((float)(2 * l + 1) * mu * p_l - (float)l * p_before) / (float)(l + 1);
        p_before = p_l;
        p_l = p_next;
    }
    return TY_INV_4PI * sum;
}

/* What is seen through what scatters nearly straight on: the phase function beside the peak, and in it the fit. */
TY_FN float ty_forward_blended_phase(TY_GLOBAL const ty_forward_fit* fit, float mu, float g) {
    const float phase = ty_hg(mu, g);
    return phase + ty_forward_peak_weight(mu) * (ty_forward_fitted(fit, mu) - phase);
}

/* What light along a line scatters at cosine mu beyond what a fit says of it, per scattering coefficient. After n
 * scatterings in the mean, moments of what goes that way are U e^(g^l n), of the fit U e^(d_l n), d_l = c_l + straight,
 * of which the fit sees, along ways on which straight goes on, what R = U e^(straight n) does not stand for. From l = L
 * on, they are as in ty_forward_scattered_order. */
TY_FN float ty_forward_fit_deficit(ty_forward light, float mu, float g, TY_GLOBAL const ty_forward_fit* fit) {
    const float ratio = light.phi_order_l / ty_maxf(light.phi_unscattered, 1e-30f);
    const float n = ty_minf(TY_FORWARD_MAX_COLLISIONS, logf(ty_maxf(1.0f, ratio)) / fit->forward_fraction);
    float p_before = 0.0f, p_l = 1.0f, g_l = 1.0f, sum = 0.0f, below;
    for (int32_t l = 0; l < fit->bands; ++l) {
        const float d = fit->moments[l] + fit->forward_fraction, weight = (float)(2 * l + 1) * p_l;
        sum += weight * (g_l * (expf(n * g_l) - 1.0f) - d * expf(n * d) +
                         fit->forward_fraction * expf(n * fit->forward_fraction));
        const float p_next = ((float)(2 * l + 1) * mu * p_l - (float)l * p_before) / (float)(l + 1);
        p_before = p_l;
        p_l = p_next;
        g_l *= g;
    }
    const float r = expf(n * g_l) - 1.0f, s = expf(n * g_l * g) - 1.0f;
    const float tail = ty_forward_tail(r > 0.0f ? s / r : g, mu, g, fit->bands, &below);
    return light.phi_unscattered * (ty_hg(mu, g) + TY_INV_4PI * (sum + r * tail));
}

/* What of the light that has not scattered does so, the same. */
TY_FN float ty_forward_unscattered(ty_forward light, float mu, float g) {
    return light.phi_unscattered * ty_hg(mu, light.mean_cosine * g);
}

#endif
