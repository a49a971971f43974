/* Images from froxels: their depths and memory, and the kernels that fill them and look them up, built once per
 * instruction set. docs/marching.md explains them. */
#ifndef TY_IMAGE_FROXELS_H
#define TY_IMAGE_FROXELS_H

#include "image/march/kernel.h"

/* Largest numbers of columns, rows and slices. */
enum { TY_FROXEL_COLUMNS_MAX = 1024, TY_FROXEL_ROWS_MAX = 4096, TY_FROXEL_SLICES_MAX = 1024 };

typedef struct ty_froxel_kernels {
    /* Widens the range of depths, m, by the media along the rays of a row of columns. */
    void (*add_range)(const ty_march_request* request, int32_t row, float range[2]);
    /* Marches the columns of a row; returns the number of steps. */
    uint64_t (*fill)(const ty_march_request* request, int32_t row);
    ty_march_kernel look_up; /* pixels from filled froxels */
} ty_froxel_kernels;
TY_DECLARE_KERNELS(ty_froxel_kernels);

/* A view of this size without depths and memory. width, height: of the image, pixels. */
ty_froxel_view ty_froxels_lay_out(const int32_t size[3], int32_t width, int32_t height);
size_t ty_froxels_count(const ty_froxel_view* grid);
/* Sets depths between those of the first and the last medium in view, m, and the ends of the slices. */
void ty_froxels_set_ends(ty_froxel_view* grid, const float range[2], float* ends);

/* Creates the froxels of a request whose scene, camera and spp are set, not yet filled, between the first and the last
 * depth of the media in view. size: columns, rows and slices; width, height: of the image, pixels. To be destroyed
 * after errors, too. Errors: TY_ERROR_MEMORY. */
ty_result ty_froxels_create(ty_context* context, ty_march_request* request, const int32_t size[3], int32_t width,
                            int32_t height);
void ty_froxels_destroy(ty_context* context, ty_froxel_view* grid);

#endif
