/* Interface between denoising and its kernels, which are built once per instruction set and work on a tile of the image
 * with a margin. docs/denoise.md has the method. */
#ifndef TY_IMAGE_DENOISE_KERNEL_H
#define TY_IMAGE_DENOISE_KERNEL_H

#include "base/dispatch.h"
#include "base/kernel.h"

enum {
    TY_DENOISE_TILE = 32,   /* pixels along a side of a tile */
    TY_DENOISE_WINDOW = 16, /* side of the window of a regression, pixels: from 8 before its center to 7 behind */
    TY_DENOISE_BEFORE = 8,
    TY_DENOISE_PATCH = 3, /* radius of the patches by which pixels are compared */
    TY_DENOISE_MARGIN = TY_DENOISE_BEFORE + TY_DENOISE_PATCH,
    TY_DENOISE_ROWS = TY_DENOISE_TILE + 2 * TY_DENOISE_MARGIN,
    TY_DENOISE_PITCH = 64, /* floats from row to row of a tile's planes */
    TY_DENOISE_PLANE = TY_DENOISE_ROWS * TY_DENOISE_PITCH,
    TY_DENOISE_STEP = 2, /* pixels between rows of centers, and half of those between centers in a row */
    TY_DENOISE_CENTERS = TY_DENOISE_TILE / (2 * TY_DENOISE_STEP), /* in a row */
    TY_DENOISE_WEIGHTS = TY_DENOISE_WINDOW * TY_DENOISE_WINDOW,
    TY_DENOISE_DISTANCES = TY_DENOISE_WEIGHTS + 16,             /* floats from center to center */
    TY_DENOISE_REACH = TY_DENOISE_TILE + 2 * TY_DENOISE_BEFORE, /* side of the pixels that a tile predicts */
    TY_DENOISE_PLANES_MAX = 16,                                 /* features */
    TY_DENOISE_CANDIDATES = 3
};

/* The candidates of a pixel: regressions with the narrow and the wide weights, and the wide weights' mean. */
enum { TY_DENOISE_NARROW = 0, TY_DENOISE_WIDE = 1, TY_DENOISE_MEAN = 2 };

typedef struct ty_denoise_tile {
    int32_t width, height; /* pixels of the tile that the image has */
    float softening;       /* added to variances where patches are compared */
    float color[2][3][TY_DENOISE_PLANE];
    float variance[TY_DENOISE_PLANE]; /* of either half, summed over channels */
    float chart[TY_DENOISE_PLANE];    /* negative: the pixel is not used */
    float feature[TY_DENOISE_PLANES_MAX][TY_DENOISE_PLANE];
    float distance[TY_DENOISE_TILE / TY_DENOISE_STEP * TY_DENOISE_CENTERS * TY_DENOISE_DISTANCES];
    /* Sums of weighted predictions of each half, R, G, B, and of their weights. */
    float sums[2][TY_DENOISE_CANDIDATES][4][TY_DENOISE_REACH * TY_DENOISE_REACH];
} ty_denoise_tile;

typedef struct ty_denoise_kernels {
    /* Distances of the pixels in the window of each center from it, by the colors of a half. */
    void (*distances)(ty_denoise_tile* tile, int32_t half);
    /* Adds predictions of a half to its sums, by regression on `features` planes with weights by tile->distance.
     * ridge: variance per feature that is taken for noise. */
    void (*regress)(ty_denoise_tile* tile, int32_t half, int32_t features, const float* ridge);
    /* NL-means of the first `channels` colors of each half by the weights of the other one, over all pixels of the
     * tile: into sums[half][0]. */
    void (*smooth)(ty_denoise_tile* tile, int32_t channels);
} ty_denoise_kernels;
TY_DECLARE_KERNELS(ty_denoise_kernels);

#endif
