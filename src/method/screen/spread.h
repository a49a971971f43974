/* Spread of scattered light over the image, as fractions for the levels of a pyramid. */
#ifndef TY_METHOD_SCREEN_SPREAD_H
#define TY_METHOD_SCREEN_SPREAD_H

#include "method/screen/scatter.k.h"

#include <tyndall/screen.h>

/* Scale angle, radians, of the small-angle spread of Henyey-Greenstein scattering: (1 - g) / sqrt(g). Clamped for g
 * near 0 and below, where no angle is small. */
double ty_screen_angle(double g);
/* Fraction of the light scattered over the optical thickness tau (scattering alone, > 0) whose Gaussian is wider than
 * the variance; width: ty_screen_angle times the focal length, pixels. */
double ty_screen_wider_fraction(double width, double tau, double variance);
/* Half-light radius of the scattered light, pixels. */
double ty_screen_half_radius(double width, double tau);

/* Fractions passed from a level of variance levels[k] to the next, for each k < count; levels has count + 1 entries.
 * gaussian: as a function of variance, Eq. 2 (Elek 2013), else of optical thickness. */
void ty_screen_gaussian_fractions(const float* levels, int32_t count, ty_screen_down_fraction* fractions);
void ty_screen_small_angle_fractions(double width, const float* levels, int32_t count,
                                     ty_screen_down_fraction* fractions);

#endif
