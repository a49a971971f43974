/* Cuts between cells: parts by open faces, planes by the surfaces that close the others. */
#include "image/march/cuts.h"

#include "base/context.h"
#include "base/parallel.h"

#include <math.h>
#include <string.h>

/* Surfaces are one plane if their normals' cosine is above the first, and they are less than the second, in cells,
 * apart. */
static const float alike = 0.9f, near = 0.2f;

typedef struct cut_job {
    const ty_boundary_faces* walls;
    double edge[3]; /* of cells, m */
    ty_cuts* cuts;
} cut_job;

static size_t cell_at(const int32_t size[3], const int32_t at[3]) {
    return ((size_t)at[2] * (size_t)size[1] + (size_t)at[1]) * (size_t)size[0] + (size_t)at[0];
}

/* One of eight cells; beyond the last one along an axis there is that. */
static void corner_at(const int32_t size[3], const int32_t base[3], int corner, int32_t at[3]) {
    for (int a = 0; a < 3; ++a) {
        at[a] = base[a] + (corner >> a & 1);
        if (at[a] >= size[a]) at[a] = size[a] - 1;
    }
}

/* True if the face between two of eight cells is closed: between `corner` and the next one along an axis. */
static bool is_closed(const ty_boundary_faces* walls, const int32_t base[3], int corner, int axis) {
    int32_t at[3];
    corner_at(walls->size, base, corner, at);
    return at[axis] + 1 < walls->size[axis] && (walls->closed[cell_at(walls->size, at)] >> (2 * axis + 1) & 1) != 0;
}

/* ---- parts ---- */

/* part: of each of eight cells, the lowest cell that open faces join it to. Returns whether there are several. */
static bool find_parts(const ty_boundary_faces* walls, const int32_t base[3], uint8_t part[8]) {
    bool open[3][8], changed = true, several = false;
    for (int i = 0; i < 8; ++i) part[i] = (uint8_t)i;
    for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i < 8; ++i) open[axis][i] = (i >> axis & 1) == 0 && !is_closed(walls, base, i, axis);
    while (changed) {
        changed = false;
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i < 8; ++i) {
                const int next = i | 1 << axis;
                if (!open[axis][i] || part[i] == part[next]) continue;
                part[i] = part[next] = part[i] < part[next] ? part[i] : part[next];
                changed = true;
            }
    }
    for (int i = 0; i < 8; ++i) several = several || part[i] != 0;
    return several;
}

/* True if any of eight cells has a closed face, which most have not. */
static bool has_walls(const ty_boundary_faces* walls, const int32_t base[3]) {
    uint8_t all = 0;
    for (int i = 0; i < 8; ++i) {
        int32_t at[3];
        corner_at(walls->size, base, i, at);
        all |= walls->closed[cell_at(walls->size, at)];
    }
    return all != 0;
}

static void number_cuts(const cut_job* job) {
    const int32_t* size = job->walls->size;
    int32_t* of_cell = job->cuts->of_cell;
    int32_t at[3];
    uint8_t part[8];
    for (at[2] = 0; at[2] < size[2]; ++at[2])
        for (at[1] = 0; at[1] < size[1]; ++at[1])
            for (at[0] = 0; at[0] < size[0]; ++at[0]) {
                const bool cut = has_walls(job->walls, at) && find_parts(job->walls, at, part);
                of_cell[cell_at(size, at)] = cut ? job->cuts->count++ : -1;
            }
}

/* ---- planes ---- */

/* Sums over the sides that make a plane. */
typedef struct plane_sum {
    ty_vec normal, position; /* in cells */
    float count;
} plane_sum;

typedef struct plane_sums {
    plane_sum planes[TY_CUT_PLANES];
    int count;
} plane_sums;

static ty_vec unit(ty_vec v) {
    return ty_scale(v, 1 / sqrtf(ty_maxf(ty_dot(v, v), 1e-30f)));
}

