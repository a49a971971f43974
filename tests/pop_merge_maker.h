/* Shared by tests of merging: grids about boxes, lights on them, and merged grids. */
#ifndef TY_TESTS_POP_MERGE_MAKER_H
#define TY_TESTS_POP_MERGE_MAKER_H

#include "checks.h"
#include "method/pop/published/residuum.h"

static inline float* new_floats(size_t count) {
    float* values = calloc(count, sizeof *values);
    assert_non_null(values);
    return values;
}

/* Half of what a box's sides cover along a direction, m. */
static inline float half_width(const ty_grid_box* box, ty_vec axis) {
    const double parts[3] = {(double)axis.x, (double)axis.y, (double)axis.z};
    double width = 0;
    for (int a = 0; a < 3; ++a) width += fabs(parts[a]) * (box->upper[a] - box->lower[a]);
    return (float)(0.5 * width);
}

static inline ty_vec box_center(const ty_grid_box* box) {
    return ty_vec_make((float)(0.5 * (box->lower[0] + box->upper[0])), (float)(0.5 * (box->lower[1] + box->upper[1])),
                       (float)(0.5 * (box->lower[2] + box->upper[2])));
}

/* Spans a box; i, j, k of different sizes. */
static inline ty_pop_light parallel_light(const ty_grid_box* box, ty_vec direction, int32_t floats) {
    ty_pop_light light = {.ordinate = {.kind = TY_DISCRETE_DIRECTIONAL, .direction = direction, .mean_cosine = 1},
                          .floats = floats};
    ty_pop_grid* grid = &light.grid;
    *grid = (ty_pop_grid){.kind = TY_DISCRETE_DIRECTIONAL, .size = {9, 10, 11}};
    ty_onb(direction, &grid->axis[0], &grid->axis[1]);
    grid->axis[2] = direction;
    grid->origin = box_center(box);
    float half[3];
    for (int a = 0; a < 3; ++a) {
        half[a] = half_width(box, grid->axis[a]);
        grid->origin = ty_mad(grid->origin, grid->axis[a], -half[a]);
    }
    grid->step = ty_vec_make(2 * half[0] / 9, 2 * half[1] / 10, 2 * half[2] / 11);
    light.accumulated = new_floats((size_t)floats * ty_pop_cells_with_ghosts(grid));
    return light;
}

static inline ty_pop_light radial_light(ty_vec position, int32_t side, int32_t shells, float inner, float outer,
                                        int32_t floats) {
    ty_pop_light light = {.ordinate = {.kind = TY_DISCRETE_POINT, .position = position}, .floats = floats};
    light.grid = (ty_pop_grid){.kind = TY_DISCRETE_POINT,
                               .size = {side, side, shells},
                               .origin = position,
                               .inner = inner,
                               .growth = logf(outer / inner) / (float)shells};
    light.accumulated = new_floats((size_t)floats * ty_pop_cells_with_ghosts(&light.grid));
    return light;
}

static inline void free_light(ty_pop_light* light) {
    free(light->accumulated);
}

/* Values of a light in cell i, j, k, ghosts included (then i and j begin at -1). */
static inline float* cell_of(const ty_pop_light* light, int32_t i, int32_t j, int32_t k) {
    const int32_t ghosts = ty_pop_ghost_width(&light->grid), row = light->grid.size[0] + 2 * ghosts;
    const int32_t rows = light->grid.size[1] + 2 * ghosts;
    return light->accumulated + (size_t)light->floats * (size_t)((k * rows + j + ghosts) * row + i + ghosts);
}

/* Fills each cell, its ghosts as what it repeats. */
static inline void fill_light(const ty_pop_light* light,
                              void (*fill)(const ty_pop_light*, ty_vec center, float* cell)) {
    const ty_pop_grid* grid = &light->grid;
    const int32_t ghosts = ty_pop_ghost_width(grid);
    for (int32_t k = 0; k < grid->size[2]; ++k)
        for (int32_t j = -ghosts; j < grid->size[1] + ghosts; ++j)
            for (int32_t i = -ghosts; i < grid->size[0] + ghosts; ++i) {
                int32_t from_i = i, from_j = j;
                if (ghosts > 0) ty_octahedral_wrap(grid->size[0], &from_i, &from_j);
                fill(light, ty_pop_cell_center(grid, from_i, from_j, k), cell_of(light, i, j, k));
                if (light->floats == TY_POP_CELL_FLOATS) cell_of(light, i, j, k)[TY_POP_CELL_WEIGHT] = 1;
            }
}

static inline size_t box_cells(const ty_grid_box* box) {
    return (size_t)box->size[0] * (size_t)box->size[1] * (size_t)box->size[2];
}

static inline ty_pop_merged make_merged(const ty_grid_box* box, bool left) {
    ty_pop_merged merged = {.box = *box};
    const size_t cells = box_cells(box);
    for (int c = 0; c < 3; ++c) {
        merged.accumulated_radiance[c] = new_floats(cells);
        merged.fluence[c] = new_floats(cells);
        if (left) merged.unpropagated[c] = new_floats(cells);
    }
    return merged;
}

static inline void free_merged(ty_pop_merged* merged) {
    for (int c = 0; c < 3; ++c) {
        free(merged->accumulated_radiance[c]);
        free(merged->fluence[c]);
        free(merged->unpropagated[c]);
    }
}

static inline ty_vec merged_center(const ty_grid_box* box, size_t cell) {
    const size_t row = (size_t)box->size[0], slice = row * (size_t)box->size[1];
    const size_t at[3] = {cell % row, cell / row % (size_t)box->size[1], cell / slice};
    double center[3];
    for (int a = 0; a < 3; ++a)
        center[a] = box->lower[a] + ((double)at[a] + 0.5) * (box->upper[a] - box->lower[a]) / box->size[a];
    return ty_vec_make((float)center[0], (float)center[1], (float)center[2]);
}

#endif
