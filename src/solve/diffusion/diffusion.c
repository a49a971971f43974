/* Entry points of the diffusion solvers: argument checks, memory, scaling and common loops. */
#include "solve/diffusion/job.h"

#include "base/context.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "solve/diffusion/closed_faces.h"
#include "solve/diffusion/divided/divided.h"
#include "solve/diffusion/result.h"

#include <math.h>
#include <string.h>

/* Smaller boxes run on one thread: waking the others takes longer. */
enum { CELLS_FOR_THREADS = 1 << 14 };

ty_diffusion_def ty_default_diffusion_def(void) {
    return (ty_diffusion_def){.limiter = TY_LIMITER_LEVERMORE_POMRANING,
                              .larsen_power = 2,
                              .streaming = 1,
                              .relaxation = 1.85,
                              .tolerance = 1e-6};
}

/* ---- memory ---- */

void* ty_solve_take_box(ty_arena* arena, const ty_box* box, size_t item) {
    char* base = ty_arena_take(arena, ty_box_items(box) * item);
    return base != NULL ? base + (size_t)ty_box_origin(box) * item : NULL;
}

void ty_solve_side_faces(const ty_box* box, int side, int32_t faces[2]) {
    faces[0] = box->size[side / 2 == 0 ? 1 : 0];
    faces[1] = box->size[side / 2 == 2 ? 1 : 2];
}

float* ty_solve_take_side(ty_arena* arena, const ty_box* box, int side, ty_side* out) {
    int32_t faces[2];
    ty_solve_side_faces(box, side, faces);
    out->step = faces[0];
    float* value = ty_arena_take(arena, sizeof(float) * (size_t)faces[0] * (size_t)faces[1]);
    out->value = value;
    return value;
}

/* A box of the finest level that also takes one of the first whole level, which may be larger than a rank's part. */
static float* take_largest(const ty_diffusion_job* job, ty_arena* arena) {
    size_t below = 0, above = 0;
    for (int32_t i = 0; i <= job->divided && i < job->level_count; ++i) {
        const ty_box* box = &job->levels[i].box;
        const size_t origin = (size_t)ty_box_origin(box), rest = ty_box_items(box) - origin;
        below = origin > below ? origin : below;
        above = rest > above ? rest : above;
    }
    float* base = ty_arena_take(arena, sizeof(float) * (below + above));
    return base != NULL ? base + below : NULL;
}

void ty_solve_lay_out(ty_diffusion_job* job, ty_arena* arena) {
    const ty_diffusion_def* def = job->def;
    ty_divided_begin(job);
    const ty_box* box = &job->cells.box;
    job->phi = ty_solve_take_box(arena, box, def->solver == TY_DIFFUSION_SOR_FLOAT ? sizeof(float) : sizeof(double));
    job->diffusivity = ty_solve_take_box(arena, box, sizeof(float));
    job->sums = ty_arena_take(arena, sizeof *job->sums * (size_t)box->whole[2]);
    job->cells.zeros = ty_arena_take(arena, sizeof(float) * (size_t)box->size[0]);
    for (int side = 0; side < 6; ++side) ty_solve_take_side(arena, box, side, &job->cells.sides[side]);
    ty_divided_lay_out_sums(job, arena);
    if (def->solver != TY_DIFFUSION_MULTIGRID) return;
    ty_multigrid_lay_out(job, arena);
    job->direction = take_largest(job, arena);
    job->change = take_largest(job, arena);
    ty_fas_lay_out(job, arena);
    ty_divided_lay_out(job, arena);
}

size_t ty_diffusion_memory(const ty_diffusion_def* def) {
    ty_diffusion_job job = {.def = def};
    ty_arena arena = {0};
    ty_solve_lay_out(&job, &arena);
    return arena.used;
}

/* ---- checks ---- */

