/* Published phase functions of particles: a fit for droplets, and particles in water. */
#include "scene/media/phase_fit.h"

#include "base/constants.h"

#include <tyndall/phase.h>

#include <math.h>

/* The four ranges of Jendersie and d'Eon (2023), d in micrometres. */
ty_mie_fit ty_mie_fit_of(double d) {
    const double l = log(d);
    if (d <= 0.1)
        return (ty_mie_fit){.g = 13.8 * d * d,
                            .draine_g = 1.1456 * d * sin(9.29044 * d),
                            .alpha = 250,
                            .draine_weight = 0.252977 - 312.983 * pow(d, 4.3)};
    if (d < 1.5) {
        const double inner = 1.19692 * cos((l - 0.238604) * (l + 1.00667) / (0.507522 - 0.15677 * l));
        return (ty_mie_fit){.g = 0.862 - 0.143 * l * l,
                            .draine_g = 0.379685 * cos(inner + 1.37932 * l + 0.0625835) + 0.344213,
                            .alpha = 250,
                            .draine_weight = 0.146209 * cos(3.38707 * l + 2.11193) + 0.316072 + 0.0778917 * l};
    }
    if (d < 5)
        return (ty_mie_fit){.g = 0.0604931 * log(l) + 0.940256,
                            .draine_g = 0.500411 - 0.081287 / (-2 * l + tan(l) + 1.27551),
                            .alpha = 7.30354 * l + 6.31675,
                            .draine_weight = 0.026914 * (l - cos(5.68947 * (log(l) - 0.0292149))) + 0.376475};
    return (ty_mie_fit){.g = exp(-0.0990567 / (d - 1.67154)),
                        .draine_g = exp(-2.20679 / (d + 3.91029) - 0.428934),
                        .alpha = exp(3.62489 - 8.29288 / (d + 5.52825)),
                        .draine_weight = exp(-0.599085 / (d - 0.641583) - 0.665888)};
}

/* ---- particles in water ---- */

/* delta at sin^2(theta / 2), and the exponent nu. */
static double delta_at(double n, double half_sine2) {
    return 4 * half_sine2 / (3 * (n - 1) * (n - 1));
}

static double exponent(double slope) {
    return (3 - slope) / 2;
}

/* Half width about the removable singularity at delta = 1, over which the function is taken as linear. */
static const double singular = 1e-3;

/* The first term of the function. */
static double forward_term(double delta, double nu, double half_sine2) {
    const double power = pow(delta, nu), less = 1 - delta;
    const double braces = nu * less - (1 - power) + (delta * (1 - power) - nu * less) / half_sine2;
    return braces / (4 * TY_PI_F64 * less * less * power);
}

/* Fournier and Forand (1994), in the form of Fournier and Jonasz (1999). */
double ty_fournier_forand(double n, double slope, double one_minus_mu) {
    const double nu = exponent(slope), back = delta_at(n, 1), mu = 1 - one_minus_mu, back_power = pow(back, nu);
    const double scale = delta_at(n, 1), delta = scale * one_minus_mu / 2;
    double first;
    if (fabs(delta - 1) >= singular) {
        first = forward_term(delta, nu, one_minus_mu / 2);
    } else {
        const double low = forward_term(1 - singular, nu, (1 - singular) / scale),
                     high = forward_term(1 + singular, nu, (1 + singular) / scale);
        first = low + (high - low) * (delta - 1 + singular) / (2 * singular);
    }
    return first + (1 - back_power) / (16 * TY_PI_F64 * (back - 1) * back_power) * (3 * mu * mu - 1);
}

/* The fraction that is scattered by more than 90 degrees, Eq. 6 (Mobley 2002). */
double ty_fournier_forand_backscatter(double n, double slope) {
    const double nu = exponent(slope), delta = delta_at(n, 0.5), power = pow(delta, nu);
    return 1 - (1 - delta * power - 0.5 * (1 - power)) / ((1 - delta) * power);
}

double ty_fournier_forand_index(double slope) {
    return 1.01 + 0.1542 * (slope - 3);
}

double ty_fournier_forand_slope(double backscatter) {
    double low = TY_PHASE_SLOPE_MIN, high = TY_PHASE_SLOPE_MAX;
    for (int i = 0; i < 60; ++i) {
        const double center = (low + high) / 2;
        if (ty_fournier_forand_backscatter(ty_fournier_forand_index(center), center) < backscatter)
            low = center;
        else
            high = center;
    }
    return (low + high) / 2;
}
