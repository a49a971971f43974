#include "solve/diffusion/adjoint/linear.h"

#include "base/context.h"
#include "solve/diffusion/job.h"

#include <string.h>

struct ty_linear_diffusion {
    ty_diffusion_job job;
    ty_diffusion_def def;
    ty_diffusion_out out;
    ty_diffusion_stats stats;
    void* memory;
    size_t bytes;
    /* of the solve at hand */
    const float* source;
    const float* solution;
    double* fluence;
};

ty_result ty_linear_diffusion_create(ty_context* context, const ty_diffusion_def* def, ty_linear_diffusion** out) {
    *out = NULL;
    ty_linear_diffusion* linear = ty_alloc_array(context, 1, sizeof *linear, true);
    if (linear == NULL) return TY_ERROR_MEMORY;
    ty_diffusion_job* job = &linear->job;
    linear->def = *def;
    linear->def.limiter = TY_LIMITER_NONE;
    linear->def.solver = TY_DIFFUSION_MULTIGRID;
    linear->def.source = def->extinction; /* required by the job, and not used */
    *job = (ty_diffusion_job){.context = context, .def = &linear->def, .out = &linear->out, .stats = &linear->stats};
    linear->bytes = ty_diffusion_memory(&linear->def);
    linear->memory = ty_alloc_array(context, linear->bytes, 1, true);
    if (linear->memory == NULL) {
        ty_linear_diffusion_destroy(linear);
        return TY_ERROR_MEMORY;
    }
    ty_arena arena = {.base = linear->memory};
    ty_solve_choose_kernels(job);
    ty_solve_lay_out(job, &arena);
    ty_solve_set_cells(job, 1);
    job->stage_count = 1; /* no coarser nonlinear levels: the problem is linear */
    ty_fas_restrict_cells(job);
    ty_fas_linearise(job, 0);
    job->levels[0].diffusivity = job->diffusivity;
    memcpy(job->levels[0].coupling, job->cells.coupling, sizeof job->cells.coupling);
    ty_multigrid_coarsen(job, 0);
    *out = linear;
    return TY_OK;
}

void ty_linear_diffusion_destroy(ty_linear_diffusion* linear) {
    if (linear == NULL) return;
    ty_context* context = linear->job.context;
    ty_free_array(context, linear->memory, linear->bytes, 1);
    ty_free_array(context, linear, 1, sizeof *linear);
}

static void set_source_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const ty_linear_diffusion* linear = user;
    const ty_box* box = &linear->job.cells.box;
    double squares = 0;
    for (int32_t y = 0; y < box->size[1]; ++y) {
        const float* from = linear->source + ty_box_dense(box, y, (int32_t)z);
        float* to = linear->job.levels[0].f + ty_box_at(box, y, (int32_t)z);
        for (int32_t x = 0; x < box->size[0]; ++x) {
            to[x] = from[x];
            squares += (double)from[x] * (double)from[x];
        }
    }
    linear->job.sums[z].a = squares;
}

static void store_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const ty_linear_diffusion* linear = user;
    const ty_box* box = &linear->job.cells.box;
    for (int32_t y = 0; y < box->size[1]; ++y) {
        const float* from = linear->solution + ty_box_at(box, y, (int32_t)z);
        double* to = linear->fluence + ty_box_dense(box, y, (int32_t)z);
        for (int32_t x = 0; x < box->size[0]; ++x) to[x] = (double)from[x];
    }
}

int32_t ty_linear_diffusion_solve(ty_linear_diffusion* linear, const float* source, double reduction, int32_t cycles,
                                  double* fluence) {
    ty_diffusion_job* job = &linear->job;
    const int32_t before = linear->stats.cycles;
    linear->source = source;
    linear->fluence = fluence;
    ty_solve_planes(job, &job->cells.box, set_source_plane, linear);
    const double squares = ty_solve_sum(job, &job->cells.box).a;
    job->levels[0].diffusivity = job->diffusivity;
    linear->solution = ty_multigrid_solve(job, 0, squares, squares * reduction * reduction, cycles);
    ty_solve_planes(job, &job->cells.box, store_plane, linear);
    return linear->stats.cycles - before;
}
