/* Full approximation scheme (FAS): the nonlinear problem on the boxes of the multigrid levels. Errors that vary slowly
 * along streaming light are nearly invisible to Picard iterations, whose D diffuses where the light is advected; on
 * coarse cells they vary fast and are visible. A coarse stage starts from means of phi, with a source that makes them
 * its solution where the finer stage has no residuals; the finer phi is multiplied by the relative change of the coarse
 * one. Coarse cells have the mean of their children's mean free paths, not of their extinctions: vacuum stays vacuum.
 */
#include "solve/diffusion/divided/divided.h"

#include <string.h>

/* Sweeps of Algorithm 1 after a Picard step. */
enum { SWEEPS = 2 };

typedef struct fas_work {
    const ty_diffusion_job* job;
    const ty_fas_level *fine, *coarse;
    const ty_level* level; /* of the finer stage */
    const float* change;   /* of its phi */
} fas_work;

/* ---- cells ---- */

void ty_fas_lay_out(ty_diffusion_job* job, ty_arena* arena) {
    job->stage_count = 1;
    for (int32_t i = 1; i < job->level_count && ty_box_cells(&job->levels[i].box) > 1; ++i) {
        ty_fas_level* stage = &job->stages[i];
        *stage = (ty_fas_level){.cells = {.box = job->levels[i].box}};
        memcpy(stage->children, job->levels[i].children, sizeof stage->children);
        const ty_box* box = &stage->cells.box;
        const size_t cells = (size_t)ty_box_cells(box);
        stage->phi = ty_solve_take_box(arena, box, sizeof(double));
        stage->diffusivity = ty_solve_take_box(arena, box, sizeof(float));
        stage->restricted = ty_solve_take_box(arena, box, sizeof(float));
        float** const dense[] = {&stage->extinction, &stage->absorption, &stage->source};
        for (int a = 0; a < 3; ++a) *dense[a] = ty_arena_take(arena, sizeof(float) * cells);
        for (int side = 0; side < 6; ++side) ty_solve_take_side(arena, box, side, &stage->cells.sides[side]);
        job->stage_count = i + 1;
    }
}

/* Means of the boundary values. */
static void fill_side(const ty_fas_level* fine, const ty_fas_level* coarse, int side) {
    const int axis = side / 2, u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    const ty_side *from = &fine->cells.sides[side], *to = &coarse->cells.sides[side];
    const int32_t *size = coarse->cells.box.size, *fine_size = fine->cells.box.size, *n = coarse->children;
    for (int32_t j = 0; j < size[v]; ++j)
        for (int32_t i = 0; i < size[u]; ++i) {
            float sum = 0, count = 0;
            for (int32_t fj = j * n[v]; fj < (j + 1) * n[v] && fj < fine_size[v]; ++fj)
                for (int32_t fi = i * n[u]; fi < (i + 1) * n[u] && fi < fine_size[u]; ++fi) {
                    sum += from->value[from->step * fj + fi];
                    count += 1;
                }
            ((float*)to->value)[to->step * j + i] = sum / count;
        }
}

/* Conditions of a stage's sides. */
static void set_sides(const ty_fas_level* fine, ty_fas_level* coarse) {
    for (int side = 0; side < 6; ++side) {
        const ty_side* from = &fine->cells.sides[side];
        ty_side* to = &coarse->cells.sides[side];
        const float ratio = (float)coarse->children[side / 2];
        to->kind = from->kind;
        to->a = from->a / (ratio * ratio);
        to->b = from->b / ratio;
    }
}

static void restrict_media_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const fas_work* w = user;
    w->job->stage_kernels->restrict_media(w->fine, w->coarse, (int32_t)index);
}

static void set_stage_cells(const ty_fas_level* fine, ty_fas_level* coarse) {
    ty_cells* cells = &coarse->cells;
    const ty_cells* from = &fine->cells;
    for (int axis = 0; axis < 3; ++axis) {
        const float ratio = (float)coarse->children[axis];
        cells->half_inverse[axis] = from->half_inverse[axis] / ratio;
        cells->coupling[axis] = from->coupling[axis] / (ratio * ratio);
    }
    cells->extinction = coarse->extinction;
    cells->absorption = coarse->absorption;
    cells->source = coarse->source;
    cells->min_extinction = from->min_extinction;
    cells->zeros = from->zeros;
    cells->scale = 1;
    cells->limiter = from->limiter;
    cells->larsen_power = from->larsen_power;
    set_sides(fine, coarse);
}

