/* Clear sky from the ground: sunlight scattered in a spherical atmosphere of air, haze and ozone.
 *
 * Single scattering along each view ray (Nishita et al. 1993); transmittance towards the sun comes from a table (mapped
 * as in Bruneton and Neyret 2008). Multiple scattering is taken as isotropic and as a function of height alone, summed
 * as a geometric series (Hillaire 2020): without it a clear sky is too dark by a quarter (red) to a half (blue) and its
 * horizon yellow. Lengths in metres, coefficients in 1/m; red, green, blue stand for 680, 550 and 440 nm. */
#include "scene/sky.h"

#include "base/constants.h"
#include "base/context.h"

#include <math.h>
#include <string.h>
#include <tyndall/scene.h>

enum {
    WIDTH_MIN = 16,
    WIDTH_MAX = 8192,
    TABLE_HEIGHTS = 64,
    TABLE_ANGLES = 256,
    TABLE_ENTRIES = 3 * TABLE_HEIGHTS * TABLE_ANGLES,
    TABLE_STEPS = 96,
    SERIES_HEIGHTS = 32,
    SERIES_RINGS = 16,
    SERIES_SPOKES = 8,
    SERIES_STEPS = 24,
    VIEW_STEPS = 48
};

static const double ground_radius = 6360e3, top_radius = 6460e3, observer_height = 2;
static const double air_scattering[3] = {5.8e-6, 13.5e-6, 33.1e-6}; /* at sea level */
static const double air_scale = 8000;
static const double haze_scattering = 4e-6, haze_extinction = 4e-6 / 0.9; /* at sea level, haze 1 */
static const double haze_scale = 1200, haze_g = 0.76;
/* Ozone absorption peaks at 25 km and falls off linearly to 0 at 10 and 40 km. */
static const double ozone_absorption[3] = {0.65e-6, 1.881e-6, 0.085e-6};
static const double ozone_height = 25e3, ozone_width = 15e3;
/* Angular radius of the sun, rad: width of the ground's penumbra. */
static const double sun_half_angle = 0.00465;

/* Position and direction in spherical symmetry: distance from the center; cosines of the angles between vertical and
 * direction, vertical and sun, direction and sun. */
typedef struct ray {
    double radius, up, sun_up, cos_sun;
} ray;

typedef struct sky_job {
    ty_sky_def def;
    double sun[3]; /* unit vector to the sun, y up */
    float* table;  /* transmittance to the top, TABLE_HEIGHTS x TABLE_ANGLES x 3 */
    /* Multiply scattered light: radiance over the solar irradiance, averaged over all directions, by height.
     * `next_series` is computed while series is zero. */
    double series[SERIES_HEIGHTS][3], next_series[SERIES_HEIGHTS][3];
    float* planes[3];
} sky_job;

void ty_init_sky_def(void* def, size_t bytes) {
    const ty_sky_def own = {.sun_direction = {-0.5, -0.6, -0.4},
                            .solar = {1.5f, 1.5f, 1.5f},
                            .haze = 1,
                            .ground = {0.2f, 0.2f, 0.2f},
                            .up_axis = TY_AXIS_Y,
                            .width = 512};
    ty_init_def(def, bytes, &own, sizeof own);
}

static ty_result check_def(ty_context* context, const ty_sky_def** given, ty_sky_def* own) {
    *own = ty_default_sky_def();
    const ty_result result = ty_take_def(context, *given, "ty_default_sky_def", own, sizeof *own);
    const ty_sky_def* def = *given = own;
    if (result != TY_OK) return result;
    const double length = hypot(hypot(def->sun_direction[0], def->sun_direction[1]), def->sun_direction[2]);
    if (!(length > 0 && length <= 1e300))
        return ty_fail(context, TY_ERROR_ARGUMENT, "sky.sun_direction is zero or not finite");
    for (int c = 0; c < 3; ++c) {
        if (!(def->solar[c] >= 0 && def->solar[c] <= 1e30f))
            return ty_fail(context, TY_ERROR_ARGUMENT, "sky.solar[%d]: %g is outside [0, 1e30]", c,
                           (double)def->solar[c]);
        if (!(def->ground[c] >= 0 && def->ground[c] <= 1))
            return ty_fail(context, TY_ERROR_ARGUMENT, "sky.ground[%d]: %g is outside [0, 1]", c,
                           (double)def->ground[c]);
    }
    if (!(def->haze >= 0 && def->haze <= 10))
        return ty_fail(context, TY_ERROR_ARGUMENT, "sky.haze: %g is outside [0, 10]", def->haze);
    if (def->up_axis != TY_AXIS_Y && def->up_axis != TY_AXIS_Z)
        return ty_fail(context, TY_ERROR_ARGUMENT, "sky.up_axis: %d is neither y (1) nor z (2)", (int)def->up_axis);
    if (def->width < WIDTH_MIN || def->width > WIDTH_MAX || def->width % 2 != 0)
        return ty_fail(context, TY_ERROR_ARGUMENT, "sky.width: %d is not an even number in %d..%d", def->width,
                       WIDTH_MIN, WIDTH_MAX);
    return TY_OK;
}

