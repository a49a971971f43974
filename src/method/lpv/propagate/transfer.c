/* Transfer functions of the links, and the scattering operator of media. */
#include "method/lpv/propagate/transfer.h"

#include <stdlib.h>

/* ---- directions ---- */

enum { PATCH_POINTS = 48 }; /* quadrature points along a side of a cube's face */

typedef struct patch_sums {
    double solid_angle, terms[TY_SH_TERMS];
} patch_sums;

/* The nearest multiple of 45 degrees (as -1, 0 or 1) to a direction in the plane of two axes, given its component along
 * one when its component along the other, the major axis, is 1. */
static int32_t nearest(double component) {
    static const double tangent = 0.41421356237309503; /* tan 22.5 degrees */
    return component > tangent ? 1 : component < -tangent ? -1 : 0;
}

/* Adds the directions through one face of the cube [-1, 1]^3, sampled on a regular grid. */
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

/* The number of axes that a link moves along, minus 1: face, edge or corner link. Links of one kind are congruent. */
static int32_t kind_of(const int32_t step[3]) {
    return abs(step[0]) + abs(step[1]) + abs(step[2]) - 1;
}

/* One link of each kind. */
static const int32_t model[3][3] = {{0, 0, 1}, {1, 1, 0}, {1, 1, 1}};

/* G_j of Eq. 3 (Billeter 2012): the spherical harmonics of link j's patch of directions over the square root of its
 * solid angle, normalised so that sum over j of G_j0^2 = 1. Rotated from the model link of its kind, so that the
 * symmetry of the links is exact. */
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
    /* Band 2 is rotationally symmetric about one axis: that of a face link, or the axis orthogonal to an edge link. */
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
                     band1_square = squares(transfer_G + 1, 3);
        transfer->length += dc * dc * sqrt(square);
        transfer->slope += dc * sqrt(band1_square * square) / 3;
        transfer->step_variance += dc * dc * square / 3;
        transfer->momentum += band1_square / 3;
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
        make_transfer_G(&sums[ty_lpv_link(model[kind][0], model[kind][1], model[kind][2])], whole, step, out->G[k]);
        momentum += squares(out->G[k] + 1, 3) / 3;
    }
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k)
        for (int32_t t = 1; t < 4 && keeps_momentum; ++t) out->G[k][t] /= (float)sqrt(momentum);
    measure(out);
}

/* ---- media ---- */

/* The maximum momentum that light keeps from step to step, that of a medium with a mean free path of 16 cells. Without
 * this limit two or three bands overshoot in vacuum to negative fluence between a small source and the border; with a
 * lower limit light between surfaces diffuses too slowly. Near local lights ty_lattice_find_extinction_floor lowers it
 * further. */
static const double momentum_retained = 0.92;

/* Diffusivity of a step without momentum, cells^2: half of its variance. */
static double reach(const ty_lpv_transfer* transfer) {
    return 0.5 * transfer->step_variance;
}

/* The momentum that adds a diffusivity of `drift` cells^2 per step. */
static double momentum_for(const ty_lpv_transfer* transfer, double drift) {
    return drift / (transfer->slope * transfer->slope + transfer->momentum * drift);
}

