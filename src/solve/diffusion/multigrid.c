/* Multigrid for the linearised problem. Red-black Gauss-Seidel; corrections are constant in a coarse cell, and its
 * couplings half the sums of those between its children: the energy of such corrections, for centres twice as far
 * apart. That holds for jumps of any size, where linear corrections and resistors in series do not; what it costs on
 * smooth media, visiting coarse levels twice gives back. Where cycles gain little, as half the couplings are wrong for
 * cells that hardly exchange anything with others, symmetric ones go on as preconditioner of conjugate gradients. Any
 * size: an odd axis ends with a coarse cell of one child. Axes with long cells are coarsened later than those with
 * short ones. */
#include "solve/diffusion/job.h"

#include <string.h>

/* Sweeps over a level that has no coarser one; planes of a level that one task relaxes. */
enum { LAST_SWEEPS = 4, SLAB = 16 };
/* What a cycle leaves of a sum of squares: where nothing is known yet, and where conjugate gradients take over. */
static const double EXPECTED = 0.25, SLOW = 0.5;
/* Cells this much longer than the shortest are not coarsened yet. */
static const double LONG = 1.5;

typedef struct pass {
    const ty_diffusion_job* job;
    const ty_level *fine, *coarse;
    int32_t color, first; /* first: the level that cycles begin on */
    bool fresh;
    float factor; /* alpha or beta of conjugate gradients */
} pass;

/* ---- levels ---- */

static void take_level(ty_level* level, ty_arena* arena) {
    level->d = ty_solve_take_box(arena, &level->box, sizeof(float));
    level->e = ty_solve_take_box(arena, &level->box, sizeof(float));
    level->f = ty_solve_take_box(arena, &level->box, sizeof(float));
}

/* The next level's box; false when one cell is left. */
static bool coarsen_box(const ty_level* fine, double cell[3], ty_level* coarse) {
    double shortest = 0;
    for (int axis = 0; axis < 3; ++axis)
        if (fine->box.size[axis] > 1 && (shortest <= 0 || cell[axis] < shortest)) shortest = cell[axis];
    if (shortest <= 0) return false;
    int32_t size[3];
    for (int axis = 0; axis < 3; ++axis) {
        const bool halved = fine->box.size[axis] > 1 && cell[axis] < LONG * shortest;
        coarse->children[axis] = halved ? 2 : 1;
        size[axis] = halved ? (fine->box.size[axis] + 1) / 2 : fine->box.size[axis];
        if (halved) cell[axis] *= 2;
    }
    coarse->box = ty_box_make(size[0], size[1], size[2]);
    return true;
}

void ty_multigrid_lay_out(ty_diffusion_job* job, ty_arena* arena) {
    double cell[3];
    memcpy(cell, job->def->cell, sizeof cell);
    job->levels[0] = (ty_level){.box = job->cells.box, .children = {1, 1, 1}};
    take_level(&job->levels[0], arena);
    job->level_count = 1;
    while (job->level_count < TY_LEVELS_MAX) {
        ty_level* next = &job->levels[job->level_count];
        *next = (ty_level){0};
        if (!coarsen_box(next - 1, cell, next)) return;
        take_level(next, arena);
        for (int axis = 0; axis < 3; ++axis) next->g[axis] = ty_solve_take_box(arena, &next->box, sizeof(float));
        ++job->level_count;
    }
}

/* ---- cycles ---- */

static void relax_plane(const pass* p, int32_t color, int32_t z, bool alone) {
    if (p->fresh && color == p->color)
        p->job->level_kernels->begin(p->fine, color, z);
    else
        p->job->level_kernels->relax(p->fine, color, z, alone);
}

/* Both colours of a slab while its planes are in the cache: the second follows one plane behind the first. The planes
 * at either end of the slab wait for the first colour of its neighbours. */
static void relax_slab(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    const int32_t planes = p->fine->box.size[2], begin = (int32_t)index * SLAB;
    const int32_t end = begin + SLAB < planes ? begin + SLAB : planes;
    for (int32_t z = begin; z < end; ++z) {
        const bool seam = (z == begin && begin > 0) || (z == end - 1 && end < planes);
        relax_plane(p, p->color, z, !seam);
        if (z - 1 > begin || (z == 1 && begin == 0)) relax_plane(p, 1 - p->color, z - 1, true);
    }
    if (end == planes && (planes - 1 > begin || begin == 0)) relax_plane(p, 1 - p->color, planes - 1, true);
}

/* The second colour of the planes where slabs meet. */
static void relax_seam(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    const int32_t begin = ((int32_t)index + 1) * SLAB;
    relax_plane(p, 1 - p->color, begin - 1, true);
    relax_plane(p, 1 - p->color, begin, true);
}

static void restrict_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    p->job->sums[index].a = p->job->level_kernels->restrict_residual(p->fine, p->coarse, (int32_t)index);
}

static void prolong_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    p->job->level_kernels->prolong(p->fine, p->coarse, (int32_t)index);
}

static void coarsen_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    p->job->level_kernels->coarsen(p->fine, p->coarse, (int32_t)index);
}

/* fresh: e counts as 0. */
static void relax(const ty_diffusion_job* job, const ty_level* level, int32_t first, bool fresh) {
    pass p = {.job = job, .fine = level, .color = first, .fresh = fresh};
    const int32_t slabs = (level->box.size[2] + SLAB - 1) / SLAB;
    ty_solve_tasks(job, &level->box, slabs, relax_slab, &p);
    ty_solve_tasks(job, &level->box, slabs - 1, relax_seam, &p);
    ty_solve_count(job, &level->box, 1);
}

