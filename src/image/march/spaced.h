/* Images from camera rays that lie several pixels apart: the lattice of rays, and the kernels that march and
 * interpolate it, built once per instruction set. docs/marching.md explains it. */
#ifndef TY_IMAGE_SPACED_H
#define TY_IMAGE_SPACED_H

#include "image/march/kernel.h"

enum { TY_SPACING_MAX = 8 };

/* A ray up to the first surface. */
typedef struct ty_spaced_ray {
    float transmittance[3], emission[3], single[3], multiple[3]; /* of the media */
    float distance;                                              /* of the surface, m; TY_FLOAT_MAX: none */
    int32_t gathered;                                            /* 1: the surface lies outside of the field, and */
    ty_vec normal;                                               /* this is its shading normal, */
    float irradiance[3];                                         /* and this its irradiance from media */
} ty_spaced_ray;

/* Rays go through every spacing-th pixel of an image along x and y, and through the last. */
typedef struct ty_spaced_rays {
    TY_GLOBAL ty_spaced_ray* rays; /* columns x rows, row by row */
    int32_t spacing, width, height, columns, rows;
} ty_spaced_rays;

/* Number of rays for a side of so many pixels. */
static inline int32_t ty_spaced_count(int32_t pixels, int32_t spacing) {
    return (pixels + spacing - 2) / spacing + 1;
}

typedef struct ty_spaced_kernels {
    /* Marches rays [begin, end) of a row, the sample-th of their pixels; returns the number of steps. */
    uint64_t (*march)(const ty_march_request* request, const ty_spaced_rays* lattice, int32_t sample, int32_t row,
                      int32_t begin, int32_t end);
    /* Adds the same sample of the pixels [begin, end) of row y to pixels[0..]; returns the number of further steps. */
    uint64_t (*fill)(const ty_march_request* request, const ty_spaced_rays* lattice, int32_t sample, int32_t y,
                     int32_t begin, int32_t end, ty_march_pixel* pixels);
} ty_spaced_kernels;
TY_DECLARE_KERNELS(ty_spaced_kernels);

#endif
