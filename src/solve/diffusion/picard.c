/* The default solver. Each iteration applies an FAS correction from coarser stages, then a Picard step: D from the
 * fluence and a correction from the resulting linear problem, in single precision against the double-precision residual
 * of the nonlinear problem; then a few sweeps of Algorithm 1, which settle D beside boundaries. */
#include "solve/diffusion/job.h"

#include <math.h>

/* Reduction of the residual by a linear solve, limited by single precision; and the target of the last one relative to
 * the tolerance. Limited problems use one cycle: the next D changes more than further cycles gain. */
static const double REDUCTION = 1e-7, TARGET = 0.3;
enum { CYCLES = 30 };
/* Sweeps of Algorithm 1 over all cells at image-quality tolerances. For tolerances below FINE_TOLERANCE there are more
 * sweeps or, in large boxes, additional sweeps of FACE_LAYERS layers of cells beside the faces, where residuals are
 * largest. Coarse tolerances take too few iterations for that to pay, and in small boxes the layers are most of all
 * cells. */
enum { SWEEPS = 4, MORE_SWEEPS = 8, FACE_SWEEPS = 12, FACE_LAYERS = 8, LARGE = 12 * FACE_LAYERS };
static const double FINE_TOLERANCE = 1e-5;
/* Damping of D where the flux is limited (ty_damped_diffusivity): the linear problem responds too weakly to the fluence
 * there, as D takes back half of the change. Across the gradient it does not, and a damping of half would remove all
 * gain. */
static const float DAMPING = 0.3f;
/* Components of an iteration for limited problems. All of them take the fewest iterations where only boundaries slow
 * convergence; coarser stages work for all smooth limiters; the Picard step alone always works. */
typedef enum components { COMPONENTS_PICARD = 0, COMPONENTS_CORRECTED = 1, COMPONENTS_SWEPT = 2 } components;
/* Sweeps, which cost more than the rest of an iteration, pay if the residual falls below SWEEPS_GAIN times the smallest
 * so far; if residuals grow without them, more sweeps are enabled permanently. An iteration gains if the residual falls
 * below GAIN times the smallest. After MAX_STAGNATION iterations in a row without gain, D is undamped and coarser
 * stages are not swept; after as many again, only the Picard step remains. */
static const double SWEEPS_GAIN = 0.33, GAIN = 0.9;
enum { MAX_STAGNATION = 4 };

typedef struct picard {
    ty_diffusion_job* job;
    bool limited;
    components components;
    int sweeps, face_sweeps;
    bool more_sweeps;    /* residuals grew without sweeps */
    double min_residual; /* smallest residual so far */
    int32_t stagnation;  /* iterations since the last gain */
} picard;

/* Rms of f of a linearised problem, from its sum of squares. */
static double rms(const ty_diffusion_job* job, double squares) {
    return sqrt(squares / (double)ty_box_whole_cells(&job->cells.box));
}

static void select_components(picard* p, double residual) {
    p->stagnation = residual < GAIN * p->min_residual ? 0 : p->stagnation + 1;
    if (p->components == COMPONENTS_CORRECTED && !p->more_sweeps && residual > p->min_residual) {
        p->more_sweeps = true;
        p->components = COMPONENTS_SWEPT;
        p->sweeps = MORE_SWEEPS;
    } else if (p->components == COMPONENTS_SWEPT && !p->more_sweeps && !(residual < SWEEPS_GAIN * p->min_residual)) {
        p->components = COMPONENTS_CORRECTED;
    }
    p->min_residual = fmin(p->min_residual, residual);
    if (p->stagnation < MAX_STAGNATION) return;
    if (!(p->job->damping > 0)) p->components = COMPONENTS_PICARD;
    p->job->damping = 0;
    p->stagnation = 0;
    p->min_residual = residual;
}

static void sweep(const picard* p) {
    if (p->components != COMPONENTS_SWEPT) return;
    for (int i = 0; i < p->face_sweeps; ++i) ty_fas_relax(p->job, 0, TY_SOR_OMEGA, FACE_LAYERS);
    for (int i = 0; i < p->sweeps; ++i) ty_fas_relax(p->job, 0, TY_SOR_OMEGA, TY_RELAX_ALL);
}

/* Removes interpolation errors beside boundaries, which coarser stages cannot correct. */
static void begin(const picard* p) {
    if (!p->limited) return;
    ty_fas_linearise(p->job, 0);
    sweep(p);
}

static void iterate(picard* p, double squares) {
    ty_diffusion_job* job = p->job;
    if (!p->limited) {
        const double target = TARGET * job->def->tolerance / rms(job, squares);
        ty_fas_picard_step(job, 0, squares, fmax(REDUCTION, target), CYCLES);
        return;
    }
    if (p->components >= COMPONENTS_CORRECTED && job->stage_count > 1) {
        ty_fas_correct(job, 0);
        squares = ty_fas_linearise(job, 0);
    }
    ty_fas_picard_step(job, 0, squares, 0, 1);
    sweep(p);
}

static bool is_large(const ty_box* box) {
    return box->whole[0] >= LARGE && box->whole[1] >= LARGE && box->whole[2] >= LARGE;
}

ty_result ty_solve_picard(ty_diffusion_job* job) {
    const ty_diffusion_def* def = job->def;
    picard p = {.job = job,
                .limited = def->limiter != TY_LIMITER_NONE,
                .min_residual = INFINITY,
                .components = COMPONENTS_SWEPT,
                .sweeps = SWEEPS};
    const int32_t limit = def->iterations > 0 ? def->iterations : 500;
    if (def->tolerance < FINE_TOLERANCE && is_large(&job->cells.box))
        p.face_sweeps = FACE_SWEEPS;
    else if (def->tolerance < FINE_TOLERANCE)
        p.sweeps = MORE_SWEEPS;
    if (p.limited) job->damping = DAMPING;
    ty_fas_restrict_cells(job);
    if (def->start == NULL) ty_fas_full_multigrid(job, ((const double*)job->phi)[0]);
    begin(&p);
    for (int32_t i = 0;; ++i) {
        const double squares = ty_fas_linearise(job, 0), residual = rms(job, squares);
        const ty_result result = ty_solve_note(job, residual);
        const bool done = job->stats->converged && i >= def->min_iterations;
        if (done || result != TY_OK || i == limit) return result;
        select_components(&p, residual);
        iterate(&p, squares);
        job->stats->iterations = i + 1;
    }
}