/* Media and boundary values of stage i. */
static void fill_stage(ty_diffusion_job* job, int32_t i) {
    ty_fas_level* stage = &job->stages[i];
    const ty_fas_level* fine = &job->stages[i - 1];
    set_stage_cells(fine, stage);
    fas_work w = {.job = job, .fine = fine, .coarse = ty_divided_coarse_stage(job, i - 1)};
    for (int side = 0; side < 6; ++side)
        if (ty_box_ends(&w.coarse->cells.box, side)) fill_side(fine, w.coarse, side);
    ty_solve_planes(job, &w.coarse->cells.box, restrict_media_plane, &w);
    ty_solve_count(job, &fine->cells.box, 1);
    if (!ty_divided_gathers(job, i - 1)) return;
    ty_divided_gather(job, (float*[]){stage->extinction, stage->absorption, stage->source}, 3, false);
    for (int side = 0; side < 6; ++side)
        if (job->def->boundary[side].value != NULL) ty_divided_gather_side(job, side);
}

void ty_fas_restrict_cells(ty_diffusion_job* job) {
    job->stages[0] =
        (ty_fas_level){.cells = job->cells, .children = {1, 1, 1}, .phi = job->phi, .diffusivity = job->diffusivity};
    for (int32_t i = 1; i < job->stage_count; ++i) fill_stage(job, i);
}

/* ---- Picard step ---- */

static void ghosts_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const fas_work* w = user;
    w->job->cell_kernels->ghosts(&w->fine->cells, w->fine->phi, (int32_t)index);
}

static void diffuse_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const fas_work* w = user;
    w->job->cell_kernels->diffuse(&w->fine->cells, w->fine->phi, w->fine->diffusivity, (int32_t)index);
}

static void assemble_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const fas_work* w = user;
    w->job->sums[index].a =
        w->job->cell_kernels->assemble(&w->fine->cells, w->fine->phi, w->fine->diffusivity, w->level, (int32_t)index);
}

static void update_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const fas_work* w = user;
    w->job->cell_kernels->update(&w->fine->cells, w->change, w->fine->phi, (int32_t)index);
}

double ty_fas_linearise(ty_diffusion_job* job, int32_t i) {
    const ty_fas_level* stage = &job->stages[i];
    const ty_box* box = &stage->cells.box;
    fas_work w = {.job = job, .fine = stage, .level = &job->levels[i]};
    ty_solve_planes(job, box, ghosts_plane, &w);
    ty_divided_exchange_fluence(job, box, stage->phi, NULL);
    ty_solve_planes(job, box, diffuse_plane, &w);
    ty_divided_exchange(job, box, &stage->diffusivity, 1);
    ty_solve_planes(job, box, assemble_plane, &w);
    ty_solve_count(job, box, 2);
    return ty_solve_sum(job, box).a;
}

static void damp_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const fas_work* w = user;
    const ty_diffusion_job* job = w->job;
    job->cell_kernels->damp(&w->fine->cells, w->fine->diffusivity, job->damping, job->direction, (int32_t)index);
}

/* D for the linear problem: the stage's, damped if enabled. Coarser stages use the beginning of the same array. */
static const float* linear_diffusivity(const ty_diffusion_job* job, const ty_fas_level* stage) {
    if (!(job->damping > 0)) return stage->diffusivity;
    fas_work w = {.job = job, .fine = stage};
    ty_solve_planes(job, &stage->cells.box, damp_plane, &w);
    ty_solve_count(job, &stage->cells.box, 1);
    ty_divided_exchange(job, &stage->cells.box, &job->direction, 1);
    return job->direction;
}

void ty_fas_picard_step(ty_diffusion_job* job, int32_t i, double squares, double reduction, int32_t cycles) {
    const ty_fas_level* stage = &job->stages[i];
    ty_level* level = &job->levels[i];
    level->diffusivity = linear_diffusivity(job, stage);
    memcpy(level->coupling, stage->cells.coupling, sizeof level->coupling);
    ty_multigrid_coarsen(job, i);
    const float* change = ty_multigrid_solve(job, i, squares, squares * reduction * reduction, cycles);
    fas_work w = {.job = job, .fine = stage, .change = change};
    ty_solve_planes(job, &stage->cells.box, update_plane, &w);
    ty_solve_count(job, &stage->cells.box, 1);
}

/* ---- transfer between stages ---- */

static void restrict_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const fas_work* w = user;
    w->job->stage_kernels->restrict_phi(w->fine, w->level->f, w->coarse, (int32_t)index);
}

static void fas_source_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const fas_work* w = user;
    w->job->stage_kernels->set_fas_source(w->fine, w->level->f, (int32_t)index);
}

