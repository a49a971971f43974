/* Cells of a plane of the wavefront. */
#ifndef TY_SOLVE_ORDINATES_DEVICE_PLANE_K_H
#define TY_SOLVE_ORDINATES_DEVICE_PLANE_K_H

#include "solve/ordinates/device/launch.h"

/* The place along an axis, from the side where an octant's directions begin. */
TY_FN int32_t ty_plane_place(TY_GLOBAL const ty_ordinates_launch* launch, int32_t octant, int axis, int32_t at) {
    return (octant >> axis & 1) != 0 ? launch->size[axis] - 1 - at : at;
}

/* The x of the cell of column (y, z) in an octant's plane; negative: none. */
TY_FN int32_t ty_plane_cell(TY_GLOBAL const ty_ordinates_launch* launch, int32_t octant, int32_t y, int32_t z) {
    const int32_t i = launch->plane - ty_plane_place(launch, octant, 1, y) - ty_plane_place(launch, octant, 2, z);
    return i >= 0 && i < launch->size[0] ? ty_plane_place(launch, octant, 0, i) : -1;
}

/* True if a cell is in an octant's plane. */
TY_FN bool ty_plane_has(TY_GLOBAL const ty_ordinates_launch* launch, int32_t octant, const int32_t at[3]) {
    return ty_plane_place(launch, octant, 0, at[0]) + ty_plane_place(launch, octant, 1, at[1]) +
               ty_plane_place(launch, octant, 2, at[2]) ==
           launch->plane;
}

#endif
