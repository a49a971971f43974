#include "solve/ordinates/adjoint.h"

#include "base/context.h"
#include "base/parallel.h"
#include "base/sh.k.h"
#include "solve/ordinates/adjoint_kernel.h"
#include "solve/ordinates/job.h"

#include <math.h>
#include <string.h>

/* State of a call: the solution's problem, and that of its adjoint. */
typedef struct adjoint_job {
    ty_context* context;
    const ty_ordinates_def* def;
    const ty_adjoint_kernels* kernels;
    ty_ordinates_def own_def, adjoint_def;
    ty_ordinates_stats solved;
    ty_ordinates_job own, adjoint;
    const ty_sweep_box* box;
    size_t cells;
    int32_t passes; /* pairs of octants times groups of lanes */
    uint16_t* closed;
    float* sums; /* per pass and cell */
    float* work; /* per worker: radiance of both octants, scratch */
    size_t psi_floats, work_floats, closed_count;
    ty_ordinates_adjoint_stats* stats;
} adjoint_job;

/* ---- passes ---- */

static ty_adjoint_pass pass_of(const adjoint_job* job, int64_t index, int32_t worker) {
    float* work = job->work + job->work_floats * (size_t)worker;
    return (ty_adjoint_pass){.pair = (int32_t)(index % 4),
                             .group = (int32_t)(index / 4),
                             .psi = {work, work + job->psi_floats},
                             .scratch = work + 2 * job->psi_floats,
                             .sums = job->sums + job->cells * (size_t)index};
}

static void note_closed(void* user, int64_t index, int32_t worker) {
    const adjoint_job* job = user;
    ty_adjoint_pass pass = pass_of(job, index, worker);
    pass.closed = job->closed;
    job->kernels->forward(job->box, job->own.emission, &pass);
}

static void multiply(void* user, int64_t index, int32_t worker) {
    const adjoint_job* job = user;
    ty_adjoint_pass pass = pass_of(job, index, worker);
    float* sums = pass.sums;
    pass.sums = NULL;
    job->kernels->forward(job->box, job->own.emission, &pass);
    pass.sums = sums;
    job->kernels->multiply(ty_sweep_tables(job->adjoint.sweep), job->adjoint.emission, &pass);
}

/* Runs all passes; their sums are added up in order. */
static void run_passes(adjoint_job* job, ty_parallel_fn pass) {
    memset(job->sums, 0, sizeof(float) * job->cells * (size_t)job->passes);
    ty_parallel_flushed(job->context, job->passes, pass, job);
    for (int32_t p = 1; p < job->passes; ++p)
        for (size_t i = 0; i < job->cells; ++i) job->sums[i] += job->sums[job->cells * (size_t)p + i];
}

