/* One call of ty_ordinates_solve. */
#ifndef TY_SOLVE_ORDINATES_JOB_H
#define TY_SOLVE_ORDINATES_JOB_H

#include "base/arena.h"
#include "solve/ordinates/dsa.h"
#include "solve/ordinates/diffusive_cells.h"

/* Iterates that the next one is mixed from; cells along an axis. */
enum { TY_ANDERSON_DEPTH = 5, TY_ORDINATES_SIDE_MAX = 512 };

/* Sums over a plane of cells: of a change and of what changed, squared; of the change times that of each iterate; of
 * what is emitted, absorbed, and taken by scattering as well. */
typedef struct ty_ordinates_sums {
    double change, fluence, products[TY_ANDERSON_DEPTH], emitted, absorbed, taken;
} ty_ordinates_sums;

typedef struct ty_ordinates_job {
    ty_context* context;
    const ty_ordinates_def* def;
    ty_ordinates_stats* stats;
    double* history;
    int32_t history_capacity;
    double start, reported; /* s */

    char* memory; /* of all arrays; NULL: the caller's */
    size_t bytes;
    int64_t cells;
    int32_t terms; /* bands^2 */
    int32_t lows;  /* of them, those that corrections change: band 0, and 1 if there is one */
    ty_sweep* sweep;
    ty_dsa* correction; /* NULL: source iteration */

    /* All without ghosts. Moments and what they emit have `terms` items of each cell after one another. */
    float* extinction; /* sigma* */
    float* fixed;      /* q, where it has more than one term; NULL: the def's plane */
    float* emission;
    float* moments[TY_ANDERSON_DEPTH]; /* of the iterates, as sweeps of mixtures left them */
    float* low[TY_ANDERSON_DEPTH];     /* the low terms alone, corrected (those of `moments` are not): of
 each row of cells, term by term */
    float* changes[TY_ANDERSON_DEPTH]; /* of low terms, from the mixture to the iterate */
    double leaving[TY_ANDERSON_DEPTH]; /* W, in the sweep that made it and of its correction */
    float* before;                     /* low terms of the mixture */
    ty_ordinates_sums* sums;           /* one for each plane */
    /* Of the sides of walls, if there are any. */
    ty_sweep_faces walls;
    float *walls_sent, *walls_before;        /* radiance; irradiance, of the mixture */
    float* walls_arrived[TY_ANDERSON_DEPTH]; /* irradiance, of the iterates */
    float* walls_changes[TY_ANDERSON_DEPTH]; /* from the mixture to the iterate */

    /* Cells whose light is diffusion's; and of their skins, irradiance over sqrt(4 pi). */
    ty_diffusive_cells thick;
    float *skin_before, *skin_excess;       /* of the mixture; the correction's source on the face */
    float* skin_arrived[TY_ANDERSON_DEPTH]; /* of the iterates */
    float* skin_changes[TY_ANDERSON_DEPTH]; /* four times from the mixture to the iterate */
    double skin_inflow;                     /* through the box's faces into thick cells, W */
    void* skin_memory;
    size_t skin_bytes;

    double shares[TY_ANDERSON_DEPTH]; /* of the iterates in the next mixture; they add up to 1, or all are 0: dark */
    int32_t depth;                    /* iterates there is room for */
    int32_t count;                    /* iterates there are */
    int32_t latest;                   /* of them */
    double missing; /* of the last sweep's fluence, relative, for light to be as much as was emitted */
    double emitted; /* by the source and walls, with what comes in, W, if there are thick cells */
    bool given;     /* the only iterate is a start: it is not known what a sweep changes it by */
} ty_ordinates_job;

/* A loop over planes of cells, in parallel if they are many, and the sum of their sums, in order. */
void ty_ordinates_planes(const ty_ordinates_job* job, ty_parallel_fn body, void* user);
ty_ordinates_sums ty_ordinates_total(const ty_ordinates_job* job);

/* sigma*; and for diffusion, sigma* - s_1 and sigma_a (NULL: not). Returns whether coefficients and sources are what
 * they must be. */
bool ty_ordinates_scale(ty_ordinates_job* job, float* reduced, float* absorption);
/* Planes, as the caller has them, to terms of cells after one another, and back. */
void ty_ordinates_gather(ty_ordinates_job* job, const float* const* planes, int32_t terms, float* cells);
void ty_ordinates_scatter(ty_ordinates_job* job, const float* cells, int32_t terms, float* const* planes);
/* The job's terms of cells, with zeros behind them. */
void ty_ordinates_widen(ty_ordinates_job* job, const float* from, int32_t terms, float* to);
/* Mixes iterates by their shares: low terms to `before`, and to emission what the mixture emits. Returns the sum of its
 * first term, with what walls send and what comes in. */
double ty_ordinates_emit(ty_ordinates_job* job);
/* The low terms of the latest iterate, from its moments, of which it returns the sum of what cells take; and back, when
 * there are no more corrections. */
