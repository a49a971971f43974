/* Multiply scattered light of a spherical atmosphere by successive orders of scattering (header: sky_orders.h). */
#include "scene/lights/sky_orders.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/sh.k.h"

#include <string.h>

enum {
    HEIGHTS = TY_SKY_HEIGHTS,
    SUNS = TY_SKY_SUNS,
    HARMONICS = TY_SKY_HARMONICS,
    BANDS = TY_SKY_BANDS,
    ENTRY = TY_SKY_ENTRY,
    RINGS_ABOVE = 9, /* directions above the horizon */
    RINGS_BELOW = 5,
    RINGS = RINGS_ABOVE + RINGS_BELOW,
    AZIMUTHS = 8, /* on one side of the plane of zenith and sun */
    LEG_STEPS = 10,
    PATH_STEPS = 40, /* of the observer's paths, at least 2 LEG_STEPS */
    ORDERS = 4
};

/* Above this height, where .06 % of the air is, light counts as that at the height. */
static const double highest = 60e3;
/* Nodes of the sun are even in x / (|x| + fineness), x its cosine, so that they are close at the horizon; below the
 * last one is night. */
static const double fineness = 0.3, last_sun = -0.31;
static const double lowest_place = -0.31 / (0.31 + 0.3), highest_place = 1 / (1 + 0.3);

/* Terms of ty_sh_all that are even in y, and their bands. */
static const int even_terms[HARMONICS] = {0, 2, 3, 6, 7, 8, 12, 13, 14, 15, 20, 21, 22, 23, 24};
static const int bands[HARMONICS] = {0, 1, 1, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4};

/* Step of a path: all that does not depend on the sun. */
typedef struct step {
    double t, radius, up, sine; /* cosine and sine of the path's angle to the vertical there */
    ty_sun_height sun;
    int height; /* node below, and how far it is to the next */
    float fraction;
    float air[3], haze[3];  /* weights of the light scattered there */
    float factor[BANDS][4]; /* the same by band */
} step;

typedef struct path {
    double radius, up;
    int count;
    bool grounded;           /* it ends on the ground */
    double length, weight;   /* weight: solid angle for which the path stands, over that of its azimuths */
    double transmittance[3]; /* of all of it */
    step steps[PATH_STEPS];
} path;

typedef struct orders_job {
    const ty_atmosphere* atmosphere;
    const ty_sky_orders* orders;
    path* paths;                       /* HEIGHTS x RINGS */
    const float* last;                 /* light of the order before; NULL: the sun's */
    const float (*last_irradiance)[4]; /* of the ground, SUNS */
    float* next;
    float (*next_irradiance)[4];
} orders_job;

/* ---- nodes ---- */

static double height_of(int index) {
    const double x = (double)index / (HEIGHTS - 1);
    return ty_observer_height + x * x * highest;
}

static double sun_of(int index) {
    const double place = lowest_place + (highest_place - lowest_place) * index / (SUNS - 1);
    return fineness * place / (1 - fabs(place));
}

/* The node below a sun, and in *fraction how far it is to the next; negative at night. */
static int locate_sun(double sun_up, float* fraction) {
    if (sun_up <= last_sun) return -1;
    const double place = sun_up / (fabs(sun_up) + fineness);
    const float position = (float)((place - lowest_place) * ((SUNS - 1) / (highest_place - lowest_place)));
    const int index = position < 0 ? 0 : position < SUNS - 2 ? (int)position : SUNS - 2;
    *fraction = ty_clampf(position - (float)index, 0, 1);
    return index;
}

/* ---- paths ---- */

static void add_step(const orders_job* job, path* p, double t, double width) {
    step* s = &p->steps[p->count++];
    const ty_air_ray at = ty_air_ray_at((ty_air_ray){p->radius, p->up, 0, 0}, t);
    const ty_air_densities m = ty_air_densities_at(job->atmosphere, at.radius);
    s->t = t;
    s->radius = at.radius;
    s->up = fmin(1, fmax(-1, at.up));
    s->sine = sqrt(1 - s->up * s->up);
    s->sun = ty_sun_at_height(job->atmosphere, at.radius);
    const double height = fmin(highest, fmax(0, at.radius - ty_ground_radius - ty_observer_height));
    const double x = sqrt(height / highest) * (HEIGHTS - 1);
    s->height = x < HEIGHTS - 2 ? (int)x : HEIGHTS - 2;
    const double below = height_of(s->height), above = height_of(s->height + 1);
    s->fraction = (float)((height + ty_observer_height - below) / (above - below));
    for (int c = 0; c < 3; ++c) {
        const double sigma_t = ty_air_extinction(m, c), transmitted = exp(-sigma_t * width);
        const double weight = p->transmittance[c] * (sigma_t > 0 ? (1 - transmitted) / sigma_t : width);
        const double air = weight * m.air * ty_air_scattering[c], haze = weight * m.haze * ty_haze_scattering;
        s->air[c] = (float)air;
        s->haze[c] = (float)haze;
        /* Legendre moments of Rayleigh scattering: 1 and 1 / 10. */
        for (int l = 0; l < BANDS; ++l)
            s->factor[l][c] = (float)((l == 0 ? air : l == 2 ? air / 10 : 0) + haze * job->orders->haze_moments[l]);
        p->transmittance[c] *= transmitted;
    }
    for (int l = 0; l < BANDS; ++l) s->factor[l][3] = 0;
}