/* Densities relative to each constituent's peak. */
typedef struct densities {
    double air, haze, ozone;
} densities;

static densities densities_at(double radius, double haze) {
    const double height = radius - ground_radius;
    return (densities){exp(-height / air_scale), haze * exp(-height / haze_scale),
                       fmax(0, 1 - fabs(height - ozone_height) / ozone_width)};
}

static double extinction(densities m, int channel) {
    return m.air * air_scattering[channel] + m.haze * haze_extinction + m.ozone * ozone_absorption[channel];
}

static double distance_to_top(double radius, double up) {
    return -radius * up + sqrt(fmax(0, radius * radius * (up * up - 1) + top_radius * top_radius));
}

/* Negative if the ray misses the ground. */
static double distance_to_ground(double radius, double up) {
    const double under_root = radius * radius * (up * up - 1) + ground_radius * ground_radius;
    return up < 0 && under_root >= 0 ? fmax(0, -radius * up - sqrt(under_root)) : -1;
}

static ray ray_at(ray from, double t) {
    const double radius = sqrt(from.radius * from.radius + t * t + 2 * from.radius * from.up * t);
    return (ray){radius, (from.radius * from.up + t) / radius, (from.radius * from.sun_up + t * from.cos_sun) / radius,
                 from.cos_sun};
}

/* Center of step i of a ray of given length: steps grow with distance, because density is highest near the ground. */
static double step_center(double length, int i, int steps, double* width) {
    const double scale = length / ((double)steps * steps);
    *width = scale * (2 * i + 1);
    return scale * (i * (i + 1) + 0.5);
}

static void transmittance_to_top(double radius, double up, double haze, double out[3]) {
    const double length = distance_to_top(radius, up);
    const ray from = {radius, up, 0, 0};
    double depth[3] = {0, 0, 0};
    for (int i = 0; i < TABLE_STEPS; ++i) {
        double width;
        const double t = step_center(length, i, TABLE_STEPS, &width);
        const densities m = densities_at(ray_at(from, t).radius, haze);
        for (int c = 0; c < 3; ++c) depth[c] += width * extinction(m, c);
    }
    for (int c = 0; c < 3; ++c) out[c] = exp(-depth[c]);
}

/* Coordinates of the table (Bruneton and Neyret 2008): distance to the horizon, and distance to the top between its
 * minimum and that of a ray grazing the ground. */
static double horizon_distance(double radius) {
    return sqrt(fmax(0, radius * radius - ground_radius * ground_radius));
}

static void table_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const sky_job* job = user;
    const double full_distance = horizon_distance(top_radius);
    const double rho = full_distance * (double)index / (TABLE_HEIGHTS - 1);
    const double radius = sqrt(rho * rho + ground_radius * ground_radius);
    const double shortest = top_radius - radius, longest = rho + full_distance;
    for (int a = 0; a < TABLE_ANGLES; ++a) {
        const double d = shortest + (longest - shortest) * a / (TABLE_ANGLES - 1);
        const double up = d > 0 ? (full_distance * full_distance - rho * rho - d * d) / (2 * radius * d) : 1;
        double t[3];
        transmittance_to_top(radius, fmin(1, fmax(-1, up)), job->def.haze, t);
        for (int c = 0; c < 3; ++c) job->table[3 * (TABLE_ANGLES * index + a) + c] = (float)t[c];
    }
}

/* Terms of sunlight at a distance from the center. */
typedef struct sun_height {
    double horizon;         /* angle by which the horizon is below the horizontal, approximately */
    double shortest, range; /* distances to the top */
    double fraction;        /* between two rows of the table */
    const float* rows;
} sun_height;

