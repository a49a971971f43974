/* Blockers between cells. */
#include "base/context.h"
#include "base/parallel.h"
#include "method/lpv/inject/inject.h"
#include "method/lpv/lattice/links.h"
#include "method/lpv/propagate/transfer.h"

#include <stdatomic.h>

/* Mode links: factor on the blocking area, so that a wall sampled by few rays still closes a link completely. */
static const float slack = 1.25f;

/* Offset of the cubes, in cells, so that rounding does not count a surface on the plane between two cubes for both. */
static const float nudge = 1e-3f;

/* Minimum distance, in cells, of a surface in front of a cell's center. */
static const float least_surface_depth = 0.01f;

/* Terms of the fuzzy blockers B (two bands). */
enum { BLOCKER_TERMS = 4 };

/* ---- cubes around corners of cells ---- */

/* Sums over the surfels in a cube around each corner of cells. */
enum { CORNER_AREA = BLOCKER_TERMS, CORNER_ALBEDO, CORNER_SUMS = CORNER_ALBEDO + 3 };

typedef struct block_job {
    ty_lattice* lattice;
    ty_lpv_mode mode;
    const ty_surfel* surfels;
    size_t count;
    ty_lpv_transfer transfer;      /* mode published */
    float (*corners)[CORNER_SUMS]; /* (size + 1) each way */
    _Atomic bool failed, blocked;
} block_job;

/* A grid of cubes as large as cells. */
typedef struct cube_grid {
    float lower[3], per_cell; /* m, 1/m */
    int32_t size[3];
} cube_grid;

/* The cubes shifted by `shift` (0 or 1) half cells towards lower coordinates. */
static cube_grid cubes_of(const ty_lattice* lattice, const int32_t shift[3]) {
    cube_grid out = {.per_cell = 1.0f / lattice->cell};
    for (int a = 0; a < 3; ++a) {
        out.lower[a] = (float)lattice->box.lower[a] - lattice->cell * (nudge + 0.5f * (float)shift[a]);
        out.size[a] = lattice->box.size[a] + shift[a];
    }
    return out;
}

/* The cube that contains a point; false outside. */
static bool cube_at(const cube_grid* cubes, ty_vec point, int32_t cube[3]) {
    const float at[3] = {point.x, point.y, point.z};
    for (int a = 0; a < 3; ++a) {
        const float place = (at[a] - cubes->lower[a]) * cubes->per_cell;
        if (!(place >= 0.0f && place < (float)cubes->size[a])) return false;
        cube[a] = (int32_t)place;
    }
    return true;
}

static size_t corner_index(const ty_lattice* lattice, int32_t x, int32_t y, int32_t z) {
    const size_t row = (size_t)y + (size_t)(lattice->box.size[1] + 1) * (size_t)z;
    return (size_t)x + (size_t)(lattice->box.size[0] + 1) * row;
}

static size_t corner_count(const ty_lattice* lattice) {
    const int32_t* size = lattice->box.size;
    return corner_index(lattice, size[0], size[1], size[2]) + 1;
}

static void add_corners(const block_job* job) {
    const cube_grid corners = cubes_of(job->lattice, (const int32_t[3]){1, 1, 1});
    const float per_face = 1.0f / (job->lattice->cell * job->lattice->cell);
    for (size_t i = 0; i < job->count; ++i) {
        const ty_surfel* surfel = &job->surfels[i];
        int32_t at[3];
        float y[TY_SH_TERMS];
        if (!cube_at(&corners, surfel->position, at)) continue;
        float* sums = job->corners[corner_index(job->lattice, at[0], at[1], at[2])];
        sums[CORNER_AREA] += surfel->area;
        for (int c = 0; c < 3; ++c) sums[CORNER_ALBEDO + c] += surfel->area * surfel->albedo[c];
        if (job->mode != TY_LPV_MODE_PUBLISHED) continue;
        /* Light that travels against the normal hits the surface. */
        ty_sh_at(ty_scale(surfel->normal, -1.0f), 2, y);
        for (int t = 0; t < BLOCKER_TERMS; ++t) sums[t] += surfel->area * per_face * ty_sh_cosine(ty_sh_band(t)) * y[t];
    }
}