/* Steps of a part of a path, that are shortest at its start, or at its end if it is `reversed`. */
static void add_leg(const orders_job* job, path* p, double start, double length, int steps, bool reversed) {
    for (int i = 0; i < steps; ++i) {
        double width;
        const double t = ty_step_center(length, reversed ? steps - 1 - i : i, steps, &width);
        add_step(job, p, start + (reversed ? length - t : t), width);
    }
}

static void trace(const orders_job* job, double radius, double up, int steps, path* p) {
    const double ground = ty_distance_to_ground(radius, up);
    p->radius = radius;
    p->up = up;
    p->count = 0;
    p->grounded = ground >= 0;
    p->length = p->grounded ? ground : ty_distance_to_top(radius, up);
    for (int c = 0; c < 3; ++c) p->transmittance[c] = 1;
    const double lowest = -radius * up; /* distance to the lowest point */
    if (p->grounded) {
        add_leg(job, p, 0, p->length, steps, true);
    } else if (up >= 0) {
        add_leg(job, p, 0, p->length, steps, false);
    } else {
        add_leg(job, p, 0, lowest, steps / 2, true);
        add_leg(job, p, lowest, p->length - lowest, steps, false);
    }
}

/* ---- light along a path ---- */

/* Position of a step of a path relative to the sun: zenith angle and azimuth. */
typedef struct aspect {
    double sun_up, cos_azimuth;
} aspect;

static aspect aspect_of(const step* s, ty_air_ray from, double cos_azimuth) {
    aspect a = {(from.radius * from.sun_up + s->t * from.cos_sun) / s->radius, cos_azimuth};
    const double squared = 1 - a.sun_up * a.sun_up, sine = squared > 0 ? s->sine * sqrt(squared) : 0;
    /* Towards the zenith the azimuth no longer matters. */
    if (sine > 1e-4) a.cos_azimuth = (from.cos_sun - s->up * a.sun_up) / sine;
    a.cos_azimuth = a.cos_azimuth > 1 ? 1 : a.cos_azimuth < -1 ? -1 : a.cos_azimuth;
    return a;
}

static void even_harmonics(double up, double sine, double cos_azimuth, float y[HARMONICS]) {
    float all[TY_SH_TERMS_MAX];
    const double squared = 1 - cos_azimuth * cos_azimuth, sin_azimuth = squared > 0 ? sqrt(squared) : 0;
    ty_sh_all(ty_vec_make((float)(sine * cos_azimuth), (float)(sine * sin_azimuth), (float)up), all);
    for (int i = 0; i < HARMONICS; ++i) y[i] = all[even_terms[i]];
}

/* Adds light of the harmonics in `light` scattered at a step. */
static void add_scattered(const step* s, aspect at, const float* light, float sum[4]) {
    float fraction, y[HARMONICS], mixed[ENTRY];
    const int sun = locate_sun(at.sun_up, &fraction);
    if (sun < 0) return;
    even_harmonics(s->up, s->sine, at.cos_azimuth, y);
    const float* a = light + ENTRY * (s->height * SUNS + sun);
    const float* b = a + ENTRY;
    const float *c = a + ENTRY * SUNS, *d = b + ENTRY * SUNS;
    const float wa = (1 - s->fraction) * (1 - fraction), wb = (1 - s->fraction) * fraction;
    const float wc = s->fraction * (1 - fraction), wd = s->fraction * fraction;
    for (int i = 0; i < ENTRY; ++i) mixed[i] = wa * a[i] + wb * b[i] + wc * c[i] + wd * d[i];
    for (int i = 0; i < HARMONICS; ++i) {
        const float* factor = s->factor[bands[i]];
        for (int k = 0; k < 4; ++k) sum[k] += y[i] * factor[k] * mixed[4 * i + k];
    }
}

