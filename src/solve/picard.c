/* The default solver. Each iteration takes a correction from coarser stages, then D from the fluence and a correction
 * from the linear problem that this makes, in single precision against the residual of the non-linear problem in double
 * precision, then a few sweeps of Algorithm 1, which settle what D does beside boundaries. */
#include "solve/job.h"

#include <math.h>

/* What one iteration's linear solve reduces its residual to: more is lost on the next D, or on single precision. */
static const double REDUCTION_LIMITED = 0.5, REDUCTION_LINEAR = 1e-7;
/* What the last one aims at, of the tolerance. */
static const double AIM = 0.5;
enum { SWEEPS = 2 };
static const double OMEGA = 1.3;

ty_result ty_solve_picard(ty_diffusion_job* job) {
    const ty_diffusion_def* def = job->def;
    const bool limited = def->limiter != TY_LIMITER_NONE;
    const int32_t limit = def->iterations > 0 ? def->iterations : 500;
    const double cells = (double)ty_box_cells(&job->cells.box);
    const double reduction = limited ? REDUCTION_LIMITED : REDUCTION_LINEAR;
    ty_stages_fill(job);
    if (def->start == NULL) ty_stages_start(job, ((const double*)job->phi)[0]);
    for (int32_t i = 0;; ++i) {
        double squares = ty_stage_linearise(job, 0);
        const double residual = sqrt(squares / cells);
        const ty_result result = ty_solve_note(job, residual);
        if (job->stats->converged || result != TY_OK || i == limit) return result;
        if (limited && job->stage_count > 1) {
            ty_stages_correct(job, 0);
            squares = ty_stage_linearise(job, 0);
        }
        ty_stage_advance(job, 0, squares, fmax(reduction, AIM * def->tolerance / sqrt(squares / cells)));
        for (int sweep = 0; limited && sweep < SWEEPS; ++sweep) ty_solve_sweep(job, OMEGA);
        job->stats->iterations = i + 1;
    }
}
