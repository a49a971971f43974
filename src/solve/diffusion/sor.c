/* Algorithm 1 (Koerner 2014): red-black over-relaxation of the fluence with D updated cell by cell. Beyond the paper, a
 * cell retains a minimum fraction of its fluence per step, without which large relaxation factors diverge, and
 * residuals are evaluated before each cell's step, so that over-relaxation does not understate them. */
#include "solve/diffusion/divided/divided.h"

#include <math.h>

/* epsilon of Algorithm 1: initial fluence and D. */
static const double EPSILON = 1e-20;

typedef struct sweep {
    ty_diffusion_job* job;
    const ty_cells* cells;
    void* phi;
    float* diffusivity;
    double omega;
    int32_t color, depth;  /* selection of cells in a plane */
    bool single_precision; /* single precision */
    bool sums;             /* residuals over all ranks, too */
} sweep;

static void ghosts_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const sweep* s = user;
    const ty_diffusion_job* job = s->job;
    if (s->single_precision)
        job->cell_kernels->ghosts_float(s->cells, s->phi, (int32_t)index);
    else
        job->cell_kernels->ghosts(s->cells, s->phi, (int32_t)index);
}

static void relax_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const sweep* s = user;
    const ty_cell_kernels* kernels = s->job->cell_kernels;
    const int32_t z = (int32_t)index;
    s->job->sums[z].a = s->single_precision
                            ? kernels->sor_float(s->cells, s->phi, s->diffusivity, s->omega, s->color, s->depth, z)
                            : kernels->sor(s->cells, s->phi, s->diffusivity, s->omega, s->color, s->depth, z);
}

static double pass(sweep* s, int32_t color) {
    const ty_box* box = &s->cells->box;
    s->color = color;
    ty_solve_planes(s->job, box, ghosts_plane, s);
    ty_divided_exchange_fluence(s->job, box, s->phi, s->diffusivity);
    ty_solve_planes(s->job, box, relax_plane, s);
    return box->cut == 0 || s->sums ? ty_solve_sum(s->job, box).a : 0;
}

/* Fraction of a grid's cells within `depth` cells of its faces. */
static double fraction_within(const ty_box* box, int32_t depth) {
    double interior = 1;
    for (int a = 0; a < 3; ++a) interior *= fmax(0, 1 - 2.0 * depth / box->whole[a]);
    return 1 - interior;
}

/* Both colours once: Eq. 32, 36 and 37 (Koerner 2014), of which the rows are in solve/diffusion/cell_rows.h. */
double ty_fas_relax(ty_diffusion_job* job, int32_t i, double omega, int32_t depth) {
    const ty_fas_level* stage = &job->stages[i];
    sweep s = {.job = job,
               .cells = &stage->cells,
               .phi = stage->phi,
               .diffusivity = stage->diffusivity,
               .omega = omega,
               .depth = depth,
               .single_precision = job->def->solver == TY_DIFFUSION_SOR_FLOAT,
               .sums = job->def->solver != TY_DIFFUSION_MULTIGRID};
    ty_solve_count(job, &stage->cells.box, fraction_within(&stage->cells.box, depth));
    const double first = pass(&s, 0);
    return first + pass(&s, 1);
}

static void initialise(const ty_diffusion_job* job) {
    const ty_box* box = &job->cells.box;
    const double shortest = fmin(fmin(job->def->cell[0], job->def->cell[1]), job->def->cell[2]);
    for (int32_t z = 0; z < box->size[2]; ++z)
        for (int32_t y = 0; y < box->size[1]; ++y) {
            float* row = job->diffusivity + ty_box_at(box, y, z);
            for (int32_t x = 0; x < box->size[0]; ++x) row[x] = (float)(EPSILON * shortest);
        }
}

static void diffuse_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const sweep* s = user;
    s->job->cell_kernels->diffuse(s->cells, s->phi, s->diffusivity, (int32_t)index);
}

/* D of a given initial fluence, so that the first sweeps preserve it. */
static void diffuse_initial(ty_diffusion_job* job) {
    const ty_box* box = &job->cells.box;
    sweep s = {.job = job, .cells = &job->cells, .phi = job->phi, .diffusivity = job->diffusivity};
    ty_solve_planes(job, box, ghosts_plane, &s);
    ty_divided_exchange_fluence(job, box, job->phi, NULL);
    ty_solve_planes(job, box, diffuse_plane, &s);
}

/* Algorithm 1 (Koerner 2014). */
ty_result ty_solve_sor(ty_diffusion_job* job) {
    const ty_diffusion_def* def = job->def;
    const int32_t limit = def->iterations > 0 ? def->iterations : 20000;
    const double cells = (double)ty_box_whole_cells(&job->cells.box);
    job->stages[0] = (ty_fas_level){.cells = job->cells, .phi = job->phi, .diffusivity = job->diffusivity};
    initialise(job);
    if (def->start != NULL && def->solver == TY_DIFFUSION_SOR) diffuse_initial(job);
    for (int32_t i = 0;; ++i) {
        const double squares = ty_fas_relax(job, 0, def->relaxation, TY_RELAX_ALL);
        job->stats->iterations = i + 1;
        const ty_result result = ty_solve_note(job, sqrt(squares / cells));
        if (!job->stats->converged && result == TY_OK && i + 1 < limit) continue;
        /* Fluxes through cuts are those of the last sweep. */
        ty_divided_exchange_fluence(job, &job->cells.box, job->phi, job->diffusivity);
        return result;
    }
}
