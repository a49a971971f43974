/* The volume that corpus/vdb/vectors.vdb and the NanoVDB files made from it hold, by formula. */
#ifndef TY_TESTS_SMALL_VOLUME_H
#define TY_TESTS_SMALL_VOLUME_H

#include "files.h"

#include <tyndall/io.h>

#include <math.h>

/* density at a place in the file's indices: a ramp in a box, a tile of 5, else background. */
static inline float small_density(int x, int y, int z) {
    if (x >= -5 && x < 11 && y >= -3 && y < 5 && z >= -3 && z < 9)
        return (float)((x * 5 + y * 3 + z * 7 + 100) % 64) / 64;
    return x >= 16 && x < 24 && y >= 0 && y < 8 && z >= 0 && z < 8 ? 5 : 0.25f;
}

/* True if a grid with its first voxel at the files' lowest index holds scale times density, to a tolerance. */
static inline void assert_small_values(const ty_grid* grid, float scale, double tolerance) {
    const ty_grid_info info = ty_grid_get_info(grid);
    for (int z = 0; z < info.size[2]; ++z)
        for (int y = 0; y < info.size[1]; ++y)
            for (int x = 0; x < info.size[0]; ++x) {
                const double expected = (double)(scale * small_density(x - 5, y - 3, z - 3));
                if (fabs((double)ty_grid_voxel(grid, x, y, z) - expected) > tolerance)
                    fail_msg("voxel %d %d %d is %g, not %g", x, y, z, (double)ty_grid_voxel(grid, x, y, z), expected);
            }
}

/* Its transform: columns (2, 0, 0), (0.5, 3, 0), (0, 0, 4), moved by (10, 20, 30), at index (-5, -3, -3). */
static inline void assert_small_place(const ty_grid* grid) {
    static const double expected[12] = {2, 0.5, 0, -1.5, 0, 3, 0, 11, 0, 0, 4, 18};
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_true(info.placed);
    for (int i = 0; i < 12; ++i) assert_true(fabs(info.index_to_local.m[i] - expected[i]) < 1e-12);
}

#endif
