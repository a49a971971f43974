/* The parts of an acceleration structure that serve scenes which are packed for devices again and again. */
#ifndef TY_SCENE_SURFACES_ACCEL_KEPT_H
#define TY_SCENE_SURFACES_ACCEL_KEPT_H

#include "scene/surfaces/bvh.h"

/* A number unlike those of all other structures of this process, and unlike all addresses. */
uint64_t ty_accel_version(const ty_accel* mesh);
/* Room for the hierarchy of the same surfaces, which the structure destroys; at first NULL. */
ty_bvh_data** ty_accel_hierarchy(ty_accel* mesh);

#endif
