/* The rays of accel.h that kernels trace, by our own hierarchy, on devices: there a ty_accel is a ty_bvh. */
#ifndef TY_SCENE_SURFACES_BVH_ACCEL_K_H
#define TY_SCENE_SURFACES_BVH_ACCEL_K_H

#include "scene/surfaces/accel.h"
#include "scene/surfaces/bvh.k.h"

TY_FN_APART bool ty_accel_intersect(const ty_accel* mesh, ty_vec origin, ty_vec direction, float far, ty_hit* hit) {
    TY_GLOBAL const ty_bvh* bvh = (TY_GLOBAL const ty_bvh*)mesh;
    ty_bvh_hit found;
    if (!ty_bvh_trace(bvh, origin, direction, far, 0, &found)) return false;
    ty_bvh_complete(bvh, origin, direction, &found, hit);
    return true;
}

TY_FN_APART bool ty_accel_occluded(const ty_accel* mesh, ty_vec origin, ty_vec direction, float far) {
    ty_bvh_hit found;
    return ty_bvh_trace((TY_GLOBAL const ty_bvh*)mesh, origin, direction, far, 1, &found);
}

TY_FN_APART int32_t ty_accel_crossings(const ty_accel* closed, ty_vec origin, ty_vec direction,
                                       ty_crossing crossings[TY_CROSSINGS_MAX], int32_t* beyond) {
    return ty_bvh_crossings((TY_GLOBAL const ty_bvh*)closed, origin, direction, crossings, beyond);
}

#endif
