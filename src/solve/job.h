/* One call of ty_diffusion_solve on its way through a solver. */
#ifndef TY_SOLVE_JOB_H
#define TY_SOLVE_JOB_H

#include "solve/kernel.h"

enum { TY_LEVELS_MAX = 14 };

typedef struct ty_diffusion_job {
    ty_context* context;
    const ty_diffusion_def* def;
    const ty_diffusion_out* out;
    ty_diffusion_stats* stats;
    const ty_cell_kernels* cell_kernels;
    const ty_level_kernels* level_kernels;
    ty_cells cells;
    void* phi;              /* double, or float for TY_DIFFUSION_SOR_FLOAT; cell (0, 0, 0) as all arrays here */
    float* diffusivity;     /* D */
    ty_plane_sums* sums;    /* one for each plane */
    double start, reported; /* seconds */

    /* Multigrid's alone. */
    ty_level levels[TY_LEVELS_MAX];
    int32_t level_count;
    float *direction, *image, *change; /* of conjugate gradients: p, A p, and what phi changes by */
} ty_diffusion_job;

/* Memory handed out piece by piece; without a base it only counts. */
typedef struct ty_solve_arena {
    char* base;
    size_t used;
} ty_solve_arena;

void* ty_solve_take(ty_solve_arena* arena, size_t bytes);
/* A plane of ghosts and all around; returns where cell (0, 0, 0) is. */
float* ty_solve_take_box(ty_solve_arena* arena, const ty_box* box);

/* A loop of body over parts of a box, or over its planes, with denormals off; by this thread alone when the box has few
 * cells. */
void ty_solve_tasks(const ty_diffusion_job* job, const ty_box* box, int64_t count, ty_parallel_fn body, void* user);
void ty_solve_planes(const ty_diffusion_job* job, const ty_box* box, ty_parallel_fn body, void* user);
/* The sums of all planes, in order. */
ty_plane_sums ty_solve_sum(const ty_diffusion_job* job, int32_t planes);

/* Notes a residual (relative to the source) before an iteration, and asks whether to go on: TY_CANCELLED if the caller
 * does not want to. */
ty_result ty_solve_note(ty_diffusion_job* job, double residual);

/* phi's ghosts, and D from phi. */
void ty_solve_diffuse(ty_diffusion_job* job);

/* The solvers: phi and the statistics. */
ty_result ty_solve_sor(ty_diffusion_job* job);
ty_result ty_solve_picard(ty_diffusion_job* job);

/* Levels below the finest, and room for them. */
void ty_multigrid_lay_out(ty_diffusion_job* job, ty_solve_arena* arena);
/* Couplings of all levels from those of the finest. */
void ty_multigrid_coarsen(ty_diffusion_job* job);
/* e of the finest level from its f: one V cycle, from 0. */
void ty_multigrid_cycle(ty_diffusion_job* job);

#endif
