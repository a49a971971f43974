/* A ray from voxel to voxel of a regular grid (Amanatides and Woo, A Fast Voxel Traversal Algorithm, 1987). */
#ifndef TY_BASE_VOXEL_DDA_H
#define TY_BASE_VOXEL_DDA_H

#include <math.h>
#include <stdint.h>

typedef struct ty_voxel_dda {
    double next[3], per_voxel[3]; /* distance at which the ray leaves its voxel along each axis, and through one, m */
    int32_t voxel[3], step[3];
} ty_voxel_dda;

/* Sets the ray's voxel along an axis, whose faces are at low and high, m from the ray's origin, and side apart. */
static inline void ty_voxel_dda_set(ty_voxel_dda* dda, int axis, int32_t voxel, double direction, double low,
                                    double high, double side) {
    dda->voxel[axis] = voxel;
    dda->step[axis] = direction > 0 ? 1 : -1;
    dda->next[axis] = direction != 0 ? (direction > 0 ? high : low) / direction : INFINITY;
    dda->per_voxel[axis] = direction != 0 ? side / fabs(direction) : INFINITY;
}

/* The axis along which the ray leaves its voxel first. */
static inline int ty_voxel_dda_axis(const ty_voxel_dda* dda) {
    const int xy = dda->next[0] < dda->next[1] ? 0 : 1;
    return dda->next[xy] < dda->next[2] ? xy : 2;
}

/* Moves to the neighbour along that axis. */
static inline void ty_voxel_dda_advance(ty_voxel_dda* dda, int axis) {
    dda->next[axis] += dda->per_voxel[axis];
    dda->voxel[axis] += dda->step[axis];
}

#endif
