/* A source field between the middles of its cells, all terms of a cell side by side in memory. */
#ifndef TY_IMAGE_UPSAMPLE_K_H
#define TY_IMAGE_UPSAMPLE_K_H

#include "base/vector.k.h"
#include "direct/single.k.h"
#include "image/cuts.k.h"

/* Floats of a cell, terms of all channels and the guide and room to spare: three channels of one term (or one of one),
 * one of four, three of four. */
enum { TY_UPSAMPLE_PLAIN = 4, TY_UPSAMPLE_SHARED = 8, TY_UPSAMPLE_DIRECTED = 16 };

/* Where cells lie. */
typedef struct ty_cell_place {
    int32_t size[3];
    ty_vec lower, per_cell; /* m; cells per m */
} ty_cell_place;

typedef struct ty_upsample_view {
    ty_cell_place place;
    int32_t floats;          /* of a cell: channel by channel its terms, then the guide */
    int32_t channels, terms; /* channels: 3, or 1 that all are multiples of */
    float color[3];          /* times which channels are what is in the cells */
    TY_GLOBAL const float* cells;
    float sharpness;   /* 1 / (2 width^2); 0: plain interpolation */
    ty_cuts_view cuts; /* surfaces between cells */
} ty_upsample_view;

TY_FN ty_vec ty_cell_coordinates(const ty_cell_place* place, ty_vec point) {
    const ty_vec from = ty_sub(point, place->lower);
    return ty_vec_make(from.x * place->per_cell.x, from.y * place->per_cell.y, from.z * place->per_cell.z);
}

TY_FN bool ty_cell_inside(const ty_cell_place* place, ty_vec cells) {
    return cells.x >= 0.0f && cells.y >= 0.0f && cells.z >= 0.0f && cells.x <= (float)place->size[0] &&
           cells.y <= (float)place->size[1] && cells.z <= (float)place->size[2];
}

/* The trilinear weights of eight cells, x fastest. */
TY_FN void ty_upsample_weights(const ty_cell_point* at, float weight[8]) {
    const float x[2] = {1.0f - at->share[0], at->share[0]};
    const float y[2] = {1.0f - at->share[1], at->share[1]};
    const float z[2] = {1.0f - at->share[2], at->share[2]};
    for (int i = 0; i < 8; ++i) weight[i] = x[i & 1] * y[i >> 1 & 1] * z[i >> 2];
}

/* Where the cells' terms are. */
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

/* Gives cells the less weight the further their extinction is from that of the sample: by a bell of half the logarithm
 * of their ratio (its hyperbolic tangent, which is bounded for empty cells). What all cells are given alike falls out
 * of the mean. */
TY_FN void ty_upsample_guide(const ty_upsample_view* view, TY_GLOBAL const float* const cells[8], float extinction,
                             float weight[8]) {
    const int32_t guide = view->channels * view->terms;
    const float sharpness = view->sharpness;
    float there[8];
    for (int i = 0; i < 8; ++i) there[i] = cells[i][guide];
    for (int i = 0; i < 8; ++i) {
        const float apart = (there[i] - extinction) / ty_maxf(there[i] + extinction, 1e-30f);
        weight[i] *= ty_exp_neg(ty_minf(apart * apart * sharpness, 40.0f));
    }
    const float scale = 1.0f / ty_maxf(ty_upsample_sum(weight), 1e-30f);
    for (int i = 0; i < 8; ++i) weight[i] *= scale;
}

/* The first `count` floats of the cells by their weights. */
TY_FN void ty_upsample_mean(TY_GLOBAL const float* const cells[8], const float weight[8], int count, float* mean) {
    for (int j = 0; j < count; ++j)
        mean[j] =
            ((weight[0] * cells[0][j] + weight[1] * cells[1][j]) +
             (weight[2] * cells[2][j] + weight[3] * cells[3][j])) +
            ((weight[4] * cells[4][j] + weight[5] * cells[5][j]) + (weight[6] * cells[6][j] + weight[7] * cells[7][j]));
}

