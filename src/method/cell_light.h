/* Light on cells from a solve, as one method hands it to another, or to shaders. */
#ifndef TY_METHOD_CELL_LIGHT_H
#define TY_METHOD_CELL_LIGHT_H

#include "direct/media/grid_medium.h"

#include <tyndall/dom.h>

/* Means over the cells of a box, x fastest, in luminance, W m^-2: of light that scattered and of light that did not. */
typedef struct ty_cell_light {
    ty_context* context;
    size_t cells;
    float* fluence;
    float* flux[3];
} ty_cell_light;

/* The light of a committed scene with media on the cells of a box, by method dom with few directions and cells. Cells
 * outside of its media are dark. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
ty_result ty_dom_cell_light(const ty_scene* scene, const ty_grid_box* box, uint64_t seed, ty_cell_light* out);
void ty_cell_light_free(ty_cell_light* light);

enum { TY_CELL_BANDS = 5, TY_CELL_TERMS = TY_CELL_BANDS * TY_CELL_BANDS };

/* Means over a caller's cells, x fastest, in the caller's arrays. */
typedef struct ty_cell_moments {
    double* unscattered; /* fluence of directional, point and spot lights that has not scattered, W m^-2: 3 a cell */
    double* rest;        /* fluence of all other light, W m^-2: 3 a cell */
    float* moments; /* of its luminance, phi_lm: the integrals of radiance times Y_lm, W m^-2: TY_CELL_TERMS a cell */
    float* cosines; /* of its channels: mean cosines with the flux of its luminance: 3 a cell */
} ty_cell_moments;

/* The light of a solution on cells. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_dom_cell_moments(const ty_dom* light, const double lower[3], const double upper[3], const int32_t size[3],
                              ty_cell_moments* out);

#endif
