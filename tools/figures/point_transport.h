/* The fluence of an isotropic point source in an infinite, isotropically scattering medium: exact, and by Eqs. 24 and
 * 27 (Koerner 2014). */
#ifndef TY_FIGURES_POINT_TRANSPORT_H
#define TY_FIGURES_POINT_TRANSPORT_H

#include "base/constants.h"
#include "base/quadrature.h"

#include <math.h>

/* Fluence phi at tau mean free paths from a source of unit intensity, over sigma_t^2 (that is 4 pi phi / sigma_t^2 for
 * unit power): Case, de Hoffmann and Placzek 1953; Case and Zweifel, Linear Transport Theory, 1967, chapter 5, with
 * c = albedo:
 *     phi = 1/tau [ exp(-tau/nu0) / (nu0 N0) + integral_0^1 exp(-tau/nu) / (nu N(nu)) dnu ],
 *     1 = c nu0 atanh(1/nu0),   N0 = c/2 nu0^3 [ c/(nu0^2-1) - 1/nu0^2 ],
 *     N(nu) = nu [ (1 - c nu atanh nu)^2 + (c pi nu / 2)^2 ].
 * The integral is taken over w, 1/nu = 1 + e^w, in which both ends are smooth. */
typedef struct transport {
    double albedo, tau;
} transport;

static inline double transport_continuum(const void* user, double w) {
    const transport* t = user;
    const double beyond = exp(w), nu = 1 / (1 + beyond);
    const double atanh_nu = 0.5 * (log(2 + beyond) - w);
    const double a = 1 - t->albedo * nu * atanh_nu, b = 0.5 * TY_PI_F64 * t->albedo * nu;
    return exp(-t->tau * (1 + beyond)) / (a * a + b * b) * beyond;
}

/* atanh(1 / nu0) */
static inline double transport_root(double albedo) {
    double lower = 0, upper = 1 / albedo;
    if (albedo >= 1) return 0;
    for (int i = 0; i < 200; ++i) {
        const double mid = 0.5 * (lower + upper);
        if (albedo * mid < tanh(mid))
            lower = mid;
        else
            upper = mid;
    }
    return lower;
}

/* 1 / nu0, the ratio of mean free path and diffusion length. */
static inline double transport_decay(double albedo) {
    return tanh(transport_root(albedo));
}

/* 1 / (nu0 N0) */
static inline double transport_discrete(double albedo) {
    const double y = transport_decay(albedo), beyond = pow(cosh(transport_root(albedo)), -2);
    return albedo >= 1 ? 3 : 2 * beyond * y * y / (albedo * (albedo - beyond));
}

static inline double transport_fluence(double albedo, double tau) {
    if (!(albedo > 0)) return exp(-tau) / (tau * tau);
    const transport t = {albedo, tau};
    const double continuum = ty_integrate(transport_continuum, &t, -60, log(60 / tau), 200);
    return (transport_discrete(albedo) * exp(-transport_decay(albedo) * tau) + continuum) / tau;
}

/* Grosjean's approximation (1951), Eq. 24 (Koerner 2014). */
static inline double transport_grosjean(double albedo, double tau) {
    const double lambda = sqrt(3 * (1 - albedo) / (2 - albedo));
    return exp(-tau) / (tau * tau) + 3 * albedo / (2 - albedo) * exp(-lambda * tau) / tau;
}

/* Knudsen number of Grosjean's approximation, -d(ln phi) / d tau. */
static inline double transport_grosjean_knudsen(double albedo, double tau) {
    const double lambda = sqrt(3 * (1 - albedo) / (2 - albedo));
    const double straight = exp(-tau) / (tau * tau), spread = 3 * albedo / (2 - albedo) * exp(-lambda * tau) / tau;
    return (straight * (1 + 2 / tau) + spread * (lambda + 1 / tau)) / (straight + spread);
}

/* Classical diffusion, Eq. 27 (Koerner 2014). */
static inline double transport_diffusion(double albedo, double tau) {
    return 3 * exp(-sqrt(3 * (1 - albedo)) * tau) / tau;
}

#endif
