/* The default solver. Each iteration takes a correction from coarser stages, then D from the fluence and a correction
 * from the linear problem that this makes, in single precision against the residual of the non-linear problem in double
 * precision, then a few sweeps of Algorithm 1, which settle what D does beside boundaries. */
#include "solve/diffusion/job.h"

#include <math.h>

/* What a linear problem's solve reduces its residual to, where more is lost on single precision; and what the last one
 * aims at, of the tolerance. Of limited problems one cycle is enough: more is lost on the next D. */
static const double REDUCTION = 1e-7, AIM = 0.3;
enum { CYCLES = 30 };
/* Of Algorithm 1, of all cells, for pictures; for tolerances below FINE more of them, or, in boxes that are large,
 * before these some of so many layers of cells beside the faces, where most is left. Pictures have too few iterations
 * for that to pay, and in small boxes layers are most of all cells. */
enum { SWEEPS = 4, MORE_SWEEPS = 8, FACE_SWEEPS = 12, FACE_LAYERS = 8, LARGE = 12 * FACE_LAYERS };
static const double FINE = 1e-5;
/* Of D, where light streams (ty_damped_diffusivity): the linear problem answers too little to the fluence there, as D takes
 * half of the change back. Across the gradient it does not, and half would leave that without any gain. */
static const float SOFTENING = 0.3f;
/* What an iteration of a limited problem consists of. All of it takes the fewest by far where little but boundaries
 * holds them up; coarser stages work for all limiters that are smooth; Picard's step alone always does. */
typedef enum means { MEANS_PICARD = 0, MEANS_CORRECTED = 1, MEANS_SWEPT = 2 } means;
/* Sweeps, which cost more than the rest of an iteration, pay if it leaves less than a share of the least residual so
 * far; but where residuals grow without them, more of them are taken for good. It gains if it leaves less than a larger
 * one: after so many in a row that do not, D is taken as it is and coarser stages are not swept; after as many more,
 * Picard's step is left alone. */
static const double SWEEPS_PAY = 0.33, GAIN = 0.9;
enum { PATIENCE = 4 };

typedef struct picard {
    ty_diffusion_job* job;
    bool limited;
    means means;
    int sweeps, face_sweeps;
    bool swept_again; /* as it went wrong without */
    double least;     /* residual so far */
    int32_t futile;   /* iterations since one gained */
} picard;

/* rms, of a linearised problem's f. */
static double rms(const ty_diffusion_job* job, double squares) {
    return sqrt(squares / (double)ty_box_cells(&job->cells.box));
}

static void judge(picard* p, double residual) {
    p->futile = residual < GAIN * p->least ? 0 : p->futile + 1;
    if (p->means == MEANS_CORRECTED && !p->swept_again && residual > p->least) {
        p->swept_again = true;
        p->means = MEANS_SWEPT;
        p->sweeps = MORE_SWEEPS;
    } else if (p->means == MEANS_SWEPT && !p->swept_again && !(residual < SWEEPS_PAY * p->least)) {
        p->means = MEANS_CORRECTED;
    }
    p->least = fmin(p->least, residual);
    if (p->futile < PATIENCE) return;
    if (!(p->job->softening > 0)) p->means = MEANS_PICARD;
    p->job->softening = 0;
    p->futile = 0;
    p->least = residual;
}

static void sweep(const picard* p) {
    if (p->means != MEANS_SWEPT) return;
    for (int i = 0; i < p->face_sweeps; ++i) ty_fas_relax(p->job, 0, TY_SOR_OMEGA, FACE_LAYERS);
    for (int i = 0; i < p->sweeps; ++i) ty_fas_relax(p->job, 0, TY_SOR_OMEGA, TY_RELAX_ALL);
}

/* What interpolation left beside boundaries is no business of coarser stages. */
static void begin(const picard* p) {
    if (!p->limited) return;
    ty_fas_linearise(p->job, 0);
    sweep(p);
}

static void iterate(picard* p, double squares) {
    ty_diffusion_job* job = p->job;
    if (!p->limited) {
        const double aim = AIM * job->def->tolerance / rms(job, squares);
        ty_fas_picard_step(job, 0, squares, fmax(REDUCTION, aim), CYCLES);
        return;
    }
    if (p->means >= MEANS_CORRECTED && job->stage_count > 1) {
        ty_fas_correct(job, 0);
        squares = ty_fas_linearise(job, 0);
    }
    ty_fas_picard_step(job, 0, squares, 0, 1);
    sweep(p);
}

static bool is_large(const ty_box* box) {
    return box->size[0] >= LARGE && box->size[1] >= LARGE && box->size[2] >= LARGE;
}

ty_result ty_solve_picard(ty_diffusion_job* job) {
    const ty_diffusion_def* def = job->def;
    picard p = {.job = job,
                .limited = def->limiter != TY_LIMITER_NONE,
                .least = INFINITY,
                .means = MEANS_SWEPT,
                .sweeps = SWEEPS};
    const int32_t limit = def->iterations > 0 ? def->iterations : 500;
    if (def->tolerance < FINE && is_large(&job->cells.box))
        p.face_sweeps = FACE_SWEEPS;
    else if (def->tolerance < FINE)
        p.sweeps = MORE_SWEEPS;
    if (p.limited) job->softening = SOFTENING;
    ty_fas_restrict_cells(job);
    if (def->start == NULL) ty_fas_full_multigrid(job, ((const double*)job->phi)[0]);
    begin(&p);
    for (int32_t i = 0;; ++i) {
        const double squares = ty_fas_linearise(job, 0), residual = rms(job, squares);
        const ty_result result = ty_solve_note(job, residual);
        const bool enough = job->stats->converged && i >= def->least_iterations;
        if (enough || result != TY_OK || i == limit) return result;
        judge(&p, residual);
        iterate(&p, squares);
        job->stats->iterations = i + 1;
    }
}
