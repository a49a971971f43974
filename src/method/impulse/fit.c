/* The axis about which a response is best described by a function of one angle (Sec. 4.2). */
#include "method/impulse/build.h"

enum { SCAN = 16, STEPS = 40 };

/* A zonal function about an axis that leans by an angle towards azimuth 0 is the response's projection there. */
static void project(const ty_impulse_recurrence* recurrence, const ty_impulse_pairs* response, double lean,
                    double zonal[TY_IMPULSE_TERMS]) {
    double y[TY_IMPULSE_PAIRS];
    ty_impulse_legendre(recurrence, cos(lean), sin(lean), y);
    for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) {
        double sum = response->at[l] * y[l];
        for (int32_t m = 1; m <= l; ++m) {
            const int32_t pair = ty_impulse_pair(l, m);
            sum += sqrt(2) * response->at[pair] * y[pair];
        }
        zonal[l] = sqrt(4 * TY_IMPULSE_PI / (2 * l + 1)) * sum;
    }
}

typedef struct fitted {
    const ty_impulse_recurrence* recurrence;
    const ty_impulse_pairs* response;
} fitted;

/* The squared error of irradiance over all normals, less the response's own square: harmonics are orthonormal. Squares
 * of radiance would be decided by the peak about the emitter, and leave a third of the irradiance to chance. */
static double error_at(const fitted* fit, double lean) {
    double zonal[TY_IMPULSE_TERMS], sum = 0;
    project(fit->recurrence, fit->response, lean, zonal);
    for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) {
        const double lobe = (double)ty_impulse_cosine_lobe[l];
        sum -= zonal[l] * zonal[l] * lobe * lobe / (2 * l + 1);
    }
    return sum;
}

/* Brent's method (1973): parabolas through the three best places, golden sections where those do not help. */
static double minimize(const fitted* fit, double low, double middle, double high) {
    const double golden = 0.3819660112501051, close = 1e-7;
    double best = middle, second = middle, third = middle, step = 0, before = 0;
    double at_best = error_at(fit, best), at_second = at_best, at_third = at_best;
    for (int i = 0; i < STEPS && high - low > 4 * close; ++i) {
        const double r = (best - second) * (at_best - at_third), q = (best - third) * (at_best - at_second);
        const double numerator = (best - third) * q - (best - second) * r, denominator = 2 * (q - r);
        const double parabola = denominator != 0 ? -numerator / denominator : 0;
        const bool helps = denominator != 0 && fabs(parabola) < 0.5 * fabs(before) && best + parabola > low + close &&
                           best + parabola < high - close;
        before = helps ? step : (best < 0.5 * (low + high) ? high - best : low - best);
        step = helps ? parabola : golden * before;
        const double next = best + (fabs(step) >= close ? step : copysign(close, step)), at_next = error_at(fit, next);
        if (at_next <= at_best) {
            *(next >= best ? &low : &high) = best;
            third = second, at_third = at_second;
            second = best, at_second = at_best;
            best = next, at_best = at_next;
            continue;
        }
        *(next < best ? &low : &high) = next;
        if (at_next <= at_second || second == best) {
            third = second, at_third = at_second;
            second = next, at_second = at_next;
        } else if (at_next <= at_third || third == best || third == second) {
            third = next, at_third = at_next;
        }
    }
    return best;
}

/* The sine of the angle from the axis of pairs to that of the best zonal function, Sec. 4.2 (Dubouchet 2019). */
double ty_impulse_fit(const ty_impulse_recurrence* recurrence, const ty_impulse_pairs* response) {
    const fitted fit = {recurrence, response};
    const double step = 0.5 * TY_IMPULSE_PI / SCAN;
    int32_t best = 0;
    double least = error_at(&fit, 0);
    for (int32_t i = 1; i <= SCAN; ++i) {
        const double error = error_at(&fit, i * step);
        if (error >= least) continue;
        least = error;
        best = i;
    }
    const double low = fmax(0, (best - 1) * step), high = fmin(SCAN * step, (best + 1) * step);
    return sin(minimize(&fit, low, best * step, high));
}

void ty_impulse_lean(const ty_impulse_recurrence* recurrence, const ty_impulse_pairs* response, double shift,
                     double zonal[TY_IMPULSE_TERMS]) {
    project(recurrence, response, asin(shift), zonal);
}
