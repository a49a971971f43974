/* State of one call of ty_ordinates_solve. */
#ifndef TY_SOLVE_ORDINATES_JOB_H
#define TY_SOLVE_ORDINATES_JOB_H

#include "base/arena.h"
#include "solve/ordinates/dsa.h"
#include "solve/ordinates/diffusive_cells.h"
#include "solve/ordinates/fresnel_faces.h"

/* Number of iterates in Anderson acceleration; maximum cells along an axis. */
enum { TY_ANDERSON_DEPTH = 5, TY_ORDINATES_SIDE_MAX = 1024 };

/* Sums over a plane of cells: squared change and squared iterate; products of the change with the change of each
 * iterate; emitted, absorbed and removed (sigma* phi) power. */
typedef struct ty_ordinates_sums {
    double change, fluence, products[TY_ANDERSON_DEPTH], emitted, absorbed, removed;
} ty_ordinates_sums;

typedef struct ty_ordinates_job {
    ty_context* context;
    const ty_ordinates_def* def;
    ty_ordinates_stats* stats;
    double* history;
    int32_t history_capacity;
    double start, reported; /* s */

    char* memory; /* all arrays; NULL: the caller's memory */
    size_t bytes;
    int64_t cells;
    int32_t terms;           /* bands^2 */
    int32_t low_order_terms; /* number of low-order moments, which DSA corrects: P0, and P1 if bands > 1 */
    ty_sweep* sweep;
    ty_dsa* dsa; /* NULL: source iteration */

    /* Arrays have no ghost cells. Moments and emission are stored cell by cell, `terms` floats each. */
    float* extinction; /* sigma* */
    float* source_lm;  /* q with more than one term; NULL: the plane of the def */
    float* displaced; /* sqrt(3) d q_00 along x, y and z, cell by cell; NULL: all sources are at their cells' centers */
    float* emission;
    float* moments[TY_ANDERSON_DEPTH];   /* iterates, as swept */
    float* low_order[TY_ANDERSON_DEPTH]; /* low-order moments of the iterates with their corrections (`moments` are
                                      uncorrected), term by term within each row of cells */
    float* changes[TY_ANDERSON_DEPTH];   /* low-order moments: iterate minus mixed iterate */
    double leaving[TY_ANDERSON_DEPTH];   /* power leaving the box in the iterate's sweep and its correction, W */
    float* mixed;                        /* low-order moments of the mixed iterate */
    ty_ordinates_sums* sums;             /* one per plane */
    /* Boundary faces, one entry per side. */
    ty_sweep_faces walls;
    float *face_radiance, *face_irradiance_mixed; /* emitted radiance; irradiance of the mixed iterate */
    float* face_irradiance[TY_ANDERSON_DEPTH];    /* irradiance of the iterates */
    float* face_changes[TY_ANDERSON_DEPTH];       /* irradiance: iterate minus mixed iterate */
    ty_fresnel_faces* fresnel;                    /* NULL: no interfaces */
    ty_ordinates_faces dsa_walls;                 /* the def's, with the albedos of the correction by diffusion */
    float* dsa_albedo;                            /* NULL: the def's own */

    /* Diffusive cells, and the partial currents into them at their interface faces, over sqrt(4 pi). */
    ty_diffusive_cells diffusive;
    float *interface_current_mixed,
        *interface_residual;                     /* partial current of the mixed iterate; DSA source on the face */
    float* interface_current[TY_ANDERSON_DEPTH]; /* partial currents of the iterates */
    float* interface_changes[TY_ANDERSON_DEPTH]; /* 4 (iterate - mixed iterate) */
    double interface_inflow;                     /* power incident on diffusive cells through the box's faces, W */
    void* interface_memory;
    size_t interface_bytes;

    /* Of a part: the flux along an axis in the neighbours' cells at its lower and upper x and y, of the latest change;
     * planes of y and z, and of x and z. NULL: the box ends there. */
    float* flux_beyond[4];
    float* flux_messages;
    size_t flux_floats; /* of all of these */

    float* images[TY_ANDERSON_DEPTH]; /* of a box that repeats: radiance that enters by its faces, laid out as that of
                                         ty_sweep_inflow, of each iterate with its correction */
    size_t image_floats;

    double anderson_weights[TY_ANDERSON_DEPTH]; /* Anderson weights of the iterates in the next mixed iterate; their sum
                                         is 1, or all are 0 (dark) */
    int32_t depth;                              /* capacity for iterates */
    int32_t count;                              /* number of iterates */
    int32_t latest;                             /* index of the latest iterate */
    double energy_deficit; /* relative deficit of the last sweep's fluence against the emitted power */
    double emitted;        /* total power of source, faces and boundary radiance, W; only with diffusive cells */
    bool from_guess;       /* the only iterate is an initial guess, whose change by a sweep is unknown */
} ty_ordinates_job;

/* A call's state, of which the caller sets context, stats and start; its memory, coefficients, sweep and first iterate;
 * its end, which frees all of that, also after errors. Errors: those of ty_ordinates_solve. */
