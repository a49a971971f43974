/* Links between cells, and what media do to light on them. */
#include "method/lpv/lattice.h"

#include <stdlib.h>

/* ---- directions ---- */

enum { PATCH_POINTS = 48 }; /* along the sides of a cube's faces */

typedef struct patch_sums {
    double solid_angle, terms[TY_SH_TERMS];
} patch_sums;

/* -1, 0 or 1: which of the multiples of 45 degrees a direction is nearest to, in the plane of an axis where it is the
 * longest component, 1, and another where it is this. */
static int32_t nearest(double component) {
    static const double tangent = 0.41421356237309503; /* of 22.5 degrees */
    return component > tangent ? 1 : component < -tangent ? -1 : 0;
}

/* Directions through one face of the cube [-1, 1]^3, whose points stand for equal parts of it. */
static void add_face(int axis, double side, patch_sums sums[TY_LPV_LINKS]) {
    for (int32_t i = 0; i < PATCH_POINTS; ++i)
        for (int32_t j = 0; j < PATCH_POINTS; ++j) {
            double p[3];
            p[axis] = side;
            p[(axis + 1) % 3] = (2 * i + 1.0) / PATCH_POINTS - 1;
            p[(axis + 2) % 3] = (2 * j + 1.0) / PATCH_POINTS - 1;
            const double far = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
            const double weight = 4.0 / (PATCH_POINTS * PATCH_POINTS) / (far * far * far);
            patch_sums* patch = &sums[ty_lpv_link(nearest(p[0]), nearest(p[1]), nearest(p[2]))];
            float y[TY_SH_TERMS];
            ty_sh_at(ty_vec_make((float)(p[0] / far), (float)(p[1] / far), (float)(p[2] / far)), TY_SH_BANDS, y);
            patch->solid_angle += weight;
            for (int32_t t = 0; t < TY_SH_TERMS; ++t) patch->terms[t] += weight * (double)y[t];
        }
}

/* How many axes a link goes along: links of one kind have the same shape. */
static int32_t kind_of(const int32_t step[3]) {
    return abs(step[0]) + abs(step[1]) + abs(step[2]) - 1;
}

/* One link of each kind. */
static const int32_t model[3][3] = {{0, 0, 1}, {1, 1, 0}, {1, 1, 1}};

/* The patch of one link turned and mirrored onto another of its kind: sums as exact as symmetry. */
static void make_shape(const patch_sums* patch, double whole, const int32_t step[3], float shape[TY_SH_TERMS]) {
    const int32_t kind = kind_of(step);
    const double dc = sqrt(patch->solid_angle / whole), scale = dc / patch->terms[0];
    const double along = scale * fabs(patch->terms[kind == 0 ? 2 : 3]);
    const double axial = scale * patch->terms[6], cross = scale * patch->terms[4];
    shape[0] = (float)dc;
    shape[1] = (float)(along * step[1]);
    shape[2] = (float)(along * step[2]);
    shape[3] = (float)(along * step[0]);
    shape[4] = (float)(kind == 0 ? 0 : cross * step[0] * step[1]);
    shape[5] = (float)(kind == 0 ? 0 : cross * step[1] * step[2]);
    shape[7] = (float)(kind == 0 ? 0 : cross * step[0] * step[2]);
    /* Band 2 is even about one axis: a face's link's own, and the one that an edge's link is square to. */
    double about[3];
    for (int a = 0; a < 3; ++a) about[a] = kind < 2 && (step[a] != 0) == (kind == 0) ? axial : 0;
    shape[6] = (float)(about[2] - 0.5 * (about[0] + about[1]));
    shape[8] = (float)(0.5 * sqrt(3.0) * (about[0] - about[1]));
}

static double squares(const float* values, int32_t count) {
    double sum = 0;
    for (int32_t i = 0; i < count; ++i) sum += (double)values[i] * (double)values[i];
    return sum;
}

static void measure(ty_lpv_transfer* transfer) {
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k) {
        const float* shape = transfer->shape[k];
        const double square = kind_of(transfer->step[k]) + 1, dc = (double)shape[0], turn = squares(shape + 1, 3);
        transfer->length += dc * dc * sqrt(square);
        transfer->slope += dc * sqrt(turn * square) / 3;
        transfer->spread += dc * dc * square / 3;
        transfer->momentum += turn / 3;
    }
}

/* Gamma_j of Eq. 2 (Billeter 2012) for all links. */
void ty_lpv_transfer_make(int32_t bands, bool keeps_momentum, ty_lpv_transfer* out) {
    *out = (ty_lpv_transfer){.bands = bands, .terms = bands * bands};
    patch_sums sums[TY_LPV_LINKS] = {{0}};
    for (int axis = 0; axis < 3; ++axis)
        for (int side = -1; side <= 1; side += 2) add_face(axis, side, sums);
    double whole = 0, momentum = 0;
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k) whole += sums[k].solid_angle;
    for (int32_t place = 0; place < 27; ++place) {
        const int32_t step[3] = {place % 3 - 1, place / 3 % 3 - 1, place / 9 - 1};
        if (place == TY_LPV_HALF_LINKS) continue;
        const int32_t k = ty_lpv_link(step[0], step[1], step[2]), kind = kind_of(step);
        memcpy(out->step[k], step, sizeof step);
        make_shape(&sums[ty_lpv_link(model[kind][0], model[kind][1], model[kind][2])], whole, step, out->shape[k]);
        momentum += squares(out->shape[k] + 1, 3) / 3;
    }
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k)
        for (int32_t t = 1; t < 4 && keeps_momentum; ++t) out->shape[k][t] /= (float)sqrt(momentum);
    measure(out);
}

/* ---- media ---- */

