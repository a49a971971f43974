/* A source field between the middles of its cells, all terms of a cell side by side in memory. */
#ifndef TY_IMAGE_UPSAMPLE_K_H
#define TY_IMAGE_UPSAMPLE_K_H

#include "base/vector.k.h"
#include "direct/single.k.h"

/* Floats of a cell: three channels of one term and the guide, or of four and the guide with room to spare. */
enum { TY_UPSAMPLE_PLAIN = 4, TY_UPSAMPLE_DIRECTED = 16 };

/* Where cells lie. */
typedef struct ty_cell_place {
    int32_t size[3];
    ty_vec lower, per_cell; /* m; cells per m */
} ty_cell_place;

typedef struct ty_upsample_view {
    ty_cell_place place;
    int32_t floats; /* of a cell: channel by channel its terms, then the guide */
    TY_GLOBAL const float* cells;
    float sharpness; /* 1 / (2 width^2); 0: plain interpolation */
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

TY_FN size_t ty_upsample_cell(const ty_upsample_view* view, const ty_cell_point* at, int i) {
    const size_t cell = at->base + ((i & 1) != 0 ? at->step[0] : 0) + ((i & 2) != 0 ? at->step[1] : 0) +
                        ((i & 4) != 0 ? at->step[2] : 0);
    return cell * (size_t)view->floats;
}

/* Gives cells the less weight the further their extinction is from that of the sample: by a bell of half the logarithm
 * of their ratio (its hyperbolic tangent, which is bounded for empty cells). What all cells are given alike falls out
 * of the mean. */
TY_FN void ty_upsample_guide(const ty_upsample_view* view, const ty_cell_point* at, float extinction, float weight[8]) {
    const int guide = view->floats == TY_UPSAMPLE_PLAIN ? 3 : 12;
    const float sharpness = view->sharpness;
    float there[8];
    for (int i = 0; i < 8; ++i) there[i] = view->cells[ty_upsample_cell(view, at, i) + (size_t)guide];
    for (int i = 0; i < 8; ++i) {
        const float apart = (there[i] - extinction) / ty_maxf(there[i] + extinction, 1e-30f);
        weight[i] *= ty_exp_minus(ty_minf(apart * apart * sharpness, 40.0f));
    }
    const float sum =
        ((weight[0] + weight[1]) + (weight[2] + weight[3])) + ((weight[4] + weight[5]) + (weight[6] + weight[7]));
    const float scale = 1.0f / ty_maxf(sum, 1e-30f);
    for (int i = 0; i < 8; ++i) weight[i] *= scale;
}

/* The field's terms at a point between cells, channel by channel as in memory; those past the last one are 0. */
TY_FN void ty_upsample_terms(const ty_upsample_view* view, const ty_cell_point* at, const float weight[8],
                             float sum[TY_UPSAMPLE_DIRECTED]) {
    for (int j = 0; j < TY_UPSAMPLE_DIRECTED; ++j) sum[j] = 0.0f;
    if (view->floats == TY_UPSAMPLE_PLAIN) {
        for (int i = 0; i < 8; ++i) {
            TY_GLOBAL const float* cell = view->cells + ty_upsample_cell(view, at, i);
            for (int j = 0; j < TY_UPSAMPLE_PLAIN; ++j) sum[j] += weight[i] * cell[j];
        }
        return;
    }
    for (int i = 0; i < 8; ++i) {
        TY_GLOBAL const float* cell = view->cells + ty_upsample_cell(view, at, i);
        for (int j = 0; j < TY_UPSAMPLE_DIRECTED; ++j) sum[j] += weight[i] * cell[j];
    }
}

/* What of the terms is alike in all directions, and what the rest is along a unit vector. */
TY_FN void ty_upsample_split(const ty_upsample_view* view, const float sum[TY_UPSAMPLE_DIRECTED], ty_vec way,
                             float even[3], float directed[3]) {
    for (int c = 0; c < 3; ++c) {
        const float* terms = sum + c * (view->floats / 4);
        even[c] = terms[0];
        directed[c] = view->floats == TY_UPSAMPLE_PLAIN ? 0.0f : terms[1] * way.x + terms[2] * way.y + terms[3] * way.z;
    }
}

/* The field's light at a point whose extinction (mean of the channels, 1/m) is given: the radiance that travels along
 * `way` is even + directed. */
TY_FN void ty_upsample(const ty_upsample_view* view, ty_vec point, float extinction, ty_vec way, float even[3],
                       float directed[3]) {
    const ty_vec cells = ty_cell_coordinates(&view->place, point);
    float weight[8], sum[TY_UPSAMPLE_DIRECTED];
    for (int c = 0; c < 3; ++c) even[c] = directed[c] = 0.0f;
    if (!ty_cell_inside(&view->place, cells)) return;
    const ty_cell_point at = ty_cell_locate(view->place.size, cells);
    ty_upsample_weights(&at, weight);
    if (view->sharpness > 0.0f) ty_upsample_guide(view, &at, extinction, weight);
    ty_upsample_terms(view, &at, weight, sum);
    ty_upsample_split(view, sum, way, even, directed);
}

/* What arrives on a surface with a unit normal, W m^-2: of radiance even + directed . way, pi even - 2 pi / 3 directed
 * . normal. The point is inside the box. */
TY_FN void ty_upsample_irradiance(const ty_upsample_view* view, ty_vec cells, ty_vec normal, float irradiance[3]) {
    const ty_cell_point at = ty_cell_locate(view->place.size, cells);
    float weight[8], sum[TY_UPSAMPLE_DIRECTED], even[3], directed[3];
    ty_upsample_weights(&at, weight);
    ty_upsample_terms(view, &at, weight, sum);
    ty_upsample_split(view, sum, normal, even, directed);
    for (int c = 0; c < 3; ++c) irradiance[c] = ty_maxf(0.0f, TY_PI * (even[c] - 2.0f / 3.0f * directed[c]));
}

#endif
