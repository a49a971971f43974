/* Source fields: what every volume method hands to the marcher. */
#ifndef TY_IMAGE_FIELD_H
#define TY_IMAGE_FIELD_H

#include "direct/grid_medium.h"

enum { TY_FIELD_TERMS = 4 };

/* Light that has scattered (or that media sent) and is scattered again, on a box of cells, as means over cells: the
 * radiance (W m^-2 sr^-1) that a medium sends along a unit vector `way` per metre and per scattering coefficient is
 * terms[c][0] + (terms[c][1], terms[c][2], terms[c][3]) . way, not below 0. Outside of the box it is 0. terms[c][0] is
 * the fluence of that light over 4 pi; the others are what is left of its direction after scattering. Arrays belong to
 * whoever made the field. */
typedef struct ty_source_field {
    ty_grid_box box;
    int32_t term_count;                    /* 1: alike in all directions; 4 */
    const float* terms[3][TY_FIELD_TERMS]; /* per channel, x fastest */
    /* Net flux vector of that light along x, y, z per channel, W m^-2, for surfaces in it; NULL: it comes to them alike
     * from all sides. */
    const float* flux[3][3];
    const float* guide; /* extinction of the cells, mean of the channels, 1/m; NULL: there is no guided upsampling */
} ty_source_field;

#endif
