/* What surfaces stop between cells. */
#include "base/context.h"
#include "base/parallel.h"
#include "method/lpv/inject.h"

#include <stdatomic.h>
#include <stdlib.h>

/* Mode links: how much more area than there is counts, so that a wall that few rays met still closes all of a link. */
static const float slack = 1.25f;

/* Surfaces on a plane between two cubes must not be shared by both, as rounding would have it: cubes lie off their
 * places by this much, in cells. */
static const float nudge = 1e-3f;

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

/* The cell's number; false outside of the lattice. */
static bool cell_index(const ty_lattice* lattice, const int32_t cell[3], size_t* index) {
    const int32_t* size = lattice->box.size;
    for (int a = 0; a < 3; ++a)
        if (cell[a] < 0 || cell[a] >= size[a]) return false;
    *index = (size_t)cell[0] + (size_t)size[0] * ((size_t)cell[1] + (size_t)size[1] * (size_t)cell[2]);
    return true;
}

/* Both directions of a link between two cells, one of which may be outside. */
static void set_opening(block_job* job, int32_t link, const int32_t step[3], const int32_t cube[3], float blocked) {
    const ty_lattice* lattice = job->lattice;
    const uint8_t open = opening(job, blocked);
    int32_t from[3], to[3];
    size_t index;
    for (int a = 0; a < 3; ++a) {
        from[a] = cube[a] - (step[a] > 0 ? 1 : 0);
        to[a] = from[a] + step[a];
    }
    if (cell_index(lattice, to, &index)) lattice->open[link][index] = open;
    if (cell_index(lattice, from, &index)) lattice->open[link + TY_LPV_HALF_LINKS][index] = open;
}

/* All links of one direction: surfaces belong to the link in the cube about whose middle they are. */
static void close_links(void* user, int64_t link, int32_t worker) {
    (void)worker;
    block_job* job = user;
    const ty_lattice* lattice = job->lattice;
    int32_t step[3];
    ty_lpv_link_step((int32_t)link, step);
    const int32_t shift[3] = {abs(step[0]), abs(step[1]), abs(step[2])};
    const ty_vec way = ty_vec_make((float)step[0], (float)step[1], (float)step[2]);
    const cube_grid all = cubes_of(lattice, shift);
    const int32_t* size = all.size;
    int32_t cube[3];
    const size_t count = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    const float per_face = slack / (lattice->cell * lattice->cell);
    float* sums = ty_alloc_array(lattice->context, count, sizeof *sums, true);
    if (sums == NULL) {
        atomic_store(&job->failed, true);
        return;
    }
    for (size_t i = 0; i < job->count; ++i) {
        const float across = fabsf(ty_dot(job->surfels[i].normal, way));
        if (!(across > 1e-4f) || !cube_at(&all, job->surfels[i].position, cube)) continue;
        sums[cube[0] + (size_t)size[0] * (size_t)(cube[1] + size[1] * cube[2])] += job->surfels[i].area * across;
    }
    const float* next = sums;
    for (cube[2] = 0; cube[2] < size[2]; ++cube[2])
        for (cube[1] = 0; cube[1] < size[1]; ++cube[1])
            for (cube[0] = 0; cube[0] < size[0]; ++cube[0])
                set_opening(job, (int32_t)link, step, cube, *next++ * per_face);
    ty_free_array(lattice->context, sums, count, sizeof *sums);
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

ty_result ty_lattice_block(ty_lattice* lattice, ty_lpv_mode mode, const ty_surfel* surfels, size_t count) {
    const int64_t rows = (int64_t)lattice->box.size[1] * lattice->box.size[2];
    const size_t corners = corner_count(lattice);
    block_job job = {.lattice = lattice, .mode = mode, .surfels = surfels, .count = count};
    job.corners = ty_alloc_array(lattice->context, corners, sizeof *job.corners, true);
    if (job.corners == NULL) return TY_ERROR_MEMORY;
    add_corners(&job);
    ty_parallel_flushed(lattice->context, rows, find_albedo, &job);
    if (mode == TY_LPV_MODE_PUBLISHED) {
        ty_lpv_transfer_make(lattice->bands, false, &job.transfer);
        ty_parallel_flushed(lattice->context, rows, fuzzy_row, &job);
    } else
        ty_parallel_flushed(lattice->context, TY_LPV_HALF_LINKS, close_links, &job);
    ty_free_array(lattice->context, job.corners, corners, sizeof *job.corners);
    lattice->blocked = atomic_load(&job.blocked);
    return atomic_load(&job.failed) ? TY_ERROR_MEMORY : TY_OK;
}