double ty_ordinates_gather_low_order(ty_ordinates_job* job);
void ty_ordinates_scatter_low_order(ty_ordinates_job* job);
/* The source of the correction: what the latest iterate scatters more than the mixture; first: all that the def emits,
 * from a dark iterate. Returns its sum of squares. */
double ty_ordinates_residual(ty_ordinates_job* job, bool first);
/* Adds the correction e to the latest iterate (NULL: none), and notes what the iterate changes. */
ty_ordinates_sums ty_ordinates_correct(ty_ordinates_job* job, const float* e);
/* Emitted and absorbed, W. */
ty_ordinates_sums ty_ordinates_balance(ty_ordinates_job* job, const float* moments, int32_t terms);

/* ---- walls, and what comes in through faces: all nothing where there are none ---- */

void ty_ordinates_faces_lay_out(ty_ordinates_job* job, ty_arena* arena);
/* Irradiance of the iterate that iterations start from, of its fluence. */
void ty_ordinates_faces_begin(ty_ordinates_job* job);
/* Tells a sweep of walls and thick cells' skins; what arrives on the former is an iterate's, if there are none of the
 * latter. */
void ty_ordinates_set_sweep_faces(ty_ordinates_job* job, ty_sweep* sweep, int32_t iterate);
double ty_ordinates_face_area(const ty_ordinates_def* def, int32_t side);
/* What the mixture sends, as part of ty_ordinates_emit; of the latest iterate, after a sweep, W to irradiance. Both
 * return all of it, W. */
double ty_ordinates_faces_emit(ty_ordinates_job* job);
double ty_ordinates_faces_receive(ty_ordinates_job* job);
/* What walls send more than they did is part of the correction's source, and no flux passes them; first: all that they
 * send by themselves. Returns what the sum of squares changes by. And what the correction e brings to walls, and to the
 * fluxes of cells beside them other than if these were not there. */
double ty_ordinates_faces_residual(ty_ordinates_job* job, bool first);
void ty_ordinates_faces_correct(ty_ordinates_job* job, const float* e);
/* What comes in through faces that are no walls, W. */
double ty_ordinates_entering(const ty_ordinates_def* def);
/* Adds changes and products, as part of ty_ordinates_correct. */
void ty_ordinates_faces_compare(ty_ordinates_job* job, ty_ordinates_sums* sums);
/* W that walls emit by themselves, and absorb of an irradiance. */
void ty_ordinates_faces_balance(ty_ordinates_job* job, const float* arrived, double* emitted, double* absorbed);

/* Makes the first iterate, whose moments are there, what iterations start from. */
void ty_ordinates_start(ty_ordinates_job* job);
/* ---- thick cells: all nothing where there are none ---- */

/* Finds them; in them `reduced` becomes that of ty_diffusive_cells_find. Errors: TY_ERROR_MEMORY. */
ty_result ty_ordinates_diffusive_find(ty_ordinates_job* job, float* reduced, const float* absorption);
void ty_ordinates_diffusive_free(ty_ordinates_job* job);
/* What arrives on skins of a start, of its fluence and flux. */
void ty_ordinates_diffusive_begin(ty_ordinates_job* job);
/* What the mixture sends, for sweeps, as part of ty_ordinates_emit, less what comes in through the box's faces without
 * sweeps; and what arrives, of the latest iterate. Both return all of it, W. Of walls, too. */
double ty_ordinates_diffusive_emit(ty_ordinates_job* job);
double ty_ordinates_diffusive_receive(ty_ordinates_job* job);
/* Of the mixture, what leaves the box from thick cells, W. */
double ty_ordinates_diffusive_leakage(const ty_ordinates_job* job);
/* What is amiss of their balances is part of the correction's source; returns what the sum of squares changes by. And
 * what the correction e brings to them. */
double ty_ordinates_diffusive_residual(ty_ordinates_job* job, bool first);
void ty_ordinates_diffusive_correct(ty_ordinates_job* job, const float* e);
/* What the latest iterate brings to walls of thick cells. */
void ty_ordinates_diffusive_reach_faces(ty_ordinates_job* job);
/* Adds changes and products, as part of ty_ordinates_correct. */
void ty_ordinates_diffusive_compare(ty_ordinates_job* job, ty_ordinates_sums* sums);
/* The moments of the latest iterate: fluence and flux. `terms` of each cell after one another. */
void ty_ordinates_diffusive_fill(const ty_ordinates_job* job, float* cells, int32_t terms);

/* What diffusion alone makes of the source, to start from. */
void ty_ordinates_diffusion_initial_guess(ty_ordinates_job* job);
/* A solution on cells twice as large, to start from: nothing where it would not save sweeps. Errors: as of
 * ty_ordinates_solve. */
ty_result ty_ordinates_coarse_initial_guess(ty_ordinates_job* job);
/* Iterates until the def says to end: TY_OK or TY_CANCELLED. The result is the latest iterate. */
ty_result ty_ordinates_iterate(ty_ordinates_job* job);

#endif