ty_ordinates_job ty_ordinates_begin_job(const ty_ordinates_def* def);
ty_result ty_ordinates_prepare(ty_ordinates_job* job);
void ty_ordinates_end_job(ty_ordinates_job* job);

/* Loop over planes of cells, parallel for large boxes, and the total of the planes' sums, in plane order. */
void ty_ordinates_planes(const ty_ordinates_job* job, ty_parallel_fn body, void* user);
ty_ordinates_sums ty_ordinates_total(const ty_ordinates_job* job);

/* Computes sigma*; for diffusion also sigma* - s_1 and sigma_a (unless NULL). Returns whether all coefficients and
 * sources are in range. */
bool ty_ordinates_scale(ty_ordinates_job* job, float* reduced, float* absorption);
/* Conversion between planes, as the caller stores them, and interleaved terms per cell. */
void ty_ordinates_gather(ty_ordinates_job* job, const float* const* planes, int32_t terms, float* cells);
void ty_ordinates_scatter(ty_ordinates_job* job, const float* cells, int32_t terms, float* const* planes);
/* Pads the job's terms per cell with zeros. */
void ty_ordinates_widen(ty_ordinates_job* job, const float* from, int32_t terms, float* to);
/* Forms the mixed iterate with the Anderson weights: low-order moments to `mixed`, its emission to `emission`. Returns
 * the part's sum of the first term over cells, with the power of faces and boundary radiance. */
double ty_ordinates_emit(ty_ordinates_job* job);
/* Copies the low-order moments of the latest iterate from its moments and returns the part's sum of sigma* phi; the
 * second function copies them back when there are no more corrections. */
double ty_ordinates_gather_low_order(ty_ordinates_job* job);
void ty_ordinates_scatter_low_order(ty_ordinates_job* job);
/* Source of the DSA equation: scattering of (latest iterate - mixed iterate); first: the def's source, for a dark
 * iterate. Returns its sum of squares. */
double ty_ordinates_residual(ty_ordinates_job* job, bool first);
/* Adds the correction e to the latest iterate (NULL: no correction) and stores the iterate's change. */
ty_ordinates_sums ty_ordinates_correct(ty_ordinates_job* job, const float* e);
/* Emitted and absorbed power of the part, W. */
ty_ordinates_sums ty_ordinates_balance(ty_ordinates_job* job, const float* moments, int32_t terms);

/* Adds to the sources of cells that are swept the first moments that stand for their known positions within the cells;
 * reduced: sigma* - s_1. The second function subtracts the flux that comes with these. Errors: TY_ERROR_MEMORY. */
ty_result ty_ordinates_displace(ty_ordinates_job* job, const float* reduced);
void ty_ordinates_undo_displaced_flux(const ty_ordinates_job* job, float* const* moments);

/* ---- boundary faces and boundary radiance: no-ops without them ---- */

void ty_ordinates_faces_lay_out(ty_ordinates_job* job, ty_arena* arena);
/* Irradiance of the initial iterate, from its fluence. */
void ty_ordinates_faces_begin(ty_ordinates_job* job);
/* Sets the sweep's faces: boundary faces and interfaces of diffusive cells. Without the latter the sweep writes
 * incident power to the iterate's irradiance. */
void ty_ordinates_set_sweep_faces(ty_ordinates_job* job, ty_sweep* sweep, int32_t iterate);
double ty_ordinates_face_area(const ty_ordinates_def* def, int32_t side);
/* Emitted radiance of the mixed iterate, called by ty_ordinates_emit; after a sweep, incident power (W) to irradiance.
 * Both return the total power, W. */
double ty_ordinates_faces_emit(ty_ordinates_job* job);
double ty_ordinates_faces_receive(ty_ordinates_job* job);
/* Adds the change of the faces' radiosity to the DSA source, without a flux through the faces; first: their own
 * emission. Returns the change of the sum of squares. The second function adds the correction e to the irradiance and
 * replaces the flux correction of adjoining cells. */
double ty_ordinates_faces_residual(ty_ordinates_job* job, bool first);
void ty_ordinates_faces_correct(ty_ordinates_job* job, const float* e);
/* Power of the boundary radiance through faces of the box that are not opaque, W. */
double ty_ordinates_entering(const ty_ordinates_def* def);
/* Adds changes and products, called by ty_ordinates_correct. */
void ty_ordinates_faces_compare(ty_ordinates_job* job, ty_ordinates_sums* sums);
/* Power emitted by the faces themselves, and absorbed from an irradiance, W. */
void ty_ordinates_faces_balance(ty_ordinates_job* job, const float* irradiance, double* emitted, double* absorbed);
/* The part of a side's irradiance that it absorbs, W m^-2. */
double ty_ordinates_face_absorbs(const ty_ordinates_job* job, int32_t side, float irradiance);

/* ---- images of a box that repeats: no-ops without them ---- */

