/* Multigrid for the linearised problem, with red-black Gauss-Seidel smoothing. Corrections are constant in a coarse
 * cell, and coarse couplings are half the sums of those between the children: the energy of such corrections for
 * centers twice as far apart. This holds for coefficient jumps of any size, unlike linear interpolation and series
 * resistors; the loss on smooth media is regained by W-cycles. Where cycles converge slowly, as half the couplings are
 * wrong for cells with little exchange, symmetric cycles continue as preconditioner of conjugate gradients. Sizes are
 * arbitrary: an odd axis ends with a coarse cell of one child. Axes with long cells are coarsened later than those with
 * short ones (semicoarsening). */
#include "solve/diffusion/divided/divided.h"
#include "solve/diffusion/images.h"

#include <string.h>

/* Sweeps on the coarsest level; planes per relaxation task. */
enum { LAST_SWEEPS = 4, SLAB = 16 };
/* Reduction of a sum of squares per cycle: assumed for the first, and above which conjugate gradients take over. */
static const double EXPECTED_RATE = 0.25, SLOW_RATE = 0.5;
/* Cells longer than the shortest by this factor are not coarsened yet. */
static const double LONG_RATIO = 1.5;

typedef struct pass {
    const ty_diffusion_job* job;
    const ty_level *fine, *coarse;
    int32_t color, first; /* first: level on which cycles begin */
    bool fresh;
    float factor; /* alpha or beta of conjugate gradients */
} pass;

/* ---- levels ---- */

static void allocate_level(ty_level* level, ty_arena* arena) {
    level->d = ty_solve_take_box(arena, &level->box, sizeof(float));
    level->e = ty_solve_take_box(arena, &level->box, sizeof(float));
    level->f = ty_solve_take_box(arena, &level->box, sizeof(float));
}

bool ty_multigrid_coarsen_size(int32_t size[3], double cell[3], int32_t children[3]) {
    double shortest = 0;
    for (int axis = 0; axis < 3; ++axis)
        if (size[axis] > 1 && (shortest <= 0 || cell[axis] < shortest)) shortest = cell[axis];
    if (shortest <= 0) return false;
    for (int axis = 0; axis < 3; ++axis) {
        const bool halved = size[axis] > 1 && cell[axis] < LONG_RATIO * shortest;
        children[axis] = halved ? 2 : 1;
        if (!halved) continue;
        size[axis] = (size[axis] + 1) / 2;
        cell[axis] *= 2;
    }
    return true;
}

void ty_multigrid_lay_out(ty_diffusion_job* job, ty_arena* arena) {
    double cell[3];
    int32_t size[3], ratio[3] = {1, 1, 1};
    memcpy(cell, job->def->cell, sizeof cell);
    memcpy(size, job->cells.box.whole, sizeof size);
    job->levels[0] = (ty_level){.box = job->cells.box, .children = {1, 1, 1}};
    allocate_level(&job->levels[0], arena);
    for (int axis = 0; axis < 3 && job->def->faces != NULL; ++axis)
        job->levels[0].g[axis] = ty_solve_take_box(arena, &job->cells.box, sizeof(float));
    job->level_count = 1;
    while (job->level_count < TY_LEVELS_MAX) {
        ty_level* next = &job->levels[job->level_count];
        *next = (ty_level){0};
        if (!ty_multigrid_coarsen_size(size, cell, next->children)) return;
        for (int axis = 0; axis < 3; ++axis) ratio[axis] *= next->children[axis];
        next->box = ty_divided_box(job, size, ratio, job->level_count < job->divided);
        allocate_level(next, arena);
        for (int axis = 0; axis < 3; ++axis) next->g[axis] = ty_solve_take_box(arena, &next->box, sizeof(float));
        ++job->level_count;
    }
}

/* ---- cycles ---- */

/* True if planes z and z - 1, or z + 1, are of different slabs. */
static bool is_at_seam(const ty_box* box, int32_t z) {
    return (z % SLAB == 0 && z > 0) || (z % SLAB == SLAB - 1 && z + 1 < box->size[2]);
}

/* True if another rank has plane z - 1 or z + 1. */
static bool is_at_cut(const ty_box* box, int32_t z) {
    return (z == 0 && !ty_box_ends(box, 4)) || (z + 1 == box->size[2] && !ty_box_ends(box, 5));
}

/* First colour of a plane. */
static void relax_first(const pass* p, int32_t z) {
    const ty_box* box = &p->fine->box;
    const int32_t rows[2] = {0, box->size[1]};
    if (p->fresh)
        p->job->level_kernels->begin(p->fine, p->color, rows, z);
    else
        p->job->level_kernels->relax(p->fine, p->color, rows, z, !is_at_seam(box, z));
}

