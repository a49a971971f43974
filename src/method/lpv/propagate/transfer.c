/* Links between cells, and what media do to light on them. */
#include "method/lpv/propagate/transfer.h"

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
static void make_transfer_G(const patch_sums* patch, double whole, const int32_t step[3],
                            float transfer_G[TY_SH_TERMS]) {
    const int32_t kind = kind_of(step);
    const double dc = sqrt(patch->solid_angle / whole), scale = dc / patch->terms[0];
    const double along = scale * fabs(patch->terms[kind == 0 ? 2 : 3]);
    const double axial = scale * patch->terms[6], cross = scale * patch->terms[4];
    transfer_G[0] = (float)dc;
    transfer_G[1] = (float)(along * step[1]);
    transfer_G[2] = (float)(along * step[2]);
    transfer_G[3] = (float)(along * step[0]);
    transfer_G[4] = (float)(kind == 0 ? 0 : cross * step[0] * step[1]);
    transfer_G[5] = (float)(kind == 0 ? 0 : cross * step[1] * step[2]);
    transfer_G[7] = (float)(kind == 0 ? 0 : cross * step[0] * step[2]);
    /* Band 2 is even about one axis: a face's link's own, and the one that an edge's link is square to. */
    double near_source[3];
    for (int a = 0; a < 3; ++a) near_source[a] = kind < 2 && (step[a] != 0) == (kind == 0) ? axial : 0;
    transfer_G[6] = (float)(near_source[2] - 0.5 * (near_source[0] + near_source[1]));
    transfer_G[8] = (float)(0.5 * sqrt(3.0) * (near_source[0] - near_source[1]));
}

static double squares(const float* values, int32_t count) {
    double sum = 0;
    for (int32_t i = 0; i < count; ++i) sum += (double)values[i] * (double)values[i];
    return sum;
}

static void measure(ty_lpv_transfer* transfer) {
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k) {
        const float* transfer_G = transfer->G[k];
        const double square = kind_of(transfer->step[k]) + 1, dc = (double)transfer_G[0],
                     turn = squares(transfer_G + 1, 3);
        transfer->length += dc * dc * sqrt(square);
        transfer->slope += dc * sqrt(turn * square) / 3;
        transfer->step_variance += dc * dc * square / 3;
        transfer->momentum += turn / 3;
    }
}

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
        make_transfer_G(&sums[ty_lpv_link(model[kind][0], model[kind][1], model[kind][2])], whole, step, out->G[k]);
        momentum += squares(out->G[k] + 1, 3) / 3;
    }
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k)
        for (int32_t t = 1; t < 4 && keeps_momentum; ++t) out->G[k][t] /= (float)sqrt(momentum);
    measure(out);
}

/* ---- media ---- */

/* The most momentum that light keeps from step to step: what media have whose free path is sixteen cells. Without it
 * two or three bands in vacuum would stand as high far from a small source as at the border, and below 0 in between;
 * with less, light between surfaces stays too long. About lamps, ty_lattice_find_extinction_floor goes further. */
static const double momentum_retained = 0.92;

/* How far a step is in cells without momentum: half of the diffusion's coefficient times the time. */
static double reach(const ty_lpv_transfer* transfer) {
    return 0.5 * transfer->step_variance;
}

/* Momentum with which the lattice diffuses by so many cells^2 a step more than without. */
static double momentum_for(const ty_lpv_transfer* transfer, double drift) {
    return drift / (transfer->slope * transfer->slope + transfer->momentum * drift);
}

/* Momentum such that the lattice diffuses as the medium does: D = 1 / (3 sigma_tr). */
ty_lpv_links_step ty_lpv_links_step_in(const ty_lpv_transfer* transfer, float cell, const ty_lpv_cell_medium* medium) {
    const double extinction = (double)medium->extinction, scattering = (double)medium->scattering;
    const double g = (double)medium->g, side = (double)cell;
    const double depth = extinction * side * transfer->length, flown = exp(-depth);
    const double absorption = fmax(extinction - scattering, 0), reduced_extinction = extinction - g * scattering;
    const double scattered = extinction > 0 ? (1 - flown) * scattering / extinction : 0;
    double length = depth > 1e-6 ? (1 - flown) / extinction : side * transfer->length;
    double scatter_factor = 1 - absorption * length, momentum_factor = momentum_retained * scatter_factor;
    const double inverse_diffusivity =
        3 * reduced_extinction * side * side; /* a step's length over it is D in cells^2 a step */
    const double drift =
        inverse_diffusivity > 0 ? length / (inverse_diffusivity * scatter_factor) - reach(transfer) : INFINITY;
    if (drift <= 0) { /* deeper than a free path: it stays until it has spread as far as a step goes */
        momentum_factor = 0;
        length = inverse_diffusivity * reach(transfer) / (1 + inverse_diffusivity * reach(transfer) * absorption);
        scatter_factor = 1 - absorption * length;
    } else if (drift < INFINITY) {
        momentum_factor = fmin(momentum_for(transfer, drift), momentum_factor);
    }
    const double injected_fraction = 1 - 0.5 * flown,
                 flight = reduced_extinction * length > 1 ? 1 / (reduced_extinction * length) : 1;
    return (ty_lpv_links_step){.scatter_factor = scatter_factor,
                               .momentum_factor = momentum_factor,
                               .length = length,
                               .band2_factor = flown + scattered * g * g,
                               .injected_fraction = injected_fraction,
                               .injected_directed = fmin(injected_fraction, flight)};
}

