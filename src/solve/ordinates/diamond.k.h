/* Rows of cells along the directions of two octants by the transpose of diamond difference. SIMD lanes are directions.
 */
#ifndef TY_SOLVE_ORDINATES_DIAMOND_K_H
#define TY_SOLVE_ORDINATES_DIAMOND_K_H

#include "solve/ordinates/cell.k.h"
#include "solve/ordinates/sweep_kernel.h"

/* ---- the transpose ---- */

/* The lanes of a mask's bits; bit i belongs to lane i. */
TY_INLINE ty_lane_mask mask_of_bits(uint32_t bits) {
#if defined(__AVX512F__)
    return (ty_lane_mask)bits;
#else
    ty_int_lanes lane;
    for (int i = 0; i < TY_LANES; ++i) lane[i] = 1 << i;
    return (ty_lane_mask)((lane & (int32_t)bits) != 0);
#endif
}

/* The lanes whose face a fix-up has set to zero: the two differ but for that. */
TY_INLINE uint32_t closed_lanes(ty_lanes out, ty_lanes two_psi_less_in) {
    const ty_lanes none = {0};
    const uint32_t lit = ty_mask_bits((ty_lane_mask)(ty_lanes_greater(out, none) | ty_lanes_greater(none, out)));
    const uint32_t moves =
        ty_mask_bits((ty_lane_mask)(ty_lanes_greater(two_psi_less_in, none) | ty_lanes_greater(none, two_psi_less_in)));
    return moves & ~lit;
}

/* The transpose of a cell's diamond difference where closed[a] has the lanes whose face across axis a is set to zero.
 * With out_a* = |mu_a| / h_a r_a the derivative by the radiance that leaves through a face, and q* that by the source,
 *     q* = (psi* + sum_open (2 |mu_a| / h_a) r_a) / (sigma* + sum_open 2 |mu_a| / h_a),
 * and in_a* = |mu_a| / h_a r_a' with r_a' = 2 q* - r_a, or q* at a closed face: without these, diamond difference along
 * the opposite direction. */
TY_INLINE void transposed_step(stream* s, const ty_lanes two_mu_over_h[3], float extinction, const uint16_t closed[3],
                               ptrdiff_t x) {
    const ty_lanes in[3] = {s->psi_x, ty_lanes_load_aligned(s->psi_y + x * TY_LANES),
                            ty_lanes_load_aligned(s->psi_z + x * TY_LANES)};
    const ty_lanes none = {0};
    ty_lanes above = ty_lanes_load_aligned(s->psi + x * TY_LANES), below = none + extinction, out[3];
    ty_lane_mask open[3];
    for (int a = 0; a < 3; ++a) {
        open[a] = mask_of_bits(~(uint32_t)closed[a]);
        above = ty_lanes_add_product(open[a], above, two_mu_over_h[a], in[a]);
        below = ty_lanes_add(open[a], below, two_mu_over_h[a]);
    }
    const ty_lanes psi = ty_lanes_keep(ty_lanes_greater(below, none), above * ty_lanes_invert(below));
    for (int a = 0; a < 3; ++a) out[a] = psi + ty_lanes_keep(open[a], psi - in[a]);
    s->psi_x = out[0];
    ty_lanes_store_aligned(s->psi_y + x * TY_LANES, out[1]);
    ty_lanes_store_aligned(s->psi_z + x * TY_LANES, out[2]);
    ty_lanes_store_aligned(s->psi + x * TY_LANES, psi);
}

/* The closed faces of a cell in an octant and a group of lanes: three numbers, whose bits are lanes. */
TY_INLINE ptrdiff_t closed_index(const ty_sweep_box* box, int32_t octant, int32_t group, ptrdiff_t cell) {
    const ptrdiff_t cells = (ptrdiff_t)box->size[0] * box->size[1] * box->size[2];
    return 3 * (((ptrdiff_t)octant * box->groups + group) * cells + cell);
}

/* Sweeps a row by the transpose, towards +x and -x; its directions are the opposite ones of those that the faces were
 * closed for. */
TY_FN_CALLED void transpose_row(const ty_sweep_box* box, int32_t octant, int32_t group, ptrdiff_t row,
                                stream streams[2]) {
    const float* extinction = box->extinction + row;
    const int32_t nx = box->size[0];
    ty_lanes two_mu_over_h[3];
    for (int a = 0; a < 3; ++a) two_mu_over_h[a] = ty_lanes_load_aligned(box->two_mu_over_h[a] + group * TY_LANES);
    const uint16_t* closed[2];
    for (int o = 0; o < 2; ++o) closed[o] = box->closed + closed_index(box, (octant + o) ^ 7, group, row);
    stream up = streams[0], down = streams[1];
    for (int32_t x = 0; x < nx; ++x) {
        const int32_t back = nx - 1 - x;
        transposed_step(&up, two_mu_over_h, extinction[x], closed[0] + 3 * x, x);
        transposed_step(&down, two_mu_over_h, extinction[back], closed[1] + 3 * back, back);
    }
    streams[0].psi_x = up.psi_x;
    streams[1].psi_x = down.psi_x;
}

#endif