/* Rows between those beside cuts along y. */
static void inner_rows(const ty_box* box, int32_t rows[2]) {
    rows[0] = ty_box_ends(box, 2) ? 0 : 1;
    rows[1] = ty_box_ends(box, 3) ? box->size[1] : box->size[1] - 1;
    if (rows[1] < rows[0]) rows[1] = rows[0];
}

/* Second colour of a plane that does not wait for other ranks. */
static void relax_second(const pass* p, int32_t z) {
    int32_t rows[2];
    inner_rows(&p->fine->box, rows);
    if (!is_at_cut(&p->fine->box, z)) p->job->level_kernels->relax(p->fine, 1 - p->color, rows, z, true);
}

/* Both colours of a slab while its planes are in the cache: the second colour follows one plane behind the first.
 * Planes at the seams between slabs wait for the first colour of their neighbours. */
static void relax_slab(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    const ty_box* box = &p->fine->box;
    const int32_t begin = (int32_t)index * SLAB;
    const int32_t end = begin + SLAB < box->size[2] ? begin + SLAB : box->size[2];
    for (int32_t z = begin; z < end; ++z) {
        relax_first(p, z);
        if (z > begin && !is_at_seam(box, z - 1)) relax_second(p, z - 1);
    }
    if (!is_at_seam(box, end - 1)) relax_second(p, end - 1);
}

/* Second colour of the planes at a seam. */
static void relax_seam(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    const int32_t begin = ((int32_t)index + 1) * SLAB;
    relax_second(p, begin - 1);
    relax_second(p, begin);
}

/* Second colour of the cells of a slab beside cuts, once the neighbours' first one is there. */
static void relax_beside_cuts(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    const ty_box* box = &p->fine->box;
    const ty_level_kernels* kernels = p->job->level_kernels;
    const int32_t begin = (int32_t)index * SLAB, rows = box->size[1];
    int32_t inner[2];
    inner_rows(box, inner);
    for (int32_t z = begin; z < begin + SLAB && z < box->size[2]; ++z) {
        const bool all = is_at_cut(box, z), seam = is_at_seam(box, z);
        kernels->relax(p->fine, 1 - p->color, (int32_t[]){0, all ? rows : inner[0]}, z, !seam);
        if (!all) kernels->relax(p->fine, 1 - p->color, (int32_t[]){inner[1], rows}, z, !seam);
    }
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

static void clear(const ty_box* box, float* items) {
    memset(items - ty_box_origin(box), 0, sizeof(float) * ty_box_items(box));
}

/* fresh: take e as 0; otherwise its layers beyond cuts are those of the neighbours, as they are afterwards. */
static void relax(const ty_diffusion_job* job, const ty_level* level, int32_t first, bool fresh) {
    pass p = {.job = job, .fine = level, .color = first, .fresh = fresh};
    const int32_t slabs = (level->box.size[2] + SLAB - 1) / SLAB;
    if (fresh && job->def->periodic != 0) clear(&level->box, level->e);
    ty_solve_tasks(job, &level->box, slabs, relax_slab, &p);
    ty_solve_tasks(job, &level->box, slabs - 1, relax_seam, &p);
    if (level->box.cut != 0) {
        ty_divided_exchange(job, &level->box, &level->e, 1);
        ty_solve_tasks(job, &level->box, slabs, relax_beside_cuts, &p);
    }
    ty_divided_exchange(job, &level->box, &level->e, 1);
    ty_solve_count(job, &level->box, 1);
}

void ty_multigrid_coarsen(ty_diffusion_job* job, int32_t first) {
    for (int32_t i = first; i + 1 < job->level_count; ++i) {
        pass p = {.job = job, .fine = &job->levels[i], .coarse = ty_divided_coarse_level(job, i)};
        ty_level* coarse = &job->levels[i + 1];
        ty_solve_planes(job, &p.coarse->box, coarsen_plane, &p);
        if (ty_divided_gathers(job, i))
            ty_divided_gather(job, (float*[]){coarse->d, coarse->g[0], coarse->g[1], coarse->g[2]}, 4, true);
        else
            ty_divided_exchange(job, &coarse->box, &coarse->g[1], 2);
        ty_diffusion_couple_images(job, coarse);
        ty_solve_count(job, &p.fine->box, 1);
    }
}

/* Post-smoothing. Conjugate gradients need the mirror image of the pre-smoothing; a stand-alone cycle converges faster
 * if no colour is relaxed twice in a row. */
typedef struct post_smoothing {
    int32_t color, sweeps;
} post_smoothing;

static const post_smoothing MIRRORED = {1, 1};

/* A second sweep pays for a linear problem, not for a D that is about to change: such iterations can oscillate. */
static post_smoothing choose_post_smoothing(const ty_diffusion_job* job) {
    return (post_smoothing){0, job->def->limiter == TY_LIMITER_NONE ? 2 : 1};
}

/* One cycle from the current e, or from 0. squares: the residual's sum of squares before the coarse-level correction;
 * NULL: not asked for. */
static void cycle(const ty_diffusion_job* job, int32_t i, post_smoothing post, bool fresh, double* squares) {
    if (i + 1 == job->level_count) {
        for (int sweep = 0; sweep < LAST_SWEEPS; ++sweep) relax(job, &job->levels[i], sweep & 1, fresh && sweep == 0);
        if (squares != NULL) *squares = 0;
        return;
    }
    pass p = {.job = job, .fine = &job->levels[i], .coarse = ty_divided_coarse_level(job, i)};
    relax(job, p.fine, 0, fresh);
    ty_solve_planes(job, &p.coarse->box, restrict_plane, &p);
    ty_solve_count(job, &p.fine->box, 1);
    if (squares != NULL) *squares = ty_solve_sum(job, &p.coarse->box).a;
    if (ty_divided_gathers(job, i)) ty_divided_gather(job, &job->levels[i + 1].f, 1, true);
    for (int visit = 0; visit < (i + 2 < job->level_count ? 2 : 1); ++visit) cycle(job, i + 1, post, visit == 0, NULL);
    ty_solve_planes(job, &p.fine->box, prolong_plane, &p);
    ty_divided_exchange(job, &p.fine->box, &p.fine->e, 1);
    ty_solve_count(job, &p.fine->box, 1);
    for (int32_t sweep = 0; sweep < post.sweeps; ++sweep) relax(job, p.fine, post.color, false);
}

/* ---- conjugate gradients ---- */

static void dot_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    p->job->sums[index].a = p->job->level_kernels->dot(p->fine, (int32_t)index);
}