static void relative_change_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const fas_work* w = user;
    w->job->stage_kernels->relative_change(w->coarse, (int32_t)index);
}

static void correct_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const fas_work* w = user;
    w->job->stage_kernels->correct(w->fine, w->coarse, (int32_t)index);
}

/* Corrects phi of stage i - 1 by the relative change of stage i. */
static void prolong_change(const ty_diffusion_job* job, int32_t i) {
    const ty_fas_level* stage = &job->stages[i];
    fas_work w = {.job = job, .fine = &job->stages[i - 1], .coarse = stage};
    ty_solve_planes(job, &stage->cells.box, relative_change_plane, &w);
    ty_divided_exchange(job, &stage->cells.box, &stage->restricted, 1);
    w.coarse = ty_divided_coarse_stage(job, i - 1);
    ty_solve_planes(job, &w.fine->cells.box, correct_plane, &w);
    ty_solve_count(job, &w.fine->cells.box, 1);
}

/* Picard step with one cycle: with more, iterations can oscillate instead of converging. */
static void smooth(ty_diffusion_job* job, int32_t i) {
    ty_fas_picard_step(job, i, ty_fas_linearise(job, i), 0, 1);
    for (int sweep = 0; job->damping > 0 && sweep < SWEEPS; ++sweep) ty_fas_relax(job, i, TY_SOR_OMEGA, TY_RELAX_ALL);
}

/* Smooths before and after the coarse-level correction. */
static void visit(ty_diffusion_job* job, int32_t i) {
    smooth(job, i);
    if (i + 1 == job->stage_count) return;
    if (job->def->limiter != TY_LIMITER_NONE) {
        ty_fas_linearise(job, i);
        ty_fas_correct(job, i);
    }
    smooth(job, i);
}

/* The first whole stage from all ranks' parts of it. */
static void gather_restricted(const ty_diffusion_job* job, const ty_fas_level* stage) {
    const ty_box* box = &stage->cells.box;
    ty_divided_gather(job, &stage->restricted, 1, true);
    ty_divided_gather(job, &stage->source, 1, false);
    for (int32_t z = 0; z < box->size[2]; ++z)
        for (int32_t y = 0; y < box->size[1]; ++y) {
            const ptrdiff_t at = ty_box_at(box, y, z);
            for (int32_t x = 0; x < box->size[0]; ++x) stage->phi[at + x] = (double)stage->restricted[at + x];
        }
}

void ty_fas_correct(ty_diffusion_job* job, int32_t i) {
    if (i + 1 >= job->stage_count) return;
    const ty_fas_level *fine = &job->stages[i], *coarse = &job->stages[i + 1];
    fas_work down = {.job = job, .fine = fine, .coarse = ty_divided_coarse_stage(job, i), .level = &job->levels[i]};
    ty_solve_planes(job, &down.coarse->cells.box, restrict_plane, &down);
    ty_solve_count(job, &fine->cells.box, 1);
    if (ty_divided_gathers(job, i)) gather_restricted(job, coarse);
    ty_fas_linearise(job, i + 1);
    fas_work here = {.job = job, .fine = coarse, .level = &job->levels[i + 1]};
    ty_solve_planes(job, &coarse->cells.box, fas_source_plane, &here);
    visit(job, i + 1);
    prolong_change(job, i + 1);
}

static void set_stage(const ty_fas_level* stage, double first) {
    const ty_box* box = &stage->cells.box;
    for (int32_t z = 0; z < box->size[2]; ++z)
        for (int32_t y = 0; y < box->size[1]; ++y) {
            double* phi = stage->phi + ty_box_at(box, y, z);
            for (int32_t x = 0; x < box->size[0]; ++x) phi[x] = first;
        }
}

static void set_expected(const ty_fas_level* stage, double first) {
    const ty_box* box = &stage->cells.box;
    for (int32_t z = 0; z < box->size[2]; ++z)
        for (int32_t y = 0; y < box->size[1]; ++y) {
            float* restricted = stage->restricted + ty_box_at(box, y, z);
            for (int32_t x = 0; x < box->size[0]; ++x) restricted[x] = (float)first;
        }
}

void ty_fas_full_multigrid(ty_diffusion_job* job, double first) {
    for (int32_t i = 1; i < job->stage_count; ++i) set_stage(&job->stages[i], (double)(float)first);
    for (int32_t i = job->stage_count - 1; i > 0; --i) {
        visit(job, i);
        set_expected(&job->stages[i], first);
        prolong_change(job, i);
    }
}
