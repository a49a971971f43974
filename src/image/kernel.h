/* What the marcher hands to its kernel, which is built once per instruction set. */
#ifndef TY_IMAGE_KERNEL_H
#define TY_IMAGE_KERNEL_H

#include "direct/single/single.k.h"
#include "image/march.h"
#include "image/upsample.k.h"
#include "scene/camera.h"
#include "scene/scene.h"

typedef struct ty_march_request {
    const ty_scene_view* scene;
    ty_camera_view camera;
    int32_t spp;
    float first;         /* where in a step the first pixel's rays begin, of a step */
    float step;          /* voxels, or cells */
    ty_cell_place light; /* the cells that lights lie on */
    const ty_light_fluence* lights;
    int32_t light_count;
    int32_t reduced;    /* as in ty_march_def */
    ty_forward_fit fit; /* no bands: none */
    TY_GLOBAL const float* blurred;
    int32_t has_field;
    ty_upsample_view field;
    ty_upsample_view surface_field; /* what surfaces in the field's box are lit by */
    int32_t has_background;         /* whether environments are seen */
} ty_march_request;

/* Sums over the rays of a pixel. */
typedef struct ty_march_pixel {
    float unscattered[3]; /* environment, and what media send */
    float single[3], multiple[3], transmittance[3];
    float depth, hits;
} ty_march_pixel;

/* Pixels [begin, end) of row y to pixels[0] and on; returns the steps taken. */
#define TY_MARCH_KERNEL(name)                                                                                          \
    uint64_t name(const ty_march_request* request, int32_t y, int32_t begin, int32_t end, ty_march_pixel* pixels)
typedef TY_MARCH_KERNEL((*ty_march_kernel));
TY_MARCH_KERNEL(ty_march_kernel_v1);
TY_MARCH_KERNEL(ty_march_kernel_v3);
TY_MARCH_KERNEL(ty_march_kernel_v4);

#endif