static void direction_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const pass* p = user;
    p->job->level_kernels->update_direction(p->fine, p->factor, p->job->direction, (int32_t)index);
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

static double sum_planes(const pass* p, ty_parallel_fn body) {
    ty_solve_planes(p->job, &p->fine->box, body, (void*)p);
    ty_solve_count(p->job, &p->fine->box, 1);
    return ty_solve_sum(p->job, &p->fine->box).a;
}

/* Subtracts A e from f; returns the residual's sum of squares. */
static double begin_conjugate_gradients(const pass* initial) {
    const ty_diffusion_job* job = initial->job;
    const ty_box* box = &initial->fine->box;
    const ptrdiff_t origin = ty_box_origin(box);
    memcpy(job->direction - origin, initial->fine->e - origin, sizeof(float) * ty_box_items(box));
    clear(box, job->change);
    pass p = *initial;
    p.factor = 1;
    sum_planes(&p, apply_plane);
    return sum_planes(&p, step_plane);
}

/* Continues from e; the result is in job->change. */
static void conjugate_gradients(const pass* initial, double target, int32_t cycles) {
    pass p = *initial;
    double squares = begin_conjugate_gradients(&p), previous_product = 0; /* f.e of the previous step */
    clear(&p.fine->box, p.job->direction);
    for (int i = 0; i < cycles && squares > target; ++i) {
        cycle(p.job, p.first, MIRRORED, true, NULL);
        p.job->stats->cycles += p.first == 0 ? 1 : 0;
        const double next = sum_planes(&p, dot_plane);
        p.factor = i == 0 ? 0 : (float)(next / previous_product);
        ty_solve_planes(p.job, &p.fine->box, direction_plane, &p);
        ty_solve_count(p.job, &p.fine->box, 1);
        ty_divided_exchange(p.job, &p.fine->box, &p.job->direction, 1);
        const double curvature = sum_planes(&p, apply_plane);
        if (!(curvature > 0)) break;
        p.factor = (float)(next / curvature);
        previous_product = next;
        squares = sum_planes(&p, step_plane);
    }
}

const float* ty_multigrid_solve(ty_diffusion_job* job, int32_t first, double squares, double target, int32_t cycles) {
    ty_level* level = &job->levels[first];
    const pass p = {.job = job, .fine = level, .first = first};
    const post_smoothing post = choose_post_smoothing(job);
    const float* change = level->e;
    double previous = 0, remaining = squares;
    for (int i = 0; i < cycles && remaining > target; ++i) {
        double now;
        cycle(job, first, post, i == 0, &now);
        job->stats->cycles += first == 0 ? 1 : 0;
        const double rate = i == 0 ? EXPECTED_RATE : previous > 0 ? now / previous : 0;
        remaining = (i == 0 ? squares : now) * rate;
        previous = now;
        if (rate <= SLOW_RATE || i + 1 == cycles) continue;
        conjugate_gradients(&p, target, cycles - i - 1);
        change = job->change;
        break;
    }
    level->diffusivity = NULL;
    return change;
}