static ty_result check_size(ty_context* context, const ty_diffusion_def* def) {
    for (int axis = 0; axis < 3; ++axis) {
        if (def->size[axis] < 1 || def->size[axis] > TY_DIFFUSION_SIDE_MAX)
            return ty_fail(context, TY_ERROR_ARGUMENT, "diffusion: size[%d]: %d cells are outside 1..%d", axis,
                           (int)def->size[axis], TY_DIFFUSION_SIDE_MAX);
        if (!(def->cell[axis] > 0 && def->cell[axis] < 1e12))
            return ty_fail(context, TY_ERROR_ARGUMENT, "diffusion: cell[%d]: %g m is no edge of a cell", axis,
                           def->cell[axis]);
    }
    return TY_OK;
}

static ty_result check_domain(ty_context* context, const ty_diffusion_def* def) {
    bool fits = true;
    for (int axis = 0; axis < 3 && def->domain != NULL; ++axis)
        fits = fits && def->size[axis] == def->domain->end[axis] - def->domain->first[axis];
    if (!fits) return ty_fail(context, TY_ERROR_ARGUMENT, "diffusion: size: it is not that of the rank's box");
    return TY_OK;
}

static ty_result check_boundaries(ty_context* context, const ty_diffusion_def* def) {
    for (int side = 0; side < 6; ++side)
        if (def->boundary[side].kind < 0 || def->boundary[side].kind >= TY_BOUNDARY_COUNT)
            return ty_fail(context, TY_ERROR_ARGUMENT, "diffusion: boundary[%d]: %d is no kind of boundary", side,
                           (int)def->boundary[side].kind);
    return TY_OK;
}

static ty_result check(ty_context* context, const ty_diffusion_def* def, const ty_diffusion_out* out) {
    ty_result result = check_size(context, def);
    if (result == TY_OK) result = check_boundaries(context, def);
    if (result == TY_OK) result = check_domain(context, def);
    if (result != TY_OK) return result;
    if (def->extinction == NULL || def->source == NULL || out->fluence == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "diffusion: there is no extinction, source or place for the fluence");
    if (def->limiter < 0 || def->limiter >= TY_LIMITER_COUNT)
        return ty_fail(context, TY_ERROR_ARGUMENT, "diffusion: limiter: there is none with number %d",
                       (int)def->limiter);
    if (def->solver < 0 || def->solver >= TY_DIFFUSION_SOLVER_COUNT)
        return ty_fail(context, TY_ERROR_ARGUMENT, "diffusion: solver: there is none with number %d", (int)def->solver);
    if (!(def->larsen_power >= 1 && def->larsen_power <= 100))
        return ty_fail(context, TY_ERROR_ARGUMENT, "diffusion: larsen_power: %g is outside [1, 100]",
                       def->larsen_power);
    if (!(def->streaming > 0 && def->streaming <= 1))
        return ty_fail(context, TY_ERROR_ARGUMENT, "diffusion: streaming: %g is outside (0, 1]", def->streaming);
    if (!(def->relaxation > 0 && def->relaxation < 2))
        return ty_fail(context, TY_ERROR_ARGUMENT, "diffusion: relaxation: %g is outside (0, 2)", def->relaxation);
    if (!(def->tolerance > 0 && def->tolerance < 1))
        return ty_fail(context, TY_ERROR_ARGUMENT, "diffusion: tolerance: %g is outside (0, 1)", def->tolerance);
    if (def->faces != NULL && def->solver != TY_DIFFUSION_MULTIGRID)
        return ty_fail(context, TY_ERROR_ARGUMENT, "diffusion: solver: surfaces need multigrid");
    if (!(def->min_extinction >= 0) || def->iterations < 0 || def->min_iterations < 0)
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "diffusion: min_extinction, iterations and min_iterations are at least 0");
    return TY_OK;
}

/* ---- scaling ---- */

