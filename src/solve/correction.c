#include "solve/correction.h"

#include "base/context.h"
#include "solve/job.h"

#include <string.h>

struct ty_correction {
    ty_diffusion_job job;
    ty_diffusion_def def;
    ty_diffusion_out out;
    ty_diffusion_stats stats;
    char* memory;
    size_t bytes;
};

static void linearise(ty_correction* correction) {
    ty_diffusion_job* job = &correction->job;
    ty_solve_set_cells(job, 1);
    job->stage_count = 1; /* no coarser ones: the problem is linear */
    ty_stages_fill(job);
    ty_stage_linearise(job, 0);
    ty_level* level = &job->levels[0];
    level->diffusivity = job->diffusivity;
    memcpy(level->coupling, job->cells.coupling, sizeof level->coupling);
    ty_multigrid_coarsen(job, 0);
}

ty_result ty_correction_create(ty_context* context, const ty_diffusion_def* def, ty_correction** out) {
    *out = NULL;
    ty_correction* correction = ty_alloc_array(context, 1, sizeof *correction, true);
    if (correction == NULL) return TY_ERROR_MEMORY;
    correction->def = *def;
    correction->def.limiter = TY_LIMITER_NONE;
    correction->def.solver = TY_DIFFUSION_MULTIGRID;
    correction->def.source = def->absorption; /* read, but what it makes is not used */
    correction->job = (ty_diffusion_job){
        .context = context, .def = &correction->def, .out = &correction->out, .stats = &correction->stats};
    correction->bytes = ty_diffusion_memory(&correction->def);
    correction->memory = ty_alloc_array(context, correction->bytes, 1, true);
    if (correction->memory == NULL) {
        ty_correction_destroy(correction);
        return TY_ERROR_MEMORY;
    }
    ty_arena arena = {.base = correction->memory};
    ty_solve_choose_kernels(&correction->job);
    ty_solve_lay_out(&correction->job, &arena);
    linearise(correction);
    *out = correction;
    return TY_OK;
}

void ty_correction_destroy(ty_correction* correction) {
    if (correction == NULL) return;
    ty_context* context = correction->job.context;
    if (correction->memory != NULL) ty_free_array(context, correction->memory, correction->bytes, 1);
    ty_free_array(context, correction, 1, sizeof *correction);
}

size_t ty_correction_bytes(const ty_correction* correction) {
    return sizeof *correction + correction->bytes;
}

const ty_box* ty_correction_box(const ty_correction* correction) {
    return &correction->job.cells.box;
}

const float* ty_correction_diffusivity(const ty_correction* correction) {
    return correction->job.diffusivity;
}

float* ty_correction_source(ty_correction* correction) {
    return correction->job.levels[0].f;
}

const float* ty_correction_solve(ty_correction* correction, double squares, double reduction, int32_t cycles) {
    ty_diffusion_job* job = &correction->job;
    job->levels[0].diffusivity = job->diffusivity; /* a solve ends without it */
    return ty_multigrid_solve(job, 0, squares, squares * reduction * reduction, cycles);
}

int32_t ty_correction_cycles(const ty_correction* correction) {
    return correction->stats.cycles;
}
