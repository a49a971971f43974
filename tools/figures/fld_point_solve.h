/* Koerner et al. 2014, Section 6.1: a cell that emits, at the center of a homogeneous cube, by the diffusion solver. */
#ifndef TY_FIGURES_FLD_POINT_SOLVE_H
#define TY_FIGURES_FLD_POINT_SOLVE_H

#include "solve/diffusion/diffusion.h"

/* Length of the cube's edges, mean free paths. */
#define POINT_EXTENT 4.0

enum { POINT_CELLS_MAX = 255, POINT_DIRECTIONS = 3, POINT_SAMPLES_MAX = POINT_DIRECTIONS * (POINT_CELLS_MAX / 2) };

typedef struct point_case {
    int32_t cells; /* along each edge: odd, 3..POINT_CELLS_MAX */
    double albedo;
    ty_limiter limiter;
    bool diffusive_faces; /* fluence on the faces: that of classical diffusion in an infinite medium; else 0 */
} point_case;

typedef struct point_sample {
    double tau, fluence; /* optical depth from the source; normalised, Eq. 25 */
} point_sample;

/* Cells from the source outwards: along an axis, then a face diagonal, then a space diagonal. */
typedef struct point_profile {
    int32_t count;
    point_sample samples[POINT_SAMPLES_MAX];
    ty_diffusion_stats stats;
} point_profile;

/* progress may be NULL. Errors: TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result point_solve(ty_context* context, const point_case* which, ty_progress_fn progress, void* progress_user,
                      point_profile* out);

/* The relative errors of samples at from <= tau <= to against a theory's fluence. */
typedef struct point_difference {
    double mean, largest; /* mean magnitude */
} point_difference;

point_difference point_compare(const point_profile* profile, double (*theory)(double albedo, double tau), double albedo,
                               double from, double to);
/* The slope of ln fluence over ln tau in a range, by least squares. */
double point_slope(const point_profile* profile, double from, double to);

#endif
