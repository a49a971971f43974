/* Lookup in grids, dense or in blocks. */
#ifndef TY_GRID_LOOKUP_K_H
#define TY_GRID_LOOKUP_K_H

#include "base/half.h"
#include "grid/grid.h"

/* Grid view for kernels, as plain arrays. Exactly one of floats and halves is set. */
typedef struct ty_grid_view {
    TY_GLOBAL const float* floats;
    TY_GLOBAL const uint16_t* halves;
    TY_GLOBAL const float* extremes; /* pairs per brick, see ty_grid */
    int32_t size[3];
    int32_t bricks[3];
    int32_t clamp; /* value outside: 1 nearest edge value, 0 background */
    int32_t wraps; /* bit a: along axis a the grid goes on at its other end */
    float background;
    TY_GLOBAL const uint32_t* table; /* of a sparse grid, see ty_grid_blocks; NULL: dense */
    int32_t table_size[3];
    int32_t shift[3];
    uint32_t block_count;
} ty_grid_view;

TY_FN ty_grid_view ty_grid_get_view(const ty_grid* grid) {
    ty_grid_view view;
    view.floats = grid->type == TY_GRID_F32 ? (const float*)grid->values : NULL;
    view.halves = grid->type == TY_GRID_F16 ? (const uint16_t*)grid->values : NULL;
    view.extremes = grid->extremes;
    for (int a = 0; a < 3; ++a) {
        view.size[a] = grid->size[a];
        view.bricks[a] = grid->bricks[a];
        view.table_size[a] = grid->blocks.size[a];
        view.shift[a] = grid->blocks.shift[a];
    }
    view.table = grid->blocks.table;
    view.block_count = grid->blocks.count;
    view.clamp = grid->placed ? 0 : 1;
    view.wraps = 0;
    view.background = grid->background;
    return view;
}

TY_FN int32_t ty_grid_wrap(int32_t i, int32_t n) {
    const int32_t rest = i % n;
    return rest < 0 ? rest + n : rest;
}

/* Where the value of voxel (i, j, k), which lies inside, is stored. */
TY_FN size_t ty_grid_offset(const ty_grid_view* grid, int32_t i, int32_t j, int32_t k) {
    if (grid->table == NULL) {
        const size_t nx = (size_t)grid->size[0], ny = (size_t)grid->size[1];
        return (size_t)i + nx * ((size_t)j + ny * (size_t)k);
    }
    const uint32_t x = (uint32_t)(i + grid->shift[0]), y = (uint32_t)(j + grid->shift[1]);
    const uint32_t z = (uint32_t)(k + grid->shift[2]), in_block = TY_GRID_BLOCK - 1;
    const size_t row =
        (size_t)(z >> TY_GRID_BLOCK_LOG2) * (size_t)grid->table_size[1] + (size_t)(y >> TY_GRID_BLOCK_LOG2);
    const size_t block = grid->table[row * (size_t)grid->table_size[0] + (size_t)(x >> TY_GRID_BLOCK_LOG2)];
    return block * TY_GRID_BLOCK_VOXELS +
           ((x & in_block) + TY_GRID_BLOCK * ((y & in_block) + TY_GRID_BLOCK * (z & in_block)));
}

/* Number of voxels from (i, j, k) on along x that are stored one after the other, from *offset on. */
TY_FN int32_t ty_grid_run(const ty_grid_view* grid, int32_t i, int32_t j, int32_t k, size_t* offset) {
    const int32_t row = grid->size[0] - i, block = TY_GRID_BLOCK - ((i + grid->shift[0]) & (TY_GRID_BLOCK - 1));
    *offset = ty_grid_offset(grid, i, j, k);
    return grid->table != NULL && block < row ? block : row;
}

/* Value of voxel (i, j, k), which may lie outside. */
TY_FN float ty_grid_fetch(const ty_grid_view* grid, int32_t i, int32_t j, int32_t k) {
    const int32_t nx = grid->size[0], ny = grid->size[1], nz = grid->size[2];
    if ((uint32_t)i >= (uint32_t)nx || (uint32_t)j >= (uint32_t)ny || (uint32_t)k >= (uint32_t)nz) {
        if ((grid->wraps & 1) != 0) i = ty_grid_wrap(i, nx);
        if ((grid->wraps & 2) != 0) j = ty_grid_wrap(j, ny);
        if ((grid->wraps & 4) != 0) k = ty_grid_wrap(k, nz);
        const bool outside = (uint32_t)i >= (uint32_t)nx || (uint32_t)j >= (uint32_t)ny || (uint32_t)k >= (uint32_t)nz;
        if (grid->clamp == 0 && outside) return grid->background;
        i = i < 0 ? 0 : i >= nx ? nx - 1 : i;
        j = j < 0 ? 0 : j >= ny ? ny - 1 : j;
        k = k < 0 ? 0 : k >= nz ? nz - 1 : k;
    }
    const size_t at = ty_grid_offset(grid, i, j, k);
    return grid->floats != NULL ? grid->floats[at] : ty_half_to_float(grid->halves[at]);
}

/* Trilinear interpolation of the eight voxels from base; weight in [0, 1] per axis. */
TY_FN float ty_grid_trilinear(const ty_grid_view* grid, const int32_t base[3], const float weight[3]) {
    float plane[2];
    for (int k = 0; k < 2; ++k) {
        float row[2];
        for (int j = 0; j < 2; ++j)
            row[j] = ty_lerpf(ty_grid_fetch(grid, base[0], base[1] + j, base[2] + k),
                              ty_grid_fetch(grid, base[0] + 1, base[1] + j, base[2] + k), weight[0]);
        plane[k] = ty_lerpf(row[0], row[1], weight[1]);
    }
    return ty_lerpf(plane[0], plane[1], weight[2]);
}

#endif
