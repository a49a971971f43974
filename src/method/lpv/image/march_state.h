/* The state of an image that is being rendered, shared by its passes.
 *
 * The image is rendered in bands of rows, each band tile by tile: first the visible surfaces and the media, then their
 * composite, which needs the media samples of neighbouring rows. Intermediate values are stored for two bands only, so
 * that they stay in caches. With several samples per pixel the passes run once per sample and the results are added. */
#ifndef TY_METHOD_LPV_IMAGE_MARCH_STATE_H
#define TY_METHOD_LPV_IMAGE_MARCH_STATE_H

#include "base/progress.h"
#include "method/lpv/image/image_job.h"
#include "method/lpv/image/kernel.h"
#include "method/lpv/image/output_planes.h"
#include "method/lpv/image/stage_clock.h"
#include "method/lpv/lattice/packed_lattice.h"
#include "scene/camera.h"

#include <pthread.h>
#include <stdatomic.h>

enum { TY_TILE = 16, TY_TILE_PIXELS = TY_TILE * TY_TILE };
/* Rows of a band, and rows whose intermediate values are stored: powers of two. */
enum { TY_BAND = 64, TY_BAND_ROWS_STORED = 2 * TY_BAND };
/* Pixels along a side of the blocks in which a tile's pixels are ordered. */
enum { TY_BLOCK = 4, TY_BLOCK_PIXELS = TY_BLOCK * TY_BLOCK };

/* The surface that a pixel's ray sees. */
typedef struct ty_lpv_pixel {
    int32_t x, y;
    ty_vec direction;
    float distance;          /* m; INFINITY: no surface, and of the fields below only radiance is set */
    ty_vec position, normal; /* normal: shading normal, unit, towards the eye */
    ty_vec facing;           /* geometric normal */
    float margin;            /* offset along the geometric normal that avoids self-intersection, m */
    float albedo[3];
    float radiance[3]; /* towards the eye; of the background where no surface is hit */
} ty_lpv_pixel;

typedef struct ty_lpv_tile {
    int32_t count;
    ty_lpv_pixel
        pixels[TY_TILE_PIXELS]; /* block by block, so that neighbours in the array are neighbours in the image */
} ty_lpv_tile;

typedef struct ty_lpv_march_state {
    const ty_lpv_image_job* job;
    ty_context* context;
    const ty_scene_view* scene;
    const ty_lpv_image_kernels* kernels;
    const char* isa;
    ty_camera_view camera;
    ty_packed_lattices lattices;
    ty_ray_march_request ray_march;
    ty_packed_lattices uncollided;         /* light of job->extended in media */
    ty_ray_march_request uncollided_march; /* lattices NULL: none, or no single scattering */
    ty_light_points light_points;          /* of this sample, for job->extended */
    bool has_media;
    int32_t width, height;
    int32_t pixels_per_ray; /* pixels along a side that share one ray through the media */
    int32_t media_width, media_height;
    float first;                        /* offset of the steps of the first pixel, of a step */
    int32_t samples;                    /* rays per pixel */
    int32_t sample;                     /* the sample that the passes are at */
    float dx, dy;                       /* its position in the pixel */
    float* distance;                    /* of ty_lpv_pixel, m; TY_BAND_ROWS_STORED rows, see ty_lpv_band_index */
    float* surface;                     /* radiance of the surfaces, 3 a pixel; as many rows */
    ty_lpv_media_sample* media_samples; /* TY_BAND_ROWS_STORED / pixels_per_ray rows; NULL: vacuum */
    ty_lpv_upsample upsample;           /* of media_samples */
    ty_lpv_output_planes planes;
    ty_lpv_stats stats; /* the image stages */
    ty_part_progress progress;
    pthread_mutex_t lock; /* guards progress reports */
    _Atomic bool cancelled;
    ty_lpv_stage_clocks clocks;
    _Atomic int64_t rays, marched;
} ty_lpv_march_state;

/* Index of a pixel in the distances and surface radiances stored. */
static inline size_t ty_lpv_band_index(const ty_lpv_march_state* state, int32_t x, int32_t y) {
    return (size_t)(y % TY_BAND_ROWS_STORED) * (size_t)state->width + (size_t)x;
}
/* The media sample of ray (x, y). */
static inline ty_lpv_media_sample* ty_lpv_media_sample_at(const ty_lpv_march_state* state, int32_t x, int32_t y) {
    return state->media_samples +
           (size_t)(y % (TY_BAND_ROWS_STORED / state->pixels_per_ray)) * (size_t)state->media_width + x;
}

#endif
