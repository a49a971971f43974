/* One call of ty_diffusion_solve on its way through a solver. */
#ifndef TY_SOLVE_DIFFUSION_JOB_H
#define TY_SOLVE_DIFFUSION_JOB_H

#include "base/arena.h"
#include "solve/diffusion/cell_kernel.h"

enum { TY_LEVELS_MAX = 14 };
/* Omega of the sweeps of Algorithm 1 between steps of Picard's. */
#define TY_SOR_OMEGA 1.3

typedef struct ty_diffusion_job {
    ty_context* context;
    const ty_diffusion_def* def;
    const ty_diffusion_out* out;
    ty_diffusion_stats* stats;
    const ty_cell_kernels* cell_kernels;
    const ty_level_kernels* level_kernels;
    const ty_fas_kernels* stage_kernels;
    ty_cells cells;
    void* phi;              /* double, or float for TY_DIFFUSION_SOR_FLOAT; cell (0, 0, 0) as all arrays with ghosts */
    float* diffusivity;     /* D */
    ty_plane_sums* sums;    /* one for each plane */
    double start, reported; /* seconds */

    /* Multigrid's alone. Stage i, the non-linear problem, has the cells of level i, its linearisation. */
    ty_level levels[TY_LEVELS_MAX];
    ty_fas_level stages[TY_LEVELS_MAX];
    int32_t level_count, stage_count;
    float *direction, *change; /* of conjugate gradients: p, and what phi changes by. Limited problems do without, and
                                  have D as their linear ones take it in `direction` */
    float softening;           /* share of D that these are without where light streams. 0: none, nor sweeps of coarser
                                  stages */
} ty_diffusion_job;

/* What a job needs to begin with: kernels, room for its arrays (all zeros), and the def's cells, for sources with an
 * rms of `rms`. */
void ty_solve_choose_kernels(ty_diffusion_job* job);
void ty_solve_lay_out(ty_diffusion_job* job, ty_arena* arena);
void ty_solve_set_cells(ty_diffusion_job* job, double rms);

/* A plane of ghosts and all around; returns where cell (0, 0, 0) is. */
void* ty_solve_take_box(ty_arena* arena, const ty_box* box, size_t item);
/* The values of a side, one for each face. */
float* ty_solve_take_side(ty_arena* arena, const ty_box* box, int side, ty_side* out);
/* Faces of a side: along its first axis, and along its second. */
void ty_solve_side_faces(const ty_box* box, int side, int32_t faces[2]);

/* A loop of body over parts of a box, or over its planes, with denormals off; by this thread alone when the box has few
 * cells. */
void ty_solve_tasks(const ty_diffusion_job* job, const ty_box* box, int64_t count, ty_parallel_fn body, void* user);
void ty_solve_planes(const ty_diffusion_job* job, const ty_box* box, ty_parallel_fn body, void* user);
/* The sums of all planes, in order. */
ty_plane_sums ty_solve_sum(const ty_diffusion_job* job, int32_t planes);
/* Counts passes over the cells of a box. */
void ty_solve_count(const ty_diffusion_job* job, const ty_box* box, double passes);

/* Notes a residual (relative to the source) before an iteration, and asks whether to go on: TY_CANCELLED if the caller
 * does not want to. */
ty_result ty_solve_note(ty_diffusion_job* job, double residual);

/* The solvers: phi and the statistics. */
ty_result ty_solve_sor(ty_diffusion_job* job);
ty_result ty_solve_picard(ty_diffusion_job* job);

/* Both colours of Algorithm 1 on a stage, on cells that are among the `depth` nearest to a face of the box. Returns the
 * sum of the squares of what the residuals were. */
enum { TY_RELAX_ALL = TY_DIFFUSION_SIDE_MAX };
double ty_fas_relax(ty_diffusion_job* job, int32_t stage, double omega, int32_t depth);

/* Room for all stages but the finest, whose arrays are the job's. */
void ty_fas_lay_out(ty_diffusion_job* job, ty_arena* arena);
/* Cells of all stages from those of the finest. */
void ty_fas_restrict_cells(ty_diffusion_job* job);
/* A step of Picard's: first D, and the residuals f of the stage's phi, of which it returns the sum of squares; then the
 * next phi, from the linear problem, solved until `reduction` of f is left or for so many cycles. */
double ty_fas_linearise(ty_diffusion_job* job, int32_t stage);
void ty_fas_picard_step(ty_diffusion_job* job, int32_t stage, double squares, double reduction, int32_t cycles);
/* Corrects a stage's phi by what the coarser ones say; the stage is linearised. */
void ty_fas_correct(ty_diffusion_job* job, int32_t stage);
/* A phi of the finest stage to start from, by way of all the others. */
void ty_fas_full_multigrid(ty_diffusion_job* job, double first);

/* Levels of multigrid, and room for them. */
void ty_multigrid_lay_out(ty_diffusion_job* job, ty_arena* arena);
/* Couplings of the levels below one, from its D. */
void ty_multigrid_coarsen(ty_diffusion_job* job, int32_t first);
/* Solves a level's problem for f, whose sum of squares is `squares`, until about `target` is left. The result holds
 * until the next solve. */
const float* ty_multigrid_solve(ty_diffusion_job* job, int32_t first, double squares, double target, int32_t cycles);

#endif
