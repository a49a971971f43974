/* The field of multiply scattered light that every volume method hands to the marcher. */
#ifndef TY_DIRECT_SINGLE_SOURCE_FIELD_H
#define TY_DIRECT_SINGLE_SOURCE_FIELD_H

#include "direct/media/grid_medium.h"
#include "direct/single/single.k.h"

enum { TY_FIELD_TERMS = 4 };

/* Multiply scattered light on a box of cells, as means over cells. The radiance (W m^-2 sr^-1) that travels along a
 * unit vector omega is terms[c][0] + (terms[c][1], terms[c][2], terms[c][3]) . omega: terms[c][0] is fluence / (4 pi),
 * the others are 3 flux / (4 pi). A medium of mean cosine g scatters into omega, per metre and scattering coefficient,
 * terms[c][0] + g (terms[c][1], terms[c][2], terms[c][3]) . omega and a third moment derived from them
 * (docs/marching.md), clamped at 0. Outside of the box the field is 0. Surfaces are lit by the radiance itself. Arrays
 * belong to the caller. */
typedef struct ty_source_field {
    ty_grid_box box;
    int32_t term_count;                    /* 1: isotropic; 4 */
    const float* terms[3][TY_FIELD_TERMS]; /* per channel, x fastest */
    bool shared; /* all channels are the first one's terms times color, and the others' are not read */
    float color[3];
    /* Nonzero for cells so thick that only light near a face of theirs is seen: their values are that, and no means.
     * NULL: none. */
    const uint8_t* at_face;
    const float* guide; /* mean extinction over channels, 1/m; NULL: no bilateral upsampling */
} ty_source_field;

/* Weights for interpolation between the cell centers of a box at a point, m. */
static inline ty_cell_point ty_coverage_locate(const ty_grid_box* box, const double point[3]) {
    float cells[3];
    for (int a = 0; a < 3; ++a)
        cells[a] = (float)((point[a] - box->lower[a]) * box->size[a] / (box->upper[a] - box->lower[a]));
    return ty_cell_locate(box->size, ty_vec_load(cells));
}

#endif
