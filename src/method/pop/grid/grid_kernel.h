/* Loops over columns and cells of ordinates' grids, compiled once per instruction set. */
#ifndef TY_METHOD_POP_GRID_GRID_KERNEL_H
#define TY_METHOD_POP_GRID_GRID_KERNEL_H

#include "base/dispatch.h"
#include "method/pop/grid/columns.h"

/* One slab of cells across a block of columns. Coefficients are means over the part of each cell inside the medium's
 * box. */
typedef struct ty_pop_slab {
    const ty_pop_columns* columns;
    const ty_grid_medium* medium;
    float ends[2];        /* distances along columns, m */
    float center;         /* cell centers, m along columns */
    float per_metre[3];   /* cells of the medium per meter */
    float default_g[3];   /* g where the scattering coefficient is 0, per plane */
    int32_t proportional; /* nonzero if g is default_g everywhere and all coefficients are plane 0's extinction times
                             these: */
    float multiple[2][3]; /* extinction and scattering, per plane */
    float length[TY_POP_BLOCK]; /* length inside the medium's box, m */
    float extinction[3][TY_POP_BLOCK], scattering[3][TY_POP_BLOCK], g[3][TY_POP_BLOCK];
    float incident[TY_POP_BLOCK]; /* incident light before attenuation, as a fraction of the ordinate's color; for a
                                     point light in a parallel grid times 1 / r^2, 1/m^2 */
} ty_pop_slab;

/* Transmittances U, R, S of grid.h per plane. */
typedef struct ty_pop_transmittance {
    int32_t orders;                  /* 1: U only; 3: all */
    float along[3][3][TY_POP_BLOCK]; /* at the slab's entry */
    float* mean[3][3];               /* cell means, times incident light */
} ty_pop_transmittance;

/* View of a slab from the eye. */
typedef struct ty_pop_eye_view {
    float eye[3];                    /* m from the medium's lower corner */
    float mu[TY_POP_BLOCK];          /* cosine between the light's direction and the direction to the eye */
    float cosine;                    /* a_n */
    float width;                     /* width of the disc with this mean cosine (ty_pop_disc_width) */
    const float* mean[3][3];         /* U, R, S per plane */
    float radiance[3][TY_POP_BLOCK]; /* towards the eye, per plane */
} ty_pop_eye_view;

typedef struct ty_pop_grid_kernels {
    /* Sums of the errors above `allowed`: of a plane as a multiple of another, and of g as one value wherever
     * scattering is not 0. */
    float (*proportionality_error)(const float* plane, const float* other, float multiple, float allowed,
                                   int32_t cells);
    float (*g_variation)(const float* g, const float* scattering, float value, float allowed, int32_t cells);
    void (*sample)(ty_pop_slab* slab);
    void (*incident_light)(ty_pop_slab* slab);
    void (*attenuate)(const ty_pop_slab* slab, ty_pop_transmittance* transmittance);
    /* Power that a plane scatters out of a forward lobe of the given fluence R, W per unit color. */
    float (*diffuse_power)(const ty_pop_slab* slab, int32_t plane, const float* fluence);
    void (*eye_cosines)(const ty_pop_slab* slab, ty_pop_eye_view* view);
    void (*scatter)(const ty_pop_slab* slab, ty_pop_eye_view* view);
} ty_pop_grid_kernels;
TY_DECLARE_KERNELS(ty_pop_grid_kernels);

#endif