/* Approximate incident flux of a boundary face, W m^-2. */
static double incident_flux(const ty_boundary* boundary, ptrdiff_t face) {
    if (boundary->value == NULL || boundary->kind == TY_BOUNDARY_REFLECTING) return 0;
    const double value = fabs((double)boundary->value[face]);
    return boundary->kind == TY_BOUNDARY_DIRICHLET ? 0.25 * value : value;
}

static double source_square(const ty_diffusion_def* def, const ty_box* box, int32_t x, int32_t y, int32_t z) {
    const int32_t at[3] = {x, y, z};
    double source = (double)def->source[ty_box_dense(box, y, z) + x];
    for (int side = 0; side < 6; ++side) {
        const int axis = side / 2;
        if (at[axis] != ((side & 1) != 0 ? box->size[axis] - 1 : 0) || !ty_box_ends(box, side)) continue;
        int32_t faces[2];
        ty_solve_side_faces(box, side, faces);
        const ptrdiff_t face = (ptrdiff_t)at[axis == 2 ? 1 : 2] * faces[0] + at[axis == 0 ? 1 : 0];
        source += incident_flux(&def->boundary[side], face) / def->cell[axis];
    }
    return source * source;
}

/* Light of the sides in a row's cell x, W m^-3; *side: the next one of the row. */
static double sides_source(const ty_diffusion_def* def, int32_t x, int32_t end, int32_t* side) {
    double source = 0;
    for (; *side < end && def->faces->x[*side] == x; ++*side)
        source += ty_diffusion_faces_source(def->faces, def->cell, *side);
    return source;
}

static double surfaces_square(const ty_diffusion_def* def, const ty_box* box, int32_t y, int32_t z) {
    const ptrdiff_t row = ty_box_dense(box, y, z) / box->size[0];
    int32_t side = def->faces->first[row];
    double sum = 0;
    for (int32_t x = 0; x < box->size[0]; ++x) {
        const double source = sides_source(def, x, def->faces->first[row + 1], &side);
        sum += source * source;
    }
    return sum;
}

static void square_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const ty_diffusion_job* job = user;
    const ty_box* box = &job->cells.box;
    double sum = 0;
    for (int32_t y = 0; y < box->size[1]; ++y) {
        for (int32_t x = 0; x < box->size[0]; ++x) sum += source_square(job->def, box, x, y, (int32_t)index);
        if (job->def->faces != NULL) sum += surfaces_square(job->def, box, y, (int32_t)index);
    }
    job->sums[index].a = sum;
}

/* Rms of the sources, including the incident flux of boundaries, W m^-3. */
static double source_rms(ty_diffusion_job* job) {
    const ty_box* box = &job->cells.box;
    ty_solve_planes(job, box, square_plane, job);
    return sqrt(ty_solve_sum(job, box).a / (double)ty_box_whole_cells(box));
}

static void set_side(ty_diffusion_job* job, int side) {
    const ty_boundary* boundary = &job->def->boundary[side];
    const double cell = job->def->cell[side / 2];
    ty_side* to = &job->cells.sides[side];
    to->kind = boundary->kind;
    to->a = boundary->kind == TY_BOUNDARY_REFLECTING ? 0 : (float)(2 / (cell * cell));
    to->b = boundary->kind == TY_BOUNDARY_MARSHAK ? (float)(4 / cell) : 0;
    if (boundary->value == NULL || boundary->kind == TY_BOUNDARY_REFLECTING) return;
    int32_t faces[2];
    ty_solve_side_faces(&job->cells.box, side, faces);
    /* Marshak boundary: net flux phi / 2 - 2 incident flux = (phi - 4 incident flux) / 2. */
    const float factor = job->cells.scale * (boundary->kind == TY_BOUNDARY_MARSHAK ? 4 : 1);
    float* value = (float*)to->value;
    for (ptrdiff_t i = 0; i < (ptrdiff_t)faces[0] * faces[1]; ++i) value[i] = boundary->value[i] * factor;
}

