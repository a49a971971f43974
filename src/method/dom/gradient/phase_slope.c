/* Moments of phase functions and their derivatives by the mean cosine. */
#include "method/dom/gradient/gradient.h"
#include "method/dom/solve/solve.h"

#include <math.h>
#include <string.h>

/* Steps of the differences of fits by g, of fourth order: small enough for 1e-6 of a derivative, and so large that the
 * single precision of the phase function does not matter. */
static const double FIT_STEP = 0.01;

static void add_fit(const ty_dom* light, double weight, ty_dom_phase_slope* out) {
    for (int32_t l = 0; l < light->fit.bands; ++l) out->scattered_by_g[l] += weight * (double)light->fit.moments[l];
    out->forward_by_g += weight * (double)light->fit.forward_fraction;
}

void ty_dom_gradient_find_fit(ty_dom_gradient_job* job) {
    static const double weights[5] = {1, -8, 0, 8, -1};
    const ty_dom* light = job->dom.light;
    ty_dom_phase_slope* out = &job->fit;
    const double step = fmin(FIT_STEP, 0.1 * (1 - (double)job->g[0]));
    memset(out, 0, sizeof *out);
    for (int32_t l = 0; l < light->fit.bands; ++l) out->scattered[l] = (double)light->fit.moments[l];
    out->forward = (double)light->fit.forward_fraction;
    for (int move = -2; move <= 2 && light->fit.bands > 0; ++move) {
        ty_dom moved = {.bands = light->fit.bands};
        if (move == 0) continue;
        ty_dom_fit_phase((double)job->g[0] + move * step, moved.bands, &moved.fit);
        add_fit(&moved, weights[move + 2] / (12 * step), out);
    }
}

/* Of given moments, which do not depend on g. */
static void moments_at(const ty_dom* light, ty_dom_phase_slope* out) {
    memset(out, 0, sizeof *out);
    for (int32_t l = 0; l < light->bands; ++l) out->scattered[l] = (double)light->scattered[l];
    out->forward = (double)(light->legendre[0] - light->scattered[0]);
}

void ty_dom_phase_slope_at(const ty_dom_gradient_job* job, double g, ty_dom_phase_slope* out) {
    const ty_dom* light = job->dom.light;
    const int32_t bands = light->bands;
    double power[TY_DOM_BANDS_MAX + 1] = {1};
    if (light->fit.bands > 0) {
        *out = job->fit;
        return;
    }
    if (ty_dom_legendre(light) != NULL) {
        moments_at(light, out);
        return;
    }
    for (int32_t l = 1; l <= bands; ++l) power[l] = power[l - 1] * g;
    out->forward = power[bands];
    out->forward_by_g = bands * power[bands - 1];
    for (int32_t l = 0; l < bands; ++l) {
        out->scattered[l] = power[l] - power[bands];
        out->scattered_by_g[l] = (l > 0 ? l * power[l - 1] : 0) - out->forward_by_g;
    }
}
