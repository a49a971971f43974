/* Interpolation of a source field between cell centers, with all terms of a cell contiguous in memory. */
#ifndef TY_IMAGE_UPSAMPLE_K_H
#define TY_IMAGE_UPSAMPLE_K_H

#include "base/vector.k.h"
#include "direct/single/single.k.h"
#include "image/march/cuts.k.h"

/* Floats per cell, for the terms of all channels, the guide and padding: three channels of one term (or one of one),
 * one of four, three of four. */
enum { TY_UPSAMPLE_PLAIN = 4, TY_UPSAMPLE_SHARED = 8, TY_UPSAMPLE_DIRECTED = 16 };

/* A lattice of cells. */
typedef struct ty_cell_lattice {
    int32_t size[3];
    ty_vec lower, per_cell; /* m; cells per m */
} ty_cell_lattice;

typedef struct ty_upsample_view {
    ty_cell_lattice lattice;
    int32_t floats;          /* per cell: terms channel by channel, then the guide */
    int32_t channels, terms; /* channels: 3, or 1 shared by all */
    float color[3];          /* factors of the channels on the cells' values */
    TY_GLOBAL const float* cells;
    float sharpness;   /* 1 / (2 sigma^2) of the bilateral weights; 0: trilinear interpolation */
    ty_cuts_view cuts; /* surfaces between cells */
} ty_upsample_view;

TY_FN ty_vec ty_cell_coordinates(const ty_cell_lattice* lattice, ty_vec point) {
    const ty_vec from = ty_sub(point, lattice->lower);
    return ty_vec_make(from.x * lattice->per_cell.x, from.y * lattice->per_cell.y, from.z * lattice->per_cell.z);
}

TY_FN bool ty_cell_inside(const ty_cell_lattice* lattice, ty_vec cells) {
    return cells.x >= 0.0f && cells.y >= 0.0f && cells.z >= 0.0f && cells.x <= (float)lattice->size[0] &&
           cells.y <= (float)lattice->size[1] && cells.z <= (float)lattice->size[2];
}

/* Trilinear weights of eight cells, x fastest. */
TY_FN void ty_upsample_weights(const ty_cell_point* at, float weight[8]) {
    const float x[2] = {1.0f - at->fraction[0], at->fraction[0]};
    const float y[2] = {1.0f - at->fraction[1], at->fraction[1]};
    const float z[2] = {1.0f - at->fraction[2], at->fraction[2]};
    for (int i = 0; i < 8; ++i) weight[i] = x[i & 1] * y[i >> 1 & 1] * z[i >> 2];
}

/* Pointers to the terms of the eight cells. */
TY_FN void ty_upsample_cells(const ty_upsample_view* view, const ty_cell_point* at, TY_GLOBAL const float* cells[8]) {
    const size_t floats = (size_t)view->floats;
    const size_t x = at->step[0] * floats, y = at->step[1] * floats, z = at->step[2] * floats;
    TY_GLOBAL const float* from = view->cells + at->base * floats;
    cells[0] = from;
    cells[1] = from + x;
    cells[2] = from + y;
    cells[3] = from + y + x;
    for (int i = 0; i < 4; ++i) cells[4 + i] = cells[i] + z;
}

TY_FN float ty_upsample_sum(const float weight[8]) {
    return ((weight[0] + weight[1]) + (weight[2] + weight[3])) + ((weight[4] + weight[5]) + (weight[6] + weight[7]));
}

/* Bilateral weights: cells lose weight with the difference of their extinction from that of the sample, by a Gaussian
 * of half the logarithm of their ratio (its hyperbolic tangent, which is bounded for empty cells). Common factors
 * cancel in the normalisation. */
TY_FN void ty_upsample_bilateral(const ty_upsample_view* view, TY_GLOBAL const float* const cells[8], float extinction,
                                 float weight[8]) {
    const int32_t guide = view->channels * view->terms;
    const float sharpness = view->sharpness;
    float guides[8];
    for (int i = 0; i < 8; ++i) guides[i] = cells[i][guide];
    for (int i = 0; i < 8; ++i) {
        const float difference = (guides[i] - extinction) / ty_maxf(guides[i] + extinction, 1e-30f);
        weight[i] *= ty_exp_neg(ty_minf(difference * difference * sharpness, 40.0f));
    }
    const float scale = 1.0f / ty_maxf(ty_upsample_sum(weight), 1e-30f);
    for (int i = 0; i < 8; ++i) weight[i] *= scale;
}

