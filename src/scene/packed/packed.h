/* A committed scene in a device's memory, as its kernels take it. */
#ifndef TY_SCENE_PACKED_PACKED_H
#define TY_SCENE_PACKED_PACKED_H

#include "device/arrays.h"
#include "scene/scene.h"

typedef struct ty_packed_scene {
    ty_address view; /* a ty_scene_view whose pointers are the device's */
    bool glossy;     /* some surface is not Lambertian */
    ty_device_arrays arrays;
} ty_packed_scene;

/* Packs `view`, which is that of the scene or one with fewer media or other lights. Errors: TY_ERROR_MEMORY,
 * TY_ERROR_UNSUPPORTED (more media than a device takes), TY_ERROR_INTERNAL. */
ty_result ty_scene_pack(ty_device* device, const ty_scene* scene, const ty_scene_view* view, ty_packed_scene** out);
void ty_packed_scene_destroy(ty_packed_scene* packed);

#endif
