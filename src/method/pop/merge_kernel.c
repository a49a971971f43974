/* Row loops of merging; built once per instruction set, with TY_ISA naming it. */
#include "method/pop/merge_kernel.h"

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)

/* What one load brings: two neighbours' eight floats, or one cell's. Without registers as wide compilers
 * take them apart. */
typedef float two_cells __attribute__((vector_size(64), aligned(4), may_alias));
typedef float one_cell __attribute__((vector_size(32), aligned(4), may_alias));

/* Registers are filled with cells beyond a row's end, which the next row's take the place of. */
enum { LANES = 16, CELLS = TY_POP_MERGE_ROWS * TY_POP_MERGE_RUN, ROOM = CELLS + LANES };

/* Where rows' cells are in a light's grid: the lowest of eight cells each, the share of the upper ones along i, and
 * what those that differ in j and k weigh, spreading included. */
typedef struct places {
    _Alignas(64) int32_t base[ROOM];
    float share[ROOM];
    float weight[4][ROOM];
    float spread[ROOM]; /* what these sum up to */
    int32_t step[3];    /* to the upper cells */
} places;

TY_FN void weigh(int32_t cell, float j, float k, float spread, places* p) {
    const float both = j * k;
    p->spread[cell] = spread;
    p->weight[0][cell] = spread * (1.0f - j - k + both);
    p->weight[1][cell] = spread * (j - both);
    p->weight[2][cell] = spread * (k - both);
    p->weight[3][cell] = spread * both;
}

/* Parallel grids in numbers of cells, from the middle of the first: where rows begin, and how far it is from one of
 * their cells, and from one row, to the next. */
typedef struct lattice {
    float at[3], step[3], row_step[3];
    float last[3], lower[3]; /* cells, and those that are the lower ones of two */
} lattice;

static lattice lattice_of(const ty_pop_frame* frame, const ty_pop_merge_rows* rows) {
    const float edge[3] = {frame->step.x, frame->step.y, frame->step.z};
    const ty_vec off = ty_sub(rows->first, frame->origin);
    lattice l;
    for (int a = 0; a < 3; ++a) {
        const float per_cell = 1.0f / edge[a];
        l.at[a] = ty_dot(off, frame->axis[a]) * per_cell - 0.5f;
        l.step[a] = frame->axis[a].x * rows->step[0] * per_cell;
        l.row_step[a] = frame->axis[a].y * rows->step[1] * per_cell;
        l.last[a] = (float)(frame->size[a] - 1);
        l.lower[a] = ty_maxf(l.last[a] - 1.0f, 0.0f);
    }
    return l;
}

/* Middles of merged cells are at equal distances here. Cells are counted in floats, which are exact. */
static void place_parallel(const ty_pop_frame* frame, const ty_pop_merge_rows* rows, places* p) {
    const lattice l = lattice_of(frame, rows);
    const int32_t size_i = frame->size[0], slice = frame->size[0] * frame->size[1];
    const int32_t count = (rows->count + LANES - 1) / LANES * LANES;
    p->step[0] = 1;
    p->step[1] = frame->size[1] > 1 ? size_i : 0;
    p->step[2] = frame->size[2] > 1 ? slice : 0;
    for (int32_t row = 0; row < rows->rows; ++row) {
        float at[3];
        for (int a = 0; a < 3; ++a) at[a] = l.at[a] + l.row_step[a] * (float)row;
        const int32_t first = row * rows->count;
#pragma omp simd
        for (int32_t n = 0; n < count; ++n) {
            const float i = ty_clampf(at[0] + l.step[0] * (float)n, 0.0f, l.last[0]);
            const float j = ty_clampf(at[1] + l.step[1] * (float)n, 0.0f, l.last[1]);
            const float k = ty_clampf(at[2] + l.step[2] * (float)n, 0.0f, l.last[2]);
            const float cell_i = ty_minf(floorf(i), l.lower[0]), cell_j = ty_minf(floorf(j), l.lower[1]),
                        cell_k = ty_minf(floorf(k), l.lower[2]);
            p->base[first + n] = (int32_t)(cell_i + cell_j * (float)size_i + cell_k * (float)slice);
            p->share[first + n] = i - cell_i;
            weigh(first + n, j - cell_j, k - cell_k, 1.0f, p);
        }
    }
}

/* The same cells for all points: those at the upper edge are reached from the cell before. */
TY_FN float shift_place(const ty_pop_place* place, int32_t axis, int32_t step, int32_t* base) {
    const bool at_edge = step > 0 && place->step[axis] == 0;
    *base -= at_edge ? step : 0;
    return at_edge ? 1.0f : place->share[axis];
}

