/* An image in the making: what its passes share. An image is made in bands of rows, each tile by tile: first what is
 * seen of surfaces and media, then both together, which needs the media around. What is seen is kept for two bands, so
 * that it stays in caches. With several rays per pixel all is done for each, and their images are added. */
#ifndef TY_METHOD_LPV_FRAME_H
#define TY_METHOD_LPV_FRAME_H

#include "base/progress.h"
#include "method/lpv/look.h"
#include "method/lpv/pixels.h"
#include "method/lpv/pixels_kernel.h"
#include "scene/camera.h"

#include <pthread.h>
#include <stdatomic.h>

enum { TY_TILE = 16, TY_TILE_PIXELS = TY_TILE * TY_TILE };
/* Rows of a band, and those of which what is seen is kept: powers of two. */
enum { TY_BAND = 64, TY_KEPT = 2 * TY_BAND };
/* Pixels along a side of the blocks in which a tile's pixels are in order. */
enum { TY_BLOCK = 4, TY_BLOCK_PIXELS = TY_BLOCK * TY_BLOCK };

/* What a ray sees of surfaces. */
typedef struct ty_lpv_pixel {
    int32_t x, y;
    ty_vec direction;
    float distance;          /* m; INFINITY: nothing is hit, and what follows but radiance is not set */
    ty_vec position, normal; /* normal: smooth, unit, towards the eye */
    ty_vec facing;           /* of the flat face */
    float margin;            /* so far off the face, m, rays do not meet it again */
    float albedo[3];
    float radiance[3]; /* that leaves towards the eye; of what is behind everything, where nothing is hit */
} ty_lpv_pixel;

typedef struct ty_lpv_tile {
    int32_t count;
    ty_lpv_pixel pixels[TY_TILE_PIXELS]; /* block by block, so that neighbours in the array are so in the image */
} ty_lpv_tile;

/* The image's channels; NULL where they are not asked for. */
typedef struct ty_lpv_planes {
    float *color[3], *transmittance[3], *depth[3], *normal[3], *albedo[3], *single[3], *multiple[3]; /* depth: [0] */
} ty_lpv_planes;

/* What time goes to within passes that do several things, processor nanoseconds. */
enum { TY_CLOCK_VIEW, TY_CLOCK_SURFACES, TY_CLOCK_MARCH, TY_CLOCK_SINGLE, TY_CLOCK_RAYS, TY_CLOCKS };

typedef struct ty_lpv_frame {
    const ty_lpv_image_job* job;
    ty_context* context;
    const ty_scene_view* scene;
    const ty_pixels_kernels* kernels;
    const char* isa;
    ty_camera_view camera;
    ty_lattice_look look;
    ty_fog_request fog;
    bool foggy; /* whether there are media */
    int32_t width, height;
    int32_t shrink; /* pixels along a side for which media are marched once */
    int32_t air_width, air_height;
    float first;          /* where steps begin, of a step */
    int32_t samples;      /* rays per pixel */
    int32_t sample;       /* the one that the passes are at */
    float dx, dy;         /* where in pixels it lies */
    float* distance;      /* m, as in ty_lpv_pixel; of TY_KEPT rows, as ty_lpv_kept says */
    float* surface;       /* 3 a pixel: its radiance; of as many */
    float* hits;          /* rays of a pixel that hit a surface; NULL: nobody asks */
    ty_lpv_air* air;      /* of TY_KEPT / shrink rows; NULL: vacuum */
    ty_upsample upsample; /* of air */
    ty_image* image;      /* sums over samples */
    ty_lpv_planes planes;
    ty_lpv_stats stats; /* its parts of images */
    ty_part_progress progress;
    double done, tiles;   /* of this ray's tiles, and all there are */
    pthread_mutex_t lock; /* guards reporting */
    _Atomic bool cancelled;
    _Atomic int64_t clocks[TY_CLOCKS];
    _Atomic int64_t rays, marched;
} ty_lpv_frame;

/* Where a pixel's distance and surface are kept. */
static inline size_t ty_lpv_kept(const ty_lpv_frame* frame, int32_t x, int32_t y) {
    return (size_t)(y % TY_KEPT) * (size_t)frame->width + (size_t)x;
}
/* The same for what media along ray (x, y) send. */
static inline ty_lpv_air* ty_lpv_kept_air(const ty_lpv_frame* frame, int32_t x, int32_t y) {
    return frame->air + (size_t)(y % (TY_KEPT / frame->shrink)) * (size_t)frame->air_width + x;
}

/* Adds the nanoseconds since `begun` to one of the clocks; returns now. */
int64_t ty_lpv_clock(ty_lpv_frame* frame, int clock, int64_t begun);

/* What the tile's rays see, traced or as the caller has it; its distances, and what is sent, but nothing reflected. */
void ty_lpv_see(ty_lpv_frame* frame, int32_t x, int32_t y, int32_t right, int32_t bottom, ty_lpv_tile* tile);
/* Adds what surfaces reflect of the lights, directly and by the lattice. */
void ty_lpv_shade(ty_lpv_frame* frame, ty_lpv_tile* tile);

/* The pixel of the image that ray (x, y) of the air goes through at half of the resolution, if the image were without
 * end; the same again every TY_AIR_PERIOD pixels. */
void ty_lpv_air_place(int32_t x, int32_t y, int32_t full[2]);
/* Weights of the rays around pixels. */
void ty_lpv_find_weights(ty_lpv_frame* frame);
/* Of a ray that goes so far, m; INFINITY: without end. Without light that was scattered once. */
ty_lpv_seen ty_lpv_seen_of(const ty_fog* fog, float distance);
/* The ray of a pixel of the image. */
ty_fog_way ty_lpv_air_way(const ty_lpv_frame* frame, int32_t x, int32_t y, float offset);
/* Where steps begin, for neighbours as far from one another as can be: (0, 1]. */
float ty_lpv_air_offset(const ty_lpv_frame* frame, int32_t x, int32_t y);
/* A tile of rays through the air: the lattice's light, then light that is scattered once. */
void ty_lpv_march_tile(ty_lpv_frame* frame, int32_t x, int32_t y, int32_t right, int32_t bottom);
void ty_lpv_single_tile(ty_lpv_frame* frame, int32_t x, int32_t y, int32_t right, int32_t bottom);

/* Adds surfaces behind media to the image. */
void ty_lpv_compose_tile(ty_lpv_frame* frame, int32_t x, int32_t y, int32_t right, int32_t bottom);

#endif
