/* Geometry of an ordinate's grid: boxes along its direction, or spherical shells about its point. */
#ifndef TY_METHOD_POP_GRID_GRID_GEOMETRY_K_H
#define TY_METHOD_POP_GRID_GRID_GEOMETRY_K_H

#include "base/octahedral.k.h"
#include "direct/lights/discrete_light.h"

/* Cells i, j, k, with k along the light's direction. Parallel: boxes along three orthogonal axes. Radial: i and j
 * index an octahedral map, whose edges are joined to themselves; the radii of shells k grow by a constant factor. */
typedef struct ty_pop_grid {
    int32_t kind;    /* TY_DISCRETE_DIRECTIONAL, TY_DISCRETE_POINT */
    int32_t size[3]; /* radial: size[0] is size[1] */
    ty_vec axis[3];  /* parallel: unit vectors; axis[2] is the ordinate's direction */
    ty_vec origin;   /* parallel: corner of cell 0, 0, 0; radial: the point; m */
    ty_vec step;     /* parallel: edges of cells, m */
    float inner;     /* radial: inner radius of shell 0, m */
    float growth;    /* radial: natural logarithm of the ratio of successive radii */
} ty_pop_grid;

/* Ghost cells per side around i and j, in arrays that have them: 1 for radial grids, else 0. */
TY_FN int32_t ty_pop_ghost_width(const ty_pop_grid* grid) {
    return grid->kind == TY_DISCRETE_POINT ? 1 : 0;
}

/* Number of cells including ghost cells. */
TY_FN size_t ty_pop_cells_with_ghosts(const ty_pop_grid* grid) {
    const size_t ghosts = 2 * (size_t)ty_pop_ghost_width(grid);
    return ((size_t)grid->size[0] + ghosts) * ((size_t)grid->size[1] + ghosts) * (size_t)grid->size[2];
}

/* Radius at shell coordinate k (in shells), m. */
TY_FN float ty_pop_radius(const ty_pop_grid* grid, float k) {
    return grid->inner * ty_expf(grid->growth * k);
}

/* Direction of light in column i, j. */
TY_FN ty_vec ty_pop_direction(const ty_pop_grid* grid, int32_t i, int32_t j) {
    if (grid->kind == TY_DISCRETE_DIRECTIONAL) return grid->axis[2];
    return ty_octahedral_direction(((float)i + 0.5f) * (2.0f / (float)grid->size[0]) - 1.0f,
                                   ((float)j + 0.5f) * (2.0f / (float)grid->size[1]) - 1.0f);
}

/* Center of a cell, m. */
TY_FN ty_vec ty_pop_cell_center(const ty_pop_grid* grid, int32_t i, int32_t j, int32_t k) {
    if (grid->kind == TY_DISCRETE_POINT)
        return ty_mad(grid->origin, ty_pop_direction(grid, i, j), ty_pop_radius(grid, (float)k + 0.5f));
    const ty_vec across = ty_mad(grid->origin, grid->axis[0], ((float)i + 0.5f) * grid->step.x);
    return ty_mad(ty_mad(across, grid->axis[1], ((float)j + 0.5f) * grid->step.y), grid->axis[2],
                  ((float)k + 0.5f) * grid->step.z);
}

/* Length of a cell along the light's direction, m. */
TY_FN float ty_pop_cell_length(const ty_pop_grid* grid, int32_t k) {
    if (grid->kind == TY_DISCRETE_DIRECTIONAL) return grid->step.z;
    return ty_pop_radius(grid, (float)k + 1.0f) - ty_pop_radius(grid, (float)k);
}

/* Trilinear position among cell centers (ghost cells included), clamped to the outermost centers. */
typedef struct ty_pop_cell_position {
    size_t base;    /* lowest of the eight cells */
    size_t step[3]; /* offset to the next cell along each axis, 0 at the upper edge */
    float fraction[3];
    float inverse_square; /* factor on values stored in radial grids: 1 / r^2, 1/m^2; 1 for parallel grids */
} ty_pop_cell_position;

/* One axis of `size` cells. at: coordinate, cells. */
TY_FN void ty_pop_locate_axis(float at, int32_t size, size_t stride, int32_t axis, ty_pop_cell_position* position) {
    const float from = ty_clampf(at - 0.5f, 0.0f, (float)(size - 1));
    const int32_t cell = (int32_t)from;
    position->fraction[axis] = from - (float)cell;
    position->base += stride * (size_t)cell;
    position->step[axis] = cell + 1 < size ? stride : 0;
}

/* Trilinear position of a point. min_distance: lower bound of r in a radial grid's 1 / r^2, m. */
TY_FN ty_pop_cell_position ty_pop_locate(const ty_pop_grid* grid, float min_distance, ty_vec point) {
    ty_pop_cell_position cell;
    const ty_vec off = ty_sub(point, grid->origin);
    cell.base = 0;
    cell.inverse_square = 1.0f;
    if (grid->kind == TY_DISCRETE_DIRECTIONAL) {
        const size_t row = (size_t)grid->size[0], slice = row * (size_t)grid->size[1];
        ty_pop_locate_axis(ty_dot(off, grid->axis[0]) / grid->step.x, grid->size[0], 1, 0, &cell);
        ty_pop_locate_axis(ty_dot(off, grid->axis[1]) / grid->step.y, grid->size[1], row, 1, &cell);
        ty_pop_locate_axis(ty_dot(off, grid->axis[2]) / grid->step.z, grid->size[2], slice, 2, &cell);
        return cell;
    }
    const int32_t n = grid->size[0];
    const size_t row = (size_t)n + 2, slice = row * row;
    const float distance = sqrtf(ty_maxf(ty_dot(off, off), 1e-30f)),
                clamped = ty_maxf(distance, ty_maxf(min_distance, 1e-6f));
    float u, v;
    ty_octahedral_map(distance > 1e-12f ? off : ty_vec_make(0.0f, 0.0f, 1.0f), &u, &v);
    ty_pop_locate_axis((u + 1.0f) * 0.5f * (float)n + 1.0f, n + 2, 1, 0, &cell);
    ty_pop_locate_axis((v + 1.0f) * 0.5f * (float)n + 1.0f, n + 2, row, 1, &cell);
    ty_pop_locate_axis(ty_logf(distance / grid->inner) / grid->growth, grid->size[2], slice, 2, &cell);
    cell.inverse_square = 1.0f / (clamped * clamped);
    return cell;
}

#endif