static sun_height sun_at_height(const sky_job* job, double radius) {
    const double full_distance = horizon_distance(top_radius), rho = horizon_distance(radius);
    const double shortest = top_radius - radius, longest = rho + full_distance;
    const double y = fmin(1, rho / full_distance) * (TABLE_HEIGHTS - 1);
    const int y0 = y < TABLE_HEIGHTS - 2 ? (int)y : TABLE_HEIGHTS - 2;
    return (sun_height){rho / radius, shortest, longest - shortest, y - y0, job->table + 3 * TABLE_ANGLES * y0};
}

/* Sunlight at a point, over the solar irradiance. */
static void sunlight(const sun_height* at, double radius, double sun_up, double out[3]) {
    const double dip = sun_up + at->horizon; /* elevation above the horizon, approximately in radians */
    const double sun_fraction = fmin(1, fmax(0, 0.5 + 0.5 * dip / sun_half_angle));
    const double position = fmin(1, fmax(0, (distance_to_top(radius, sun_up) - at->shortest) / at->range));
    const double x = position * (TABLE_ANGLES - 1);
    const int x0 = x < TABLE_ANGLES - 2 ? (int)x : TABLE_ANGLES - 2;
    const double fx = x - x0, fy = at->fraction;
    const float* cell = at->rows + 3 * x0;
    for (int c = 0; c < 3; ++c) {
        const double low = (1 - fx) * cell[c] + fx * cell[3 + c];
        const double high = (1 - fx) * cell[3 * TABLE_ANGLES + c] + fx * cell[3 * TABLE_ANGLES + 3 + c];
        out[c] = sun_fraction * ((1 - fy) * low + fy * high);
    }
}

static double series_at(const sky_job* job, double radius, int channel) {
    const double x = fmin(1, fmax(0, (radius - ground_radius) / (top_radius - ground_radius)));
    const double position = sqrt(x) * (SERIES_HEIGHTS - 1);
    const int i = position < SERIES_HEIGHTS - 2 ? (int)position : SERIES_HEIGHTS - 2;
    return job->series[i][channel] + (position - i) * (job->series[i + 1][channel] - job->series[i][channel]);
}

/* Step of a path through the atmosphere: all that does not depend on the sun's place. */
typedef struct path_step {
    double t, radius;
    sun_height sun;
    double weight[3], air[3], haze[3]; /* of the light scattered there */
    double multiple[3];                /* radiance scattered from the table of multiple scattering */
} path_step;

typedef struct sky_path {
    int steps;
    path_step step[VIEW_STEPS];
    double transmittance[3];
    double transfer[3]; /* radiance along the path for unit isotropic incident radiance */
} sky_path;

static void trace_path(const sky_job* job, double radius, double up, double length, int steps, sky_path* path) {
    const ray from = {radius, up, 0, 0};
    path->steps = steps;
    for (int c = 0; c < 3; ++c) {
        path->transmittance[c] = 1;
        path->transfer[c] = 0;
    }
    for (int i = 0; i < steps; ++i) {
        path_step* step = &path->step[i];
        double width;
        step->t = step_center(length, i, steps, &width);
        step->radius = ray_at(from, step->t).radius;
        step->sun = sun_at_height(job, step->radius);
        const densities m = densities_at(step->radius, job->def.haze);
        for (int c = 0; c < 3; ++c) {
            const double sigma_t = extinction(m, c), transmitted = exp(-sigma_t * width);
            step->air[c] = m.air * air_scattering[c];
            step->haze[c] = m.haze * haze_scattering;
            const double scattering = step->air[c] + step->haze[c];
            step->weight[c] = path->transmittance[c] * (sigma_t > 0 ? (1 - transmitted) / sigma_t : width);
            step->multiple[c] = scattering * series_at(job, step->radius, c);
            path->transfer[c] += step->weight[c] * scattering;
            path->transmittance[c] *= transmitted;
        }
    }
}

/* Radiance along a path over the solar irradiance, singly scattered by the given phase functions plus multiply
 * scattered from the table. from: the start of the path, and the sun. */
