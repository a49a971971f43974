/* The eight voxels around a point, fetched together. */
#ifndef TY_IMAGE_VOXEL_K_H
#define TY_IMAGE_VOXEL_K_H

#include "scene/media/medium.k.h"

#if defined(__F16C__)
#include <immintrin.h>
#endif

/* Loads eight half-precision voxels: two per row, rows one `row` and one `plane` apart. */
TY_FN void ty_voxels_widen(TY_GLOBAL const uint16_t* from, size_t row, size_t plane, float values[8]) {
#if defined(__F16C__)
    int32_t pairs[4];
    for (size_t i = 0; i < 4; ++i) memcpy(&pairs[i], from + (i & 1) * row + (i >> 1) * plane, sizeof pairs[i]);
    _mm256_storeu_ps(values, _mm256_cvtph_ps(_mm_setr_epi32(pairs[0], pairs[1], pairs[2], pairs[3])));
#else
    for (size_t i = 0; i < 8; ++i) values[i] = ty_half_to_float(from[(i & 1) + (i >> 1 & 1) * row + (i >> 2) * plane]);
#endif
}

/* True if the voxels starting at `cell`, which lie inside, do not lie in one block of a sparse grid. */
TY_FN bool ty_voxels_cross_blocks(TY_GLOBAL const ty_grid_view* grid, const int32_t cell[3]) {
    const int32_t last = TY_GRID_BLOCK - 1;
    return ((cell[0] + grid->shift[0]) & last) == last || ((cell[1] + grid->shift[1]) & last) == last ||
           ((cell[2] + grid->shift[2]) & last) == last;
}

/* The eight voxels starting at `cell`, x fastest. */
TY_FN void ty_voxels_fetch(TY_GLOBAL const ty_grid_view* grid, const int32_t cell[3], float values[8]) {
    const int32_t* size = grid->size;
    const bool sparse = grid->table != NULL;
    if ((uint32_t)cell[0] >= (uint32_t)(size[0] - 1) || (uint32_t)cell[1] >= (uint32_t)(size[1] - 1) ||
        (uint32_t)cell[2] >= (uint32_t)(size[2] - 1) || (sparse && ty_voxels_cross_blocks(grid, cell))) {
        for (int i = 0; i < 8; ++i)
            values[i] = ty_grid_fetch(grid, cell[0] + (i & 1), cell[1] + (i >> 1 & 1), cell[2] + (i >> 2));
        return;
    }
    const size_t row = sparse ? TY_GRID_BLOCK : (size_t)size[0],
                 plane = row * (sparse ? TY_GRID_BLOCK : (size_t)size[1]);
    const size_t base = ty_grid_offset(grid, cell[0], cell[1], cell[2]);
    if (grid->floats == NULL) {
        ty_voxels_widen(grid->halves + base, row, plane, values);
        return;
    }
    TY_GLOBAL const float* from = grid->floats + base;
    for (size_t i = 0; i < 4; ++i) memcpy(&values[2 * i], from + (i & 1) * row + (i >> 1) * plane, 2 * sizeof *values);
}

/* Trilinear interpolation; along z first, four at once. */
TY_FN float ty_voxels_interpolate(const float values[8], float x, float y, float z) {
    float edge[4];
    for (int i = 0; i < 4; ++i) edge[i] = ty_lerpf(values[i], values[i + 4], z);
    return ty_lerpf(ty_lerpf(edge[0], edge[2], y), ty_lerpf(edge[1], edge[3], y), x);
}

/* Density of a medium from the value of its grid. */
TY_FN float ty_voxels_to_density(TY_GLOBAL const ty_medium_view* medium, float value) {
    if (medium->transfer != NULL) return ty_transfer_density(medium->transfer, medium->transfer_count, value);
    return ty_maxf(0.0f, value);
}

/* Density of a grid medium at a point in its index space. */
TY_FN float ty_voxels_density(TY_GLOBAL const ty_medium_view* medium, ty_vec p) {
    const ty_vec base = ty_vec_make(floorf(p.x), floorf(p.y), floorf(p.z));
    const int32_t cell[3] = {(int32_t)base.x, (int32_t)base.y, (int32_t)base.z};
    float values[8];
    ty_voxels_fetch(&medium->grid, cell, values);
    return ty_voxels_to_density(medium, ty_voxels_interpolate(values, p.x - base.x, p.y - base.y, p.z - base.z));
}

#endif
