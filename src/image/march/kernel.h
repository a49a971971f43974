/* The request from the marcher to its kernel, which is built once per instruction set. */
#ifndef TY_IMAGE_KERNEL_H
#define TY_IMAGE_KERNEL_H

#include "base/dispatch.h"
#include "direct/single/single.k.h"
#include "image/march/gathered.k.h"
#include "image/march/irradiance_cache.k.h"
#include "image/march/march.h"
#include "image/march/upsample.k.h"
#include "scene/camera.h"
#include "scene/scene.h"

/* Light and transmittance from the camera to a point of a column of froxels. */
typedef struct ty_froxel {
    float transmittance[3], emission[3], single[3], multiple[3];
} ty_froxel;

/* Froxels: voxels of the camera's frustum between two depths along its axis, see image/march/froxels.k.h. */
typedef struct ty_froxel_view {
    int32_t size[3];              /* columns, rows, slices; 0: none */
    float pixels[2];              /* width and height of a column, pixels */
    float near, inverse_range;    /* depth of the first slice, m; 1 / (far - near), 1/m */
    float growth;                 /* r of ty_froxel_slice */
    TY_GLOBAL const float* ends;  /* depths of the slices' ends, m: slices + 1, the first is `near` */
    TY_GLOBAL ty_froxel* froxels; /* slices + 1 of each column, at the slices' ends; column by column, row by row */
} ty_froxel_view;

/* Pixels through which edges of thick media pass. */
typedef struct ty_edges_view {
    int32_t rays; /* of such pixels; 0: there are none */
    int32_t width;
    size_t pixels;
    TY_GLOBAL uint8_t* marked; /* nonzero for such pixels, row by row */
} ty_edges_view;

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
    int32_t reduced;      /* as in ty_march_def */
    int32_t traces_faces; /* 1: light through the outer halves of outer cells is traced; 0: it is those cells' */
    int32_t has_forward;  /* 1: forward fractions of orders L and L + 1 are given in place of powers of g */
    float forward[2];
    ty_forward_fit fit;       /* bands 0: none */
    ty_march_octaves octaves; /* count 0: none */
    TY_GLOBAL const float* blurred;
    int32_t has_field;
    ty_upsample_view field;
    ty_upsample_view surface_field; /* field that lights surfaces inside its box */
    ty_irradiance_view cache;       /* of surfaces outside of that box */
    ty_gathered_view gathered;      /* their irradiance at pixels some distance apart */
    int32_t without_emission;       /* 1: surfaces gather no emission of media */
    int32_t has_background;         /* 1: environments are visible */
    ty_froxel_view froxels;
    ty_edges_view edges;
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
TY_DECLARE_KERNEL_FUNCTION(TY_MARCH_KERNEL, ty_march_sampled_kernel);

#endif