void ty_solve_set_cells(ty_diffusion_job* job, double rms) {
    const ty_diffusion_def* def = job->def;
    ty_cells* cells = &job->cells;
    double longest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        cells->half_inverse[axis] = (float)(0.5 / (def->streaming * def->cell[axis]));
        cells->coupling[axis] = (float)(0.5 / (def->cell[axis] * def->cell[axis]));
        longest = fmax(longest, def->cell[axis] * cells->box.whole[axis]);
    }
    cells->extinction = def->extinction;
    cells->absorption = def->absorption;
    cells->source = def->source;
    cells->min_extinction = (float)(def->min_extinction > 0 ? def->min_extinction : 1e-3 / longest);
    cells->scale = (float)(1 / rms);
    cells->limiter = def->limiter;
    cells->larsen_power = (float)def->larsen_power;
    for (int side = 0; side < 6; ++side) set_side(job, side);
}

/* Initial fluence without a start, for sources with rms 1: epsilon (Algorithm 1), but for multigrid or boundaries with
 * incident flux, the magnitude of a source integrated over the box's length. A dark box is also a solution, in which
 * nothing diffuses. */
static double initial_fluence(const ty_diffusion_def* def) {
    bool has_magnitude = def->solver == TY_DIFFUSION_MULTIGRID;
    for (int side = 0; side < 6; ++side) has_magnitude = has_magnitude || def->boundary[side].value != NULL;
    const double shortest = fmin(fmin(def->cell[0], def->cell[1]), def->cell[2]);
    return has_magnitude ? shortest * (double)def->size[0] : 1e-20 * shortest;
}

static void set_phi(ty_diffusion_job* job) {
    const ty_box* box = &job->cells.box;
    const ty_diffusion_def* def = job->def;
    const double first = initial_fluence(def), min_phi = fmin(first, 1e-20);
    for (int32_t z = 0; z < box->size[2]; ++z)
        for (int32_t y = 0; y < box->size[1]; ++y) {
            const ptrdiff_t at = ty_box_at(box, y, z), dense = ty_box_dense(box, y, z);
            for (int32_t x = 0; x < box->size[0]; ++x) {
                double phi = def->start != NULL ? (double)def->start[dense + x] * (double)job->cells.scale : first;
                if (!(phi > min_phi) && def->limiter != TY_LIMITER_NONE) phi = min_phi;
                if (def->solver == TY_DIFFUSION_SOR_FLOAT)
                    ((float*)job->phi)[at + x] = (float)phi;
                else
                    ((double*)job->phi)[at + x] = phi;
            }
        }
}

/* ---- solve ---- */

void ty_solve_tasks(const ty_diffusion_job* job, const ty_box* box, int64_t count, ty_parallel_fn body, void* user) {
    ty_parallel_flushed(ty_box_cells(box) >= CELLS_FOR_THREADS ? job->context : NULL, count, body, user);
}

void ty_solve_planes(const ty_diffusion_job* job, const ty_box* box, ty_parallel_fn body, void* user) {
    ty_solve_tasks(job, box, box->size[2], body, user);
}

ty_plane_sums ty_solve_sum(const ty_diffusion_job* job, const ty_box* box) {
    if (box->cut != 0 && job->domain != NULL) return ty_divided_sum(job, box);
    ty_plane_sums total = {0};
    for (int32_t z = 0; z < box->size[2]; ++z) {
        total.a += job->sums[z].a;
        total.b += job->sums[z].b;
        total.c += job->sums[z].c;
    }
    return total;
}

void ty_solve_count(const ty_diffusion_job* job, const ty_box* box, double passes) {
    job->stats->work += passes * (double)ty_box_whole_cells(box) / (double)ty_box_whole_cells(&job->cells.box);
}