/* The most momentum that light keeps from step to step: what media have whose free path is sixteen cells. Without it
 * two or three bands in vacuum would stand as high far from a small source as at the border, and below 0 in between;
 * with less, light between surfaces stays too long. About lamps, ty_lattice_spread goes further. */
static const double momentum_kept = 0.92;

/* How far a step is in cells without momentum: half of the diffusion's coefficient times the time. */
static double reach(const ty_lpv_transfer* transfer) {
    return 0.5 * transfer->spread;
}

/* Momentum with which the lattice diffuses by so many cells^2 a step more than without. */
static double kept_for(const ty_lpv_transfer* transfer, double drift) {
    return drift / (transfer->slope * transfer->slope + transfer->momentum * drift);
}

/* Momentum such that the lattice diffuses as the medium does: D = 1 / (3 sigma_tr). */
ty_lpv_links_step ty_lpv_links_step_in(const ty_lpv_transfer* transfer, float cell, const ty_lpv_cell_medium* medium) {
    const double extinction = (double)medium->extinction, scattering = (double)medium->scattering;
    const double g = (double)medium->g, side = (double)cell;
    const double depth = extinction * side * transfer->length, flown = exp(-depth);
    const double absorption = fmax(extinction - scattering, 0), turned = extinction - g * scattering;
    const double scattered = extinction > 0 ? (1 - flown) * scattering / extinction : 0;
    double length = depth > 1e-6 ? (1 - flown) / extinction : side * transfer->length;
    double pass = 1 - absorption * length, kept = momentum_kept * pass;
    const double resistance = 3 * turned * side * side; /* a step's length over it is D in cells^2 a step */
    const double drift = resistance > 0 ? length / (resistance * pass) - reach(transfer) : INFINITY;
    if (drift <= 0) { /* deeper than a free path: it stays until it has spread as far as a step goes */
        kept = 0;
        length = resistance * reach(transfer) / (1 + resistance * reach(transfer) * absorption);
        pass = 1 - absorption * length;
    } else if (drift < INFINITY) {
        kept = fmin(kept_for(transfer, drift), kept);
    }
    const double seen = 1 - 0.5 * flown, flight = turned * length > 1 ? 1 / (turned * length) : 1;
    return (ty_lpv_links_step){.pass = pass,
                               .kept = kept,
                               .length = length,
                               .third = flown + scattered * g * g,
                               .seen = seen,
                               .seen_way = fmin(seen, flight)};
}

/* Sums are of light that goes on, divided by how much of what arrives that is: never 0. */
static float at_least_something(double pass) {
    static const double least = 1e-6;
    return (float)(fabs(pass) < least ? least : pass);
}

ty_lpv_medium_step ty_lpv_links_step_about(const ty_lpv_transfer* transfer, float cell, const ty_lpv_links_step* step,
                                           float spread) {
    double kept = step->kept;
    if (spread > 0) {
        const double about = step->length / (3 * (double)spread * (double)cell * (double)cell) - reach(transfer);
        kept = fmin(kept, about > 0 ? kept_for(transfer, about) : 0);
    }
    /* Flux out of the lattice's gradients, against -D grad of the fluence; light that was injected has what it flies.
     */
    const double beta2 = transfer->slope * transfer->slope, straight = 1 - transfer->momentum * kept;
    const double shown =
        sqrt(3.0) * (beta2 * kept + reach(transfer) * straight) * (double)cell / (transfer->slope * step->length);
    return (ty_lpv_medium_step){.pass = {at_least_something(step->pass), at_least_something(kept),
                                         at_least_something(fmin(step->third, kept / momentum_kept))},
                                .length = (float)step->length,
                                .shown = {1, (float)shown, 1},
                                .seen = {(float)step->seen, (float)(step->seen_way / shown), (float)step->seen_way}};
}

/* lambda, lambda_s and gamma_j of Eq. 3 (Billeter 2012), with gamma_j = G_j0 / sqrt(4 pi), which conserves energy. */
static ty_lpv_medium_step step_as_published(const ty_lpv_transfer* transfer, double cell, double extinction,
                                            double scattering, double g) {
    const double depth = extinction * cell * transfer->length, flown = exp(-depth);
    const double scattered = extinction > 0 ? (1 - flown) * scattering / extinction : 0;
    return (ty_lpv_medium_step){.pass = {at_least_something(flown + scattered),
                                         at_least_something(flown + scattered * g),
                                         at_least_something(flown + scattered * g * g)},
                                .length = (float)(depth > 1e-6 ? (1 - flown) / extinction : cell * transfer->length),
                                .shown = {1, 1, 1},
                                .seen = {1, 1, 1}};
}

ty_lpv_medium_step ty_lpv_step_in(const ty_lpv_transfer* transfer, ty_lpv_mode mode, float cell,
                                  const ty_lpv_cell_medium* medium) {
    if (mode != TY_LPV_MODE_LINKS)
        return step_as_published(transfer, (double)cell, (double)medium->extinction, (double)medium->scattering,
                                 (double)medium->g);
    const ty_lpv_links_step step = ty_lpv_links_step_in(transfer, cell, medium);
    return ty_lpv_links_step_about(transfer, cell, &step, medium->spread);
}

ty_lpv_cell_medium ty_lattice_medium_in(const ty_lattice* lattice, int32_t channel, size_t cell) {
    const ty_grid_medium* medium = lattice->medium;
    ty_lpv_cell_medium out = {.spread = lattice->spread != NULL ? lattice->spread[cell] : 0.0f};
    if (medium == NULL) return out;
    out.extinction = medium->extinction[channel][cell];
    out.scattering = medium->scattering[channel][cell];
    out.g = medium->g[channel][cell];
    return out;
}
