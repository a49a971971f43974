/* A spherical atmosphere of air, haze and ozone (header: atmosphere.h). */
#include "scene/lights/atmosphere.h"

enum { HEIGHTS = TY_ATMOSPHERE_HEIGHTS, ANGLES = TY_ATMOSPHERE_ANGLES, DEPTH_STEPS = 96 };

const double ty_air_scattering[3] = {5.8e-6, 13.5e-6, 33.1e-6};
const double ty_air_scale = 8000;
const double ty_haze_scattering = 4e-6, ty_haze_extinction = 4e-6 / 0.9; /* haze 1 */
const double ty_haze_scale = 1200, ty_haze_g = 0.76;
/* Ozone absorption peaks at 25 km and falls off linearly to 0 at 10 and 40 km. */
static const double ozone_absorption[3] = {0.65e-6, 1.881e-6, 0.085e-6};
static const double ozone_height = 25e3, ozone_width = 15e3;
/* Angular radius of the sun, rad: width of the ground's penumbra. */
static const double sun_half_angle = 0.00465;

ty_air_densities ty_air_densities_at(const ty_atmosphere* atmosphere, double radius) {
    const double height = radius - ty_ground_radius;
    return (ty_air_densities){exp(-height / ty_air_scale), atmosphere->haze * exp(-height / ty_haze_scale),
                              atmosphere->ozone * fmax(0, 1 - fabs(height - ozone_height) / ozone_width)};
}

double ty_air_extinction(ty_air_densities densities, int channel) {
    return densities.air * ty_air_scattering[channel] + densities.haze * ty_haze_extinction +
           densities.ozone * ozone_absorption[channel];
}

void ty_air_transmittance(const ty_atmosphere* atmosphere, double radius, double up, double out[3]) {
    const double length = ty_distance_to_top(radius, up);
    const ty_air_ray from = {radius, up, 0, 0};
    double depth[3] = {0, 0, 0};
    for (int i = 0; i < DEPTH_STEPS; ++i) {
        double width;
        const double t = ty_step_center(length, i, DEPTH_STEPS, &width);
        const ty_air_densities m = ty_air_densities_at(atmosphere, ty_air_ray_at(from, t).radius);
        for (int c = 0; c < 3; ++c) depth[c] += width * ty_air_extinction(m, c);
    }
    for (int c = 0; c < 3; ++c) out[c] = exp(-depth[c]);
}

/* Coordinates of the table (Bruneton and Neyret 2008): distance to the horizon, and distance to the top between its
 * minimum and that of a ray grazing the ground. */
static void table_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const ty_atmosphere* atmosphere = user;
    const double full_distance = ty_horizon_distance(ty_top_radius);
    const double rho = full_distance * (double)index / (HEIGHTS - 1);
    const double radius = sqrt(rho * rho + ty_ground_radius * ty_ground_radius);
    const double shortest = ty_top_radius - radius, longest = rho + full_distance;
    for (int a = 0; a < ANGLES; ++a) {
        const double d = shortest + (longest - shortest) * a / (ANGLES - 1);
        const double up = d > 0 ? (full_distance * full_distance - rho * rho - d * d) / (2 * radius * d) : 1;
        double t[3];
        ty_air_transmittance(atmosphere, radius, fmin(1, fmax(-1, up)), t);
        for (int c = 0; c < 3; ++c) atmosphere->table[3 * (ANGLES * index + a) + c] = (float)t[c];
    }
}

void ty_atmosphere_fill(ty_context* context, ty_atmosphere* atmosphere) {
    ty_parallel_for(context, HEIGHTS, table_row, atmosphere);
}

ty_sun_height ty_sun_at_height(const ty_atmosphere* atmosphere, double radius) {
    const double full_distance = ty_horizon_distance(ty_top_radius), rho = ty_horizon_distance(radius);
    const double shortest = ty_top_radius - radius, longest = rho + full_distance;
    const double y = fmin(1, rho / full_distance) * (HEIGHTS - 1);
    const int y0 = y < HEIGHTS - 2 ? (int)y : HEIGHTS - 2;
    return (ty_sun_height){rho / radius, shortest, longest - shortest, y - y0, atmosphere->table + 3 * ANGLES * y0};
}

/* fmin and fmax are calls. */
static double clamp_01(double x) {
    return x > 0 ? x < 1 ? x : 1 : 0;
}

void ty_sunlight(const ty_sun_height* at, double radius, double sun_up, double out[3]) {
    const double dip = sun_up + at->horizon; /* elevation above the horizon, approximately in radians */
    const double sun_fraction = clamp_01(0.5 + 0.5 * dip / sun_half_angle);
    if (sun_fraction <= 0) {
        for (int c = 0; c < 3; ++c) out[c] = 0;
        return;
    }
    const double position = clamp_01((ty_distance_to_top(radius, sun_up) - at->shortest) / at->range);
    const double x = position * (ANGLES - 1);
    const int x0 = x < ANGLES - 2 ? (int)x : ANGLES - 2;
    const double fx = x - x0, fy = at->fraction;
    const float* cell = at->rows + 3 * x0;
    for (int c = 0; c < 3; ++c) {
        const double low = (1 - fx) * (double)cell[c] + fx * (double)cell[3 + c];
        const double high = (1 - fx) * (double)cell[3 * ANGLES + c] + fx * (double)cell[3 * ANGLES + 3 + c];
        out[c] = sun_fraction * ((1 - fy) * low + fy * high);
    }
}
