/* How the light that a medium scatters spreads over the picture, as shares for the levels of a pyramid. */
#ifndef TY_METHOD_SCREEN_SPREAD_H
#define TY_METHOD_SCREEN_SPREAD_H

#include "method/screen/scatter.k.h"

#include <tyndall/screen.h>

/* The angle, in radians, that scales the small-angle spread of Henyey-Greenstein scattering: (1 - g) / sqrt(g). Large
 * for g near 0 and below, where no angle is small. */
double ty_screen_angle(double g);
/* The share of the light scattered over the optical thickness tau (scattering alone, > 0) whose Gaussian is wider than
 * the variance; width: ty_screen_angle times the focal length, pixels. */
double ty_screen_wider_fraction(double width, double tau, double variance);
/* The radius, pixels, within which half of it falls. */
double ty_screen_half_radius(double width, double tau);

/* The share that goes on from a level that holds the variance levels[k] to the next, for each k < count; levels has
 * count + 1 entries. gaussian: shares of a variance itself (Eq. 2), else of an optical thickness. */
void ty_screen_gaussian_fractions(const float* levels, int32_t count, ty_screen_down_fraction* shares);
void ty_screen_small_angle_fractions(double width, const float* levels, int32_t count, ty_screen_down_fraction* shares);

#endif
