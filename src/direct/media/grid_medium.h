/* The scene's media on a box of equal cells: the input of all grid methods. */
#ifndef TY_DIRECT_MEDIA_GRID_MEDIUM_H
#define TY_DIRECT_MEDIA_GRID_MEDIUM_H

#include <tyndall/scene.h>

/* A box, m, divided into cells. */
typedef struct ty_grid_box {
    double lower[3], upper[3];
    int32_t size[3]; /* cells, each 1..16384 */
} ty_grid_box;

/* Means over cells, x fastest. Where coefficients are gray, the three planes are the same array. */
typedef struct ty_grid_medium {
    ty_context* context;
    ty_grid_box box;
    double cell[3]; /* sides of a cell, m */
    size_t cells;
    int32_t planes;       /* 1: gray coefficients; 3: one plane per channel */
    float* extinction[3]; /* sigma_t, 1/m */
    float* scattering[3]; /* sigma_s, 1/m */
    float* g[3];          /* mean cosine, weighted by scattering; 0 where nothing scatters */
    float* emission[3];   /* j, W m^-3: 4 pi times absorption coefficient times emitted radiance; NULL: nothing emits */
    /* Legendre moments 0..13 of the phase function of all media, where they have one in common that is not
       Henyey-Greenstein; legendre[0] is 0 otherwise, and moments are powers of g. */
    float legendre[TY_PHASE_ORDER_MAX + 1];
    uint32_t periodic; /* axes along which the scene repeats, bit a for axis a */
} ty_grid_medium;

/* The bounding box of all media with cells as small as their finest voxels, but at most `longest` along a side; media
 * without voxels get `longest` cells along the longest side. Errors: TY_ERROR_ARGUMENT (nothing committed, no media,
 * longest). */
ty_result ty_grid_box_fit(const ty_scene* scene, int32_t longest, ty_grid_box* out);

/* Resolves a method's option for `longest`: 0 means the number of the finest voxels, at most 256, and 64 where no
 * medium has voxels. The scene is committed. */
int32_t ty_grid_box_longest(const ty_scene* scene, int32_t asked);

/* Numbers of nearly cubic cells along a box's sides, `longest` along the longest. */
void ty_grid_box_cut(const ty_grid_box* box, int32_t longest, int32_t size[3]);

/* Samples all media: eight points per voxel (exact for aligned voxels), at most 4096 points per cell, times the
 * fraction of each cell within the medium's bounds. Media outside of the box are left out. Errors: TY_ERROR_ARGUMENT,
 * TY_ERROR_MEMORY. */
ty_result ty_grid_medium_create(const ty_scene* scene, const ty_grid_box* box, ty_grid_medium** out);
/* The same box in other cells, as overlap-weighted means: integrals over the box are conserved. */
ty_result ty_grid_medium_resize(const ty_grid_medium* medium, const int32_t size[3], ty_grid_medium** out);
void ty_grid_medium_destroy(ty_grid_medium* medium);
/* The mean density of one of the scene's media in cells, as the extinction of a medium of one plane. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_grid_medium_density(const ty_scene* scene, int32_t index, const ty_grid_box* box, ty_grid_medium** out);
/* The transpose of that: adds to the voxels of the medium's density, x fastest, the derivatives by it of each cell of a
 * medium on the box. Errors: TY_ERROR_ARGUMENT (rotated grids, transfer functions, negative voxels, no voxels),
 * TY_ERROR_MEMORY. */
ty_result ty_grid_medium_spread_density(const ty_scene* scene, int32_t index, ty_grid_medium* medium,
                                        const double* by_density, double* voxels);

/* The moment of an order that counts as unscattered, where medium->legendre is set: at least 0. */
float ty_grid_medium_forward(const ty_grid_medium* medium, int32_t order);

/* Delta-scaled extinction sigma_t - g^order sigma_s (Wiscombe 1977, delta-M). Order 1 is the reduced extinction of
 * diffusion (similarity), order L the scaling for L Legendre orders. planes: as many as the medium has, of its cells.
 */
void ty_grid_medium_reduce(const ty_grid_medium* medium, int32_t order, float* const planes[3]);
/* Extinction sigma_t - fraction sigma_s with a forward fraction that does not depend on g (delta-fit). */
void ty_grid_medium_reduce_by(const ty_grid_medium* medium, float fraction, float* const planes[3]);

/* Overlap-weighted means of a plane of from_size cells over to_size cells of the same box. */
void ty_grid_average(ty_context* context, const float* from, const int32_t from_size[3], const int32_t to_size[3],
                     float* to);
/* The transpose of ty_grid_average: adds to each of to_size cells the values of from_size cells that it is part of,
 * times its part of them. */
void ty_grid_spread(ty_context* context, const float* from, const int32_t from_size[3], const int32_t to_size[3],
                    float* to);
/* Means of the plane times a plane of weights, and of the plane itself (plain; NULL: not computed). */
void ty_grid_average_both(ty_context* context, const float* from, const float* weight, const int32_t from_size[3],
                          const int32_t to_size[3], float* weighted, float* plain);

#endif