/* Mean albedo of the surfaces within one cell of a cell's center. */
static void find_albedo(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const block_job* job = user;
    ty_lattice* lattice = job->lattice;
    const int32_t* size = lattice->box.size;
    const int32_t y = (int32_t)(row % size[1]), z = (int32_t)(row / size[1]);
    for (int32_t x = 0; x < size[0]; ++x) {
        float area = 0, albedo[3] = {0, 0, 0};
        for (int corner = 0; corner < 8; ++corner) {
            const float* sums =
                job->corners[corner_index(lattice, x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2))];
            area += sums[CORNER_AREA];
            for (int c = 0; c < 3; ++c) albedo[c] += sums[CORNER_ALBEDO + c];
        }
        for (int c = 0; c < 3; ++c)
            lattice->albedo[c][(size_t)row * (size_t)size[0] + (size_t)x] = area > 0.0f ? albedo[c] / area : 0.0f;
    }
}

static uint8_t quantized_transmission(block_job* job, float blocked) {
    if (blocked > 0.0f) atomic_store_explicit(&job->blocked, true, memory_order_relaxed);
    return (uint8_t)(255.0f * (1.0f - ty_clampf(blocked, 0.0f, 1.0f)) + 0.5f);
}

/* ---- mode links ---- */

/* Transmission of all links of one direction. A surfel belongs to the link whose midpoint is the center of its cube. */
static void close_links(void* user, int64_t link, int32_t worker) {
    (void)worker;
    block_job* job = user;
    ty_lattice* lattice = job->lattice;
    const ty_link_grid grid = ty_link_grid_of(lattice, (int32_t)link);
    const int32_t shift[3] = {abs(grid.step[0]), abs(grid.step[1]), abs(grid.step[2])};
    const ty_vec direction = ty_vec_make((float)grid.step[0], (float)grid.step[1], (float)grid.step[2]);
    const cube_grid cubes = cubes_of(lattice, shift);
    const float per_face = slack / (lattice->cell * lattice->cell);
    int32_t cube[3];
    float* covered = ty_alloc_array(lattice->context, grid.count, sizeof *covered, true);
    if (covered == NULL) {
        atomic_store(&job->failed, true);
        return;
    }
    for (size_t i = 0; i < job->count; ++i) {
        const float across = fabsf(ty_dot(job->surfels[i].normal, direction));
        if (!(across > 1e-4f) || !cube_at(&cubes, job->surfels[i].position, cube)) continue;
        covered[ty_link_at(&grid, cube)] += job->surfels[i].area * across * per_face;
    }
    const float* next = covered;
    for (cube[2] = 0; cube[2] < grid.size[2]; ++cube[2])
        for (cube[1] = 0; cube[1] < grid.size[1]; ++cube[1])
            for (cube[0] = 0; cube[0] < grid.size[0]; ++cube[0])
                ty_link_set(lattice, (int32_t)link, &grid, cube, quantized_transmission(job, *next++));
    ty_free_array(lattice->context, covered, grid.count, sizeof *covered);
}

/* ---- surfaces in front of cell centers ---- */

/* The cell that contains a surfel, and the surfel's distance in front of the center, in cells; false if it is not in
 * front, or outside the lattice. */
static bool is_before_center(const block_job* job, const cube_grid* cells, const ty_surfel* surfel, size_t* cell,
                             float* off) {
    const float half = 0.5f * job->lattice->cell;
    int32_t at[3];
    if (!cube_at(cells, surfel->position, at)) return false;
    const ty_vec center =
        ty_vec_make(cells->lower[0] + half * (float)(2 * at[0] + 1), cells->lower[1] + half * (float)(2 * at[1] + 1),
                    cells->lower[2] + half * (float)(2 * at[2] + 1));
    *off = ty_dot(ty_sub(surfel->position, center), surfel->normal) * cells->per_cell;
    ty_link_cell(job->lattice, at, cell);
    return *off > least_surface_depth;
}

