/* Compiled once per instruction set, which TY_ISA names. */
#include "solve/ordinates/adjoint_kernel.h"

#include "base/kernel.h"
#include "solve/ordinates/diamond.k.h"

#include <string.h>

/* Radiance at the upwind faces of the next cells along y and z in both octants; mean radiance of a row. */
typedef struct pass_scratch {
    float *faces_y[2], *faces_z[2], *row[2];
} pass_scratch;

static size_t row_floats(const ty_sweep_box* box) {
    return (size_t)box->size[0] * TY_LANES;
}

static size_t scratch_floats(const ty_sweep_box* box) {
    return 2 * row_floats(box) * (2 + (size_t)box->size[1]);
}

static pass_scratch lay_out(const ty_sweep_box* box, float* scratch) {
    const size_t row = row_floats(box), plane = row * (size_t)box->size[1];
    memset(scratch, 0, sizeof *scratch * scratch_floats(box));
    return (pass_scratch){.row = {scratch, scratch + row},
                          .faces_y = {scratch + 2 * row, scratch + 3 * row},
                          .faces_z = {scratch + 4 * row, scratch + 4 * row + plane}};
}

/* The weight of each direction times Y_00. */
static ty_lanes weights_of(const ty_sweep_box* box, int32_t pair, int32_t group) {
    ty_lanes weights = {0};
    for (int32_t i = 0; i < TY_LANES && group * TY_LANES + i < box->directions; ++i)
        weights[i] = box->weighted_y_lm[pair][(ptrdiff_t)(group * TY_LANES + i) * box->padded];
    return weights;
}

static float sum_of(ty_lanes value) {
    float sum = 0;
    for (int i = 0; i < TY_LANES; ++i) sum += value[i];
    return sum;
}

static int32_t bands_of(const ty_sweep_box* box) {
    return 2 * box->even - box->terms;
}

/* The source of a row in each direction. */
static void emit_row(const ty_sweep_box* box, const float* emission, int32_t pair, int32_t group, ptrdiff_t row,
                     float* const to[2]) {
    const ptrdiff_t pitch = (ptrdiff_t)box->groups * TY_LANES;
    const emission_view view = {box->order, box->y_lm[pair] + group * TY_LANES, pitch};
    emit(&view, emission + row * box->terms, box->size[0], to[0], to[1], bands_of(box));
}

/* A cell's step, after which the lanes with closed faces are noted. */
TY_INLINE void forward_step(stream* s, const ty_lanes two_mu_over_h[3], float extinction, ptrdiff_t x,
                            uint16_t* closed) {
    const ty_lanes in[3] = {s->psi_x, ty_lanes_load_aligned(s->psi_y + x * TY_LANES),
                            ty_lanes_load_aligned(s->psi_z + x * TY_LANES)};
    const ty_lanes inverse = ty_lanes_invert(extinction + (two_mu_over_h[0] + two_mu_over_h[1] + two_mu_over_h[2]));
    int64_t fixups = 0;
    diamond_difference_step(s, two_mu_over_h, extinction, inverse, x, &fixups);
    if (closed == NULL) return;
    const ty_lanes two_psi = 2.0f * ty_lanes_load_aligned(s->psi + x * TY_LANES);
    const ty_lanes out[3] = {s->psi_x, ty_lanes_load_aligned(s->psi_y + x * TY_LANES),
                             ty_lanes_load_aligned(s->psi_z + x * TY_LANES)};
    for (int a = 0; a < 3; ++a) closed[a] = fixups > 0 ? (uint16_t)closed_lanes(out[a], two_psi - in[a]) : 0;
}

