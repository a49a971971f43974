/* Rays beside a box. */
#include "direct/stops.h"

/* Of a cell's sides. */
static const double rim = 1e-3;

ty_stop_room ty_stop_room_of(const ty_grid_medium* medium) {
    ty_stop_room room;
    for (int a = 0; a < 3; ++a) {
        room.lower[a] = medium->box.lower[a] + rim * medium->cell[a];
        room.upper[a] = medium->box.upper[a] - rim * medium->cell[a];
    }
    return room;
}

/* `count` rays, so many floats apart: from those of them that are in the room to either side. */
static void fill_line(float* stops, size_t count, size_t apart) {
    for (size_t i = 1; i < count; ++i)
        if (signbit(stops[i * apart])) stops[i * apart] = stops[(i - 1) * apart];
    for (size_t i = count - 1; i-- > 0;)
        if (signbit(stops[i * apart])) stops[i * apart] = stops[(i + 1) * apart];
}

void ty_stops_fill(float* stops, int32_t columns, int32_t rows) {
    const size_t across = (size_t)columns, down = (size_t)rows;
    for (size_t row = 0; row < down; ++row) fill_line(stops + row * across, across, 1);
    for (size_t column = 0; column < across; ++column) fill_line(stops + column, down, across);
    for (size_t i = 0; i < across * down; ++i) stops[i] = fabsf(stops[i]);
}
