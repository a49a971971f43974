/* Where surfaces stop rays, for cells that have no more than a ray's nearest to tell whether they are lit. A ray beside
 * the box may be lit where the cell next to it is behind a wall in the box's face, or the other way round: so rays have
 * everywhere what they have within the box. */
#ifndef TY_DIRECT_STOPS_H
#define TY_DIRECT_STOPS_H

#include "base/vector.k.h"
#include "direct/cell_ray.h"

/* A medium's box, less a thousandth of a cell on all sides, m: surfaces in its faces are outside. */
typedef struct ty_stop_room {
    double lower[3], upper[3];
} ty_stop_room;

ty_stop_room ty_stop_room_of(const ty_grid_medium* medium);

/* What ty_stop_within takes of a ray's way along one axis. */
static inline double ty_stop_inverse(double way) {
    return way != 0 ? 1 / way : 1e300;
}

/* along: m from the origin to the first surface, TY_FLOAT_MAX: none. Returns 0 where the ray is stopped before it
 * enters the room, TY_FLOAT_MAX where it gets through, else along; less than 0, or -0, where it passes the room by. */
static inline float ty_stop_within(const ty_stop_room* room, const double origin[3], const double inverse[3],
                                   float along) {
    double enter = -INFINITY, leave = INFINITY;
    for (int a = 0; a < 3; ++a) {
        const double low = (room->lower[a] - origin[a]) * inverse[a], high = (room->upper[a] - origin[a]) * inverse[a];
        enter = ty_cell_max(enter, ty_cell_min(low, high));
        leave = ty_cell_min(leave, ty_cell_max(low, high));
    }
    if (!(enter < leave)) return -ty_maxf(along, 0.0f);
    return (double)along <= enter ? 0.0f : (double)along >= leave ? TY_FLOAT_MAX : along;
}

/* Rows of rays that ty_stop_within has looked at: those that pass the room by get what their nearest in the row has
 * that does not, or in the column; if none does, what they were stopped at. */
void ty_stops_fill(float* stops, int32_t columns, int32_t rows);

#endif