static int32_t side_of(ty_vec normal) {
    const float along[3] = {normal.x, normal.y, normal.z};
    int axis = fabsf(normal.x) > fabsf(normal.y) ? 0 : 1;
    if (fabsf(normal.z) > fabsf(along[axis])) axis = 2;
    return 2 * axis + (along[axis] < 0.0f ? 1 : 0);
}

static void add_surface_depth(ty_surface_depths* surface_depths, const ty_surfel* surfel, float off) {
    float* plane = surface_depths->plane[side_of(surfel->normal)];
    plane[0] += surfel->area * surfel->normal.x;
    plane[1] += surfel->area * surfel->normal.y;
    plane[2] += surfel->area * surfel->normal.z;
    plane[3] += surfel->area * off;
}

/* Area-weighted sums to means. */
static void finish_surface_depths(ty_surface_depths* surface_depths) {
    for (int side = 0; side < TY_SURFACE_SIDES; ++side) {
        float* plane = surface_depths->plane[side];
        const float length = sqrtf(plane[0] * plane[0] + plane[1] * plane[1] + plane[2] * plane[2]);
        for (int t = 0; t < 4 && length > 0.0f; ++t) plane[t] /= length;
    }
}

static void free_surface_depths(ty_lattice* lattice) {
    ty_free_array(lattice->context, lattice->surface_depth_index, lattice->cells, sizeof *lattice->surface_depth_index);
    ty_free_array(lattice->context, lattice->surface_depths, lattice->surface_depth_count,
                  sizeof *lattice->surface_depths);
    lattice->surface_depth_index = NULL;
    lattice->surface_depths = NULL;
    lattice->surface_depth_count = 0;
}

static ty_result find_surface_depths(const block_job* job) {
    ty_lattice* lattice = job->lattice;
    const cube_grid cells = cubes_of(lattice, (const int32_t[3]){0, 0, 0});
    size_t cell, count = 0;
    float off;
    free_surface_depths(lattice);
    lattice->surface_depth_index =
        ty_alloc_array(lattice->context, lattice->cells, sizeof *lattice->surface_depth_index, false);
    if (lattice->surface_depth_index == NULL) return TY_ERROR_MEMORY;
    for (cell = 0; cell < lattice->cells; ++cell) lattice->surface_depth_index[cell] = -1;
    for (size_t i = 0; i < job->count; ++i)
        if (is_before_center(job, &cells, &job->surfels[i], &cell, &off) && lattice->surface_depth_index[cell] < 0)
            lattice->surface_depth_index[cell] = (int32_t)count++;
    if (count == 0) {
        free_surface_depths(lattice);
        return TY_OK;
    }
    lattice->surface_depths = ty_alloc_array(lattice->context, count, sizeof *lattice->surface_depths, true);
    if (lattice->surface_depths == NULL) {
        free_surface_depths(lattice);
        return TY_ERROR_MEMORY;
    }
    lattice->surface_depth_count = count;
    for (size_t i = 0; i < job->count; ++i)
        if (is_before_center(job, &cells, &job->surfels[i], &cell, &off))
            add_surface_depth(&lattice->surface_depths[lattice->surface_depth_index[cell]], &job->surfels[i], off);
    for (size_t i = 0; i < count; ++i) finish_surface_depths(&lattice->surface_depths[i]);
    return TY_OK;
}

/* ---- mode published ---- */

/* The mean blocker of the cubes that meet at the midpoint of the link into a cell: one cube for links across a corner,
 * two across an edge, four across a face. */
