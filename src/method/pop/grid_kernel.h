/* Loops over columns and cells of ordinates' grids, built once per instruction set. */
#ifndef TY_METHOD_POP_GRID_KERNEL_H
#define TY_METHOD_POP_GRID_KERNEL_H

#include "base/dispatch.h"
#include "method/pop/columns.h"

/* A slab of cells across some columns: coefficients, means over the part of each cell that is in the medium's box. */
typedef struct ty_pop_slab {
    const ty_pop_columns* columns;
    const ty_grid_medium* medium;
    float ends[2];        /* m along columns */
    float middle;         /* of its cells, m along columns */
    float per_metre[3];   /* the medium's cells */
    float usual_g[3];     /* per plane; where nothing scatters */
    int32_t multiples;    /* whether g is that everywhere, and all coefficients are plane 0's extinction times these: */
    float multiple[2][3]; /* extinction and scattering, per plane */
    float length[TY_POP_BLOCK]; /* of the part in the box, m */
    float extinction[3][TY_POP_BLOCK], scattering[3][TY_POP_BLOCK], g[3][TY_POP_BLOCK];
    float lit[TY_POP_BLOCK]; /* light before the medium, as a share of the ordinate's color; in parallel grids of a lamp
                                its fall with distance, too, 1/m^2 */
} ty_pop_slab;

/* Transmittances U, R, S of grid.h per plane. */
typedef struct ty_pop_transmittance {
    int32_t orders;                  /* 1: U alone; 3 */
    float along[3][3][TY_POP_BLOCK]; /* up to the slab */
    float* mean[3][3];               /* over cells, times lit */
} ty_pop_transmittance;

/* What is seen of a slab. */
typedef struct ty_pop_look {
    float eye[3];                    /* m from the medium's lower corner */
    float mu[TY_POP_BLOCK];          /* cosines of light that scatters towards the eye */
    float cosine;                    /* a_n */
    float width;                     /* of the disc that has this mean cosine (ty_pop_disc_width) */
    const float* mean[3][3];         /* U, R, S per plane */
    float radiance[3][TY_POP_BLOCK]; /* per plane */
} ty_pop_look;

/* Modes published and collided. Slices of cells have a ring around them, in which factors and light are 0. */
enum { TY_POP_WALK_PLANE_ARRAYS = 7, TY_POP_WALK_ARRAYS = 4, TY_POP_WALK_SLICES = 13 };

/* What half a cell does to light that comes in or goes out, along k and across: how much absorption leaves, and how
 * much scattering leaves of mean cosines. */
typedef struct ty_pop_half_cells {
    const float *pass[2], *keep[2];
} ty_pop_half_cells;

/* What a slice of cells hands to those in front, beside and behind, and that times its mean cosine. */
typedef struct ty_pop_handed {
    float *front, *side, *back, *front_turned, *side_turned, *back_turned;
} ty_pop_handed;

/* What the walk starts from in a slab. */
typedef struct ty_pop_start {
    int32_t collided; /* whether mode is; else it is published */
    int32_t plane;
    float across;      /* how far it is to the next cell beside, as part of the slab's thickness */
    const float* mean; /* light that has not scattered, with surfaces' shadows */
    float light[TY_POP_BLOCK], again[TY_POP_BLOCK]; /* as in ty_pop_take */
    float pass[2][TY_POP_BLOCK], keep[2][TY_POP_BLOCK];
} ty_pop_start;

/* What has been seen of it before the first iteration. */
typedef struct ty_pop_begin {
    int32_t count, collided;
    float cosine; /* a_n */
    const float *uncollided, *light, *again, *tilt;
    float *cosines, *fluence, *seen;
} ty_pop_begin;

typedef struct ty_pop_give {
    int32_t count;
    ty_pop_half_cells half;
    const float *light, *cosine;
    ty_pop_handed out;
} ty_pop_give;

typedef struct ty_pop_take {
    int32_t row;        /* cells of a row, ring included */
    int32_t begin, end; /* cells; sides reach a row further */
    ty_pop_half_cells half;
    ty_pop_handed before, beside, after; /* slices k - 1, k, k + 1 */
    const float *tilt,
        *again; /* 2 (1 - mu) towards the eye; mean cosine of what scatters there once more, 1: nothing */
    float *light, *cosine;
    float *fluence, *seen; /* added to */
} ty_pop_take;

typedef struct ty_pop_grid_kernels {
    /* By how much more than allowed, all cells together, a plane is not a multiple of another, and g not a value where
     * there is scattering. */
    float (*misfit)(const float* plane, const float* other, float multiple, float allowed, int32_t cells);
    float (*unevenness)(const float* g, const float* scattering, float value, float allowed, int32_t cells);
    void (*sample)(ty_pop_slab* slab);
    void (*light)(ty_pop_slab* slab);
    void (*pass)(const ty_pop_slab* slab, ty_pop_transmittance* transmittance);
    /* What a plane turns aside of a fluence R, W per color. */
    float (*turned)(const ty_pop_slab* slab, int32_t plane, const float* kept);
    void (*look)(const ty_pop_slab* slab, ty_pop_look* look);
    void (*scatter)(const ty_pop_slab* slab, ty_pop_look* look);
    void (*start)(const ty_pop_slab* slab, ty_pop_start* start);
    void (*begin)(const ty_pop_begin* begin);
    float (*sum)(const float* values, int32_t count);
    void (*give)(const ty_pop_give* give);
    void (*take)(const ty_pop_take* take);
} ty_pop_grid_kernels;
TY_DECLARE_KERNELS(ty_pop_grid_kernels);

#endif