void ty_multigrid_coarsen(ty_diffusion_job* job, int32_t first) {
    for (int32_t i = first; i + 1 < job->level_count; ++i) {
        pass p = {.job = job, .fine = &job->levels[i], .coarse = &job->levels[i + 1]};
        ty_solve_planes(job, &p.coarse->box, coarsen_plane, &p);
        ty_solve_count(job, &p.fine->box, 1);
    }
}

/* Relaxation on the way up. Conjugate gradients need the way down mirrored; on its own a cycle gains more when no
 * colour is relaxed twice in a row. */
typedef struct way_up {
    int32_t color, sweeps;
} way_up;

static const way_up MIRRORED = {1, 1};

/* A second sweep pays where the problem is solved for good, not for a D that is about to change: iterations may swing
 * to and fro then. */
static way_up repeated(const ty_diffusion_job* job) {
    return (way_up){0, job->def->limiter == TY_LIMITER_NONE ? 2 : 1};
}

/* e of a level, from what it is, or from 0. Returns the sum of squares of what was left before coarser levels were
 * asked. */
static double cycle(const ty_diffusion_job* job, int32_t i, way_up up, bool fresh) {
    if (i + 1 == job->level_count) {
        for (int sweep = 0; sweep < LAST_SWEEPS; ++sweep) relax(job, &job->levels[i], sweep & 1, fresh && sweep == 0);
        return 0;
    }
    pass p = {.job = job, .fine = &job->levels[i], .coarse = &job->levels[i + 1]};
    relax(job, p.fine, 0, fresh);
    ty_solve_planes(job, &p.coarse->box, restrict_plane, &p);
    ty_solve_count(job, &p.fine->box, 1);
    const double squares = ty_solve_sum(job, p.coarse->box.size[2]).a;
    for (int visit = 0; visit < (i + 2 < job->level_count ? 2 : 1); ++visit) cycle(job, i + 1, up, visit == 0);
    ty_solve_planes(job, &p.fine->box, prolong_plane, &p);
    ty_solve_count(job, &p.fine->box, 1);
    for (int32_t sweep = 0; sweep < up.sweeps; ++sweep) relax(job, p.fine, up.color, false);
    return squares;
}

/* ---- conjugate gradients ---- */

static void dot_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    p->job->sums[index].a = p->job->level_kernels->dot(p->fine, (int32_t)index);
}

static void direct_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    p->job->level_kernels->direct(p->fine, p->factor, p->job->direction, (int32_t)index);
}

static void apply_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    p->job->sums[index].a = p->job->level_kernels->apply(p->fine, p->job->direction, (int32_t)index);
}

static void step_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    const ty_diffusion_job* job = p->job;
    job->sums[index].a = job->level_kernels->step(p->fine, p->factor, job->direction, job->change, (int32_t)index);
}

static double run(const pass* p, ty_parallel_fn body) {
    ty_solve_planes(p->job, &p->fine->box, body, (void*)p);
    ty_solve_count(p->job, &p->fine->box, 1);
    return ty_solve_sum(p->job, p->fine->box.size[2]).a;
}

static void clear(const ty_box* box, float* items) {
    memset(items - ty_box_origin(box), 0, sizeof(float) * ty_box_items(box));
}

/* Takes what e explains from f; returns the sum of squares of what is left. */
static double begin_gradients(const pass* whole) {
    const ty_diffusion_job* job = whole->job;
    const ty_box* box = &whole->fine->box;
    const ptrdiff_t origin = ty_box_origin(box);
    memcpy(job->direction - origin, whole->fine->e - origin, sizeof(float) * ty_box_items(box));
    clear(box, job->change);
    pass p = *whole;
    p.factor = 1;
    run(&p, apply_plane);
    return run(&p, step_plane);
}

/* Goes on from e; the result is in job->change. */
static void solve_gradients(const pass* whole, double target, int32_t cycles) {
    pass p = *whole;
    double squares = begin_gradients(&p), along = 0; /* f.e of the step before */
    clear(&p.fine->box, p.job->direction);
    for (int i = 0; i < cycles && squares > target; ++i) {
        cycle(p.job, p.first, MIRRORED, true);
        p.job->stats->cycles += p.first == 0 ? 1 : 0;
        const double next = run(&p, dot_plane);
        p.factor = i == 0 ? 0 : (float)(next / along);
        run(&p, direct_plane);
        const double curvature = run(&p, apply_plane);
        if (!(curvature > 0)) break;
        p.factor = (float)(next / curvature);
        along = next;
        squares = run(&p, step_plane);
    }
}

const float* ty_multigrid_solve(ty_diffusion_job* job, int32_t first, double squares, double target, int32_t cycles) {
    ty_level* level = &job->levels[first];
    const pass p = {.job = job, .fine = level, .first = first};
    const way_up up = repeated(job);
    const float* change = level->e;
    double before = 0, left = squares;
    for (int i = 0; i < cycles && left > target; ++i) {
        const double now = cycle(job, first, up, i == 0);
        job->stats->cycles += first == 0 ? 1 : 0;
        const double rate = i == 0 ? EXPECTED : before > 0 ? now / before : 0;
        left = (i == 0 ? squares : now) * rate;
        before = now;
        if (rate <= SLOW || i + 1 == cycles) continue;
        solve_gradients(&p, target, cycles - i - 1);
        change = job->change;
        break;
    }
    level->diffusivity = NULL;
    return change;
}