static void forward(const ty_sweep_box* box, const float* emission, const ty_adjoint_pass* pass) {
    const ptrdiff_t nx = box->size[0], ny = box->size[1], nz = box->size[2], step = nx * TY_LANES;
    const pass_scratch scratch = lay_out(box, pass->scratch);
    const ty_lanes weights = weights_of(box, pass->pair, pass->group);
    ty_lanes two_mu_over_h[3];
    for (int a = 0; a < 3; ++a)
        two_mu_over_h[a] = ty_lanes_load_aligned(box->two_mu_over_h[a] + pass->group * TY_LANES);
    for (ptrdiff_t k = 0; k < nz; ++k) {
        memset(scratch.faces_y[0], 0, 2 * sizeof(float) * row_floats(box));
        for (ptrdiff_t j = 0; j < ny; ++j) {
            const ptrdiff_t y = (pass->pair & 1) != 0 ? ny - 1 - j : j, z = (pass->pair & 2) != 0 ? nz - 1 - k : k;
            const ptrdiff_t row = (z * ny + y) * nx;
            float* psi[2] = {pass->psi[0] + row * TY_LANES, pass->psi[1] + row * TY_LANES};
            stream streams[2];
            uint16_t* closed[2] = {NULL, NULL};
            emit_row(box, emission, pass->pair, pass->group, row, psi);
            for (int o = 0; o < 2; ++o) {
                streams[o] =
                    (stream){.psi = psi[o], .psi_y = scratch.faces_y[o], .psi_z = scratch.faces_z[o] + y * step};
                if (pass->closed != NULL)
                    closed[o] = pass->closed + closed_index(box, 2 * pass->pair + o, pass->group, row);
            }
            for (ptrdiff_t x = 0; x < nx; ++x) {
                const ptrdiff_t back = nx - 1 - x;
                forward_step(&streams[0], two_mu_over_h, box->extinction[row + x], x,
                             closed[0] != NULL ? closed[0] + 3 * x : NULL);
                forward_step(&streams[1], two_mu_over_h, box->extinction[row + back], back,
                             closed[1] != NULL ? closed[1] + 3 * back : NULL);
            }
            for (ptrdiff_t x = 0; x < nx && pass->sums != NULL; ++x)
                pass->sums[row + x] += sum_of(weights * (ty_lanes_load_aligned(psi[0] + x * TY_LANES) +
                                                         ty_lanes_load_aligned(psi[1] + x * TY_LANES)));
        }
    }
}

static void multiply(const ty_sweep_box* box, const float* emission, const ty_adjoint_pass* pass) {
    const ptrdiff_t nx = box->size[0], ny = box->size[1], nz = box->size[2], step = nx * TY_LANES;
    const pass_scratch scratch = lay_out(box, pass->scratch);
    const ty_lanes weights = weights_of(box, pass->pair, pass->group);
    const int32_t opposite = pass->pair ^ 3;
    for (ptrdiff_t k = 0; k < nz; ++k) {
        memset(scratch.faces_y[0], 0, 2 * sizeof(float) * row_floats(box));
        for (ptrdiff_t j = 0; j < ny; ++j) {
            const ptrdiff_t y = (opposite & 1) != 0 ? ny - 1 - j : j, z = (opposite & 2) != 0 ? nz - 1 - k : k;
            const ptrdiff_t row = (z * ny + y) * nx;
            stream streams[2];
            emit_row(box, emission, opposite, pass->group, row, scratch.row);
            for (int o = 0; o < 2; ++o)
                streams[o] = (stream){
                    .psi = scratch.row[o], .psi_y = scratch.faces_y[o], .psi_z = scratch.faces_z[o] + y * step};
            transpose_row(box, 2 * opposite, pass->group, row, streams);
            const float *up = pass->psi[0] + row * TY_LANES, *down = pass->psi[1] + row * TY_LANES;
            for (ptrdiff_t x = 0; x < nx; ++x)
                pass->sums[row + x] += sum_of(weights * (ty_lanes_load_aligned(up + x * TY_LANES) *
                                                             ty_lanes_load_aligned(scratch.row[1] + x * TY_LANES) +
                                                         ty_lanes_load_aligned(down + x * TY_LANES) *
                                                             ty_lanes_load_aligned(scratch.row[0] + x * TY_LANES)));
        }
    }
}

const ty_adjoint_kernels TY_KERNEL_NAME(ty_adjoint_kernels) = {
    .lanes = TY_LANES,
    .scratch = scratch_floats,
    .forward = forward,
    .multiply = multiply,
};
