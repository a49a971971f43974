/* Marching on the device of a context. */
#ifndef TY_IMAGE_MARCH_DEVICE_DEVICE_H
#define TY_IMAGE_MARCH_DEVICE_DEVICE_H

#include "image/march/request.h"

typedef struct ty_marched_on_device {
    bool stats;       /* asked for: steps are counted, which costs a copy from the device for each launch */
    const char* kind; /* of the device; NULL: the processor is to march */
    uint64_t steps;
} ty_marched_on_device;

/* Marches the pixels of an image that exists. The processor is to do so where the context has no device, or the scene
 * has more media than a device's thread has memory for. Errors: those of ty_context_device and ty_scene_pack,
 * TY_CANCELLED. */
ty_result ty_march_on_device(const ty_scene* scene, const ty_march_def* def, const ty_packed_request* packed,
                             ty_image* image, ty_marched_on_device* out);

#endif
