/* Diamond difference in the cells of a plane of the wavefront, on devices. */
#include "device/entry.k.h"
#include "solve/ordinates/cell.k.h"
#include "solve/ordinates/device/plane.k.h"

/* The source in a direction, from its moments. */
TY_FN float source_along(TY_GLOBAL const ty_ordinates_launch* launch, int32_t octant, int32_t direction, int64_t cell) {
    const emission_view view = {launch->order, launch->y_lm[octant / 2] + direction, launch->pitch};
    float source[2];
    emit_cells(&view, launch->emission + cell * launch->terms, &source[0], &source[1], 1, launch->bands);
    return source[octant & 1];
}

TY_DEVICE_ENTRY(ordinates_sweep, ty_ordinates_launch) {
    TY_GLOBAL const int32_t* size = arguments->size;
    const int32_t count = arguments->directions;
    const int64_t column = index / count, columns = (int64_t)size[1] * size[2];
    const int32_t direction = (int32_t)(index % count), octant = (int32_t)(column / columns);
    const int32_t y = (int32_t)(column % columns % size[1]), z = (int32_t)(column % columns / size[1]);
    const int32_t x = ty_plane_cell(arguments, octant, y, z);
    if (x < 0) return;
    const int64_t cell = ((int64_t)z * size[1] + y) * size[0] + x;
    const float extinction = arguments->extinction[cell];
    ty_lanes two_mu_over_h[3];
    for (int a = 0; a < 3; ++a) two_mu_over_h[a][0] = arguments->two_mu_over_h[a][direction];
    const ty_lanes faces = two_mu_over_h[0] + two_mu_over_h[1] + two_mu_over_h[2];
    int64_t fixups = 0;
    float psi = source_along(arguments, octant, direction, cell);
    TY_GLOBAL float* across_x = arguments->faces[0] + index;
    stream s = {.psi = &psi,
                .psi_y = arguments->faces[1] + (((int64_t)octant * size[2] + z) * size[0] + x) * count + direction,
                .psi_z = arguments->faces[2] + (((int64_t)octant * size[1] + y) * size[0] + x) * count + direction};
    s.psi_x[0] = *across_x;
    diamond_difference_step(&s, two_mu_over_h, extinction, ty_lanes_invert(extinction + faces), 0, &fixups);
    *across_x = s.psi_x[0];
    arguments->psi[index] = psi;
    if (arguments->fixups != NULL) arguments->fixups[index] += (uint32_t)fixups;
}
