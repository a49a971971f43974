/* Cells along the directions of an octant: the source in each direction from its moments, and diamond difference. SIMD
 * lanes are directions; programs of devices have one lane. */
#ifndef TY_SOLVE_ORDINATES_CELL_K_H
#define TY_SOLVE_ORDINATES_CELL_K_H

#include "base/kernel.h"
#include "base/simd.h"

/* Cells of a row that are evaluated together. */
enum { TY_SWEEP_CELLS = 8 };

/* ---- harmonics ---- */

/* Number of terms rounded up to a multiple of the lanes. */
TY_INLINE ptrdiff_t padded_terms(ptrdiff_t terms) {
    return (terms + TY_LANES - 1) / TY_LANES * TY_LANES;
}

/* Number of harmonics with even parity in x; and of all, with each parity padded to whole lanes. */
TY_INLINE ptrdiff_t even_terms(ptrdiff_t bands) {
    return bands * (bands + 1) / 2;
}

TY_INLINE ptrdiff_t split_terms(ptrdiff_t bands) {
    return padded_terms(even_terms(bands)) + padded_terms(even_terms(bands - 1));
}

/* ---- emission ---- */

typedef struct emission_view {
    const int32_t* order; /* terms, even parity first */
    const float* y_lm;    /* of the group: all its directions of each term in `order` */
    ptrdiff_t pitch;      /* from one term to the next */
} emission_view;

TY_INLINE void emit_cells(const emission_view* view, const float* emission, float* up, float* down, const int count,
                          const int32_t bands) {
    const int32_t terms = bands * bands, evens = (int32_t)even_terms(bands);
    const int32_t* order = view->order;
    const float* y = view->y_lm;
    ty_lanes even[TY_SWEEP_CELLS] = {{0}}, odd[TY_SWEEP_CELLS] = {{0}};
    int32_t t = 0;
    for (; t < evens; ++t, y += view->pitch) {
        const ty_lanes at = ty_lanes_load_aligned(y);
        const float* from = emission + order[t];
        for (int i = 0; i < count; ++i) even[i] += from[i * terms] * at;
    }
    for (; t < terms; ++t, y += view->pitch) {
        const ty_lanes at = ty_lanes_load_aligned(y);
        const float* from = emission + order[t];
        for (int i = 0; i < count; ++i) odd[i] += from[i * terms] * at;
    }
    for (int i = 0; i < count; ++i) {
        ty_lanes_store_aligned(up + i * TY_LANES, even[i] + odd[i]);
        ty_lanes_store_aligned(down + i * TY_LANES, even[i] - odd[i]);
    }
}

TY_INLINE void emit(const emission_view* view, const float* emission, int32_t nx, float* up, float* down,
                    const int32_t bands) {
    const int32_t terms = bands * bands;
    int32_t x = 0;
    for (; x + TY_SWEEP_CELLS <= nx; x += TY_SWEEP_CELLS)
        emit_cells(view, emission + (ptrdiff_t)x * terms, up + x * TY_LANES, down + x * TY_LANES, TY_SWEEP_CELLS,
                   bands);
    for (; x < nx; ++x)
        emit_cells(view, emission + (ptrdiff_t)x * terms, up + x * TY_LANES, down + x * TY_LANES, 1, bands);
}

/* ---- diamond difference ---- */

/* State of a sweep along a row in one direction of x. */
typedef struct stream {
    ty_lanes psi_x;             /* radiance at the face that the row has reached */
    float *psi, *psi_y, *psi_z; /* source, then mean radiance, per cell; radiance at the faces along y and z */
} stream;

/* Set-to-zero fix-up: faces with negative outgoing radiance are set to zero and the cell balance is solved again
 * without their outflow, until no face is negative. Such a face contributes half of its usual inflow term. Returns 2
 * psi. */
TY_INLINE ty_lanes set_to_zero_fixup(const ty_lanes two_mu_over_h[3], float extinction, ty_lanes source,
                                     const ty_lanes in[3], ty_lanes out[3], int64_t* fixups) {
    const ty_lanes none = {0};
    ty_lanes two_psi, all = source + source;
    ty_lane_mask open[3], low[3];
    for (int a = 0; a < 3; ++a) {
        all += two_mu_over_h[a] * in[a];
        low[a] = ty_lanes_greater(none, out[a]);
        open[a] = (ty_lane_mask)~low[a];
    }
    do {
        ty_lanes above = all, below = none + extinction;
        for (int a = 0; a < 3; ++a) {
            above = ty_lanes_add_product(open[a], above, two_mu_over_h[a], in[a]);
            below = ty_lanes_add(open[a], below, two_mu_over_h[a]);
        }
        two_psi = ty_lanes_keep(ty_lanes_greater(below, none), above * ty_lanes_invert(below));
        for (int a = 0; a < 3; ++a) {
            out[a] = ty_lanes_keep(open[a], two_psi - in[a]);
            low[a] = ty_lanes_greater(none, out[a]);
            open[a] = (ty_lane_mask)(open[a] & ~low[a]);
        }
    } while (ty_mask_bits((ty_lane_mask)(low[0] | low[1] | low[2])) != 0);
    *fixups += TY_LANES - __builtin_popcount(ty_mask_bits((ty_lane_mask)(open[0] & open[1] & open[2])));
    return two_psi;
}

/* Diamond difference in one cell and direction (Lewis and Miller 1984):
 *     psi = (q + sum_a (2 |mu_a| / h_a) psi_in,a) / (sigma* + sum_a 2 |mu_a| / h_a),   psi_out,a = 2 psi - psi_in,a. */
TY_INLINE void diamond_difference_step(stream* s, const ty_lanes two_mu_over_h[3], float extinction, ty_lanes inverse,
                                       ptrdiff_t x, int64_t* fixups) {
    const ty_lanes source = ty_lanes_load_aligned(s->psi + x * TY_LANES);
    const ty_lanes in[3] = {s->psi_x, ty_lanes_load_aligned(s->psi_y + x * TY_LANES),
                            ty_lanes_load_aligned(s->psi_z + x * TY_LANES)};
    const ty_lanes psi_center =
        (source + two_mu_over_h[1] * in[1] + two_mu_over_h[2] * in[2]) * inverse + two_mu_over_h[0] * inverse * in[0];
    ty_lanes two_psi = psi_center + psi_center;
    ty_lanes out[3] = {two_psi - in[0], two_psi - in[1], two_psi - in[2]};
    if (__builtin_expect(ty_lanes_signs((ty_int_lanes)out[0] | (ty_int_lanes)out[1] | (ty_int_lanes)out[2]) != 0, 0))
        two_psi = set_to_zero_fixup(two_mu_over_h, extinction, source, in, out, fixups);
    s->psi_x = out[0];
    ty_lanes_store_aligned(s->psi_y + x * TY_LANES, out[1]);
    ty_lanes_store_aligned(s->psi_z + x * TY_LANES, out[2]);
    ty_lanes_store_aligned(s->psi + x * TY_LANES, 0.5f * two_psi);
}

#endif
