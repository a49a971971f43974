/* Multiply scattered light of a spherical atmosphere by successive orders of scattering.
 *
 * Each order is the light of the one before that the air and the haze scatter, by their own phase functions, or the
 * ground reflects; the first is that of the sun. Radiance depends on height, on the sun's zenith angle, and on two
 * angles of direction (Bruneton and Neyret 2008), of which spherical harmonics up to band 4 are kept: all that Rayleigh
 * scattering sees (bands 0 and 2), and haze to within g^5. */
#ifndef TY_SCENE_LIGHTS_SKY_ORDERS_H
#define TY_SCENE_LIGHTS_SKY_ORDERS_H

#include "scene/lights/atmosphere.h"

enum { TY_SKY_HEIGHTS = 12, TY_SKY_SUNS = 40, TY_SKY_HARMONICS = 15, TY_SKY_BANDS = 5 };

/* Harmonics of radiance at one height and sun, those that are even about the plane of zenith and sun; rgb and a 0. */
enum { TY_SKY_ENTRY = 4 * TY_SKY_HARMONICS, TY_SKY_ENTRIES = TY_SKY_HEIGHTS * TY_SKY_SUNS * TY_SKY_ENTRY };

/* The radiance of all orders, over the solar irradiance. */
typedef struct ty_sky_orders {
    float* light;                      /* TY_SKY_ENTRIES */
    double ground[3];                  /* albedo */
    double haze_moments[TY_SKY_BANDS]; /* Legendre moments of the haze's phase function */
} ty_sky_orders;

/* Solves for light, which the caller has allocated, from the other fields. Errors: TY_ERROR_MEMORY. */
ty_result ty_sky_orders_solve(ty_context* context, const ty_atmosphere* atmosphere, ty_sky_orders* orders);

/* Coefficients of a cosine series in the azimuth between view and sun. */
enum { TY_SKY_AZIMUTHS = 12 };

typedef struct ty_sky_ring {
    double cosine[TY_SKY_AZIMUTHS][3];
} ty_sky_ring;

/* Light scattered more than once that comes to a distance from the center from the cosine `up` >= 0, over the solar
 * irradiance. */
void ty_sky_orders_ring(const ty_atmosphere* atmosphere, const ty_sky_orders* orders, double radius, double up,
                        double sun_up, ty_sky_ring* out);
double ty_sky_ring_value(const ty_sky_ring* ring, double cos_azimuth, int channel);

#endif