/* Adds a surface's position to the plane that it lies in, or to a new one while the list is not full. */
static void add_plane(plane_sums* sums, ty_vec normal, ty_vec position) {
    for (int i = 0; i < sums->count; ++i) {
        plane_sum* plane = &sums->planes[i];
        const ty_vec mean = unit(plane->normal), off = ty_sub(position, ty_scale(plane->position, 1 / plane->count));
        const float cosine = ty_dot(mean, normal);
        if (!(fabsf(cosine) > alike && fabsf(ty_dot(mean, off)) < near)) continue;
        plane->normal = ty_add(plane->normal, ty_scale(normal, cosine < 0 ? -1.0f : 1.0f));
        plane->position = ty_add(plane->position, position);
        plane->count += 1;
        return;
    }
    if (sums->count < TY_CUT_PLANES) sums->planes[sums->count++] = (plane_sum){normal, position, 1};
}

/* The side of a cell's face, which is closed. */
static const ty_boundary_side* side_of(const ty_boundary_faces* walls, const int32_t at[3], int face) {
    const size_t row = (size_t)at[2] * (size_t)walls->size[1] + (size_t)at[1];
    int32_t low = walls->first[row], high = walls->first[row + 1];
    while (low < high) {
        const int32_t center = low + (high - low) / 2;
        if (walls->x[center] < at[0] || (walls->x[center] == at[0] && walls->face[center] < face))
            low = center + 1;
        else
            high = center;
    }
    return &walls->sides[low];
}

/* A closed face's side, as it is seen from a cell. */
static void add_side(const cut_job* job, const int32_t at[3], int face, plane_sums* sums) {
    const ty_boundary_side* side = side_of(job->walls, at, face);
    const double* edge = job->edge;
    float position[3] = {(float)at[0] + 0.5f, (float)at[1] + 0.5f, (float)at[2] + 0.5f};
    position[face / 2] += (face & 1) != 0 ? side->depth : -side->depth;
    const ty_vec normal =
        ty_vec_make(side->normal.x * (float)edge[0], side->normal.y * (float)edge[1], side->normal.z * (float)edge[2]);
    add_plane(sums, unit(normal), ty_vec_load(position));
}

static void find_planes(const cut_job* job, const int32_t base[3], plane_sums* sums) {
    for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i < 8; ++i) {
            if ((i >> axis & 1) != 0 || !is_closed(job->walls, base, i, axis)) continue;
            int32_t at[3];
            corner_at(job->walls->size, base, i, at);
            add_side(job, at, 2 * axis + 1, sums);
            ++at[axis];
            add_side(job, at, 2 * axis, sums);
        }
}

/* ---- cuts ---- */

static uint32_t side_at(const ty_cell_cut* cut, const float position[3]) {
    uint32_t side = 0;
    for (uint32_t i = 0; i < TY_CUT_PLANES; ++i) {
        const float* plane = cut->plane[i];
        if (plane[0] * position[0] + plane[1] * position[1] + plane[2] * position[2] + plane[3] < 0) side |= 1u << i;
    }
    return side;
}

/* The part that most cells behind and before the same planes are of; where there are none, behind and before all planes
 * but as few as can be. */
static uint8_t part_of_side(uint32_t side, const uint32_t sides[8], const uint8_t part[8]) {
    static const int votes[TY_CUT_PLANES + 1] = {4096, 256, 16, 1};
    int sum[8] = {0}, best = 0;
    for (int i = 0; i < 8; ++i) {
        const uint32_t other = side ^ sides[i];
        sum[part[i]] += votes[(other & 1) + (other >> 1 & 1) + (other >> 2 & 1)];
    }
    for (int i = 1; i < 8; ++i)
        if (sum[i] > sum[best]) best = i;
    return (uint8_t)best;
}

static uint8_t cells_of(const uint8_t part[8], uint8_t own) {
    uint32_t cells = 0;
    for (uint32_t i = 0; i < 8; ++i)
        if (part[i] == own) cells |= 1u << i;
    return (uint8_t)cells;
}