/* Sums are of light that goes on, divided by how much of what arrives that is: never 0. */
static float nonzero_factor(double scatter_factor) {
    static const double least = 1e-6;
    return (float)(fabs(scatter_factor) < least ? least : scatter_factor);
}

ty_lpv_medium_step ty_lpv_links_step_about(const ty_lpv_transfer* transfer, float cell, const ty_lpv_links_step* step,
                                           float extinction_floor) {
    double momentum_factor = step->momentum_factor;
    if (extinction_floor > 0) {
        const double near_source =
            step->length / (3 * (double)extinction_floor * (double)cell * (double)cell) - reach(transfer);
        momentum_factor = fmin(momentum_factor, near_source > 0 ? momentum_for(transfer, near_source) : 0);
    }
    /* Flux out of the lattice's gradients, against -D grad of the fluence; light that was injected has what it flies.
     */
    const double beta2 = transfer->slope * transfer->slope, unretained = 1 - transfer->momentum * momentum_factor;
    const double flux_factor = sqrt(3.0) * (beta2 * momentum_factor + reach(transfer) * unretained) * (double)cell /
                               (transfer->slope * step->length);
    return (ty_lpv_medium_step){
        .scatter_factor = {nonzero_factor(step->scatter_factor), nonzero_factor(momentum_factor),
                           nonzero_factor(fmin(step->band2_factor, momentum_factor / momentum_retained))},
        .length = (float)step->length,
        .flux_factor = {1, (float)flux_factor, 1},
        .injected_fraction = {(float)step->injected_fraction, (float)(step->injected_directed / flux_factor),
                              (float)step->injected_directed}};
}

static ty_lpv_medium_step step_as_published(const ty_lpv_transfer* transfer, double cell, double extinction,
                                            double scattering, double g) {
    const double depth = extinction * cell * transfer->length, flown = exp(-depth);
    const double scattered = extinction > 0 ? (1 - flown) * scattering / extinction : 0;
    return (ty_lpv_medium_step){.scatter_factor = {nonzero_factor(flown + scattered),
                                                   nonzero_factor(flown + scattered * g),
                                                   nonzero_factor(flown + scattered * g * g)},
                                .length = (float)(depth > 1e-6 ? (1 - flown) / extinction : cell * transfer->length),
                                .flux_factor = {1, 1, 1},
                                .injected_fraction = {1, 1, 1}};
}

ty_lpv_medium_step ty_lpv_step_in(const ty_lpv_transfer* transfer, ty_lpv_mode mode, float cell,
                                  const ty_lpv_cell_medium* medium) {
    if (mode != TY_LPV_MODE_LINKS)
        return step_as_published(transfer, (double)cell, (double)medium->extinction, (double)medium->scattering,
                                 (double)medium->g);
    const ty_lpv_links_step step = ty_lpv_links_step_in(transfer, cell, medium);
    return ty_lpv_links_step_about(transfer, cell, &step, medium->extinction_floor);
}

ty_lpv_cell_medium ty_lattice_medium_in(const ty_lattice* lattice, int32_t channel, size_t cell) {
    const ty_grid_medium* medium = lattice->medium;
    ty_lpv_cell_medium out = {.extinction_floor =
                                  lattice->extinction_floor != NULL ? lattice->extinction_floor[cell] : 0.0f};
    if (medium == NULL) return out;
    out.extinction = medium->extinction[channel][cell];
    out.scattering = medium->scattering[channel][cell];
    out.g = medium->g[channel][cell];
    return out;
}