static void blocker_between(const block_job* job, const int32_t step[3], const int32_t cell[3],
                            float blocker[BLOCKER_TERMS]) {
    int32_t corners = 0;
    for (int t = 0; t < BLOCKER_TERMS; ++t) blocker[t] = 0.0f;
    for (int corner = 0; corner < 8; ++corner) {
        const int32_t off[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
        bool meets = true;
        for (int a = 0; a < 3; ++a) meets = meets && (step[a] == 0 || off[a] == (step[a] < 0));
        if (!meets) continue;
        const float* sums =
            job->corners[corner_index(job->lattice, cell[0] + off[0], cell[1] + off[1], cell[2] + off[2])];
        for (int t = 0; t < BLOCKER_TERMS; ++t) blocker[t] += sums[t];
        ++corners;
    }
    for (int t = 0; t < BLOCKER_TERMS; ++t) blocker[t] /= (float)corners;
}

/* Fuzzy blockers (Kaplanyan and Dachsbacher 2010): a surface blocks the fraction of a cell's face that its area covers,
 * times the cosine. Two bands blur the end of the cosine lobe: a wall blocks a quarter of the light parallel to it, so
 * blocking is overestimated in corners and narrow passages. */
static void fuzzy_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    block_job* job = user;
    ty_lattice* lattice = job->lattice;
    const int32_t* size = lattice->box.size;
    int32_t cell[3] = {0, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
    for (int32_t link = 0; link < TY_LPV_LINKS; ++link) {
        const float* transfer_G = job->transfer.G[link];
        const float whole = transfer_G[0] / TY_SH_0; /* <1 | G_j> */
        for (cell[0] = 0; cell[0] < size[0]; ++cell[0]) {
            float blocker[BLOCKER_TERMS], sum = 0.0f;
            blocker_between(job, job->transfer.step[link], cell, blocker);
            for (int t = 0; t < BLOCKER_TERMS; ++t) sum += blocker[t] * transfer_G[t];
            lattice->transmission[link][(size_t)row * (size_t)size[0] + (size_t)cell[0]] =
                quantized_transmission(job, sum / whole); /* b = <B | G_j> / <1 | G_j>, Eq. 2 (Billeter 2012) */
        }
    }
}

/* Independent sums over all surfels, one per index. */
static void sum_surfels(void* user, int64_t index, int32_t worker) {
    block_job* job = user;
    if (index == 0)
        add_corners(job);
    else if (index == 1 && find_surface_depths(job) != TY_OK)
        atomic_store(&job->failed, true);
    else if (index > 1)
        close_links(user, index - 2, worker);
}

/* b_cc' of Eq. 2 (Billeter 2012), from surface points. */
ty_result ty_lattice_find_blockers(ty_lattice* lattice, ty_lpv_mode mode, const ty_surfel* surfels, size_t count) {
    const int64_t rows = (int64_t)lattice->box.size[1] * lattice->box.size[2];
    const size_t corners = corner_count(lattice);
    block_job job = {.lattice = lattice, .mode = mode, .surfels = surfels, .count = count};
    job.corners = ty_alloc_array(lattice->context, corners, sizeof *job.corners, true);
    if (job.corners == NULL) return TY_ERROR_MEMORY;
    ty_parallel_flushed(lattice->context, mode == TY_LPV_MODE_PUBLISHED ? 1 : 2 + TY_LPV_HALF_LINKS, sum_surfels, &job);
    ty_parallel_flushed(lattice->context, rows, find_albedo, &job);
    if (mode == TY_LPV_MODE_PUBLISHED) {
        ty_lpv_transfer_make(lattice->bands, false, &job.transfer);
        ty_parallel_flushed(lattice->context, rows, fuzzy_row, &job);
    }
    ty_free_array(lattice->context, job.corners, corners, sizeof *job.corners);
    lattice->blocked = atomic_load(&job.blocked);
    return atomic_load(&job.failed) ? TY_ERROR_MEMORY : TY_OK;
}
