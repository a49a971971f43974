/* The request from the marcher to its kernel, which is built once per instruction set. */
#ifndef TY_IMAGE_KERNEL_H
#define TY_IMAGE_KERNEL_H

#include "base/dispatch.h"
#include "direct/single/single.k.h"
#include "image/march.h"
#include "image/upsample.k.h"
#include "scene/camera.h"
#include "scene/scene.h"

typedef struct ty_march_request {
    const ty_scene_view* scene;
    ty_camera_view camera;
    int32_t spp;
    float step_offset;     /* offset of the first pixel's first step, as a fraction of a step */
    float step;            /* voxels, or cells */
    float black;           /* transmittance below which a ray ends as opaque */
    ty_cell_lattice light; /* lattice of the lights' fluence */
    const ty_light_fluence* lights;
    int32_t light_count;
    int32_t reduced;     /* as in ty_march_def */
    int32_t has_forward; /* 1: forward fractions of orders L and L + 1 are given in place of powers of g */
    float forward[2];
    ty_forward_fit fit;       /* bands 0: none */
    ty_march_octaves octaves; /* count 0: none */
    TY_GLOBAL const float* blurred;
    int32_t has_field;
    ty_upsample_view field;
    ty_upsample_view surface_field; /* field that lights surfaces inside its box */
    int32_t has_background;         /* 1: environments are visible */
} ty_march_request;

/* Sums over the rays of a pixel. */
typedef struct ty_march_pixel {
    float unscattered[3]; /* environment, and emission of media */
    float single[3], multiple[3], transmittance[3];
    float depth, hits;
} ty_march_pixel;

/* Marches pixels [begin, end) of row y into pixels[0..]; returns the number of steps. */
#define TY_MARCH_KERNEL(name)                                                                                          \
    uint64_t name(const ty_march_request* request, int32_t y, int32_t begin, int32_t end, ty_march_pixel* pixels)
typedef TY_MARCH_KERNEL((*ty_march_kernel));
TY_DECLARE_KERNEL_FUNCTION(TY_MARCH_KERNEL, ty_march_kernel);

#endif