/* Adds sunlight scattered at a step. */
static void add_sunlight(const step* s, double sun_up, double air_phase, double haze_phase, float sum[4]) {
    double sun[3];
    ty_sunlight(&s->sun, s->radius, sun_up, sun);
    for (int c = 0; c < 3; ++c)
        sum[c] += (float)(sun[c] * ((double)s->air[c] * air_phase + (double)s->haze[c] * haze_phase));
}

/* Radiance along a path of the order after that of job->last. */
static void gather(const orders_job* job, const path* p, ty_air_ray from, double cos_azimuth, float radiance[4]) {
    for (int k = 0; k < 4; ++k) radiance[k] = 0;
    const double mu = from.cos_sun, air_phase = ty_air_phase(mu), haze_phase = ty_haze_phase(mu);
    for (int i = 0; i < p->count; ++i) {
        const aspect at = aspect_of(&p->steps[i], from, cos_azimuth);
        if (job->last == NULL)
            add_sunlight(&p->steps[i], at.sun_up, air_phase, haze_phase, radiance);
        else
            add_scattered(&p->steps[i], at, job->last, radiance);
    }
    float fraction;
    const int sun = p->grounded ? locate_sun(ty_air_ray_at(from, p->length).sun_up, &fraction) : -1;
    if (sun < 0) return;
    for (int c = 0; c < 3; ++c) {
        const float irradiance = ty_lerpf(job->last_irradiance[sun][c], job->last_irradiance[sun + 1][c], fraction);
        radiance[c] += (float)(p->transmittance[c] * job->orders->ground[c] / TY_PI_F64) * irradiance;
    }
}

/* ---- orders ---- */

/* Directions of a height: the horizon divides them, and they are close to it above, where radiance is steep. */
static void trace_height(void* user, int64_t index, int32_t worker) {
    (void)worker;
    orders_job* job = user;
    const double radius = ty_ground_radius + height_of((int)index);
    const double horizon = -ty_horizon_distance(radius) / radius;
    for (int i = 0; i < RINGS; ++i) {
        path* p = &job->paths[index * RINGS + i];
        double up;
        if (i < RINGS_ABOVE) {
            const double low = (double)i / RINGS_ABOVE, high = (i + 1.0) / RINGS_ABOVE, center = (low + high) / 2;
            up = horizon + (1 - horizon) * center * center;
            p->weight = (1 - horizon) * (high * high - low * low);
        } else {
            up = horizon - (1 + horizon) * (i - RINGS_ABOVE + 0.5) / RINGS_BELOW;
            p->weight = (1 + horizon) / RINGS_BELOW;
        }
        trace(job, radius, up, LEG_STEPS, p);
    }
}

/* The next order at one height and sun. */
static void next_entry(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const orders_job* job = user;
    const int height = (int)(index / SUNS), sun = (int)(index % SUNS);
    const double sun_up = sun_of(sun), sun_sine = sqrt(fmax(0, 1 - sun_up * sun_up));
    float* entry = job->next + ENTRY * index;
    float irradiance[4] = {0, 0, 0, 0};
    memset(entry, 0, ENTRY * sizeof *entry);
    if (sun == 0) return;
    for (int i = 0; i < RINGS; ++i) {
        const path* p = &job->paths[height * RINGS + i];
        const double sine = sqrt(1 - p->up * p->up), weight = p->weight * 2 * TY_PI_F64 / AZIMUTHS;
        for (int j = 0; j < AZIMUTHS; ++j) {
            const double cos_azimuth = cos(TY_PI_F64 * (j + 0.5) / AZIMUTHS);
            const double cos_sun = p->up * sun_up + sine * sun_sine * cos_azimuth;
            float radiance[4], y[HARMONICS];
            gather(job, p, (ty_air_ray){p->radius, p->up, sun_up, cos_sun}, cos_azimuth, radiance);
            even_harmonics(p->up, sine, cos_azimuth, y);
            for (int k = 0; k < 4; ++k) radiance[k] *= (float)weight;
            for (int t = 0; t < HARMONICS; ++t)
                for (int k = 0; k < 4; ++k) entry[4 * t + k] += y[t] * radiance[k];
            for (int k = 0; k < 4; ++k) irradiance[k] += (float)fmax(0, p->up) * radiance[k];
        }
    }
    if (height == 0) memcpy(job->next_irradiance[sun], irradiance, sizeof irradiance);
}