/* Chooses the momentum such that the lattice's diffusion coefficient is the medium's, D = 1 / (3 sigma_tr). */
ty_lpv_links_step ty_lpv_links_step_in(const ty_lpv_transfer* transfer, float cell, const ty_lpv_cell_medium* medium) {
    const double extinction = (double)medium->extinction, scattering = (double)medium->scattering;
    const double g = (double)medium->g, side = (double)cell;
    const double depth = extinction * side * transfer->length,
                 remaining = exp(-depth); /* 1 - lambda, Eq. 3 (Billeter 2012) */
    const double absorption = fmax(extinction - scattering, 0), reduced_extinction = extinction - g * scattering;
    const double lambda_s = extinction > 0 ? (1 - remaining) * scattering / extinction : 0; /* Eq. 3 (Billeter 2012) */
    const double reduced_albedo = reduced_extinction > 0 ? (1 - g) * scattering / reduced_extinction : 0;
    const double flight = side * transfer->length, ending = extinction - reduced_albedo * reduced_albedo * scattering;
    double length = ending * flight > 1e-6 ? (1 - exp(-ending * flight)) / ending : flight;
    double scatter_factor = 1 - absorption * length, momentum_factor = momentum_retained * scatter_factor;
    const double inverse_diffusivity =
        3 * reduced_extinction * side * side; /* length / inverse_diffusivity is D in cells^2 per step */
    const double drift =
        inverse_diffusivity > 0 ? length / (inverse_diffusivity * scatter_factor) - reach(transfer) : INFINITY;
    if (drift <= 0) { /* deeper than a mean free path: light stays until it has diffused as far as a step goes */
        momentum_factor = 0;
        length = inverse_diffusivity * reach(transfer) / (1 + inverse_diffusivity * reach(transfer) * absorption);
        scatter_factor = 1 - absorption * length;
    } else if (drift < INFINITY) {
        momentum_factor = fmin(momentum_for(transfer, drift), momentum_factor);
    }
    const double injected_fraction = 1 - 0.5 * remaining,
                 uncollided = reduced_extinction * length > 1 ? 1 / (reduced_extinction * length) : 1;
    return (ty_lpv_links_step){.scatter_factor = scatter_factor,
                               .momentum_factor = momentum_factor,
                               .length = length,
                               .band2_factor = remaining + lambda_s * g * g,
                               .injected_fraction = injected_fraction,
                               .injected_directed = fmin(injected_fraction, uncollided)};
}

/* Sums of outgoing light are divided by this factor, which therefore must not be 0. */
static float nonzero_factor(double scatter_factor) {
    static const double min = 1e-6;
    return (float)(fabs(scatter_factor) < min ? min : scatter_factor);
}

ty_lpv_medium_step ty_lpv_links_step_about(const ty_lpv_transfer* transfer, float cell, const ty_lpv_links_step* step,
                                           float extinction_floor) {
    double momentum_factor = step->momentum_factor;
    if (extinction_floor > 0) {
        const double near_source =
            step->length / (3 * (double)extinction_floor * (double)cell * (double)cell) - reach(transfer);
        momentum_factor = fmin(momentum_factor, near_source > 0 ? momentum_for(transfer, near_source) : 0);
    }
    /* Ratio of the lattice's flux to band 1; injected light has the flux of its free flight instead. */
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

/* lambda, lambda_s and gamma_j of Eq. 3 (Billeter 2012), with gamma_j = G_j0 / sqrt(4 pi), which conserves energy. */
static ty_lpv_medium_step step_as_published(const ty_lpv_transfer* transfer, double cell, double extinction,
                                            double scattering, double g) {
    const double depth = extinction * cell * transfer->length, remaining = exp(-depth);
    const double lambda = 1 - remaining;                                           /* Eq. 3 (Billeter 2012) */
    const double lambda_s = extinction > 0 ? lambda * scattering / extinction : 0; /* Eq. 3 (Billeter 2012) */
    /* (1 - lambda) <L | G_j> + gamma_j lambda_s <L | 1> with gamma_j = G_j0 / sqrt(4 pi), Eq. 3 (Billeter 2012): as
     * <L | 1> = sqrt(4 pi) L_0, the second term is lambda_s times band 0 of <L | G_j>. A Henyey-Greenstein medium adds
     * lambda_s g^l to band l, so both terms are one factor per band. */
    return (ty_lpv_medium_step){.scatter_factor = {nonzero_factor(remaining + lambda_s),
                                                   nonzero_factor(remaining + lambda_s * g),
                                                   nonzero_factor(remaining + lambda_s * g * g)},
                                .length = (float)(depth > 1e-6 ? lambda / extinction : cell * transfer->length),
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
    const float* border_scale = lattice->border_scale[medium->planes == 1 ? 0 : channel];
    const float scale = border_scale != NULL ? border_scale[cell] : 1.0f;
    const float g = medium->g[channel][cell], scattering = medium->scattering[channel][cell];
    const float forward = lattice->reduces ? ty_reduced_forward_fraction(g) * scattering : 0.0f;
    out.extinction = scale * (medium->extinction[channel][cell] - forward);
    out.scattering = scale * (scattering - forward);
    out.g = lattice->reduces ? ty_reduced_g(g) : g;
    return out;
}
