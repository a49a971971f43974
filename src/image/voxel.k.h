/* The eight voxels around a point, fetched together. */
#ifndef TY_IMAGE_VOXEL_K_H
#define TY_IMAGE_VOXEL_K_H

#include "scene/medium.k.h"

/* The voxels from `cell` on, x fastest; values[] is what they are in. */
TY_FN void ty_voxels_fetch(TY_GLOBAL const ty_grid_view* grid, const int32_t cell[3], float values[8]) {
    const int32_t* size = grid->size;
    if ((uint32_t)cell[0] >= (uint32_t)(size[0] - 1) || (uint32_t)cell[1] >= (uint32_t)(size[1] - 1) ||
        (uint32_t)cell[2] >= (uint32_t)(size[2] - 1)) {
        for (int i = 0; i < 8; ++i)
            values[i] = ty_grid_fetch(grid, cell[0] + (i & 1), cell[1] + (i >> 1 & 1), cell[2] + (i >> 2));
        return;
    }
    const size_t row = (size_t)size[0], plane = row * (size_t)size[1];
    const size_t base = (size_t)cell[0] + row * (size_t)cell[1] + plane * (size_t)cell[2];
    if (grid->floats != NULL) {
        TY_GLOBAL const float* from = grid->floats + base;
        for (int i = 0; i < 8; ++i) values[i] = from[(i & 1) + (i >> 1 & 1) * row + (i >> 2) * plane];
        return;
    }
    TY_GLOBAL const uint16_t* from = grid->halves + base;
    for (int i = 0; i < 8; ++i) values[i] = ty_half_to_float(from[(i & 1) + (i >> 1 & 1) * row + (i >> 2) * plane]);
}

/* Trilinear between them. */
TY_FN float ty_voxels_between(const float v[8], float x, float y, float z) {
    const float low = ty_lerpf(ty_lerpf(v[0], v[1], x), ty_lerpf(v[2], v[3], x), y);
    const float high = ty_lerpf(ty_lerpf(v[4], v[5], x), ty_lerpf(v[6], v[7], x), y);
    return ty_lerpf(low, high, z);
}

/* What a medium makes of its grid's value. */
TY_FN float ty_voxels_to_density(TY_GLOBAL const ty_medium_view* medium, float value) {
    if (medium->transfer != NULL) return ty_transfer_density(medium->transfer, medium->transfer_count, value);
    return ty_maxf(0.0f, value);
}

/* The density of a medium that has a grid at a point in its index space. */
TY_FN float ty_voxels_density(TY_GLOBAL const ty_medium_view* medium, ty_vec p) {
    const ty_vec low = ty_vec_make(floorf(p.x), floorf(p.y), floorf(p.z));
    const int32_t cell[3] = {(int32_t)low.x, (int32_t)low.y, (int32_t)low.z};
    float values[8];
    ty_voxels_fetch(&medium->grid, cell, values);
    return ty_voxels_to_density(medium, ty_voxels_between(values, p.x - low.x, p.y - low.y, p.z - low.z));
}

#endif
