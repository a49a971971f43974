/* Clear sky from the ground: sunlight scattered in a spherical atmosphere of air, haze and ozone.
 *
 * Single scattering along each view ray (Nishita et al. 1993); transmittance towards the sun comes from a table (mapped
 * as in Bruneton and Neyret 2008). Light scattered more than once comes from successive orders (sky_orders.h), or is
 * taken as isotropic and as a function of height alone, summed as a geometric series (Hillaire 2020). Without it a
 * clear sky is too dark by a quarter (red) to a half (blue) and its horizon yellow. */
#include "scene/lights/sky.h"

#include "base/constants.h"
#include "base/context.h"
#include "scene/lights/sky_orders.h"

#include <math.h>
#include <string.h>
#include <tyndall/scene.h>

enum {
    WIDTH_MIN = 16,
    WIDTH_MAX = 8192,
    SERIES_HEIGHTS = 32,
    SERIES_RINGS = 16,
    SERIES_SPOKES = 8,
    SERIES_STEPS = 24,
    VIEW_STEPS = 48
};

typedef struct sky_job {
    ty_sky_def def;
    double sun[3]; /* unit vector to the sun, y up */
    ty_atmosphere atmosphere;
    ty_sky_orders orders;
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
                            .width = 512,
                            .ozone = 1,
                            .scattering = TY_SKY_ORDERS,
                            .height = ty_observer_height};
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
    if (!(def->ozone >= 0 && def->ozone <= 10))
        return ty_fail(context, TY_ERROR_ARGUMENT, "sky.ozone: %g is outside [0, 10]", def->ozone);
    if (!(def->height >= ty_observer_height && def->height <= TY_SKY_HEIGHT_MAX))
        return ty_fail(context, TY_ERROR_ARGUMENT, "sky.height: %g is outside [%g, %d]", def->height,
                       ty_observer_height, TY_SKY_HEIGHT_MAX);
    if (def->scattering < TY_SKY_ORDERS || def->scattering > TY_SKY_SINGLE)
        return ty_fail(context, TY_ERROR_ARGUMENT, "sky.scattering: %d is not a ty_sky_scattering",
                       (int)def->scattering);
    if (def->up_axis != TY_AXIS_Y && def->up_axis != TY_AXIS_Z)
        return ty_fail(context, TY_ERROR_ARGUMENT, "sky.up_axis: %d is neither y (1) nor z (2)", (int)def->up_axis);
    if (def->width < WIDTH_MIN || def->width > WIDTH_MAX || def->width % 2 != 0)
        return ty_fail(context, TY_ERROR_ARGUMENT, "sky.width: %d is not an even number in %d..%d", def->width,
                       WIDTH_MIN, WIDTH_MAX);
    return TY_OK;
}

static double series_at(const sky_job* job, double radius, int channel) {
    const double x = fmin(1, fmax(0, (radius - ty_ground_radius) / (ty_top_radius - ty_ground_radius)));
    const double position = sqrt(x) * (SERIES_HEIGHTS - 1);
    const int i = position < SERIES_HEIGHTS - 2 ? (int)position : SERIES_HEIGHTS - 2;
    return job->series[i][channel] + (position - i) * (job->series[i + 1][channel] - job->series[i][channel]);
}