/* False if the caller cancels. */
static bool report(ty_diffusion_job* job, double residual) {
    const ty_diffusion_def* def = job->def;
    if (def->progress == NULL || !ty_report_due(&job->reported)) return true;
    /* Residuals decrease about geometrically. */
    const double done = residual > 0 && residual < 1 ? fmin(log(residual) / log(def->tolerance), 1) : 0;
    const ty_progress progress = ty_progress_at("fluence", done, job->reported - job->start);
    return def->progress(def->progress_user, &progress);
}

static ty_result lost_rank(const ty_diffusion_job* job) {
    const int32_t lost = job->domain != NULL ? ty_comm_lost(job->domain->comm) : -1;
    return lost < 0 ? TY_OK : ty_fail(job->context, TY_ERROR_UNSUPPORTED, "rank %d does not answer", (int)lost);
}

ty_result ty_solve_note(ty_diffusion_job* job, double residual) {
    ty_diffusion_stats* stats = job->stats;
    const ty_diffusion_def* def = job->def;
    if (job->out->history != NULL && stats->history_count < job->out->history_capacity)
        job->out->history[stats->history_count++] = residual;
    stats->residual = residual;
    stats->converged = residual <= def->tolerance;
    const bool cancelled = ty_divided_any(job, !report(job, residual));
    const ty_result result = lost_rank(job);
    return result == TY_OK && cancelled ? TY_CANCELLED : result;
}

void ty_solve_choose_kernels(ty_diffusion_job* job) {
    job->cell_kernels = TY_BEST_KERNELS(ty_cell_kernels);
    job->level_kernels = TY_BEST_KERNELS(ty_level_kernels);
    job->stage_kernels = TY_BEST_KERNELS(ty_fas_kernels);
}

static ty_result solve(ty_diffusion_job* job) {
    const double rms = source_rms(job);
    if (!isfinite(rms)) return ty_fail(job->context, TY_ERROR_ARGUMENT, "diffusion: the source is not finite");
    ty_solve_set_cells(job, rms > 0 ? rms : 1);
    if (!(rms > 0)) {
        job->stats->converged = true;
        ty_solve_store_dark(job);
        return TY_OK;
    }
    set_phi(job);
    const ty_result result = job->def->faces != NULL                      ? ty_solve_closed(job)
                             : job->def->solver == TY_DIFFUSION_MULTIGRID ? ty_solve_picard(job)
                                                                          : ty_solve_sor(job);
    if (result == TY_OK || result == TY_CANCELLED) ty_solve_store(job);
    return result == TY_OK ? lost_rank(job) : result;
}

ty_result ty_diffusion_solve(ty_context* context, const ty_diffusion_def* def, const ty_diffusion_out* out,
                             ty_diffusion_stats* stats) {
    ty_result result = check(context, def, out);
    if (result != TY_OK) return result;
    ty_diffusion_stats ignored;
    ty_diffusion_job job = {.context = context, .def = def, .out = out, .stats = stats != NULL ? stats : &ignored};
    *job.stats = (ty_diffusion_stats){0};
    job.start = job.reported = ty_wall_seconds();
    ty_solve_choose_kernels(&job);
    const size_t bytes = ty_diffusion_memory(def);
    char* memory = def->memory != NULL ? def->memory : ty_alloc_array(context, bytes, 1, false);
    job.domain = def->domain;
    if (ty_divided_any(&job, memory == NULL)) {
        if (def->memory == NULL) ty_free_array(context, memory, bytes, 1);
        return TY_ERROR_MEMORY;
    }
    job.stats->ranks = def->domain != NULL ? ty_comm_size(def->domain->comm) : 1;
    job.stats->bytes = (double)bytes;
    memset(memory, 0, bytes); /* initial ghosts are 0 */
    ty_arena arena = {.base = memory};
    ty_solve_lay_out(&job, &arena);
    result = solve(&job);
    if (def->memory == NULL) ty_free_array(context, memory, bytes, 1);
    job.stats->seconds = ty_wall_seconds() - job.start;
    return result;
}
