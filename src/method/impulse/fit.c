/* Axis about which a response is best described by a zonal function (Sec. 4.2, Dubouchet 2019). */
#include "method/impulse/build.h"

enum { SCAN = 16, STEPS = 40 };

/* Projection of the response onto zonal harmonics about an axis tilted towards azimuth 0. */
static void project(const ty_impulse_recurrence* recurrence, const ty_impulse_pairs* response, double axis_tilt,
                    double zonal[TY_IMPULSE_TERMS]) {
    double y[TY_IMPULSE_PAIRS];
    ty_impulse_legendre(recurrence, cos(axis_tilt), sin(axis_tilt), y);
    for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) {
        double sum = response->at[l] * y[l];
        for (int32_t m = 1; m <= l; ++m) {
            const int32_t pair = ty_impulse_pair(l, m);
            sum += sqrt(2) * response->at[pair] * y[pair];
        }
        zonal[l] = ty_impulse_zonal_norm(l) * sum;
    }
}

typedef struct axis_fit {
    const ty_impulse_recurrence* recurrence;
    const ty_impulse_pairs* response;
} axis_fit;

/* Squared error of irradiance over all normals, minus the constant square of the response: harmonics are orthonormal.
 * Squares of radiance would be dominated by the peak about the emitter and leave a third of the irradiance
 * undetermined. */
static double error_at(const axis_fit* fit, double axis_tilt) {
    double zonal[TY_IMPULSE_TERMS], sum = 0;
    project(fit->recurrence, fit->response, axis_tilt, zonal);
    for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) {
        const double lobe = (double)ty_impulse_cosine_lobe[l];
        sum -= zonal[l] * zonal[l] * lobe * lobe / (2 * l + 1);
    }
    return sum;
}

/* Brent's method (1973): parabolas through the three best points, golden sections where they do not help. */
static double minimize(const axis_fit* fit, double low, double start, double high) {
    const double golden = 0.3819660112501051, tolerance = 1e-7;
    double best = start, second = start, third = start, step = 0, before = 0;
    double at_best = error_at(fit, best), at_second = at_best, at_third = at_best;
    for (int i = 0; i < STEPS && high - low > 4 * tolerance; ++i) {
        const double r = (best - second) * (at_best - at_third), q = (best - third) * (at_best - at_second);
        const double numerator = (best - third) * q - (best - second) * r, denominator = 2 * (q - r);
        const double parabola = denominator != 0 ? -numerator / denominator : 0;
        const bool helps = denominator != 0 && fabs(parabola) < 0.5 * fabs(before) &&
                           best + parabola > low + tolerance && best + parabola < high - tolerance;
        before = helps ? step : (best < 0.5 * (low + high) ? high - best : low - best);
        step = helps ? parabola : golden * before;
        const double next = best + (fabs(step) >= tolerance ? step : copysign(tolerance, step)),
                     at_next = error_at(fit, next);
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
double ty_impulse_fit_axis(const ty_impulse_recurrence* recurrence, const ty_impulse_pairs* response) {
    const axis_fit fit = {recurrence, response};
    const double step = 0.5 * TY_PI_F64 / SCAN;
    int32_t best = 0;
    double min_error = error_at(&fit, 0);
    for (int32_t i = 1; i <= SCAN; ++i) {
        const double error = error_at(&fit, i * step);
        if (error >= min_error) continue;
        min_error = error;
        best = i;
    }
    const double low = fmax(0, (best - 1) * step), high = fmin(SCAN * step, (best + 1) * step);
    return sin(minimize(&fit, low, best * step, high));
}

void ty_impulse_project(const ty_impulse_recurrence* recurrence, const ty_impulse_pairs* response, double axis_tilt,
                        double zonal[TY_IMPULSE_TERMS]) {
    project(recurrence, response, asin(axis_tilt), zonal);
}
