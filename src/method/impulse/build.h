/* State of table construction. Lengths are optical, the albedo is 1. */
#ifndef TY_METHOD_IMPULSE_BUILD_H
#define TY_METHOD_IMPULSE_BUILD_H

#include "method/impulse/harmonics.h"
#include "method/impulse/nodes.h"
#include "method/impulse/tables.h"
#include "scene/media/phase.k.h"

/* Products of y_l^m at the receiver and y_k^m at the emitter, l, k >= m: sorted by m, l, k. */
enum { TY_IMPULSE_PRODUCTS = 556 };

/* Spherical harmonic coefficients of a response, m >= 0, about the axis to the emitter, in the plane of that axis and
 * the emitter's normal. */
typedef struct ty_impulse_pairs {
    double at[TY_IMPULSE_PAIRS];
} ty_impulse_pairs;

/* Single scattering of areas: coefficients at every tabulated angle. */
typedef struct ty_impulse_angles {
    ty_impulse_pairs angle[TY_IMPULSE_ANGLES];
} ty_impulse_angles;

typedef struct ty_impulse_work {
    ty_impulse* tables;
    ty_impulse_recurrence recurrence;
    double angles[TY_IMPULSE_ANGLES][TY_IMPULSE_EMITTED_PAIRS]; /* harmonics at the angles of areas */

    /* Fluence is known at the distances of the bins and beyond, as far as light returns from. */
    int32_t distance_count;
    double* distances;

    /* Single scattering: lattice points of directions and their weights. */
    struct ty_impulse_lattice* lattice;
    ty_impulse_angles* singles; /* [bin][phase] */

    /* Operators of one scattering on the fluence at all distances: [distance][order][distance] for areas,
     * [distance][term][distance] for the half space. */
    double *fluence_operator, *half_space_operator;
    /* Fluence of each bounce: [bounce - 1][order][distance] for areas (times distance), [bounce - 1][distance] for the
     * half space. */
    double *fluence, *half_space_fluence;
    double* products; /* [worker][bounce - 2][product] */
} ty_impulse_work;

static inline double* ty_impulse_fluence(const ty_impulse_work* work, int32_t bounce, int32_t order) {
    return work->fluence + ((size_t)(bounce - 1) * TY_IMPULSE_ORDERS + (size_t)order) * (size_t)work->distance_count;
}

static inline double* ty_impulse_half_space_fluence(const ty_impulse_work* work, int32_t bounce) {
    return work->half_space_fluence + (size_t)(bounce - 1) * (size_t)work->distance_count;
}

/* Cubic interpolation: the first of four nodes about a distance and their weights; distances below the first node use
 * it. False: the distance is beyond the last node. */
bool ty_impulse_cubic_weights(const ty_impulse_work* work, double distance, int32_t* first, double weight[4]);
/* Nodes from 0 to the farthest distance from which light returns, for integrands singular at 0 and at `distance`. */
void ty_impulse_add_radii(const ty_impulse_work* work, double distance, ty_impulse_nodes* out);
/* Stores an emitter's response to a scattering: vector 0..2 for the phases of single scattering, or those of bounce 2..
 */
void ty_impulse_store(const ty_impulse_work* work, ty_impulse_emitter emitter, int32_t angle, int32_t bin,
                      int32_t vector, const double zonal[TY_IMPULSE_TERMS]);

/* Steps; each is the body of a parallel loop whose user is the work.
 * Single scattering of points and areas, TY_IMPULSE_BLOCK distances at a time. */
enum { TY_IMPULSE_BLOCK = 8 };
ty_result ty_impulse_make_lattice(ty_impulse_work* work);
void ty_impulse_free_lattice(ty_impulse_work* work);
void ty_impulse_single_scattering(void* user, int64_t block, int32_t worker);
/* Single scattering in the half space, at one distance. */
void ty_impulse_half_space_single(void* user, int64_t index, int32_t worker);
/* Rows of the operators for one distance. */
void ty_impulse_make_fluence_operator(void* user, int64_t index, int32_t worker);
void ty_impulse_make_half_space_operator(void* user, int64_t index, int32_t worker);
/* Multiple scattering responses of one bin. */
void ty_impulse_multiple_scattering(void* user, int64_t bin, int32_t worker);
void ty_impulse_half_space_multiple(void* user, int64_t bin, int32_t worker);

/* Sine of the angle between the fitted axis of the best zonal function and the axis to the emitter: d_fit, Eq. 16
 * (Dubouchet 2019). */
double ty_impulse_fit_axis(const ty_impulse_recurrence* recurrence, const ty_impulse_pairs* response);
/* Zonal harmonics about the fitted axis. */
void ty_impulse_project(const ty_impulse_recurrence* recurrence, const ty_impulse_pairs* response, double axis_tilt,
                        double zonal[TY_IMPULSE_TERMS]);

#endif