static void gather(const sky_path* path, ray from, double air_phase, double haze_phase, double radiance[3]) {
    for (int c = 0; c < 3; ++c) radiance[c] = 0;
    for (int i = 0; i < path->steps; ++i) {
        const path_step* step = &path->step[i];
        const double sun_up = (from.radius * from.sun_up + step->t * from.cos_sun) / step->radius;
        double sun[3];
        sunlight(&step->sun, step->radius, sun_up, sun);
        for (int c = 0; c < 3; ++c) {
            const double single = sun[c] * (step->air[c] * air_phase + step->haze[c] * haze_phase);
            radiance[c] += step->weight[c] * (single + step->multiple[c]);
        }
    }
}

/* Eqs. 5-9 (Hillaire 2020): twice-scattered light incident at a point, averaged over directions, and the fraction f of
 * isotropic light that is incident there again; 1 + f + f^2 + ... sums all orders. job->series is still zero, so that
 * gather gives the first order only. */
static void series_point(void* user, int64_t index, int32_t worker) {
    (void)worker;
    sky_job* job = user;
    const double x = (double)index / (SERIES_HEIGHTS - 1), isotropic = 1 / (4 * TY_PI_F64);
    const double radius = fmin(top_radius - 1, ground_radius + observer_height + x * x * (top_radius - ground_radius));
    const double sun_up = job->sun[1], sun_horizontal = sqrt(fmax(0, 1 - sun_up * sun_up));
    double second[3] = {0, 0, 0}, fraction[3] = {0, 0, 0};
    const sun_height at_ground = sun_at_height(job, ground_radius);
    for (int ring = 0; ring < SERIES_RINGS; ++ring) {
        const double up = 1 - (2 * ring + 1.0) / SERIES_RINGS, ground = distance_to_ground(radius, up);
        sky_path path;
        trace_path(job, radius, up, ground >= 0 ? ground : distance_to_top(radius, up), SERIES_STEPS, &path);
        for (int azimuth = 0; azimuth < SERIES_SPOKES; ++azimuth) {
            const double angle = TY_PI_F64 * (azimuth + 0.5) / SERIES_SPOKES;
            const double cos_gamma = up * sun_up + sqrt(1 - up * up) * sun_horizontal * cos(angle);
            const ray from = {radius, up, sun_up, cos_gamma};
            double single[3];
            gather(&path, from, isotropic, isotropic, single);
            if (ground >= 0) {
                const ray hit = ray_at(from, ground);
                double sun[3];
                sunlight(&at_ground, ground_radius, hit.sun_up, sun);
                for (int c = 0; c < 3; ++c)
                    single[c] +=
                        path.transmittance[c] * sun[c] * fmax(0, hit.sun_up) * (double)job->def.ground[c] / TY_PI_F64;
            }
            for (int c = 0; c < 3; ++c) {
                second[c] += single[c] / (SERIES_RINGS * SERIES_SPOKES);
                fraction[c] += path.transfer[c] / (SERIES_RINGS * SERIES_SPOKES);
            }
        }
    }
    for (int c = 0; c < 3; ++c) job->next_series[index][c] = second[c] / (1 - fraction[c]);
}

/* One row above the horizon. With z up a map holds (x, -z, y) where with y up it holds (x, y, z). */
static void sky_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const sky_job* job = user;
    const int32_t width = job->def.width;
    const double theta = TY_PI_F64 * ((double)index + 0.5) / (width / 2);
    const double up = fmax(0, cos(theta)), horizontal = sin(theta), g = haze_g;
    const double radius = ground_radius + observer_height, length = distance_to_top(radius, up);
    sky_path path;
    trace_path(job, radius, up, length, VIEW_STEPS, &path);
    for (int32_t column = 0; column < width; ++column) {
        const double phi = 2 * TY_PI_F64 * ((column + 0.5) / width - 0.5);
        const double cos_gamma =
            horizontal * cos(phi) * job->sun[0] + up * job->sun[1] + horizontal * sin(phi) * job->sun[2];
        const double mu = fmin(1, fmax(-1, cos_gamma));
        const double rayleigh = 3 / (16 * TY_PI_F64) * (1 + mu * mu);
        /* Eq. 6 (Cornette and Shanks 1992) */
        const double cornette =
            3 / (8 * TY_PI_F64) * (1 - g * g) * (1 + mu * mu) / ((2 + g * g) * pow(1 + g * g - 2 * g * mu, 1.5));
        double radiance[3];
        gather(&path, (ray){radius, up, job->sun[1], mu}, rayleigh, cornette, radiance);
        for (int c = 0; c < 3; ++c)
            job->planes[c][(size_t)index * (size_t)width + (size_t)column] = (float)(job->def.solar[c] * radiance[c]);
    }
}

