/* The scene's media on a box of equal cells: what grid methods work on. */
#ifndef TY_DIRECT_MEDIA_GRID_MEDIUM_H
#define TY_DIRECT_MEDIA_GRID_MEDIUM_H

#include <tyndall/scene.h>

/* A box, m, cut into cells. */
typedef struct ty_grid_box {
    double lower[3], upper[3];
    int32_t size[3]; /* cells, each 1..16384 */
} ty_grid_box;

/* Means over cells, x fastest. Where coefficients are alike in all channels, the three planes are one. */
typedef struct ty_grid_medium {
    ty_context* context;
    ty_grid_box box;
    double cell[3]; /* sides of a cell, m */
    size_t cells;
    int32_t planes;       /* 1: coefficients are alike in all channels, 3: they are not */
    float* extinction[3]; /* sigma_t, 1/m */
    float* scattering[3]; /* sigma_s, 1/m */
    float* g[3];          /* mean cosine, weighted by scattering; 0 where nothing scatters */
    float* emission[3];   /* j, W m^-3: 4 pi absorption coefficient times radiance; NULL: nothing glows */
} ty_grid_medium;

/* The box around all media, cut as their finest voxels are but into `longest` cells at most along any side; media
 * without voxels are cut into as many. Errors: TY_ERROR_ARGUMENT (nothing committed, no media, longest). */
ty_result ty_grid_box_fit(const ty_scene* scene, int32_t longest, ty_grid_box* out);

/* What a method's option asks of `longest`: itself, or for 0 as many as the finest voxels, but 256 at most, and 64
 * where no medium has voxels. The scene is committed. */
int32_t ty_grid_box_longest(const ty_scene* scene, int32_t asked);

/* How many about cubic cells a box has along its sides, `longest` along the longest. */
void ty_grid_box_cut(const ty_grid_box* box, int32_t longest, int32_t size[3]);

/* Samples all media: eight points per voxel (which is exact for voxels that cells are aligned with) as long as that is
 * 4096 points a cell at most, times the part of each cell within the medium's bounds. Media outside the box are left
 * out. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
ty_result ty_grid_medium_create(const ty_scene* scene, const ty_grid_box* box, ty_grid_medium** out);
/* The same box in other cells: means over what each new cell covers of the old, so that nothing is lost or added. */
ty_result ty_grid_medium_resize(const ty_grid_medium* medium, const int32_t size[3], ty_grid_medium** out);
void ty_grid_medium_destroy(ty_grid_medium* medium);

/* Extinction that leaves out what scattering sends nearly straight on: sigma_t - g^order sigma_s. Order 1 is the
 * reduced coefficient of diffusion, order L the delta-M scaling of L Legendre terms. planes: as many as the medium has,
 * of its cells. */
void ty_grid_medium_reduce(const ty_grid_medium* medium, int32_t order, float* const planes[3]);
/* The same with a share of what scatters that does not depend on g: sigma_t - share sigma_s. */
void ty_grid_medium_reduce_by(const ty_grid_medium* medium, float fraction, float* const planes[3]);

/* Means of a plane of from_size cells over the cells of another size of the same box, weighted by overlap. */
void ty_grid_average(ty_context* context, const float* from, const int32_t from_size[3], const int32_t to_size[3],
                     float* to);
/* The same of the plane times another of weights, and of the plane itself (plain; NULL: not). */
void ty_grid_average_both(ty_context* context, const float* from, const float* weight, const int32_t from_size[3],
                          const int32_t to_size[3], float* weighted, float* plain);

#endif
