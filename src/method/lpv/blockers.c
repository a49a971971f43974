/* What surfaces stop between cells. */
#include "base/context.h"
#include "base/parallel.h"
#include "method/lpv/links.h"

#include <stdatomic.h>

/* Mode links: how much more area than there is counts, so that a wall that few rays met still closes all of a link. */
static const float slack = 1.25f;

/* Surfaces on a plane between two cubes must not be shared by both, as rounding would have it: cubes lie off their
 * places by this much, in cells. */
static const float nudge = 1e-3f;

/* Surfaces through cells' middles are not in front of them, m/m. */
static const float least_front = 0.01f;

/* Terms of the fuzzy blockers. */
enum { BLOCKER_TERMS = 4 };

/* ---- cubes about corners of cells ---- */

/* Sums over surfels in a cube about each corner of cells. */
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

/* Cubes of a cell's side. */
typedef struct cube_grid {
    float lower[3], per_cell; /* m, 1/m */
    int32_t size[3];
} cube_grid;

/* Those that begin `shift` (0 or 1) halves of a cell before the cells. */
static cube_grid cubes_of(const ty_lattice* lattice, const int32_t shift[3]) {
    cube_grid out = {.per_cell = 1.0f / lattice->cell};
    for (int a = 0; a < 3; ++a) {
        out.lower[a] = (float)lattice->box.lower[a] - lattice->cell * (nudge + 0.5f * (float)shift[a]);
        out.size[a] = lattice->box.size[a] + shift[a];
    }
    return out;
}

/* The cube a point is in; false outside. */
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
        /* Light that travels against the normal meets the surface. */
        ty_sh_at(ty_scale(surfel->normal, -1.0f), 2, y);
        for (int t = 0; t < BLOCKER_TERMS; ++t) sums[t] += surfel->area * per_face * ty_sh_cosine(ty_sh_band(t)) * y[t];
    }
}

/* Means over the surfaces within a cell about a cell's middle. */
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

static uint8_t opening(block_job* job, float blocked) {
    if (blocked > 0.0f) atomic_store_explicit(&job->blocked, true, memory_order_relaxed);
    return (uint8_t)(255.0f * (1.0f - ty_clampf(blocked, 0.0f, 1.0f)) + 0.5f);
}

/* ---- mode links ---- */

/* All links of one direction: surfaces belong to the link in the cube about whose middle they are. */
static void close_links(void* user, int64_t link, int32_t worker) {
    (void)worker;
    block_job* job = user;
    ty_lattice* lattice = job->lattice;
    const ty_link_grid grid = ty_link_grid_of(lattice, (int32_t)link);
    const int32_t shift[3] = {abs(grid.step[0]), abs(grid.step[1]), abs(grid.step[2])};
    const ty_vec way = ty_vec_make((float)grid.step[0], (float)grid.step[1], (float)grid.step[2]);
    const cube_grid cubes = cubes_of(lattice, shift);
    const float per_face = slack / (lattice->cell * lattice->cell);
    int32_t cube[3];
    float* covered = ty_alloc_array(lattice->context, grid.count, sizeof *covered, true);
    if (covered == NULL) {
        atomic_store(&job->failed, true);
        return;
    }
    for (size_t i = 0; i < job->count; ++i) {
        const float across = fabsf(ty_dot(job->surfels[i].normal, way));
        if (!(across > 1e-4f) || !cube_at(&cubes, job->surfels[i].position, cube)) continue;
        covered[ty_link_at(&grid, cube)] += job->surfels[i].area * across * per_face;
    }
    const float* next = covered;
    for (cube[2] = 0; cube[2] < grid.size[2]; ++cube[2])
        for (cube[1] = 0; cube[1] < grid.size[1]; ++cube[1])
            for (cube[0] = 0; cube[0] < grid.size[0]; ++cube[0])
                ty_link_set(lattice, (int32_t)link, &grid, cube, opening(job, *next++));
    ty_free_array(lattice->context, covered, grid.count, sizeof *covered);
}

/* ---- what is in front of cells' middles ---- */

/* The cell that a surfel is in, and how far in front of its middle, in cells; false: not in front, or outside. */
static bool in_front(const block_job* job, const cube_grid* cells, const ty_surfel* surfel, size_t* cell, float* off) {
    const float half = 0.5f * job->lattice->cell;
    int32_t at[3];
    if (!cube_at(cells, surfel->position, at)) return false;
    const ty_vec middle =
        ty_vec_make(cells->lower[0] + half * (float)(2 * at[0] + 1), cells->lower[1] + half * (float)(2 * at[1] + 1),
                    cells->lower[2] + half * (float)(2 * at[2] + 1));
    *off = ty_dot(ty_sub(surfel->position, middle), surfel->normal) * cells->per_cell;
    ty_link_cell(job->lattice, at, cell);
    return *off > least_front;
}

