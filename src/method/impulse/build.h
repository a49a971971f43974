/* Tables in the making. Lengths are optical, the albedo is 1. */
#ifndef TY_METHOD_IMPULSE_BUILD_H
#define TY_METHOD_IMPULSE_BUILD_H

#include "method/impulse/harmonics.h"
#include "method/impulse/nodes.h"
#include "method/impulse/tables.h"
#include "scene/phase.k.h"

/* Products of y_l^m at the receiver and y_k^m at the emitter, l, k >= m: sorted by m, l, k. */
enum { TY_IMPULSE_PRODUCTS = 556 };

/* A response about the axis to the emitter, in the plane of that and the emitter's normal: what y_l^m is multiplied by,
 * m >= 0. */
typedef struct ty_impulse_pairs {
    double at[TY_IMPULSE_PAIRS];
} ty_impulse_pairs;

/* What single scattering of areas is summed from: of every angle, its pairs. */
typedef struct ty_impulse_angles {
    ty_impulse_pairs angle[TY_IMPULSE_ANGLES];
} ty_impulse_angles;

typedef struct ty_impulse_work {
    ty_impulse* tables;
    ty_impulse_recurrence recurrence;
    double angles[TY_IMPULSE_ANGLES][TY_IMPULSE_SENT]; /* harmonics at the angles of areas */

    /* Fluence is known at the bins' distances and beyond, as far as light comes back from. */
    int32_t places;
    double* distances;

    /* Single scattering: lattice points of directions and what they weigh. */
    struct ty_impulse_lattice* lattice;
    ty_impulse_angles* singles; /* [bin][phase] */

    /* What one scattering makes of fluence at all places: [place][order][place] of areas, [place][term][place] by
     * depth. */
    double *spread, *sink;
    /* Of lights that scattered 1, 2, .. times: [bounce - 1][order][place] of areas (times distance), [bounce -
     * 1][place] by depth. */
    double *fluence, *depth;
    double* products; /* [worker][bounce - 2][product] */
} ty_impulse_work;

static inline double* ty_impulse_fluence(const ty_impulse_work* work, int32_t bounce, int32_t order) {
    return work->fluence + ((size_t)(bounce - 1) * TY_IMPULSE_ORDERS + (size_t)order) * (size_t)work->places;
}

static inline double* ty_impulse_depth(const ty_impulse_work* work, int32_t bounce) {
    return work->depth + (size_t)(bounce - 1) * (size_t)work->places;
}

/* The four places about a distance and their weights, for cubic interpolation; the nearest place stands for what is
 * nearer. False: it is beyond the last. */
bool ty_impulse_around(const ty_impulse_work* work, double distance, int32_t* first, double weight[4]);
/* Nodes from 0 to where light comes back from, for integrands that are singular at 0 and at a distance. */
void ty_impulse_add_radii(const ty_impulse_work* work, double distance, ty_impulse_nodes* out);
/* Tables an emitter's response to a scattering: phase 0..2 of single scattering, or bounce 2.. */
void ty_impulse_keep(const ty_impulse_work* work, ty_impulse_emitter emitter, int32_t angle, int32_t bin,
                     int32_t vector, const double zonal[TY_IMPULSE_TERMS]);

/* Steps; each is a parallel loop's body whose user is the work.
 * Single scattering of points and areas, TY_IMPULSE_BLOCK places a time. */
enum { TY_IMPULSE_BLOCK = 8 };
ty_result ty_impulse_make_lattice(ty_impulse_work* work);
void ty_impulse_free_lattice(ty_impulse_work* work);
void ty_impulse_scatter_once(void* user, int64_t block, int32_t worker);
/* By depth, once, at one place. */
void ty_impulse_sink_once(void* user, int64_t place, int32_t worker);
/* A place's rows of spread and sink. */
void ty_impulse_make_spread(void* user, int64_t place, int32_t worker);
void ty_impulse_make_sink(void* user, int64_t place, int32_t worker);
/* A bin's responses to light that scattered before. */
void ty_impulse_scatter_again(void* user, int64_t bin, int32_t worker);
void ty_impulse_sink_again(void* user, int64_t bin, int32_t worker);

/* The sine of the angle by which the axis of the best zonal function leans from the axis of pairs (Sec. 4.2). */
double ty_impulse_fit(const ty_impulse_recurrence* recurrence, const ty_impulse_pairs* response);
/* Zonal harmonics about that axis. */
void ty_impulse_lean(const ty_impulse_recurrence* recurrence, const ty_impulse_pairs* response, double shift,
                     double zonal[TY_IMPULSE_TERMS]);

#endif