/* Errors: TY_ERROR_MEMORY. */
ty_result ty_ordinates_images_create(ty_ordinates_job* job);
void ty_ordinates_images_destroy(ty_ordinates_job* job);
/* Radiance at the faces for an initial guess, from its fluence and flux. */
void ty_ordinates_images_begin(ty_ordinates_job* job);
/* Sets what enters in a sweep for the mixed iterate; and after it stores what left as the latest iterate's, and returns
 * by how much its power is larger than what entered, W. */
void ty_ordinates_images_emit(const ty_ordinates_job* job, ty_sweep* sweep);
double ty_ordinates_images_receive(ty_ordinates_job* job);
/* Adds the difference of both to the DSA source, and returns the change of the sum of squares; the second function adds
 * the correction e. */
double ty_ordinates_images_residual(ty_ordinates_job* job, bool first);
void ty_ordinates_images_correct(ty_ordinates_job* job, const float* e);

/* ---- parts of a box: no-ops for a whole one ---- */

/* Memory for what lies beyond the cuts. Errors: TY_ERROR_MEMORY. */
ty_result ty_ordinates_parts_create(ty_ordinates_job* job);
void ty_ordinates_parts_destroy(ty_ordinates_job* job);
/* Sums over all ranks, in the order of ranks. */
void ty_ordinates_sum_ranks(const ty_ordinates_job* job, double* values, int32_t count);
/* Fetches the neighbours' flux of the latest change. */
void ty_ordinates_exchange_flux(ty_ordinates_job* job);
/* TY_OK, or the error of ranks that do not answer. */
ty_result ty_ordinates_check_ranks(const ty_ordinates_job* job);
/* True if a face (2 * axis + (1 for the upper one)) of the part is one of the whole box. */
static inline bool ty_ordinates_ends(const ty_ordinates_def* def, int face) {
    return def->domain == NULL || ty_domain_neighbour(def->domain, face) < 0;
}
/* The patch of boundary_radiance of a cell's face across an axis. */
static inline int32_t ty_ordinates_patch(const ty_ordinates_def* def, int axis, const int32_t at[3]) {
    if (def->domain == NULL) return ty_boundary_patch(&def->boundary_radiance, def->size, axis, at);
    const int32_t* first = def->domain->first;
    const int32_t whole[3] = {at[0] + first[0], at[1] + first[1], at[2] + first[2]};
    return ty_boundary_patch(&def->boundary_radiance, def->domain->cells, axis, whole);
}

/* Makes the first iterate, whose moments are set, the initial guess. */
void ty_ordinates_start(ty_ordinates_job* job);
/* ---- diffusive cells: no-ops without them ---- */

/* Finds diffusive cells and sets `reduced` as in ty_diffusive_cells_find. Errors: TY_ERROR_MEMORY. */
ty_result ty_ordinates_diffusive_find(ty_ordinates_job* job, float* reduced, const float* absorption);
void ty_ordinates_diffusive_free(ty_ordinates_job* job);
/* Partial currents into interfaces for an initial guess, from its fluence and flux. */
void ty_ordinates_diffusive_begin(ty_ordinates_job* job);
/* Emission of the interfaces for the mixed iterate, called by ty_ordinates_emit, minus boundary power that enters
 * diffusive cells directly; and after a sweep the incident partial currents of the latest iterate, including those on
 * boundary faces. Both return the total power, W. */
double ty_ordinates_diffusive_emit(ty_ordinates_job* job);
double ty_ordinates_diffusive_receive(ty_ordinates_job* job);
/* Power that leaves the box from diffusive cells in the mixed iterate, W. */
double ty_ordinates_diffusive_leakage(const ty_ordinates_job* job);
/* Adds the imbalance of diffusive cells to the DSA source and returns the change of the sum of squares; the second
 * function adds the correction e to their partial currents. */
double ty_ordinates_diffusive_residual(ty_ordinates_job* job, bool first);
void ty_ordinates_diffusive_correct(ty_ordinates_job* job, const float* e);
/* Irradiance of the latest iterate on boundary faces of diffusive cells. */
void ty_ordinates_diffusive_reach_faces(ty_ordinates_job* job);
/* Adds changes and products, called by ty_ordinates_correct. */
void ty_ordinates_diffusive_compare(ty_ordinates_job* job, ty_ordinates_sums* sums);
/* Writes fluence and flux of the latest iterate to the moments of diffusive cells; `terms` floats per cell. */
void ty_ordinates_diffusive_fill(const ty_ordinates_job* job, float* cells, int32_t terms);

/* The diffusion solution for the source as the initial guess. */
void ty_ordinates_diffusion_initial_guess(ty_ordinates_job* job);
/* A solution on cells of twice the size as the initial guess; no-op where it would not save sweeps. Errors: those of
 * ty_ordinates_solve. */
ty_result ty_ordinates_coarse_initial_guess(ty_ordinates_job* job);
/* Iterates until convergence, the maximum of sweeps or cancellation: TY_OK or TY_CANCELLED. The result is the latest
 * iterate. */
ty_result ty_ordinates_iterate(ty_ordinates_job* job);

#endif