static int32_t side_of(ty_vec normal) {
    const float along[3] = {normal.x, normal.y, normal.z};
    int axis = fabsf(normal.x) > fabsf(normal.y) ? 0 : 1;
    if (fabsf(normal.z) > fabsf(along[axis])) axis = 2;
    return 2 * axis + (along[axis] < 0.0f ? 1 : 0);
}

static void add_front(ty_lattice_front* front, const ty_surfel* surfel, float off) {
    float* plane = front->plane[side_of(surfel->normal)];
    plane[0] += surfel->area * surfel->normal.x;
    plane[1] += surfel->area * surfel->normal.y;
    plane[2] += surfel->area * surfel->normal.z;
    plane[3] += surfel->area * off;
}

/* From sums over areas to means. */
static void finish_front(ty_lattice_front* front) {
    for (int side = 0; side < TY_FRONT_SIDES; ++side) {
        float* plane = front->plane[side];
        const float length = sqrtf(plane[0] * plane[0] + plane[1] * plane[1] + plane[2] * plane[2]);
        for (int t = 0; t < 4 && length > 0.0f; ++t) plane[t] /= length;
    }
}

static void free_fronts(ty_lattice* lattice) {
    ty_free_array(lattice->context, lattice->fronts, lattice->cells, sizeof *lattice->fronts);
    ty_free_array(lattice->context, lattice->front, lattice->front_count, sizeof *lattice->front);
    lattice->fronts = NULL;
    lattice->front = NULL;
    lattice->front_count = 0;
}

static ty_result find_fronts(const block_job* job) {
    ty_lattice* lattice = job->lattice;
    const cube_grid cells = cubes_of(lattice, (const int32_t[3]){0, 0, 0});
    size_t cell, count = 0;
    float off;
    free_fronts(lattice);
    lattice->fronts = ty_alloc_array(lattice->context, lattice->cells, sizeof *lattice->fronts, false);
    if (lattice->fronts == NULL) return TY_ERROR_MEMORY;
    for (cell = 0; cell < lattice->cells; ++cell) lattice->fronts[cell] = -1;
    for (size_t i = 0; i < job->count; ++i)
        if (in_front(job, &cells, &job->surfels[i], &cell, &off) && lattice->fronts[cell] < 0)
            lattice->fronts[cell] = (int32_t)count++;
    if (count == 0) {
        free_fronts(lattice);
        return TY_OK;
    }
    lattice->front = ty_alloc_array(lattice->context, count, sizeof *lattice->front, true);
    if (lattice->front == NULL) {
        free_fronts(lattice);
        return TY_ERROR_MEMORY;
    }
    lattice->front_count = count;
    for (size_t i = 0; i < job->count; ++i)
        if (in_front(job, &cells, &job->surfels[i], &cell, &off))
            add_front(&lattice->front[lattice->fronts[cell]], &job->surfels[i], off);
    for (size_t i = 0; i < count; ++i) finish_front(&lattice->front[i]);
    return TY_OK;
}

/* ---- mode published ---- */

/* The mean of the cubes that meet at the middle of the link that leads into a cell: one for links across a corner, two
 * across an edge, four across a face. */
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

/* Kaplanyan and Dachsbacher 2010: surfaces stop what share of a direction their area covers of a cell's face, times
 * the cosine; G_j takes the mean over its patch. Two bands know little of where a cosine ends: a wall still stops a
 * quarter of what runs along it, so there is more blocking than surfaces in corners and narrow places. */
static void fuzzy_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    block_job* job = user;
    ty_lattice* lattice = job->lattice;
    const int32_t* size = lattice->box.size;
    int32_t cell[3] = {0, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
    for (int32_t link = 0; link < TY_LPV_LINKS; ++link) {
        const float* shape = job->transfer.shape[link];
        const float whole = shape[0] / TY_SH_0; /* <1 | G_j> */
        for (cell[0] = 0; cell[0] < size[0]; ++cell[0]) {
            float blocker[BLOCKER_TERMS], sum = 0.0f;
            blocker_between(job, job->transfer.step[link], cell, blocker);
            for (int t = 0; t < BLOCKER_TERMS; ++t) sum += blocker[t] * shape[t];
            lattice->open[link][(size_t)row * (size_t)size[0] + (size_t)cell[0]] = opening(job, sum / whole);
        }
    }
}

/* Sums over all surfels that do not need one another. */
static void sum_surfels(void* user, int64_t index, int32_t worker) {
    block_job* job = user;
    if (index == 0)
        add_corners(job);
    else if (index == 1 && find_fronts(job) != TY_OK)
        atomic_store(&job->failed, true);
    else if (index > 1)
        close_links(user, index - 2, worker);
}

/* b_cc' of Eq. 2 (Billeter 2012), from surface points. */
ty_result ty_lattice_block(ty_lattice* lattice, ty_lpv_mode mode, const ty_surfel* surfels, size_t count) {
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