static void make_cut(const cut_job* job, const int32_t base[3], ty_cell_cut* cut) {
    plane_sums sums = {.count = 0};
    uint8_t part[8];
    uint32_t sides[8];
    memset(cut, 0, sizeof *cut);
    find_parts(job->walls, base, part);
    find_planes(job, base, &sums);
    for (int i = 0; i < sums.count; ++i) {
        const ty_vec normal = unit(sums.planes[i].normal);
        const float off = ty_dot(normal, sums.planes[i].position) / sums.planes[i].count;
        const float plane[4] = {normal.x, normal.y, normal.z, -off};
        memcpy(cut->plane[i], plane, sizeof plane);
    }
    for (int i = 0; i < 8; ++i) {
        const float position[3] = {(float)(base[0] + (i & 1)) + 0.5f, (float)(base[1] + (i >> 1 & 1)) + 0.5f,
                                   (float)(base[2] + (i >> 2)) + 0.5f};
        sides[i] = side_at(cut, position);
    }
    for (int i = 0; i < 8; ++i) cut->parts[i] = cells_of(part, part[i]);
    for (uint32_t side = 0; side < TY_CUT_SIDES; ++side)
        cut->joined[side] = cells_of(part, part_of_side(side, sides, part));
}

static void make_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const cut_job* job = user;
    const int32_t* size = job->walls->size;
    int32_t at[3] = {0, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
    for (; at[0] < size[0]; ++at[0]) {
        const int32_t index = job->cuts->of_cell[cell_at(size, at)];
        if (index >= 0) make_cut(job, at, &job->cuts->cuts[index]);
    }
}

/* ---- looking at them ---- */

bool ty_cuts_are_about(const ty_cuts* cuts, const int32_t at[3]) {
    for (int corner = 0; corner < 8; ++corner) {
        int32_t base[3];
        for (int a = 0; a < 3; ++a) base[a] = at[a] - (at[a] > 0 ? corner >> a & 1 : 0);
        if (cuts->of_cell[cell_at(cuts->size, base)] >= 0) return true;
    }
    return false;
}

bool ty_cuts_join(const ty_cuts* cuts, const int32_t at[3], const int32_t next[3]) {
    int32_t base[3];
    int from = 0, to = 0;
    for (int a = 0; a < 3; ++a) {
        base[a] = at[a] < next[a] ? at[a] : next[a];
        from |= (at[a] - base[a]) << a;
        to |= (next[a] - base[a]) << a;
    }
    const int32_t index = cuts->of_cell[cell_at(cuts->size, base)];
    return index < 0 || (cuts->cuts[index].parts[from] >> to & 1) != 0;
}

/* ---- all ---- */

ty_result ty_cuts_find(ty_context* context, const ty_boundary_faces* walls, const ty_grid_box* box, ty_cuts** out) {
    *out = NULL;
    if (walls == NULL) return TY_OK;
    ty_cuts* cuts = ty_alloc_array(context, 1, sizeof *cuts, true);
    if (cuts == NULL) return TY_ERROR_MEMORY;
    const int32_t* size = walls->size;
    cuts->context = context;
    memcpy(cuts->size, size, sizeof cuts->size);
    cuts->cells = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    cut_job job = {.walls = walls, .cuts = cuts};
    for (int a = 0; a < 3; ++a) job.edge[a] = (box->upper[a] - box->lower[a]) / size[a];
    cuts->of_cell = ty_alloc_array(context, cuts->cells, sizeof *cuts->of_cell, false);
    if (cuts->of_cell != NULL) {
        number_cuts(&job);
        cuts->cuts = ty_alloc_array(context, (size_t)cuts->count, sizeof *cuts->cuts, false);
    }
    const bool whole = cuts->of_cell != NULL && (cuts->cuts != NULL || cuts->count == 0);
    if (whole && cuts->count > 0) {
        ty_parallel_flushed(context, (int64_t)size[1] * size[2], make_row, &job);
        *out = cuts;
    } else {
        ty_cuts_destroy(cuts);
    }
    return whole ? TY_OK : TY_ERROR_MEMORY;
}

void ty_cuts_destroy(ty_cuts* cuts) {
    if (cuts == NULL) return;
    ty_context* context = cuts->context;
    ty_free_array(context, cuts->of_cell, cuts->cells, sizeof *cuts->of_cell);
    ty_free_array(context, cuts->cuts, (size_t)cuts->count, sizeof *cuts->cuts);
    ty_free_array(context, cuts, 1, sizeof *cuts);
}

ty_cuts_view ty_cuts_get_view(const ty_cuts* cuts) {
    return cuts != NULL ? (ty_cuts_view){cuts->of_cell, cuts->cuts} : (ty_cuts_view){NULL, NULL};
}
