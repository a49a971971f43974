/* Discrete ordinates: light that scatters on a box of cells, along a set of directions, one colour channel a call.
 *
 *     w . grad psi + sigma* psi = sum_lm s_l phi_lm Y_lm(w) + sum_lm q_lm Y_lm(w)
 *     sigma* = sigma_t - g^L sigma_s,   s_l = sigma_s (g^l - g^L),   l < L
 *
 * which is the transport equation with a Henyey-Greenstein phase function whose forward peak counts as light that goes
 * straight on (delta-M). phi_lm is the integral of psi Y_lm over all directions, Y_lm are real and orthonormal, without
 * Condon-Shortley sign, number l (l + 1) + m (base/sh.k.h), so that phi_00 sqrt(4 pi) is the fluence. What comes
 * in through the box's faces is given; walls between cells, or around the box, reflect. Cells hold means; in those that
 * are diffusion's, of fluence and flux alone. The result
 * does not depend on the number of threads. */
#ifndef TY_SOLVE_ORDINATES_ORDINATES_H
#define TY_SOLVE_ORDINATES_ORDINATES_H

#include <tyndall/base.h>

enum { TY_ORDINATES_MAX = 1024, TY_SCATTERING_ORDER_MAX = 12 };
/* Free paths across cells that may be diffusion's. */
enum { TY_DIFFUSIVE_FREE_PATHS = 6 };

/* Directions with weights that add up to 4 pi, those of one octant after one another: first[o] is where octant o begins
 * (bit a of o: whether the component along axis a is negative), first[8] the count. */
typedef struct ty_angular_quadrature {
    int32_t count;
    int32_t first[9];
    float direction[3][TY_ORDINATES_MAX];
    float weight[TY_ORDINATES_MAX];
} ty_angular_quadrature;

/* About `count` directions (8..1024), as many in each octant, mirrored along the axes, no component zero, whose
 * weighted sums of spherical harmonics up to order `exact` at least vanish (but the first); *exact may be NULL. The set
 * is described in docs/method/dom.md. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
ty_result ty_angular_quadrature_create(ty_context* context, int32_t count, ty_angular_quadrature* out, int32_t* exact);

/* Walls, as ty_sweep_faces has them. They reflect alike in all directions. */
typedef struct ty_ordinates_faces {
    int32_t count;         /* of sides; 0 (default): there are none */
    const int32_t* first;  /* of each row of cells, and count */
    const int32_t* x;      /* the cell of the row that a side is of */
    const uint8_t* face;   /* 2 * axis, and 1 more for a cell's upper face */
    const float* albedo;   /* [0, 1] */
    const float* emission; /* radiance that they send besides, W m^-2 sr^-1 */
    float* arrived;        /* out: irradiance, W m^-2; may be NULL */
} ty_ordinates_faces;

typedef struct ty_ordinates_def {
    int32_t size[3]; /* cells along x, y, z: 1..512 each */
    double cell[3];  /* their edges, m */
    const ty_angular_quadrature* set;
    const ty_angular_quadrature* last; /* directions of one more sweep at the end, through what the others found, so
                                    that few do not show as rays: not together with inflow; NULL (default): none */
    int32_t bands;                     /* L, 1..TY_SCATTERING_ORDER_MAX */
    int32_t kept;                      /* bands of moments that come out, bands..TY_SCATTERING_ORDER_MAX */
    const float* extinction;           /* sigma_t, 1/m, x fastest; 0: vacuum */
    const float* scattering;           /* sigma_s, 1/m, at most sigma_t */
    const float* g;                    /* mean cosine, (-1, 1) */
    const float* scattered;     /* s_l / sigma_s, l < bands, the same in all cells, in place of what g makes of them:
                                   the first at most 1, and what it leaves goes straight on; NULL (default): by g */
    const float* const* source; /* q_lm: `source_terms` planes */
    int32_t source_terms;       /* 1 or bands^2 */
    ty_ordinates_faces walls;
    const float* inflow; /* radiance that comes in along each of the set's directions, the same all over the box's
                            faces; NULL (default): none */
    bool accelerated;    /* diffusion synthetic acceleration, 2 to 12 sweeps, and cells of more than 6 free paths are
                            diffusion's (solve/ordinates/diffusive_cells.h); false: source iteration, as many as light
                            scatters */
    double tolerance;    /* of what is still to come, rms of fluences; default 1e-3 */
    int32_t sweeps;      /* at most; 0 (default): 100 accelerated, else 10000 */
    float* seen;         /* out: of each cell six numbers, one a face (2 * axis, and 1 more for the upper one): of cells
                            that are diffusion's beside others, 4 / sqrt(4 pi) of what leaves there, the fluence that
                            an eye before that face sees; below 0 elsewhere. NULL (default): not asked for */
    const float* const* start; /* moments to start from, bands^2 planes; NULL (default): none (dark, or diffusion's) */
    void* memory;              /* ty_ordinates_memory bytes, aligned to 64; NULL (default): from the context */
    ty_progress_fn progress;   /* default NULL */
    void* progress_user;
} ty_ordinates_def;

ty_ordinates_def ty_default_ordinates_def(void);
/* Bytes of the arrays of cells that a solve works on: of size, bands, source_terms, walls.count and accelerated. Sweeps
 * and corrections take their own. */
size_t ty_ordinates_memory(const ty_ordinates_def* def);

typedef struct ty_ordinates_stats {
    bool converged;
    int32_t sweeps, cycles;
    double change; /* what is still to come, of the rms fluence, estimated; where cells are diffusion's, what is missing
                      of the energy if more */
    double emitted, absorbed, leaving; /* W: by the source, by the medium, out of the box's faces */
    double walls_emitted, walls_absorbed, entering;
    double seconds, sweep_seconds;
    double bytes;
} ty_ordinates_stats;

/* Solves for the moments: kept^2 planes of as many floats as there are cells. history: the estimate of what is still to
 * come after each sweep, may be NULL. stats may be NULL. A solve that runs out of sweeps is TY_OK with stats->converged
 * false; on TY_CANCELLED moments hold what there was. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
ty_result ty_ordinates_solve(ty_context* context, const ty_ordinates_def* def, float* const* moments, double* history,
                             int32_t history_capacity, ty_ordinates_stats* stats);

#endif
