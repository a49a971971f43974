/* Where surfaces stop rays, for cells that have no more than a ray's nearest to tell whether they are lit. A ray beside
 * the box may be lit where the cell next to it is behind a wall in the box's face, or the other way round: so rays have
 * everywhere what they have within the box. A ray's stop is how far it gets, m: 0 if it is stopped before it enters the
 * box, TY_FLOAT_MAX if it gets through. */
#ifndef TY_DIRECT_UNCOLLIDED_OCCLUSION_H
#define TY_DIRECT_UNCOLLIDED_OCCLUSION_H

#include "base/vector.k.h"
#include "direct/media/cell_ray.h"

/* A medium's box, less a thousandth of a cell on all sides, m: surfaces in its faces are outside. */
typedef struct ty_occlusion_box {
    double lower[3], upper[3];
} ty_occlusion_box;

ty_occlusion_box ty_occlusion_box_of(const ty_grid_medium* medium);

/* The stop of a ray that passes the room by, until ty_occlusion_fill. */
#define TY_OCCLUSION_UNDEFINED (-1.0f)

/* What ty_occlusion_clip takes of a ray's way along one axis. */
static inline double ty_occlusion_inverse(double omega) {
    return omega != 0 ? 1 / omega : 1e300;
}

/* Where a ray enters and leaves the room, m from its origin: empty where it passes it by. */
typedef struct ty_occlusion_span {
    double enter, leave;
} ty_occlusion_span;

/* Cuts a span to the room along one axis, of which the ray's origin and way are given. */
static inline ty_occlusion_span ty_occlusion_clip(ty_occlusion_span span, const ty_occlusion_box* box, int axis,
                                                  double origin, double inverse) {
    const double low = (box->lower[axis] - origin) * inverse, high = (box->upper[axis] - origin) * inverse;
    return (ty_occlusion_span){ty_cell_max(span.enter, ty_cell_min(low, high)),
                               ty_cell_min(span.leave, ty_cell_max(low, high))};
}

/* Rows of rays' stops: those that pass the room by get that of the nearest in their row that does not, and rows of
 * which all do that of the next row. */
void ty_occlusion_fill(float* distances, int32_t columns, int32_t rows);

#endif
