/* Test problems of the discrete ordinates solver for benches and figures. */
#ifndef TY_BENCH_ORDINATES_BOX_H
#define TY_BENCH_ORDINATES_BOX_H

#include "solve/ordinates/ordinates.h"

typedef enum ordinates_box_kind {
    ORDINATES_BOX_EVEN = 0, /* homogeneous medium, albedo 1, uniform emission */
    ORDINATES_BOX_CLOUD = 1 /* inhomogeneous emissive ball in vacuum, albedo 0.999 */
} ordinates_box_kind;
enum { ORDINATES_BOX_KINDS = 2 };

extern const char* const ordinates_box_names[ORDINATES_BOX_KINDS];

/* A cube of 1 m, isotropic scattering. def.set and planes point into the struct, so it must not be moved. */
typedef struct ordinates_box {
    ty_ordinates_def def;
    ty_angular_quadrature set;
    size_t cells;
    float *extinction, *scattering, *g, *source, *fluence;
    const float* sources[1];
} ordinates_box;

/* thickness: mean optical thickness across the cube, or across the ball of the cloud. Errors: TY_ERROR_MEMORY,
 * TY_ERROR_ARGUMENT. */
ty_result ordinates_box_open(ty_context* context, ordinates_box_kind kind, int32_t edge, int32_t directions,
                             double thickness, ordinates_box* out);
void ordinates_box_close(ordinates_box* box);
/* Solves with def; history and stats as in ty_ordinates_solve. */
ty_result ordinates_box_solve(ty_context* context, ordinates_box* box, double* history, int32_t history_capacity,
                              ty_ordinates_stats* stats);

#endif