static void place_radial(const ty_pop_light* light, const ty_pop_merge_rows* rows, places* p) {
    const ty_pop_frame* frame = &light->frame;
    const int32_t ringed = frame->size[0] + 2;
    const int32_t step[3] = {1, ringed, frame->size[2] > 1 ? ringed * ringed : 0};
    const float least = light->ordinate.min_distance;
    for (int a = 0; a < 3; ++a) p->step[a] = step[a];
    for (int32_t row = 0; row < rows->rows; ++row) {
        const float y = rows->first.y + rows->step[1] * (float)row;
        const int32_t first = row * rows->count;
#pragma omp simd
        for (int32_t n = 0; n < rows->count; ++n) {
            const ty_vec point = ty_vec_make(rows->first.x + rows->step[0] * (float)n, y, rows->first.z);
            const ty_pop_place place = ty_pop_locate(frame, least, point);
            int32_t base = (int32_t)place.base;
            const float i = shift_place(&place, 0, step[0], &base), j = shift_place(&place, 1, step[1], &base),
                        k = shift_place(&place, 2, step[2], &base);
            p->base[first + n] = base;
            p->share[first + n] = i;
            weigh(first + n, j, k, place.spread, p);
        }
    }
}

/* The weighted sum of what is at an address and in the cells above it along j, k and both. */
#define BLEND(type, from)                                                                                              \
    (w0 * *(const type*)(from) + w1 * *(const type*)((from) + j) + w2 * *(const type*)((from) + k) +                   \
     w3 * *(const type*)((from) + j + k))

/* Adds what a light has at rows' cells. */
TY_FN void add_cells(const ty_pop_light* light, int32_t floats, bool weighted, const places* p,
                     const ty_pop_merge_rows* rows) {
    const size_t j = (size_t)p->step[1] * (size_t)floats, k = (size_t)p->step[2] * (size_t)floats;
    const int32_t count = rows->count * rows->rows;
    for (int32_t n = 0; n < count; ++n) {
        const float* at = light->seen + (size_t)p->base[n] * (size_t)floats;
        const float w0 = p->weight[0][n], w1 = p->weight[1][n], w2 = p->weight[2][n], w3 = p->weight[3][n];
        one_cell lower, upper;
        if (floats == TY_POP_SEEN) {
            const two_cells both = BLEND(two_cells, at);
            lower = __builtin_shufflevector(both, both, 0, 1, 2, 3, 4, 5, 6, 7);
            upper = __builtin_shufflevector(both, both, 8, 9, 10, 11, 12, 13, 14, 15);
        } else {
            lower = BLEND(one_cell, at);
            upper = BLEND(one_cell, at + floats);
        }
        one_cell cell = lower + p->share[n] * (upper - lower);
        if (weighted) cell *= p->spread[n] / ty_maxf(cell[TY_POP_WEIGHT], 1e-30f);
        *(one_cell*)(rows->sums + (size_t)TY_POP_MERGE_SUMS * (size_t)n) += cell;
    }
}

#undef BLEND

static void merge(const ty_pop_light* light, const ty_pop_merge_rows* rows) {
    places p;
    if (light->frame.kind == TY_DISCRETE_POINT)
        place_radial(light, rows, &p);
    else
        place_parallel(&light->frame, rows, &p);
    if (light->floats == TY_POP_SEEN)
        add_cells(light, TY_POP_SEEN, true, &p, rows);
    else
        add_cells(light, TY_POP_SEEN_LEFT, false, &p, rows);
}

/* A sixth of each neighbour's light comes in, less what half of either cell absorbs. */
static float pass(const ty_pop_residuum_row* row) {
    const ptrdiff_t x = row->stride[0], y = row->stride[1], z = row->stride[2];
    const float *half_x = row->half[0], *half_y = row->half[1], *half_z = row->half[2], *from = row->from;
    float *to = row->to, *through = row->through;
    float sum = 0.0f;
#pragma omp simd reduction(+ : sum)
    for (int32_t i = 0; i < row->count; ++i) {
        const float along_x = half_x[i] * (half_x[i - x] * from[i - x] + half_x[i + x] * from[i + x]);
        const float along_y = half_y[i] * (half_y[i - y] * from[i - y] + half_y[i + y] * from[i + y]);
        const float along_z = half_z[i] * (half_z[i - z] * from[i - z] + half_z[i + z] * from[i + z]);
        const float in = (along_x + along_y + along_z) * (1.0f / 6.0f);
        to[i] = in;
        through[i] += in;
        sum += in;
    }
    return sum;
}

const ty_pop_merge_kernels TY_JOIN(ty_pop_merge_kernels_, TY_ISA) = {.merge = merge, .pass = pass};
