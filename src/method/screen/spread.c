/* The small-angle spread of Henyey-Greenstein scattering, in closed form except for one sum.
 *
 * Near the forward direction the phase function is the planar Cauchy kernel a / (2 pi (a^2 + theta^2)^(3/2)) with
 * a = (1 - g) / sqrt(g), whose transform is exp(-a k). Light from a point at distance D that scatters n times, at
 * fractions t_i of D, arrives from directions spread by the same kernel of width a T, T = t_1 + ... + t_n, since such
 * kernels add under convolution. n is Poisson distributed with mean tau = sigma_s D, and the t_i are uniform. (The mean
 * over T is the transfer function (exp(tau (1 - exp(-a k)) / (a k)) - 1) / (exp(tau) - 1).)
 *
 * A planar Cauchy kernel of width c is a mixture of Gaussians whose variance has Levy's distribution: the fraction with
 * a variance above v is erf(c / sqrt(2 v)). A pyramid of Gaussians needs exactly this fraction. */
#include "method/screen/spread.h"

#include "base/constants.h"

#include <math.h>

/* Optical thickness beyond which T is treated as normal; below, too much of the normal would be negative. */
static const double normal_thickness = 16;
enum { TERMS_MAX = 64, NODES = TY_SCREEN_FRACTION_TERMS };

double ty_screen_angle(double g) {
    const double widest = 2; /* at g = 0.17: below it light scatters in all directions, and no image is wider */
    const double angle = g > 0 ? (1 - g) / sqrt(g) : widest;
    return angle < widest ? angle : widest;
}

/* Mean of erf(x T) over a normal T. */
static double normal_mean(double x, double mean, double variance) {
    return erf(x * mean / sqrt(1 + 2 * x * x * variance));
}

/* Mean of erf(x T) over T = t_1, uniform, and over more terms, approximated by normals. */
static double mean_of_terms(double x, int terms) {
    if (terms > 1) return normal_mean(x, 0.5 * terms, terms / 12.0);
    return x < 1e-4 ? x / sqrt(TY_PI_F64) : erf(x) - (1 - exp(-x * x)) / (x * sqrt(TY_PI_F64));
}

double ty_screen_wider_fraction(double width, double tau, double variance) {
    if (variance <= 0) return 1;
    const double x = width / sqrt(2 * variance);
    if (tau > normal_thickness) return normal_mean(x, 0.5 * tau, tau / 3);
    double weight = 1, sum = 0, weights = 0; /* tau^(n - 1) / n!, until negligible */
    for (int n = 1; n <= TERMS_MAX && (n <= tau || weight > 1e-7 * weights); ++n) {
        sum += weight * mean_of_terms(x, n);
        weights += weight;
        weight *= tau / (n + 1);
    }
    return sum / weights;
}

double ty_screen_half_radius(double width, double tau) {
    /* If all scattered light had the mean T, r = sqrt(3) c. The variation of T reduces the half-light radius by a term
     * fitted to samples of T (to 1%). */
    const double mean = tau > 1e-6 ? 0.5 * tau / -expm1(-tau) : 0.5;
    return width * (sqrt(3.0) * mean - 0.447 + 0.33 * exp(-tau / 2.2));
}

/* Fraction of light passed from a level to the next: the mean of the wider fraction over the variances between the two.
 * Intermediate Gaussians are divided by the logarithm of their variance, which keeps the half-light radius to 4%;
 * dividing by the variance makes it up to 14% too small. (Below the first level, where the logarithm is undefined, the
 * radius is less than a pixel.) */
static double mean_wider_fraction(double width, double tau, double low, double high) {
    static const double points[3] = {0.1127016653792583, 0.5, 0.8872983346207417}; /* Gauss-Legendre */
    static const double weights[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        const double variance = low > 0 ? low * pow(high / low, points[i]) : points[i] * high;
        sum += weights[i] * ty_screen_wider_fraction(width, tau, variance);
    }
    return sum;
}

/* Interpolating polynomial in z from values at the Chebyshev nodes. */
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

void ty_screen_gaussian_fractions(const float* levels, int32_t count, ty_screen_down_fraction* fractions) {
    for (int32_t k = 0; k < count; ++k)
        fractions[k] = (ty_screen_down_fraction){.low = levels[k], .inverse_range = 1 / (levels[k + 1] - levels[k])};
}

void ty_screen_small_angle_fractions(double width, const float* levels, int32_t count,
                                     ty_screen_down_fraction* fractions) {
    double values[TY_SCREEN_LEVELS_MAX + 1][NODES];
    for (int i = 0; i < NODES; ++i) {
        const double z = cos((i + 0.5) * TY_PI_F64 / NODES);
        const double t = 0.5 * (double)TY_SCREEN_FRACTION_T_MAX * (1 + z);
        const double tau = (double)TY_SCREEN_FRACTION_SCALE * t / (1 - t);
        double previous = 1;
        for (int32_t k = 0; k < count; ++k) {
            const double passed = mean_wider_fraction(width, tau, (double)levels[k], (double)levels[k + 1]);
            values[k][i] = previous > 0 ? passed / previous : 0;
            previous = passed;
        }
    }
    for (int32_t k = 0; k < count; ++k) {
        fractions[k] = (ty_screen_down_fraction){.small_angle = 1};
        interpolate(values[k], fractions[k].terms);
    }
}
