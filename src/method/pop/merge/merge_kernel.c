/* Row loops of merging; compiled once per instruction set, named by TY_ISA. */
#include "method/pop/merge/merge_kernel.h"

/* Vector loads: floats of two neighbouring cells, or of one. Compilers split them where registers are narrower. */
typedef float two_cells __attribute__((vector_size(64), aligned(4), may_alias));
typedef float one_cell __attribute__((vector_size(32), aligned(4), may_alias));

/* Vectors reach beyond the end of a row; the next row overwrites those cells. */
enum { LANES = 16, CELLS = TY_POP_MERGE_ROWS * TY_POP_MERGE_RUN, PADDED = CELLS + LANES };

/* Trilinear positions of rows of merged cells in a light's grid: the lowest of eight cells, the fraction along i,
 * and weights of the four combinations in j and k, times the inverse square. */
typedef struct cell_positions {
    _Alignas(64) int32_t base[PADDED];
    float fraction[PADDED];
    float weight[4][PADDED];
    float inverse_square[PADDED]; /* sum of the weights */
    int32_t step[3];              /* offsets to the upper cells */
} cell_positions;

TY_FN void set_weights(int32_t cell, float j, float k, float inverse_square, cell_positions* p) {
    const float both = j * k;
    p->inverse_square[cell] = inverse_square;
    p->weight[0][cell] = inverse_square * (1.0f - j - k + both);
    p->weight[1][cell] = inverse_square * (j - both);
    p->weight[2][cell] = inverse_square * (k - both);
    p->weight[3][cell] = inverse_square * both;
}

/* Affine map from merged cells to a parallel grid's cell coordinates (0 at the first center): start, step per cell
 * and step per row. */
typedef struct lattice {
    float at[3], step[3], row_step[3];
    float last[3], lower[3]; /* upper bound of coordinates, and of a lower cell's index */
} lattice;

static lattice lattice_of(const ty_pop_grid* grid, const ty_pop_merge_rows* rows) {
    const float edge[3] = {grid->step.x, grid->step.y, grid->step.z};
    const ty_vec off = ty_sub(rows->first, grid->origin);
    lattice l;
    for (int a = 0; a < 3; ++a) {
        const float per_cell = 1.0f / edge[a];
        l.at[a] = ty_dot(off, grid->axis[a]) * per_cell - 0.5f;
        l.step[a] = grid->axis[a].x * rows->step[0] * per_cell;
        l.row_step[a] = grid->axis[a].y * rows->step[1] * per_cell;
        l.last[a] = (float)(grid->size[a] - 1);
        l.lower[a] = ty_maxf(l.last[a] - 1.0f, 0.0f);
    }
    return l;
}

/* Merged cells are equidistant in parallel grids. Cell indices are floats here, which are exact. */
static void locate_parallel(const ty_pop_grid* grid, const ty_pop_merge_rows* rows, cell_positions* p) {
    const lattice l = lattice_of(grid, rows);
    const int32_t size_i = grid->size[0], slice = grid->size[0] * grid->size[1];
    const int32_t count = (rows->count + LANES - 1) / LANES * LANES;
    p->step[0] = 1;
    p->step[1] = grid->size[1] > 1 ? size_i : 0;
    p->step[2] = grid->size[2] > 1 ? slice : 0;
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
            p->fraction[first + n] = i - cell_i;
            set_weights(first + n, j - cell_j, k - cell_k, 1.0f, p);
        }
    }
}

/* Moves a position on the upper edge to the cell before it with fraction 1, so that all positions share one step. */
TY_FN float move_off_edge(const ty_pop_cell_position* cell, int32_t axis, int32_t step, int32_t* base) {
    const bool at_edge = step > 0 && cell->step[axis] == 0;
    *base -= at_edge ? step : 0;
    return at_edge ? 1.0f : cell->fraction[axis];
}

static void locate_radial(const ty_pop_light* light, const ty_pop_merge_rows* rows, cell_positions* p) {
    const ty_pop_grid* grid = &light->grid;
    const int32_t with_ghosts = grid->size[0] + 2;
    const int32_t step[3] = {1, with_ghosts, grid->size[2] > 1 ? with_ghosts * with_ghosts : 0};
    const float min_distance = light->ordinate.min_distance;
    for (int a = 0; a < 3; ++a) p->step[a] = step[a];
    for (int32_t row = 0; row < rows->rows; ++row) {
        const float y = rows->first.y + rows->step[1] * (float)row;
        const int32_t first = row * rows->count;
#pragma omp simd
        for (int32_t n = 0; n < rows->count; ++n) {
            const ty_vec point = ty_vec_make(rows->first.x + rows->step[0] * (float)n, y, rows->first.z);
            const ty_pop_cell_position cell = ty_pop_locate(grid, min_distance, point);
            int32_t base = (int32_t)cell.base;
            const float i = move_off_edge(&cell, 0, step[0], &base), j = move_off_edge(&cell, 1, step[1], &base),
                        k = move_off_edge(&cell, 2, step[2], &base);
            p->base[first + n] = base;
            p->fraction[first + n] = i;
            set_weights(first + n, j, k, cell.inverse_square, p);
        }
    }
}

/* Weighted sum of the values at an address and at its neighbours along j, k and both. */
#define BLEND(type, from)                                                                                              \
    (w0 * *(const type*)(from) + w1 * *(const type*)((from) + j) + w2 * *(const type*)((from) + k) +                   \
     w3 * *(const type*)((from) + j + k))

/* Adds a light's values at the rows' cells. */
TY_FN void add_cells(const ty_pop_light* light, int32_t floats, bool weighted, const cell_positions* p,
                     const ty_pop_merge_rows* rows) {
    const size_t j = (size_t)p->step[1] * (size_t)floats, k = (size_t)p->step[2] * (size_t)floats;
    const int32_t count = rows->count * rows->rows;
    for (int32_t n = 0; n < count; ++n) {
        const float* at = light->accumulated + (size_t)p->base[n] * (size_t)floats;
        const float w0 = p->weight[0][n], w1 = p->weight[1][n], w2 = p->weight[2][n], w3 = p->weight[3][n];
        one_cell lower, upper;
        if (floats == TY_POP_CELL_FLOATS) {
            const two_cells both = BLEND(two_cells, at);
            lower = __builtin_shufflevector(both, both, 0, 1, 2, 3, 4, 5, 6, 7);
            upper = __builtin_shufflevector(both, both, 8, 9, 10, 11, 12, 13, 14, 15);
        } else {
            lower = BLEND(one_cell, at);
            upper = BLEND(one_cell, at + floats);
        }
        one_cell cell = lower + p->fraction[n] * (upper - lower);
        if (weighted) cell *= p->inverse_square[n] / ty_maxf(cell[TY_POP_CELL_WEIGHT], 1e-30f);
        *(one_cell*)(rows->sums + (size_t)TY_POP_MERGE_SUMS * (size_t)n) += cell;
    }
}

#undef BLEND

static void merge(const ty_pop_light* light, const ty_pop_merge_rows* rows) {
    cell_positions p;
    if (light->grid.kind == TY_DISCRETE_POINT)
        locate_radial(light, rows, &p);
    else
        locate_parallel(&light->grid, rows, &p);
    if (light->floats == TY_POP_CELL_FLOATS)
        add_cells(light, TY_POP_CELL_FLOATS, true, &p, rows);
    else
        add_cells(light, TY_POP_CELL_FLOATS_PROPAGATED, false, &p, rows);
}

const ty_pop_merge_kernels TY_KERNEL_NAME(ty_pop_merge_kernels) = {.merge = merge};
