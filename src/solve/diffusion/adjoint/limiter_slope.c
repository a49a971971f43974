#include "solve/diffusion/adjoint/limiter_slope.h"

#include <math.h>

/* F = (coth R - 1/R) / R (Levermore and Pomraning 1981); its series below 0.05. */
static ty_limiter_point levermore_pomraning(double r) {
    const double s = r * r;
    if (r < 0.05)
        return (ty_limiter_point){.value = 1.0 / 3 - s * (1.0 / 45 - s * (2.0 / 945 - s / 4725)),
                                  .slope = -2 * r * (1.0 / 45 - s * (4.0 / 945 - 3 * s / 4725))};
    const double e = exp(-2 * fmin(r, 300)), coth = (1 + e) / (1 - e);
    const double csch2 = 4 * e / ((1 - e) * (1 - e)), value = (coth - 1 / r) / r;
    return (ty_limiter_point){.value = value, .slope = (1 / s - csch2 - value) / r};
}

static ty_limiter_point larsen(double r, double n) {
    const double sum = pow(3, n) + pow(r, n), value = pow(sum, -1 / n);
    return (ty_limiter_point){.value = value, .slope = r > 0 ? -value / sum * pow(r, n - 1) : 0};
}

ty_limiter_point ty_limiter_at(ty_limiter limiter, double larsen_power, double r) {
    const double root = sqrt(9 + 4 * r * r);
    switch (limiter) {
    case TY_LIMITER_SUM: return (ty_limiter_point){.value = 1 / (3 + r), .slope = -1 / ((3 + r) * (3 + r))};
    case TY_LIMITER_MAX: return (ty_limiter_point){.value = 1 / fmax(3, r), .slope = r > 3 ? -1 / (r * r) : 0};
    case TY_LIMITER_KERSHAW:
        return (ty_limiter_point){.value = 2 / (3 + root), .slope = -8 * r / (root * (3 + root) * (3 + root))};
    case TY_LIMITER_LARSEN: return larsen(r, larsen_power);
    case TY_LIMITER_LEVERMORE_POMRANING: return levermore_pomraning(r);
    default: return (ty_limiter_point){.value = 1.0 / 3, .slope = 0};
    }
}
