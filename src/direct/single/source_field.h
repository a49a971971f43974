/* Source fields: what every volume method hands to the marcher. */
#ifndef TY_DIRECT_SINGLE_SOURCE_FIELD_H
#define TY_DIRECT_SINGLE_SOURCE_FIELD_H

#include "direct/media/grid_medium.h"

enum { TY_FIELD_TERMS = 4 };

/* Multiply scattered light on a box of cells, as means over cells. The radiance (W m^-2 sr^-1) that travels along a
 * unit vector `way` is terms[c][0] + (terms[c][1], terms[c][2], terms[c][3]) . way, so terms[c][0] is fluence / (4 pi)
 * and the rest are 3 flux / (4 pi). What a medium of mean cosine g sends along `way` per metre and per scattering
 * coefficient is terms[c][0] + g (terms[c][1], terms[c][2], terms[c][3]) . way and a third moment that follows from
 * them (docs/marching.md), not below 0. Outside of the box there is none. Surfaces in it are lit by it as it is. Arrays
 * belong to whoever made the field. */
typedef struct ty_source_field {
    ty_grid_box box;
    int32_t term_count;                    /* 1: alike in all directions; 4 */
    const float* terms[3][TY_FIELD_TERMS]; /* per channel, x fastest */
    bool shared; /* whether all channels are the first one's terms, times color: the others' are not looked at */
    float color[3];
    const float* guide; /* extinction of the cells, mean of the channels, 1/m; NULL: no guided upsampling */
} ty_source_field;

#endif