/* Light that leaves a thick medium comes from half of all directions, alike from each of them: fluence 1, flux 1/2,
 * then moments 0 and -1/8. Two moments alone make it a quarter too bright along the normal. The third Legendre term,
 * -7/8 P3, comes in with the cube of twice the flux's share of the fluence, so that it is right there and does nothing
 * inside. */
TY_FN float ty_upsample_third(float even, const float* terms, float along) {
    const float square = terms[1] * terms[1] + terms[2] * terms[2] + terms[3] * terms[3];
    const float length = sqrtf(ty_maxf(square, 1e-30f)), mu = along / length;
    const float share = ty_minf(1.0f, 2.0f / 3.0f * length / ty_maxf(even, 1e-30f));
    return -0.4375f * even * share * share * share * mu * (5.0f * mu * mu - 3.0f);
}

/* What of the field's light between cells is alike in all directions, and what the rest is along a unit vector. */
TY_FN void ty_upsample_terms(const ty_upsample_view* view, TY_GLOBAL const float* const cells[8], const float weight[8],
                             ty_vec way, float even[3], float directed[3], float third[3]) {
    float mean[TY_UPSAMPLE_DIRECTED];
    if (view->floats == TY_UPSAMPLE_PLAIN)
        ty_upsample_mean(cells, weight, TY_UPSAMPLE_PLAIN, mean);
    else if (view->floats == TY_UPSAMPLE_SHARED)
        ty_upsample_mean(cells, weight, TY_UPSAMPLE_SHARED, mean);
    else
        ty_upsample_mean(cells, weight, TY_UPSAMPLE_DIRECTED, mean);
    for (int32_t c = 0; c < 3; ++c) {
        const float* terms = mean + (view->channels == 3 ? c * view->terms : 0);
        even[c] = view->color[c] * terms[0];
        directed[c] = third[c] = 0.0f;
        if (view->terms == 1) continue;
        const float along = terms[1] * way.x + terms[2] * way.y + terms[3] * way.z;
        directed[c] = view->color[c] * along;
        third[c] = view->color[c] * ty_upsample_third(terms[0], terms, along);
    }
}

/* The field's light at a point whose extinction (mean of the channels, 1/m) is given: the radiance that travels along
 * `way` is even + directed + third, of the first, second and fourth Legendre terms about the flux. */
TY_FN void ty_upsample(const ty_upsample_view* view, ty_vec point, float extinction, ty_vec way, float even[3],
                       float directed[3], float third[3]) {
    const ty_vec cells = ty_cell_coordinates(&view->place, point);
    TY_GLOBAL const float* eight[8];
    float weight[8];
    for (int c = 0; c < 3; ++c) even[c] = directed[c] = third[c] = 0.0f;
    if (!ty_cell_inside(&view->place, cells)) return;
    const ty_cell_point at = ty_cell_locate(view->place.size, cells);
    ty_upsample_cells(view, &at, eight);
    ty_upsample_weights(&at, weight);
    if (view->cuts.of_cell != NULL) ty_cuts_weigh(&view->cuts, at.base, cells, weight);
    if (view->sharpness > 0.0f) ty_upsample_guide(view, eight, extinction, weight);
    ty_upsample_terms(view, eight, weight, way, even, directed, third);
}

/* What arrives on a surface with a unit normal, W m^-2: of radiance even + directed . way, pi even - 2 pi / 3 directed
 * . normal. The point is inside the box. */
TY_FN void ty_upsample_irradiance(const ty_upsample_view* view, ty_vec cells, ty_vec normal, float irradiance[3]) {
    const ty_cell_point at = ty_cell_locate(view->place.size, cells);
    TY_GLOBAL const float* eight[8];
    float weight[8], even[3], directed[3], third[3];
    ty_upsample_cells(view, &at, eight);
    ty_upsample_weights(&at, weight);
    ty_upsample_terms(view, eight, weight, normal, even, directed, third);
    for (int c = 0; c < 3; ++c) irradiance[c] = ty_maxf(0.0f, TY_PI * (even[c] - 2.0f / 3.0f * directed[c]));
}

#endif
