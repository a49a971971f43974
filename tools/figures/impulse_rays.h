/* Impulse responses by brute-force quadrature: radiance along rays, harmonics over directions. Lengths are optical,
 * albedo 1. The code is independent of the table builder, which integrates over other variables in another order. */
#ifndef TY_FIGURES_IMPULSE_RAYS_H
#define TY_FIGURES_IMPULSE_RAYS_H

#include "base/constants.h"
#include "base/quadrature.h"

#include <math.h>
#include <string.h>
#include <tyndall/impulse.h>

enum { RAYS_PHASES = 3 };

/* Fluence of the source at a point, per unit emission; arrives: its unit direction of travel. Isotropic sources leave
 * arrives unset. */
typedef double (*rays_source)(const void* user, const double point[3], double arrives[3]);

typedef struct rays_scene {
    rays_source source;
    const void* user;
    double emitter[3]; /* panels are refined near this point */
    double top;        /* the medium ends at this z; HUGE_VAL: nowhere */
    bool isotropic;    /* only phase 1, g = 0, is computed */
} rays_scene;

static const double rays_node[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
static const double rays_weight[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};

/* Node i and weight of the 8-point Gauss-Legendre rule on a..b. */
static inline double rays_at(double a, double b, int i, double* weight) {
    const double half = 0.5 * (b - a);
    *weight = half * rays_weight[i / 2];
    return 0.5 * (a + b) + half * (i % 2 == 0 ? -1 : 1) * rays_node[i / 2];
}

static inline double rays_phase(double cosine, double g) {
    const double base = 1 + g * g - 2 * g * cosine;
    return (1 - g * g) / (4 * TY_PI_F64 * base * sqrt(base));
}

static inline void rays_panel(const rays_scene* scene, const double from[3], const double omega[3], double a, double b,
                              double out[RAYS_PHASES]) {
    for (int i = 0; i < 8; ++i) {
        double weight, point[3], arrives[3];
        const double t = rays_at(a, b, i, &weight);
        for (int k = 0; k < 3; ++k) point[k] = from[k] + t * omega[k];
        const double light = weight * exp(-t) * scene->source(scene->user, point, arrives);
        if (scene->isotropic) {
            out[1] += light / (4 * TY_PI_F64);
            continue;
        }
        const double mu = -(arrives[0] * omega[0] + arrives[1] * omega[1] + arrives[2] * omega[2]);
        for (int g = 0; g < RAYS_PHASES; ++g) out[g] += light * rays_phase(mu, 0.5 * (g - 1));
    }
}

/* Radiance along a direction for g = -0.5, 0, 0.5, by panels that grow with distance from the ray's closest point to
 * the emitter. Beyond that point, where transmittance and source both fall, panels end once one adds less than 1e-8. */
static inline void rays_radiance(const rays_scene* scene, const double from[3], const double omega[3],
                                 double out[RAYS_PHASES]) {
    double nearest = 0, square = 0, end = 40;
    for (int k = 0; k < 3; ++k) nearest += (scene->emitter[k] - from[k]) * omega[k];
    if (omega[2] > 0) end = fmin(end, (scene->top - from[2]) / omega[2]);
    nearest = fmin(end, fmax(0, nearest));
    for (int k = 0; k < 3; ++k) square += pow(from[k] + nearest * omega[k] - scene->emitter[k], 2);
    memset(out, 0, RAYS_PHASES * sizeof *out);
    double width = fmin(1.5, 0.7 * sqrt(square) + 1e-9);
    for (double a = nearest; a < end; width = fmin(1.5, 1.7 * width)) {
        const double before = out[1];
        rays_panel(scene, from, omega, a, fmin(end, a + width), out);
        a += width;
        if (width == 1.5 && out[1] - before < 1e-8 * out[1]) break;
    }
    width = fmin(1.5, 0.7 * sqrt(square) + 1e-9);
    for (double b = nearest; b > 0; width = fmin(1.5, 1.7 * width)) {
        rays_panel(scene, from, omega, fmax(0, b - width), b, out);
        b -= width;
    }
}

/* Zonal harmonics about an axis. */
static inline void rays_zonal(double cosine, double out[TY_IMPULSE_TERMS]) {
    double before = 0, last = 1;
    for (int l = 0; l < TY_IMPULSE_TERMS; ++l) {
        out[l] = sqrt((2 * l + 1) / (4 * TY_PI_F64)) * last;
        const double next = ((2 * l + 1) * cosine * last - l * before) / (l + 1);
        before = last;
        last = next;
    }
}

/* Zonal harmonics of the radiance at a point about an axis in the plane y = 0, at angle axis_theta from `up` (+1: +z,
 * -1: -z) towards +x; directions are parameterized about +-z. phi_panels: panels of phi over a half circle; 0:
 * rotational symmetry about z. theta_panels: panels of theta per hemisphere. */
static inline void rays_harmonics(const rays_scene* scene, const double from[3], double up, double axis_theta,
                                  int theta_panels, int phi_panels, double out[RAYS_PHASES][TY_IMPULSE_TERMS]) {
    memset(out, 0, RAYS_PHASES * sizeof *out);
    const double axis[3] = {sin(axis_theta), 0, up * cos(axis_theta)};
    for (int i = 0; i < 8 * 2 * theta_panels; ++i) {
        /* Nodes are denser near the axis and the equator: theta = pi/2 (half + s^2 (3 - 2 s)). */
        const int panel = i / 8 % theta_panels, half = i / (8 * theta_panels);
        double s_weight, phi_weight = 2 * TY_PI_F64;
        const double s = rays_at((double)panel / theta_panels, (double)(panel + 1) / theta_panels, i % 8, &s_weight);
        const double fraction = s * s * (3 - 2 * s), slope = 6 * s * (1 - s);
        const double theta = 0.5 * TY_PI_F64 * (half + fraction);
        const double weight = s_weight * slope * 0.5 * TY_PI_F64 * sin(theta);
        for (int j = 0; j < (phi_panels > 0 ? 8 * phi_panels : 1); ++j) {
            double phi = 0, zonal[TY_IMPULSE_TERMS], radiance[RAYS_PHASES];
            if (phi_panels > 0) {
                phi =
                    rays_at(TY_PI_F64 * (j / 8) / phi_panels, TY_PI_F64 * (j / 8 + 1) / phi_panels, j % 8, &phi_weight);
                phi_weight *= 2;
            }
            const double omega[3] = {sin(theta) * cos(phi), sin(theta) * sin(phi), up * cos(theta)};
            rays_radiance(scene, from, omega, radiance);
            rays_zonal(axis[0] * omega[0] + axis[2] * omega[2], zonal);
            for (int g = 0; g < RAYS_PHASES; ++g)
                for (int l = 0; l < TY_IMPULSE_TERMS; ++l) out[g][l] += weight * phi_weight * radiance[g] * zonal[l];
        }
    }
}

/* ---- emitters: at the origin, or light going down from z = 0 ---- */

typedef struct rays_area {
    double normal[3];
} rays_area;

static inline double rays_from_origin(const double point[3], double arrives[3]) {
    const double square = point[0] * point[0] + point[1] * point[1] + point[2] * point[2], r = sqrt(square);
    for (int k = 0; k < 3; ++k) arrives[k] = point[k] / r;
    return exp(-r) / square;
}

static inline double rays_point(const void* user, const double point[3], double arrives[3]) {
    (void)user;
    return rays_from_origin(point, arrives);
}

static inline double rays_area_light(const void* user, const double point[3], double arrives[3]) {
    const double* normal = ((const rays_area*)user)->normal;
    const double light = rays_from_origin(point, arrives);
    return light * fmax(0, normal[0] * arrives[0] + normal[1] * arrives[1] + normal[2] * arrives[2]);
}

static inline double rays_directional(const void* user, const double point[3], double arrives[3]) {
    (void)user;
    arrives[0] = arrives[1] = 0;
    arrives[2] = -1;
    return exp(point[2]);
}

#endif
