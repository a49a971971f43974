/* Algorithm 1 of Koerner et al. 2014: red-black over-relaxation of the fluence, D renewed cell by cell on the way.
 * Beyond the paper: a step leaves a cell a share of its fluence, without which large factors diverge, and residuals are
 * what they were before each cell's step, so that over-relaxation does not flatter them. */
#include "solve/job.h"

#include <math.h>

/* epsilon of Algorithm 1: what fluence and D start from. */
static const double EPSILON = 1e-20;

typedef struct sweep {
    ty_diffusion_job* job;
    const ty_cells* cells;
    void* phi;
    float* diffusivity;
    double omega;
    int32_t color;
    int32_t first; /* plane */
    bool narrow;   /* single precision */
} sweep;

static void ghosts_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const sweep* s = user;
    const ty_diffusion_job* job = s->job;
    if (s->narrow)
        job->cell_kernels->ghosts_float(s->cells, s->phi, (int32_t)index);
    else
        job->cell_kernels->ghosts(s->cells, s->phi, (int32_t)index);
}

static void relax_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const sweep* s = user;
    const ty_cell_kernels* kernels = s->job->cell_kernels;
    const int32_t z = s->first + 2 * (int32_t)index;
    s->job->sums[z].a = s->narrow ? kernels->sor_float(s->cells, s->phi, s->diffusivity, s->omega, s->color, z)
                                  : kernels->sor(s->cells, s->phi, s->diffusivity, s->omega, s->color, z);
}

/* Every other plane at a time: the kernels read all cells of the planes on either side. */
static double pass(sweep* s, int32_t color) {
    const ty_box* box = &s->cells->box;
    s->color = color;
    ty_solve_planes(s->job, box, ghosts_plane, s);
    for (s->first = 0; s->first < 2; ++s->first)
        ty_solve_tasks(s->job, box, (box->size[2] + 1 - s->first) / 2, relax_plane, s);
    return ty_solve_sum(s->job, box->size[2]).a;
}

double ty_stage_sweep(ty_diffusion_job* job, int32_t i, double omega) {
    const ty_stage* stage = &job->stages[i];
    sweep s = {.job = job,
               .cells = &stage->cells,
               .phi = stage->phi,
               .diffusivity = stage->diffusivity,
               .omega = omega,
               .narrow = job->def->solver == TY_DIFFUSION_SOR_FLOAT};
    ty_solve_count(job, &stage->cells.box, 1);
    const double first = pass(&s, 0);
    return first + pass(&s, 1);
}

static void start(const ty_diffusion_job* job) {
    const ty_box* box = &job->cells.box;
    const double shortest = fmin(fmin(job->def->cell[0], job->def->cell[1]), job->def->cell[2]);
    for (int32_t z = 0; z < box->size[2]; ++z)
        for (int32_t y = 0; y < box->size[1]; ++y) {
            float* row = job->diffusivity + ty_box_at(box, y, z);
            for (int32_t x = 0; x < box->size[0]; ++x) row[x] = (float)(EPSILON * shortest);
        }
}

ty_result ty_solve_sor(ty_diffusion_job* job) {
    const ty_diffusion_def* def = job->def;
    const int32_t limit = def->iterations > 0 ? def->iterations : 20000;
    const double cells = (double)ty_box_cells(&job->cells.box);
    job->stages[0] = (ty_stage){.cells = job->cells, .phi = job->phi, .diffusivity = job->diffusivity};
    start(job);
    for (int32_t i = 0;; ++i) {
        const double squares = ty_stage_sweep(job, 0, def->relaxation);
        job->stats->iterations = i + 1;
        const ty_result result = ty_solve_note(job, sqrt(squares / cells));
        if (job->stats->converged || result != TY_OK || i + 1 == limit) return result;
    }
}
