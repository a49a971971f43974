/* One transport sweep: solves w . grad psi + sigma* psi = q for every direction of an angular quadrature on a box of
 * cells, with a known source q.
 *
 * The spatial scheme is diamond difference with set-to-zero fix-up (Lewis and Miller 1984): the mean
 * radiance of a cell is the mean of that at opposite faces; a negative outgoing face radiance is set to zero and the
 * cell balance is solved again without that face. The scheme conserves energy to rounding for cells of any optical
 * thickness. Its error is of second order in the cell edges, and small in thick cells where the radiance varies slowly.
 *
 * Rows of cells form blocks in y and z; blocks without dependencies on each other run in parallel (a wavefront). The
 * order of blocks and of all sums is independent of the number of threads. */
#ifndef TY_SOLVE_ORDINATES_SWEEP_H
#define TY_SOLVE_ORDINATES_SWEEP_H

#include "comm/domain.h"
#include "solve/ordinates/ordinates.h"
#include "solve/ordinates/sweep_schedule.h"

/* Data shared by all sweeps of one box. Arrays given to it belong to the caller and must outlive it. */
typedef struct ty_sweep ty_sweep;

/* extinction: delta-M scaled sigma*, 1/m, at least 0. bands: Legendre terms L of source and moments. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_sweep_create(ty_context* context, const int32_t size[3], const double cell[3],
                          const ty_angular_quadrature* set, int32_t bands, const float* extinction, ty_sweep** out);
/* The box is this rank's part of a domain that is not cut along z and outlives the sweep; NULL: it is the whole. Sweeps
 * are then calls of all ranks, whose order of work docs/farm.md tells. Errors: TY_ERROR_MEMORY. */
ty_result ty_sweep_divide(ty_sweep* sweep, const ty_domain* domain);
/* Sets the radiance that enters; initially there is none. Errors: TY_ERROR_MEMORY. */
ty_result ty_sweep_set_boundary_radiance(ty_sweep* sweep, const ty_boundary_radiance* boundary);

/* Makes the box repeat along axes (bit a for axis a), without boundary radiance, boundary faces or domain: what enters
 * by a face there is what ty_sweep_inflow points to, which the caller writes before a sweep; initially 0. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_sweep_repeat(ty_sweep* sweep, uint32_t axes);
/* Radiance that enters by the faces across each such axis, one after the other: by octant, face (the lower axis
 * fastest) and direction of the octant, padded to ty_sweep_pitch. */
float* ty_sweep_inflow(ty_sweep* sweep);
size_t ty_sweep_inflow_floats(const ty_sweep* sweep);
/* The same of what left by the opposite faces in the last sweep. */
void ty_sweep_outflow(const ty_sweep* sweep, float* out);
/* Its power, W. */
double ty_sweep_inflow_power(const ty_sweep* sweep, const float* inflow);
/* Adds to these planes, in the next sweeps, the power through the faces of cells across y or z: of each cell, through
 * the lower face of what goes down, and through the upper one of what goes up, W. NULL: does not. */
void ty_sweep_set_passing(ty_sweep* sweep, int axis, float* const passing[2]);

/* Boundary faces: opaque faces between two cells or on the box. Each adjoining cell has its own side of the face. The
 * sides of a row of cells along x are stored contiguously, in the order of the cells. */
typedef struct ty_sweep_faces {
    int32_t count;              /* number of sides */
    const int32_t* first;       /* first side of each row y + size[1] * z; the last entry is count */
    const int32_t* x;           /* cell of each side within its row */
    const uint8_t* face;        /* 2 * axis + (1 for the upper face) */
    const float* emitted;       /* isotropic radiance into the side's cell, W m^-2 sr^-1 */
    const float* emitted_slope; /* its slope in |mu|, times half the cell's edge along the axis; NULL: isotropic */
    float* incident_power;      /* out: incident power per side, W */
    /* Angular reflection; reflected NULL (default): none. Of each side 4 * ty_sweep_pitch values, by the octant of the
     * direction without the bit of the face's axis, and by the direction in it. The side emits factor * reflected. */
    const float *reflected, *factor; /* factor: per side */
    float* arriving;                 /* out: arriving radiance */
} ty_sweep_faces;

/* The struct and its arrays belong to the caller, who may change `emitted` between sweeps. NULL (initially): none. */
void ty_sweep_set_faces(ty_sweep* sweep, const ty_sweep_faces* walls);
/* Makes the sweep the transpose of one whose set-to-zero fix-ups closed these faces (solve/ordinates/adjoint.h), along
 * the opposite directions; without boundary faces. NULL (initially): no transpose. The caller keeps the array. */
void ty_sweep_set_closed(ty_sweep* sweep, const uint16_t* closed);
void ty_sweep_destroy(ty_sweep* sweep);
/* Directions of an octant, padded to whole vectors; a multiple of 16 bytes. */
int32_t ty_sweep_pitch(const ty_sweep* sweep);
/* Memory in bytes. */
size_t ty_sweep_bytes(const ty_sweep* sweep);
/* The memory that a sweep of a box, or of a part, would have, and its blocks, without making it. */
size_t ty_sweep_plan(ty_context* context, const int32_t size[3], const ty_angular_quadrature* set, int32_t bands,
                     const ty_domain* domain, ty_sweep_schedule* schedule);
/* Minimum number of floating-point operations per cell and direction: evaluation of the source from its moments, the
 * diamond difference step and the accumulation of flux moments. */
double ty_sweep_operations(int32_t bands);

/* emission: q_lm, W m^-3 sr^-1; moments: out, phi_lm, the integrals of psi Y_lm over directions. Both are interleaved:
 * bands^2 values per cell, cells with x fastest; psi is the cell mean. leaving: out, leakage through the box's faces,
 * W; may be NULL. fixups: out, fraction of cells times directions that needed the set-to-zero fix-up; may be NULL. Of a
 * part both are the part's. Errors: TY_ERROR_INTERNAL: a rank does not answer. */
ty_result ty_sweep_run(ty_sweep* sweep, const float* emission, float* moments, double* leaving, double* fixups);

#endif
