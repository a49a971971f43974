/* Moments of the radiance in the cells of a plane of the wavefront, on devices. */
#include "device/entry.k.h"
#include "solve/ordinates/device/plane.k.h"

/* The part of an octant's directions in the term at a place in the order of parities. */
TY_FN float octant_moment(TY_GLOBAL const ty_ordinates_launch* launch, int32_t octant, int64_t column, int32_t term) {
    const bool odd = term >= launch->even;
    TY_GLOBAL const float* weighted =
        launch->weighted_y_lm[octant / 2] + (odd ? launch->odd_begin + term - launch->even : term);
    TY_GLOBAL const float* psi =
        launch->psi + ((int64_t)octant * launch->size[1] * launch->size[2] + column) * launch->directions;
    float sum = 0.0f;
    for (int32_t d = 0; d < launch->directions; ++d) sum += psi[d] * weighted[(int64_t)d * launch->padded];
    return odd && (octant & 1) != 0 ? -sum : sum;
}

/* Of the octants in whose planes a cell lies, the first one's item adds all of them, in their order. */
TY_DEVICE_ENTRY(ordinates_moments, ty_ordinates_launch) {
    TY_GLOBAL const int32_t* size = arguments->size;
    const int32_t term = (int32_t)(index % arguments->terms);
    const int64_t item = index / arguments->terms, columns = (int64_t)size[1] * size[2], column = item % columns;
    const int32_t octant = (int32_t)(item / columns);
    int32_t at[3] = {0, (int32_t)(column % size[1]), (int32_t)(column / size[1])};
    at[0] = ty_plane_cell(arguments, octant, at[1], at[2]);
    if (at[0] < 0) return;
    for (int32_t o = 0; o < octant; ++o)
        if (ty_plane_has(arguments, o, at)) return;
    float sum = octant_moment(arguments, octant, column, term);
    for (int32_t o = octant + 1; o < 8; ++o)
        if (ty_plane_has(arguments, o, at)) sum += octant_moment(arguments, o, column, term);
    arguments->moments[(column * size[0] + at[0]) * arguments->terms + arguments->order[term]] += sum;
}