/* Irradiance of a horizontal plane from the rows above the horizon. */
static double sky_irradiance(const sky_job* job, int channel) {
    const int32_t width = job->def.width, height = width / 2;
    double sum = 0;
    for (int32_t row = 0; 2 * row + 1 <= height; ++row) {
        const double from = sin(TY_PI_F64 * row / height),
                     to = sin(fmin(TY_PI_F64 / 2, TY_PI_F64 * (row + 1) / height));
        double line = 0;
        for (int32_t i = 0; i < width; ++i) line += job->planes[channel][(size_t)row * (size_t)width + (size_t)i];
        sum += line * TY_PI_F64 * (to * to - from * from) / width;
    }
    return sum;
}

static void fill_image(ty_context* context, sky_job* job, float sun_irradiance[3]) {
    const int32_t width = job->def.width, height = width / 2, above = (height + 1) / 2;
    ty_parallel_for(context, SERIES_HEIGHTS, series_point, job);
    memcpy(job->series, job->next_series, sizeof job->series);
    ty_parallel_for(context, above, sky_row, job);
    double transmitted[3];
    transmittance_to_top(ground_radius + observer_height, job->sun[1], job->def.haze, transmitted);
    for (int c = 0; c < 3; ++c) {
        const double sun = job->sun[1] > 0 ? (double)job->def.solar[c] * transmitted[c] : 0;
        const double irradiance = sun * fmax(0, job->sun[1]) + sky_irradiance(job, c);
        const float ground = (float)((double)job->def.ground[c] / TY_PI_F64 * irradiance);
        for (size_t i = (size_t)above * (size_t)width; i < (size_t)height * (size_t)width; ++i)
            job->planes[c][i] = ground;
        if (sun_irradiance != NULL) sun_irradiance[c] = (float)sun;
    }
}

/* Fills a table unless it is of the job's haze. */
static ty_result make_table(ty_context* context, sky_job* job, ty_sky_table* table) {
    if (table->values != NULL && table->haze == job->def.haze) return TY_OK;
    if (table->values == NULL) table->values = ty_alloc_array(context, TABLE_ENTRIES, sizeof(float), false);
    if (table->values == NULL) return TY_ERROR_MEMORY;
    job->table = table->values;
    table->haze = job->def.haze;
    ty_parallel_for(context, TABLE_HEIGHTS, table_row, job);
    return TY_OK;
}

void ty_sky_table_release(ty_context* context, ty_sky_table* table) {
    ty_free_array(context, table->values, TABLE_ENTRIES, sizeof(float));
    *table = (ty_sky_table){.values = NULL};
}

ty_result ty_sky_create_image_with(ty_context* context, const ty_sky_def* def, ty_sky_table* table, ty_image** out,
                                   float sun_irradiance[3]) {
    ty_sky_def own;
    ty_result result = check_def(context, &def, &own);
    if (result != TY_OK) return result;
    sky_job job = {.def = *def};
    const double* d = def->sun_direction;
    const double length = hypot(hypot(d[0], d[1]), d[2]);
    job.sun[0] = -d[0] / length;
    job.sun[1] = -(def->up_axis == TY_AXIS_Y ? d[1] : d[2]) / length;
    job.sun[2] = -(def->up_axis == TY_AXIS_Y ? d[2] : -d[1]) / length;
    result = make_table(context, &job, table);
    if (result != TY_OK) return result;
    job.table = table->values;
    ty_image* image = NULL;
    result = ty_image_create_rgb(context, def->width, def->width / 2, &image);
    if (result != TY_OK) return result;
    for (int c = 0; c < 3; ++c) job.planes[c] = ty_image_plane(image, c);
    fill_image(context, &job, sun_irradiance);
    *out = image;
    return TY_OK;
}

ty_result ty_sky_create_image(ty_context* context, const ty_sky_def* def, ty_image** out, float sun_irradiance[3]) {
    if (context == NULL || out == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_sky_create_image: a pointer is NULL");
    ty_sky_table table = {.values = NULL};
    const ty_result result = ty_sky_create_image_with(context, def, &table, out, sun_irradiance);
    ty_sky_table_release(context, &table);
    return result;
}