/* Adds an order; the last one with all that follow it, each of which is to the one before as the last to its own. */
static void add_order(float* sum, const float* last, const float* next, bool final) {
    for (int i = 0; i < HEIGHTS * SUNS; ++i) {
        float factor[4] = {1, 1, 1, 1};
        for (int c = 0; c < 3 && final; ++c) {
            const float before = last[ENTRY * i + c], now = next[ENTRY * i + c];
            const float ratio = before > 0 ? ty_clampf(now / before, 0, 0.95f) : 0;
            factor[c] = 1 / (1 - ratio);
        }
        for (int j = 0; j < ENTRY; ++j) sum[ENTRY * i + j] += factor[j % 4] * next[ENTRY * i + j];
    }
}

ty_result ty_sky_orders_solve(ty_context* context, const ty_atmosphere* atmosphere, ty_sky_orders* orders) {
    float irradiance[2][SUNS][4];
    float* light[2] = {NULL, NULL};
    orders_job job = {.atmosphere = atmosphere, .orders = orders};
    job.paths = ty_alloc_array(context, HEIGHTS * RINGS, sizeof *job.paths, false);
    for (int i = 0; i < 2; ++i) light[i] = ty_alloc_array(context, TY_SKY_ENTRIES, sizeof *light[i], false);
    const bool allocated = job.paths != NULL && light[0] != NULL && light[1] != NULL;
    if (allocated) {
        memset(irradiance, 0, sizeof irradiance);
        const ty_sun_height ground = ty_sun_at_height(atmosphere, ty_ground_radius);
        for (int i = 1; i < SUNS; ++i) {
            const double sun_up = sun_of(i);
            double sun[3];
            ty_sunlight(&ground, ty_ground_radius, sun_up, sun);
            for (int c = 0; c < 3; ++c) irradiance[0][i][c] = (float)(sun[c] * fmax(0, sun_up));
        }
        ty_parallel_for(context, HEIGHTS, trace_height, &job);
        memset(orders->light, 0, TY_SKY_ENTRIES * sizeof *orders->light);
        for (int n = 0; n < ORDERS; ++n) {
            job.last = n > 0 ? light[n % 2] : NULL;
            job.last_irradiance = irradiance[n % 2];
            job.next = light[(n + 1) % 2];
            job.next_irradiance = irradiance[(n + 1) % 2];
            ty_parallel_for(context, HEIGHTS * SUNS, next_entry, &job);
            add_order(orders->light, job.last, job.next, n == ORDERS - 1);
        }
    }
    for (int i = 0; i < 2; ++i) ty_free_array(context, light[i], TY_SKY_ENTRIES, sizeof *light[i]);
    ty_free_array(context, job.paths, HEIGHTS * RINGS, sizeof *job.paths);
    return allocated ? TY_OK : TY_ERROR_MEMORY;
}

/* ---- the observer's view ---- */

void ty_sky_orders_ring(const ty_atmosphere* atmosphere, const ty_sky_orders* orders, double radius, double up,
                        double sun_up, ty_sky_ring* out) {
    enum { COUNT = TY_SKY_AZIMUTHS };
    const orders_job job = {.atmosphere = atmosphere, .orders = orders};
    const double sine = sqrt(fmax(0, 1 - up * up)), sun_sine = sqrt(fmax(0, 1 - sun_up * sun_up));
    path p;
    float light[COUNT][4];
    trace(&job, radius, up, PATH_STEPS, &p);
    for (int j = 0; j < COUNT; ++j) {
        const double cos_azimuth = cos(TY_PI_F64 * (j + 0.5) / COUNT);
        const ty_air_ray from = {p.radius, up, sun_up, up * sun_up + sine * sun_sine * cos_azimuth};
        memset(light[j], 0, sizeof light[j]);
        for (int i = 0; i < p.count; ++i)
            add_scattered(&p.steps[i], aspect_of(&p.steps[i], from, cos_azimuth), orders->light, light[j]);
    }
    for (int m = 0; m < COUNT; ++m)
        for (int c = 0; c < 3; ++c) {
            double sum = 0;
            for (int j = 0; j < COUNT; ++j) sum += (double)light[j][c] * cos(TY_PI_F64 * m * (j + 0.5) / COUNT);
            out->cosine[m][c] = sum * (m == 0 ? 1 : 2) / COUNT;
        }
}

/* Clenshaw's recurrence. */
double ty_sky_ring_value(const ty_sky_ring* ring, double cos_azimuth, int channel) {
    double after = 0, next = 0;
    for (int m = TY_SKY_AZIMUTHS - 1; m > 0; --m) {
        const double now = ring->cosine[m][channel] + 2 * cos_azimuth * next - after;
        after = next;
        next = now;
    }
    return fmax(0, ring->cosine[0][channel] + cos_azimuth * next - after);
}
