/* State of one call of ty_diffusion_solve. */
#ifndef TY_SOLVE_DIFFUSION_JOB_H
#define TY_SOLVE_DIFFUSION_JOB_H

#include "base/arena.h"
#include "comm/domain.h"
#include "solve/diffusion/cell_kernel.h"

enum { TY_LEVELS_MAX = 14 };
/* omega of Algorithm 1 as a smoother between Picard iterations. */
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
    void* phi; /* double, or float for TY_DIFFUSION_SOR_FLOAT; points to cell (0, 0, 0), like all arrays with ghosts */
    float* diffusivity;     /* D */
    ty_plane_sums* sums;    /* one per plane */
    double start, reported; /* s */

    /* Multigrid only. Stage i holds the nonlinear problem, level i its linearisation on the same cells. */
    ty_level levels[TY_LEVELS_MAX];
    ty_fas_level stages[TY_LEVELS_MAX];
    int32_t level_count, stage_count;
    float *direction, *change; /* conjugate gradients: search direction p and correction of phi. Limited problems do not
                                  use them, and store the damped D in `direction` */
    /* Divided grids only (divided.h). Levels and stages from `divided` on are whole on every rank. */
    ty_domain* domain;
    int32_t divided;
    ty_level part_level;     /* this rank's part of the first whole level, */
    ty_fas_level part_stage; /* and of the first whole stage */
    ty_plane_sums* all_sums;
    float* gathered;
    size_t* offsets;

    float damping; /* damping factor of D where the flux is limited; 0: no damping and no sweeps of coarser stages */
} ty_diffusion_job;

/* Set-up of a job: kernels, memory (all zeros), and the def's cells scaled to sources with rms `rms`. */
void ty_solve_choose_kernels(ty_diffusion_job* job);
void ty_solve_lay_out(ty_diffusion_job* job, ty_arena* arena);
void ty_solve_set_cells(ty_diffusion_job* job, double rms);

/* Allocates a box with ghosts; returns the address of cell (0, 0, 0). */
void* ty_solve_take_box(ty_arena* arena, const ty_box* box, size_t item);
/* Allocates the values of a side, one per face. */
float* ty_solve_take_side(ty_arena* arena, const ty_box* box, int side, ty_side* out);
/* Number of faces of a side along its first and second axis. */
void ty_solve_side_faces(const ty_box* box, int side, int32_t faces[2]);

/* Loop of body over tasks or planes of a box with denormals flushed to zero; on the calling thread for small boxes. */
void ty_solve_tasks(const ty_diffusion_job* job, const ty_box* box, int64_t count, ty_parallel_fn body, void* user);
void ty_solve_planes(const ty_diffusion_job* job, const ty_box* box, ty_parallel_fn body, void* user);
/* Total over the planes of a box, in order. */
ty_plane_sums ty_solve_sum(const ty_diffusion_job* job, const ty_box* box);
/* Adds passes over the cells of a box to the statistics. */
void ty_solve_count(const ty_diffusion_job* job, const ty_box* box, double passes);

/* Records a residual (relative to the source) before an iteration and reports progress: TY_CANCELLED if the caller
 * cancels. */
ty_result ty_solve_note(ty_diffusion_job* job, double residual);

/* The solvers; they set phi and the statistics. */
ty_result ty_solve_sor(ty_diffusion_job* job);
ty_result ty_solve_picard(ty_diffusion_job* job);

/* Red and black sweep of Algorithm 1 on stage i, over cells within `depth` cells of a face of the box. Returns the sum
 * of squared residuals (of multigrid on a divided grid 0). */
enum { TY_RELAX_ALL = TY_DIFFUSION_SIDE_MAX };
double ty_fas_relax(ty_diffusion_job* job, int32_t i, double omega, int32_t depth);

/* Memory of all stages but the finest, whose arrays are the job's. */
void ty_fas_lay_out(ty_diffusion_job* job, ty_arena* arena);
/* Restricts the media of the finest stage to all others. */
void ty_fas_restrict_cells(ty_diffusion_job* job);
/* Picard iteration: the first function computes D and the residuals f of the stage's phi and returns their sum of
 * squares; the second solves the linear problem to `reduction` of f, or for at most `cycles` cycles, and updates phi.
 */
double ty_fas_linearise(ty_diffusion_job* job, int32_t i);
void ty_fas_picard_step(ty_diffusion_job* job, int32_t i, double squares, double reduction, int32_t cycles);
/* Coarse-level correction of a stage's phi (FAS); the stage is linearised. */
void ty_fas_correct(ty_diffusion_job* job, int32_t i);
/* Initial phi of the finest stage by full multigrid over all stages. */
void ty_fas_full_multigrid(ty_diffusion_job* job, double first);

/* Cells of the next level, their edges, and the children of one along each axis; false if only one cell is left. */
bool ty_multigrid_coarsen_size(int32_t size[3], double cell[3], int32_t children[3]);
/* Levels of multigrid and their memory. */
void ty_multigrid_lay_out(ty_diffusion_job* job, ty_arena* arena);
/* Couplings of the levels coarser than one, from its D. */
void ty_multigrid_coarsen(ty_diffusion_job* job, int32_t first);
/* Solves a level's linear problem for f, whose sum of squares is `squares`, until it is reduced to about `target`. The
 * result is valid until the next solve. */
const float* ty_multigrid_solve(ty_diffusion_job* job, int32_t first, double squares, double target, int32_t cycles);

#endif
