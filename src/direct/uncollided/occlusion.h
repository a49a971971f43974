/* Occlusion distances per ray, for grids that store only the nearest hit per ray. A ray outside of the box can disagree
 * with its neighbouring cell about a surface that lies in a face of the box. So occlusion is defined inside of a
 * slightly shrunken box and extended constantly outside. The distance is 0 if the ray is occluded before it enters the
 * box, TY_FLOAT_MAX if it is not occluded. */
#ifndef TY_DIRECT_UNCOLLIDED_OCCLUSION_H
#define TY_DIRECT_UNCOLLIDED_OCCLUSION_H

#include "base/vector.k.h"
#include "direct/media/cell_ray.h"

/* A medium's box, m, shrunken by a thousandth of a cell: surfaces in its faces are outside. */
typedef struct ty_occlusion_box {
    double lower[3], upper[3];
} ty_occlusion_box;

ty_occlusion_box ty_occlusion_box_of(const ty_grid_medium* medium);

/* Distance of a ray that misses the box, before ty_occlusion_fill. */
#define TY_OCCLUSION_UNDEFINED (-1.0f)

/* Inverse of a direction's component for ty_occlusion_clip. */
static inline double ty_occlusion_inverse(double omega) {
    return omega != 0 ? 1 / omega : 1e300;
}

/* Range of a ray within the box, m from its origin; empty where it misses. */
typedef struct ty_occlusion_span {
    double enter, leave;
} ty_occlusion_span;

/* Clips a range to the box along one axis, given the ray's origin and inverse direction. */
static inline ty_occlusion_span ty_occlusion_clip(ty_occlusion_span span, const ty_occlusion_box* box, int axis,
                                                  double origin, double inverse) {
    const double low = (box->lower[axis] - origin) * inverse, high = (box->upper[axis] - origin) * inverse;
    return (ty_occlusion_span){ty_cell_max(span.enter, ty_cell_min(low, high)),
                               ty_cell_min(span.leave, ty_cell_max(low, high))};
}

/* Replaces undefined distances by the nearest defined ones of the row, and rows without any by the next row. */
void ty_occlusion_fill(float* distances, int32_t columns, int32_t rows);

#endif