static ty_result allocate(adjoint_job* job) {
    job->box = ty_sweep_tables(job->own.sweep);
    job->kernels = TY_BEST_KERNELS(ty_adjoint_kernels);
    job->passes = 4 * job->box->groups;
    job->psi_floats = job->cells * (size_t)job->box->lanes;
    job->work_floats = 2 * job->psi_floats + job->kernels->scratch(job->box);
    job->closed_count = 6 * (size_t)job->passes * job->cells;
    job->closed = ty_alloc_array(job->context, job->closed_count, sizeof *job->closed, false);
    job->sums = ty_alloc_array(job->context, job->cells * (size_t)job->passes, sizeof(float), false);
    job->work =
        ty_alloc_array(job->context, job->work_floats, sizeof(float) * (size_t)ty_context_threads(job->context), false);
    return job->closed != NULL && job->sums != NULL && job->work != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static void free_all(adjoint_job* job) {
    ty_free_array(job->context, job->closed, job->closed_count, sizeof *job->closed);
    ty_free_array(job->context, job->sums, job->cells * (size_t)job->passes, sizeof(float));
    ty_free_array(job->context, job->work, job->work_floats, sizeof(float) * (size_t)ty_context_threads(job->context));
    if (job->own.def != NULL) ty_ordinates_end_job(&job->own);
    if (job->adjoint.def != NULL) ty_ordinates_end_job(&job->adjoint);
}

/* ---- the two problems ---- */

/* Makes a problem whose first iterate are these moments, and its source of the next sweep. */
static ty_result begin(adjoint_job* job, ty_ordinates_def* def, const float* const* moments, ty_ordinates_job* out) {
    def->start = moments;
    def->memory = NULL;
    *out = ty_ordinates_begin_job(def);
    out->context = job->context;
    out->stats = &job->solved;
    const ty_result result = ty_ordinates_prepare(out);
    if (result == TY_OK) ty_ordinates_emit(out);
    return result;
}

/* The change of the solution's fluence by a sweep. */
static double imbalance_of(const adjoint_job* job, const float* fluence) {
    double change = 0, square = 0;
    for (size_t i = 0; i < job->cells; ++i) {
        const double difference = (double)job->sums[i] - (double)fluence[i];
        change += difference * difference;
        square += (double)fluence[i] * (double)fluence[i];
    }
    return square > 0 ? sqrt(change / square) : 0;
}

static ty_result sweep_solution(adjoint_job* job, const float* const* moments) {
    job->own_def = *job->def;
    ty_result result = begin(job, &job->own_def, moments, &job->own);
    if (result == TY_OK && (job->own.diffusive.count > 0 || job->own.displaced != NULL))
        result = ty_fail(job->context, TY_ERROR_ARGUMENT,
                         "ordinates: diffusive cells and displaced sources have no adjoint");
    if (result == TY_OK) result = allocate(job);
    if (result != TY_OK) return result;
    run_passes(job, note_closed);
    job->stats->imbalance = imbalance_of(job, moments[0]);
    return TY_OK;
}

/* z of the header, in place of y. */
static ty_result solve_adjoint(adjoint_job* job, const float* const* weight, double tolerance,
                               const ty_ordinates_adjoint_out* out) {
    ty_ordinates_def* def = &job->adjoint_def;
    *def = *job->def;
    def->output_order = def->bands;
    def->source = weight;
    def->source_terms = 1;
    def->source_center = NULL;
    def->displaces_sources = false;
    def->diffusive_paths = (double)INFINITY;
    def->face_fluence = def->face_incident = NULL;
    def->tolerance = tolerance;
    def->sweeps = 0;
    def->closed = job->closed;
    def->start = NULL;
    def->memory = NULL;
    ty_result result = ty_ordinates_solve(job->context, def, out->source, NULL, 0, &job->solved);
    job->stats->converged = job->solved.converged;
    job->stats->sweeps = job->solved.sweeps;
    job->stats->change = job->solved.change;
    def->accelerated = false;
    if (result == TY_OK) result = begin(job, def, (const float* const*)out->source, &job->adjoint);
    return result;
}

/* y of the header, and the derivatives by s_l. */
static void store(const adjoint_job* job, const float* const* moments, const ty_ordinates_adjoint_out* out) {
    for (int32_t l = 0; l < job->def->bands; ++l) {
        memset(out->scattered[l], 0, sizeof(float) * job->cells);
        for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t)
            for (size_t i = 0; i < job->cells; ++i) {
                if (l % 2 != 0) out->source[t][i] = -out->source[t][i];
                out->scattered[l][i] += out->source[t][i] * moments[t][i];
            }
    }
    for (size_t i = 0; i < job->cells; ++i) out->extinction[i] = -job->sums[i] / TY_SH_0;
}

static bool is_dark(const float* weight, size_t cells) {
    for (size_t i = 0; i < cells; ++i)
        if (weight[i] != 0) return false;
    return true;
}

static void set_dark(const adjoint_job* job, const ty_ordinates_adjoint_out* out) {
    for (int32_t t = 0; t < job->def->bands * job->def->bands; ++t)
        memset(out->source[t], 0, sizeof(float) * job->cells);
    for (int32_t l = 0; l < job->def->bands; ++l) memset(out->scattered[l], 0, sizeof(float) * job->cells);
    memset(out->extinction, 0, sizeof(float) * job->cells);
}

ty_result ty_ordinates_adjoint(ty_context* context, const ty_ordinates_def* def, const float* const* moments,
                               const float* weight, double tolerance, const ty_ordinates_adjoint_out* out,
                               ty_ordinates_adjoint_stats* stats) {
    adjoint_job job = {.context = context, .def = def, .stats = stats};
    *stats = (ty_ordinates_adjoint_stats){.converged = true};
    job.cells = (size_t)def->size[0] * (size_t)def->size[1] * (size_t)def->size[2];
    if (def->walls.count > 0 || def->boundary_radiance.across[0] != NULL || def->final_set != NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "ordinates: walls, boundary radiance and final sets have no adjoint");
    ty_result result = sweep_solution(&job, moments);
    const bool dark = is_dark(weight, job.cells);
    if (result == TY_OK && dark) set_dark(&job, out);
    if (result == TY_OK && !dark) {
        result = solve_adjoint(&job, &weight, tolerance, out);
        if (result == TY_OK) run_passes(&job, multiply);
        if (result == TY_OK) store(&job, moments, out);
    }
    free_all(&job);
    return result;
}