/* Weighted mean of the first `count` floats of the cells. */
TY_FN void ty_upsample_mean(TY_GLOBAL const float* const cells[8], const float weight[8], int count, float* mean) {
    for (int j = 0; j < count; ++j)
        mean[j] =
            ((weight[0] * cells[0][j] + weight[1] * cells[1][j]) +
             (weight[2] * cells[2][j] + weight[3] * cells[3][j])) +
            ((weight[4] * cells[4][j] + weight[5] * cells[5][j]) + (weight[6] * cells[6][j] + weight[7] * cells[7][j]));
}

/* Radiance leaving a dense medium fills one hemisphere uniformly: fluence 1, flux 1/2, then moments 0 and -1/8. Two
 * moments alone make it a quarter too bright along the normal. The third Legendre term, -7/8 P3, enters with the cube
 * of twice the ratio of flux to fluence, so it is exact there and vanishes inside. */
TY_FN float ty_upsample_third(float isotropic, const float* terms, float along) {
    const float square = terms[1] * terms[1] + terms[2] * terms[2] + terms[3] * terms[3];
    const float length = sqrtf(ty_maxf(square, 1e-30f)), mu = along / length;
    const float flux_ratio = ty_minf(1.0f, 2.0f / 3.0f * length / ty_maxf(isotropic, 1e-30f));
    return -0.4375f * isotropic * flux_ratio * flux_ratio * flux_ratio * mu * (5.0f * mu * mu - 3.0f);
}

/* The isotropic term of the field between cells, and the directed terms along a unit vector. */
TY_FN void ty_upsample_terms(const ty_upsample_view* view, TY_GLOBAL const float* const cells[8], const float weight[8],
                             ty_vec omega, float isotropic[3], float directed[3], float third[3]) {
    float mean[TY_UPSAMPLE_DIRECTED];
    if (view->floats == TY_UPSAMPLE_PLAIN)
        ty_upsample_mean(cells, weight, TY_UPSAMPLE_PLAIN, mean);
    else if (view->floats == TY_UPSAMPLE_SHARED)
        ty_upsample_mean(cells, weight, TY_UPSAMPLE_SHARED, mean);
    else
        ty_upsample_mean(cells, weight, TY_UPSAMPLE_DIRECTED, mean);
    for (int32_t c = 0; c < 3; ++c) {
        const float* terms = mean + (view->channels == 3 ? c * view->terms : 0);
        isotropic[c] = view->color[c] * terms[0];
        directed[c] = third[c] = 0.0f;
        if (view->terms == 1) continue;
        const float along = terms[1] * omega.x + terms[2] * omega.y + terms[3] * omega.z;
        directed[c] = view->color[c] * along;
        third[c] = view->color[c] * ty_upsample_third(terms[0], terms, along);
    }
}

/* The field at a point of given extinction (channel mean, 1/m): the radiance travelling along omega is isotropic +
 * directed + third, of the first, second and fourth Legendre terms about the flux. */
TY_FN void ty_upsample(const ty_upsample_view* view, ty_vec point, float extinction, ty_vec omega, float isotropic[3],
                       float directed[3], float third[3]) {
    const ty_vec cells = ty_cell_coordinates(&view->lattice, point);
    TY_GLOBAL const float* eight[8];
    float weight[8];
    for (int c = 0; c < 3; ++c) isotropic[c] = directed[c] = third[c] = 0.0f;
    if (!ty_cell_inside(&view->lattice, cells)) return;
    const ty_cell_point at = ty_cell_locate(view->lattice.size, cells);
    ty_upsample_cells(view, &at, eight);
    ty_upsample_weights(&at, weight);
    if (view->cuts.of_cell != NULL) ty_cuts_weigh(&view->cuts, at.base, cells, weight);
    if (view->sharpness > 0.0f) ty_upsample_bilateral(view, eight, extinction, weight);
    ty_upsample_terms(view, eight, weight, omega, isotropic, directed, third);
}

/* Irradiance on a surface with a unit normal, W m^-2: for radiance isotropic + directed . omega, pi isotropic - 2 pi /
 * 3 directed . normal. The point is inside the box. */
TY_FN void ty_upsample_irradiance(const ty_upsample_view* view, ty_vec cells, ty_vec normal, float irradiance[3]) {
    const ty_cell_point at = ty_cell_locate(view->lattice.size, cells);
    TY_GLOBAL const float* eight[8];
    float weight[8], isotropic[3], directed[3], third[3];
    ty_upsample_cells(view, &at, eight);
    ty_upsample_weights(&at, weight);
    ty_upsample_terms(view, eight, weight, normal, isotropic, directed, third);
    for (int c = 0; c < 3; ++c) irradiance[c] = ty_maxf(0.0f, TY_PI * (isotropic[c] - 2.0f / 3.0f * directed[c]));
}

#endif
