/* The small-angle spread of Henyey-Greenstein scattering, in closed form but for one sum.
 *
 * Near the forward direction the phase function is the planar Cauchy kernel a / (2 pi (a^2 + theta^2)^(3/2)) with
 * a = (1 - g) / sqrt(g), whose transform is exp(-a k). Light from a point at distance D that scatters n times, at
 * fractions t_i of the way, arrives from directions that are spread by the same kernel with a T, T = t_1 + ... + t_n,
 * since such kernels add up. n is Poisson's with mean tau = sigma_s D, and the t_i are uniform. (The mean over T is the
 * transfer function (exp(tau (1 - exp(-a k)) / (a k)) - 1) / (exp(tau) - 1).)
 *
 * A planar Cauchy kernel of width c is a mixture of Gaussians whose variance has Levy's distribution: the part with a
 * variance above v is erf(c / sqrt(2 v)). That is what a pyramid of Gaussians wants to know. */
#include "method/screen/spread.h"

#include "base/constants.h"

#include <math.h>

/* Beyond this thickness T is as good as normal; at less, too much of the normal is below 0. */
static const double thick = 16;
enum { TERMS_MAX = 64, NODES = TY_SCREEN_FRACTION_TERMS };

double ty_screen_angle(double g) {
    const double widest = 2; /* at g = 0.17: below it light goes all ways, and no picture is wider */
    const double angle = g > 0 ? (1 - g) / sqrt(g) : widest;
    return angle < widest ? angle : widest;
}

/* The mean of erf(x T) over a normal T. */
static double normal_mean(double x, double mean, double variance) {
    return erf(x * mean / sqrt(1 + 2 * x * x * variance));
}

/* The same for T = t_1, uniform; and for more, which normals are near to. */
static double mean_of_terms(double x, int terms) {
    if (terms > 1) return normal_mean(x, 0.5 * terms, terms / 12.0);
    return x < 1e-4 ? x / sqrt(TY_PI_F64) : erf(x) - (1 - exp(-x * x)) / (x * sqrt(TY_PI_F64));
}

double ty_screen_wider_fraction(double width, double tau, double variance) {
    if (variance <= 0) return 1;
    const double x = width / sqrt(2 * variance);
    if (tau > thick) return normal_mean(x, 0.5 * tau, tau / 3);
    double weight = 1, sum = 0, weights = 0; /* tau^(n - 1) / n!, as long as it counts */
    for (int n = 1; n <= TERMS_MAX && (n <= tau || weight > 1e-7 * weights); ++n) {
        sum += weight * mean_of_terms(x, n);
        weights += weight;
        weight *= tau / (n + 1);
    }
    return sum / weights;
}

double ty_screen_half_radius(double width, double tau) {
    /* With all light at the mean T, given that it scattered at all, r = sqrt(3) c. That T varies draws the half in, by
     * what is fitted here to draws of T (to 1%). */
    const double mean = tau > 1e-6 ? 0.5 * tau / -expm1(-tau) : 0.5;
    return width * (sqrt(3.0) * mean - 0.447 + 0.33 * exp(-tau / 2.2));
}

/* What of the light goes on from a level to the next: the mean of the tail over variances between the two. Gaussians in
 * between are shared by the logarithm of their variance, which keeps the radius of half their light to 4%; by the
 * variance itself that radius is up to 14% too small. (Below the first level, where no logarithm is, it is less than a
 * pixel.) */
static double mean_tail(double width, double tau, double low, double high) {
    static const double points[3] = {0.1127016653792583, 0.5, 0.8872983346207417}; /* Gauss-Legendre */
    static const double weights[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        const double variance = low > 0 ? low * pow(high / low, points[i]) : points[i] * high;
        sum += weights[i] * ty_screen_wider_fraction(width, tau, variance);
    }
    return sum;
}

/* The polynomial in z through values at the zeros of Chebyshev's polynomial. */
static void interpolate(const double values[NODES], float coefficients[NODES]) {
    double sums[NODES] = {0}, previous[NODES] = {1}, current[NODES] = {0, 1};
    for (int j = 0; j < NODES; ++j) {
        double c = 0;
        for (int i = 0; i < NODES; ++i) c += values[i] * cos(j * (i + 0.5) * TY_PI_F64 / NODES);
        c *= (j == 0 ? 1.0 : 2.0) / NODES;
        for (int power = 0; power < NODES; ++power) sums[power] += c * previous[power];
        double next[NODES] = {0}; /* T_(j+2) = 2 z T_(j+1) - T_j */
        for (int power = 0; power < NODES; ++power)
            next[power] = (power > 0 ? 2 * current[power - 1] : 0) - previous[power];
        for (int power = 0; power < NODES; ++power) {
            previous[power] = current[power];
            current[power] = next[power];
        }
    }
    for (int power = 0; power < NODES; ++power) coefficients[power] = (float)sums[power];
}

void ty_screen_gaussian_fractions(const float* levels, int32_t count, ty_screen_down_fraction* shares) {
    for (int32_t k = 0; k < count; ++k)
        shares[k] = (ty_screen_down_fraction){.low = levels[k], .inverse_range = 1 / (levels[k + 1] - levels[k])};
}

void ty_screen_small_angle_fractions(double width, const float* levels, int32_t count, ty_screen_down_fraction* shares) {
    double values[TY_SCREEN_LEVELS_MAX + 1][NODES];
    for (int i = 0; i < NODES; ++i) {
        const double z = cos((i + 0.5) * TY_PI_F64 / NODES);
        const double t = 0.5 * (double)TY_SCREEN_FRACTION_T_MAX * (1 + z);
        const double tau = (double)TY_SCREEN_FRACTION_SCALE * t / (1 - t);
        double whole = 1;
        for (int32_t k = 0; k < count; ++k) {
            const double onward = mean_tail(width, tau, (double)levels[k], (double)levels[k + 1]);
            values[k][i] = whole > 0 ? onward / whole : 0;
            whole = onward;
        }
    }
    for (int32_t k = 0; k < count; ++k) {
        shares[k] = (ty_screen_down_fraction){.small_angle = 1};
        interpolate(values[k], shares[k].terms);
    }
}
