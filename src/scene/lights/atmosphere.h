/* A spherical atmosphere of air, haze and ozone: its densities, its transmittance, and sunlight in it.
 *
 * Lengths in metres, coefficients in 1/m; red, green, blue stand for 680, 550 and 440 nm. */
#ifndef TY_SCENE_LIGHTS_ATMOSPHERE_H
#define TY_SCENE_LIGHTS_ATMOSPHERE_H

#include "base/constants.h"

#include <math.h>
#include <tyndall/base.h>

enum { TY_ATMOSPHERE_HEIGHTS = 64, TY_ATMOSPHERE_ANGLES = 256 };
enum { TY_ATMOSPHERE_ENTRIES = 3 * TY_ATMOSPHERE_HEIGHTS * TY_ATMOSPHERE_ANGLES };

/* Largest height of an observer, m; ozone is above it. */
enum { TY_SKY_HEIGHT_MAX = 10000 };

static const double ty_ground_radius = 6360e3, ty_top_radius = 6460e3, ty_observer_height = 2;

/* Properties of the constituents: coefficients at sea level per channel, and scale heights. */
extern const double ty_air_scattering[3], ty_haze_scattering, ty_haze_extinction, ty_haze_g, ty_air_scale,
    ty_haze_scale;

typedef struct ty_atmosphere {
    double haze, ozone; /* amounts, 1: as on a clear day */
    float* table;       /* transmittance to the top, TY_ATMOSPHERE_HEIGHTS x TY_ATMOSPHERE_ANGLES x 3 */
} ty_atmosphere;

/* Position and direction in spherical symmetry: distance from the center; cosines of the angles between vertical and
 * direction, vertical and sun, direction and sun. */
typedef struct ty_air_ray {
    double radius, up, sun_up, cos_sun;
} ty_air_ray;

/* Densities relative to each constituent's peak. */
typedef struct ty_air_densities {
    double air, haze, ozone;
} ty_air_densities;

ty_air_densities ty_air_densities_at(const ty_atmosphere* atmosphere, double radius);
double ty_air_extinction(ty_air_densities densities, int channel);

/* Transmittance from a point to the top along a direction. */
void ty_air_transmittance(const ty_atmosphere* atmosphere, double radius, double up, double out[3]);

/* Fills the table, which the caller has allocated. */
void ty_atmosphere_fill(ty_context* context, ty_atmosphere* atmosphere);

static inline double ty_distance_to_top(double radius, double up) {
    const double squared = radius * radius * (up * up - 1) + ty_top_radius * ty_top_radius;
    return -radius * up + (squared > 0 ? sqrt(squared) : 0);
}

/* Negative if the ray misses the ground. */
static inline double ty_distance_to_ground(double radius, double up) {
    const double under_root = radius * radius * (up * up - 1) + ty_ground_radius * ty_ground_radius;
    return up < 0 && under_root >= 0 ? fmax(0, -radius * up - sqrt(under_root)) : -1;
}

static inline double ty_horizon_distance(double radius) {
    return sqrt(fmax(0, radius * radius - ty_ground_radius * ty_ground_radius));
}

static inline ty_air_ray ty_air_ray_at(ty_air_ray from, double t) {
    const double radius = sqrt(from.radius * from.radius + t * t + 2 * from.radius * from.up * t);
    return (ty_air_ray){radius, (from.radius * from.up + t) / radius,
                        (from.radius * from.sun_up + t * from.cos_sun) / radius, from.cos_sun};
}

/* Center of step i of a ray of given length: steps grow with distance, because density is highest near the ground. */
static inline double ty_step_center(double length, int i, int steps, double* width) {
    const double scale = length / ((double)steps * steps);
    *width = scale * (2 * i + 1);
    return scale * (i * (i + 1) + 0.5);
}

/* Phase function of haze, Eq. 6 (Cornette 1992), 1/sr. */
static inline double ty_haze_phase(double mu) {
    const double g = ty_haze_g;
    return 3 / (8 * TY_PI_F64) * (1 - g * g) * (1 + mu * mu) / ((2 + g * g) * pow(1 + g * g - 2 * g * mu, 1.5));
}

/* Phase function of air (Rayleigh), 1/sr. */
static inline double ty_air_phase(double mu) {
    return 3 / (16 * TY_PI_F64) * (1 + mu * mu);
}

/* Terms of sunlight at a distance from the center. */
typedef struct ty_sun_height {
    double horizon;         /* angle by which the horizon is below the horizontal, approximately */
    double shortest, range; /* distances to the top */
    double fraction;        /* between two rows of the table */
    const float* rows;
} ty_sun_height;

ty_sun_height ty_sun_at_height(const ty_atmosphere* atmosphere, double radius);

/* Sunlight at a point, over the solar irradiance. */
void ty_sunlight(const ty_sun_height* at, double radius, double sun_up, double out[3]);

#endif
