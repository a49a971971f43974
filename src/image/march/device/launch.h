/* Arguments of the marcher's launches on a device, and its programs. */
#ifndef TY_IMAGE_MARCH_DEVICE_LAUNCH_H
#define TY_IMAGE_MARCH_DEVICE_LAUNCH_H

#include "device/program.h"
#include "image/aovs.h"
#include "image/march/spaced.h"

/* Component c of the channels of a TY_AOV_... */
typedef struct ty_march_channel {
    uint32_t aov;
    int32_t c;
} ty_march_channel;

/* Items begin + index of a program. All arrays are in the device's memory, and so are those that the request names. */
typedef struct ty_march_launch {
    TY_GLOBAL const ty_march_request* request;
    int64_t begin;
    int32_t width, height; /* of the image, pixels */
    int32_t sample, last;  /* spaced rays: the sample of each pixel; nonzero: pixels have no further one */
    ty_spaced_rays lattice;
    TY_GLOBAL ty_march_pixel* sums;        /* of pixels with several samples of spaced rays; NULL: they have one */
    TY_GLOBAL int32_t* faces;              /* at pixels, with a border of one */
    TY_GLOBAL ty_gathered_point* smoothed; /* as many as request->gathered has points */
    TY_GLOBAL float* ranges;               /* 2 of each column of froxels: first and last depth of media, m */
    TY_GLOBAL uint32_t* steps;             /* of each item of a launch; NULL: not counted */
    TY_GLOBAL float* planes;               /* one after another */
    TY_GLOBAL const float* unscattered[3]; /* of the request's def; NULL: none */
    int32_t channel_count;
    ty_march_channel channels[TY_AOV_CHANNELS_MAX]; /* of the planes */
} ty_march_launch;

/* Pixels by rays of their own; what comes before them: points at which irradiance is gathered, their smoothing, faces
 * of thick media at pixels with a border of one, pixels at which those differ. */
extern const ty_program ty_program_march_pixels, ty_program_march_gathered, ty_program_march_smoothed,
    ty_program_march_faces, ty_program_march_edges;
/* Spaced rays, and the pixels between them. */
extern const ty_program ty_program_march_rays, ty_program_march_between;
/* Columns of froxels: their ranges of depths, their light; and pixels by them. */
extern const ty_program ty_program_march_ranges, ty_program_march_columns, ty_program_march_froxels;

#endif
