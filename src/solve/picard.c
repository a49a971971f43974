/* The default solver: D from the last fluence, then a correction from the linear problem that this makes, solved in
 * single precision by conjugate gradients with a cycle of multigrid as preconditioner, against the residual of the
 * non-linear problem in double precision. */
#include "solve/job.h"

#include <math.h>

/* What one iteration's linear solve reduces its residual to: more is lost on the next D, or on single precision. */
static const double REDUCTION_LIMITED = 0.3, REDUCTION_LINEAR = 1e-4;
enum { GRADIENTS_MAX = 30 };

typedef struct picard {
    ty_diffusion_job* job;
    float factor; /* alpha or beta */
} picard;

static void assemble_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const ty_diffusion_job* job = ((picard*)user)->job;
    const int32_t z = (int32_t)index;
    job->sums[z].a = job->cell_kernels->assemble(&job->cells, job->phi, job->diffusivity, &job->levels[0], z);
}

static void apply_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const ty_diffusion_job* job = ((picard*)user)->job;
    const int32_t z = (int32_t)index;
    job->sums[z] = job->level_kernels->apply(&job->levels[0], job->direction, job->image, z);
}

static void dots_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const ty_diffusion_job* job = ((picard*)user)->job;
    job->sums[index] = job->level_kernels->dots(&job->levels[0], job->image, (int32_t)index);
}

static void direct_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const picard* p = user;
    p->job->level_kernels->direct(&p->job->levels[0], p->factor, p->job->direction, (int32_t)index);
}

static void step_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const picard* p = user;
    const ty_diffusion_job* job = p->job;
    job->sums[index] =
        job->level_kernels->step(&job->levels[0], p->factor, job->direction, job->image, job->change, (int32_t)index);
}

static void update_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const ty_diffusion_job* job = ((picard*)user)->job;
    job->cell_kernels->update(&job->cells, job->change, job->phi, (int32_t)index);
}

static ty_plane_sums run(picard* p, ty_parallel_fn body) {
    ty_diffusion_job* job = p->job;
    ty_solve_planes(job, &job->cells.box, body, p);
    job->stats->work += 1;
    return ty_solve_sum(job, job->cells.box.size[2]);
}

static void clear_change(picard* p) {
    const ty_box* box = &p->job->cells.box;
    float* items = p->job->change - ty_box_origin(box);
    for (size_t i = 0; i < ty_box_items(box); ++i) items[i] = 0;
}

/* Flexible conjugate gradients (the preconditioner is not quite symmetric): beta after Polak and Ribiere, where the
 * change of the residual is -alpha A p. change, from f; squares: f.f, which falls to `target`. */
static void solve_linear(picard* p, double squares, double target) {
    clear_change(p);
    double alpha = 0, along = 0; /* f.e of the step before */
    for (int i = 0; i < GRADIENTS_MAX && squares > target; ++i) {
        ty_multigrid_cycle(p->job);
        const ty_plane_sums dots = run(p, dots_plane);
        p->factor = i == 0 ? 0 : (float)(-alpha * dots.b / along);
        run(p, direct_plane);
        const double curvature = run(p, apply_plane).a;
        if (!(curvature > 0)) return;
        /* p.f is e.f, since f is orthogonal to the last p. */
        alpha = dots.a / curvature;
        along = dots.a;
        p->factor = (float)alpha;
        squares = run(p, step_plane).a;
    }
}

ty_result ty_solve_picard(ty_diffusion_job* job) {
    picard p = {.job = job};
    const ty_diffusion_def* def = job->def;
    const int32_t limit = def->iterations > 0 ? def->iterations : 500;
    const double cells = (double)ty_box_cells(&job->cells.box);
    const double reduction = def->limiter == TY_LIMITER_NONE ? REDUCTION_LINEAR : REDUCTION_LIMITED;
    for (int32_t i = 0;; ++i) {
        ty_solve_diffuse(job);
        const double squares = run(&p, assemble_plane).a, residual = sqrt(squares / cells);
        const ty_result result = ty_solve_note(job, residual);
        if (job->stats->converged || result != TY_OK || i == limit) return result;
        ty_multigrid_coarsen(job);
        const double relative = fmax(reduction, 0.3 * def->tolerance / residual);
        solve_linear(&p, squares, squares * relative * relative);
        run(&p, update_plane);
        job->stats->iterations = i + 1;
    }
}
