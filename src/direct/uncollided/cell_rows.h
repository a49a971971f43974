/* Rows of cells in the pyramids around a point light. */
#ifndef TY_DIRECT_UNCOLLIDED_CELL_ROWS_H
#define TY_DIRECT_UNCOLLIDED_CELL_ROWS_H

#include "direct/uncollided/ray_lattice.h"

/* A row of cells along u within a pyramid. */
typedef struct ty_cell_row {
    const ty_ray_lattice* l;
    int32_t slab;
    int32_t cell[3]; /* along u, v, w; of u: 0 */
    size_t first;    /* offset of the row, and between cells, in planes */
    size_t stride;
    double v, w; /* cell centers, m from the light; w > 0 */
    float *mean, *visible, *transmittance[3], *falloff, *omega[3];
} ty_cell_row;

/* A cell's center along an axis, m from the light. */
double ty_point_light_center(const ty_point_light_job* point, int32_t axis, int32_t cell);
/* Floats of scratch for a row: rays, then cells. */
size_t ty_cell_row_scratch(const ty_point_light_job* point);
void ty_cell_row_place(const ty_ray_lattice* l, int32_t slab, int32_t v, float* scratch, ty_cell_row* row);
/* The cells [ranges[n][0], ranges[n][1]) within the pyramid, without those next to the light unless near_too; returns
 * the number of ranges. */
int32_t ty_cell_row_ranges(const ty_cell_row* row, bool near_too, int32_t ranges[2][2]);
/* Interpolation of mean extinction and visibility of the rays around the cells [begin, end). */
ty_ray_row_blend ty_cell_row_rays(const ty_cell_row* row, int32_t plane, int32_t begin, int32_t end);
/* Means over the cells [begin, end), without extinction and result. */
ty_cell_row_means ty_cell_row_means_of(const ty_cell_row* row, int32_t begin, int32_t end);
/* Directions and falloff of these cells, which it fills in. */
void ty_cell_row_find_directions(const ty_cell_row* row, int32_t begin, int32_t end);

#endif