/* Step of a path through the atmosphere: all that does not depend on the sun's place. */
typedef struct path_step {
    double t, radius;
    ty_sun_height sun;
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
    const ty_air_ray from = {radius, up, 0, 0};
    path->steps = steps;
    for (int c = 0; c < 3; ++c) {
        path->transmittance[c] = 1;
        path->transfer[c] = 0;
    }
    for (int i = 0; i < steps; ++i) {
        path_step* step = &path->step[i];
        double width;
        step->t = ty_step_center(length, i, steps, &width);
        step->radius = ty_air_ray_at(from, step->t).radius;
        step->sun = ty_sun_at_height(&job->atmosphere, step->radius);
        const ty_air_densities m = ty_air_densities_at(&job->atmosphere, step->radius);
        for (int c = 0; c < 3; ++c) {
            const double sigma_t = ty_air_extinction(m, c), transmitted = exp(-sigma_t * width);
            step->air[c] = m.air * ty_air_scattering[c];
            step->haze[c] = m.haze * ty_haze_scattering;
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
static void gather(const sky_path* path, ty_air_ray from, double air_phase, double haze_phase, double radiance[3]) {
    for (int c = 0; c < 3; ++c) radiance[c] = 0;
    for (int i = 0; i < path->steps; ++i) {
        const path_step* step = &path->step[i];
        const double sun_up = (from.radius * from.sun_up + step->t * from.cos_sun) / step->radius;
        double sun[3];
        ty_sunlight(&step->sun, step->radius, sun_up, sun);
        for (int c = 0; c < 3; ++c) {
            const double single = sun[c] * (step->air[c] * air_phase + step->haze[c] * haze_phase);
            radiance[c] += step->weight[c] * (single + step->multiple[c]);
        }
    }
}

/* Eq. 5-9 (Hillaire 2020): twice-scattered light incident at a point, averaged over directions, and the fraction f of
 * isotropic light that is incident there again; 1 + f + f^2 + ... sums all orders. job->series is still zero, so that
 * gather gives the first order only. */
static void series_point(void* user, int64_t index, int32_t worker) {
    (void)worker;
    sky_job* job = user;
    const double x = (double)index / (SERIES_HEIGHTS - 1), isotropic = 1 / (4 * TY_PI_F64);
    const double radius =
        fmin(ty_top_radius - 1, ty_ground_radius + ty_observer_height + x * x * (ty_top_radius - ty_ground_radius));
    const double sun_up = job->sun[1], sun_horizontal = sqrt(fmax(0, 1 - sun_up * sun_up));
    double second[3] = {0, 0, 0}, fraction[3] = {0, 0, 0};
    const ty_sun_height at_ground = ty_sun_at_height(&job->atmosphere, ty_ground_radius);
    for (int ring = 0; ring < SERIES_RINGS; ++ring) {
        const double up = 1 - (2 * ring + 1.0) / SERIES_RINGS, ground = ty_distance_to_ground(radius, up);
        sky_path path;
        trace_path(job, radius, up, ground >= 0 ? ground : ty_distance_to_top(radius, up), SERIES_STEPS, &path);
        for (int azimuth = 0; azimuth < SERIES_SPOKES; ++azimuth) {
            const double angle = TY_PI_F64 * (azimuth + 0.5) / SERIES_SPOKES;
            const double cos_gamma = up * sun_up + sqrt(1 - up * up) * sun_horizontal * cos(angle);
            const ty_air_ray from = {radius, up, sun_up, cos_gamma};
            double single[3];
            gather(&path, from, isotropic, isotropic, single);
            if (ground >= 0) {
                const ty_air_ray hit = ty_air_ray_at(from, ground);
                double sun[3];
                ty_sunlight(&at_ground, ty_ground_radius, hit.sun_up, sun);
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
    const double up = fmax(0, cos(theta)), horizontal = sin(theta);
    const double radius = ty_ground_radius + job->def.height, length = ty_distance_to_top(radius, up);
    const double sun_horizontal = hypot(job->sun[0], job->sun[2]);
    const bool by_orders = job->def.scattering == TY_SKY_ORDERS;
    sky_path path;
    ty_sky_ring ring;
    trace_path(job, radius, up, length, VIEW_STEPS, &path);
    if (by_orders) ty_sky_orders_ring(&job->atmosphere, &job->orders, radius, up, job->sun[1], &ring);
    for (int32_t column = 0; column < width; ++column) {
        const double phi = 2 * TY_PI_F64 * ((column + 0.5) / width - 0.5);
        const double cos_gamma =
            horizontal * cos(phi) * job->sun[0] + up * job->sun[1] + horizontal * sin(phi) * job->sun[2];
        const double mu = fmin(1, fmax(-1, cos_gamma));
        double radiance[3];
        gather(&path, (ty_air_ray){radius, up, job->sun[1], mu}, ty_air_phase(mu), ty_haze_phase(mu), radiance);
        const double azimuth = cos(phi) * job->sun[0] + sin(phi) * job->sun[2];
        const double cos_azimuth = sun_horizontal > 1e-9 ? azimuth / sun_horizontal : 0;
        for (int c = 0; c < 3 && by_orders; ++c) radiance[c] += ty_sky_ring_value(&ring, cos_azimuth, c);
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
    if (job->def.scattering == TY_SKY_ISOTROPIC) {
        ty_parallel_for(context, SERIES_HEIGHTS, series_point, job);
        memcpy(job->series, job->next_series, sizeof job->series);
    }
    ty_parallel_for(context, above, sky_row, job);
    double transmitted[3];
    ty_air_transmittance(&job->atmosphere, ty_ground_radius + job->def.height, job->sun[1], transmitted);
    for (int c = 0; c < 3; ++c) {
        const double sun = job->sun[1] > 0 ? (double)job->def.solar[c] * transmitted[c] : 0;
        const double irradiance = sun * fmax(0, job->sun[1]) + sky_irradiance(job, c);
        const float ground = (float)((double)job->def.ground[c] / TY_PI_F64 * irradiance);
        for (size_t i = (size_t)above * (size_t)width; i < (size_t)height * (size_t)width; ++i)
            job->planes[c][i] = ground;
        if (sun_irradiance != NULL) sun_irradiance[c] = (float)sun;
    }
}

/* Fills a table unless it is of the job's air. */
static ty_result make_transmittance(ty_context* context, sky_job* job, ty_sky_table* table) {
    const bool kept = table->transmittance != NULL && table->haze == job->def.haze && table->ozone == job->def.ozone;
    if (table->transmittance == NULL)
        table->transmittance = ty_alloc_array(context, TY_ATMOSPHERE_ENTRIES, sizeof(float), false);
    if (table->transmittance == NULL) return TY_ERROR_MEMORY;
    job->atmosphere = (ty_atmosphere){job->def.haze, job->def.ozone, table->transmittance};
    if (kept) return TY_OK;
    table->haze = job->def.haze;
    table->ozone = job->def.ozone;
    table->solved = false;
    ty_atmosphere_fill(context, &job->atmosphere);
    return TY_OK;
}

/* Solves for multiply scattered light unless the table has that of the job's air and ground. */
static ty_result make_orders(ty_context* context, sky_job* job, ty_sky_table* table) {
    const bool kept = table->solved && memcmp(table->ground, job->def.ground, sizeof table->ground) == 0;
    if (table->light == NULL) table->light = ty_alloc_array(context, TY_SKY_ENTRIES, sizeof(float), false);
    if (table->light == NULL) return TY_ERROR_MEMORY;
    job->orders.light = table->light;
    double moments[3 * TY_SKY_BANDS];
    const ty_phase_lobe haze = {.kind = TY_PHASE_DRAINE, .weight = {1, 1, 1}, .g = ty_haze_g, .alpha = 1};
    ty_result result = ty_phase_moments(context, &haze, 1, TY_SKY_BANDS - 1, moments);
    if (result != TY_OK) return result;
    memcpy(job->orders.haze_moments, moments, sizeof job->orders.haze_moments);
    for (int c = 0; c < 3; ++c) job->orders.ground[c] = (double)job->def.ground[c];
    if (kept) return TY_OK;
    table->solved = false;
    result = ty_sky_orders_solve(context, &job->atmosphere, &job->orders);
    if (result != TY_OK) return result;
    table->solved = true;
    memcpy(table->ground, job->def.ground, sizeof table->ground);
    return TY_OK;
}

void ty_sky_table_release(ty_context* context, ty_sky_table* table) {
    ty_free_array(context, table->transmittance, TY_ATMOSPHERE_ENTRIES, sizeof(float));
    ty_free_array(context, table->light, TY_SKY_ENTRIES, sizeof(float));
    *table = (ty_sky_table){.solved = false};
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
    result = make_transmittance(context, &job, table);
    if (result == TY_OK && def->scattering == TY_SKY_ORDERS) result = make_orders(context, &job, table);
    if (result != TY_OK) return result;
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
    ty_sky_table table = {.solved = false};
    const ty_result result = ty_sky_create_image_with(context, def, &table, out, sun_irradiance);
    ty_sky_table_release(context, &table);
    return result;
}
