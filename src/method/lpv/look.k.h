/* The lattices' light between the middles of their cells, all terms of a cell side by side in memory: what images look
 * up for every pixel. Of the eight cells around a point those count that no surface separates from the one that the
 * point lies in. */
#ifndef TY_METHOD_LPV_LOOK_K_H
#define TY_METHOD_LPV_LOOK_K_H

#include "base/sh.k.h"

#include <tyndall/lpv.h>

/* Floats of a cell: channel by channel the first two bands and a quarter to spare, then, with three bands, five more
 * terms a channel and one to spare. */
enum { TY_LOOK_FLOATS = 16, TY_LOOK_FLOATS_MAX = 32 };
/* Bytes of a cell's links: how open the way is to the cell dx + 3 dy + 9 dz + 13. */
enum { TY_LOOK_NEAR = 32, TY_LOOK_SELF = 13 };

typedef struct ty_look_lattice {
    int32_t size[3];
    int32_t floats;
    float cell;   /* m */
    ty_vec lower; /* m */
    ty_vec upper;
    TY_GLOBAL const float* light;
    TY_GLOBAL const uint8_t* closed; /* per cell: whether any of its links is not fully open; NULL: none is */
    TY_GLOBAL const uint8_t* near;   /* TY_LOOK_NEAR a cell */
} ty_look_lattice;

/* All of them, finest first. */
typedef struct ty_look {
    int32_t count;
    ty_look_lattice lattices[TY_LPV_CASCADES_MAX];
} ty_look;

typedef struct ty_look_cells {
    size_t index[8];
    float weight[8];
} ty_look_cells;

/* A place along an axis, in cells: the lower of the two cells around, how far on it is, the step to the other one, and
 * which of them it lies in. */
TY_FN int32_t ty_look_axis(float place, int32_t size, float* share, size_t* step, int32_t* own) {
    const float middle = ty_clampf(place - 0.5f, 0.0f, (float)(size - 1));
    const int32_t last = size > 1 ? size - 2 : 0, floor = (int32_t)middle, base = floor < last ? floor : last;
    *share = middle - (float)base;
    *step = size > 1 ? 1 : 0;
    *own = *share >= 0.5f ? 1 : 0;
    return base;
}

/* Leaves out what surfaces separate from the cell that the point lies in, which always counts. */
TY_FN void ty_look_close(TY_GLOBAL const uint8_t* near, const int32_t own[3], ty_look_cells* cells) {
    float sum = 0.0f;
    for (int i = 0; i < 8; ++i) {
        const int32_t dx = (i & 1) - own[0], dy = (i >> 1 & 1) - own[1], dz = (i >> 2) - own[2];
        cells->weight[i] *= (float)near[TY_LOOK_SELF + dx + 3 * dy + 9 * dz];
        sum += cells->weight[i];
    }
    const float scale = 1.0f / sum;
    for (int i = 0; i < 8; ++i) cells->weight[i] *= scale;
}

/* The cells around a point, which is moved into the lattice if it is not there. */
TY_FN void ty_look_locate(const ty_look_lattice* lattice, ty_vec point, ty_look_cells* cells) {
    const float per_metre = 1.0f / lattice->cell;
    const ty_vec p = ty_scale(ty_sub(point, lattice->lower), per_metre);
    float share[3];
    size_t step[3];
    int32_t own[3];
    const size_t nx = (size_t)lattice->size[0], ny = (size_t)lattice->size[1];
    const size_t x = (size_t)ty_look_axis(p.x, lattice->size[0], &share[0], &step[0], &own[0]);
    const size_t y = (size_t)ty_look_axis(p.y, lattice->size[1], &share[1], &step[1], &own[1]);
    const size_t z = (size_t)ty_look_axis(p.z, lattice->size[2], &share[2], &step[2], &own[2]);
    const size_t base = x + nx * (y + ny * z), dy = step[1] * nx, dz = step[2] * nx * ny;
    const float wx[2] = {1.0f - share[0], share[0]}, wy[2] = {1.0f - share[1], share[1]};
    const float wz[2] = {1.0f - share[2], share[2]};
    for (int i = 0; i < 8; ++i) {
        cells->index[i] = base + ((i & 1) != 0 ? step[0] : 0) + ((i >> 1 & 1) != 0 ? dy : 0) + (i >> 2 != 0 ? dz : 0);
        cells->weight[i] = wx[i & 1] * wy[i >> 1 & 1] * wz[i >> 2];
    }
    if (lattice->closed == NULL) return;
    const size_t self = base + (own[0] != 0 ? step[0] : 0) + (own[1] != 0 ? dy : 0) + (own[2] != 0 ? dz : 0);
    if (lattice->closed[self] != 0) ty_look_close(lattice->near + self * TY_LOOK_NEAR, own, cells);
}

/* Adds factor times the mean of the cells' first `count` floats from `first` on. */
TY_FN void ty_look_add(const ty_look_lattice* lattice, const ty_look_cells* cells, int32_t first, float factor,
                       float sum[TY_LOOK_FLOATS]) {
    TY_GLOBAL const float* light = lattice->light + first;
    const size_t floats = (size_t)lattice->floats;
    for (int i = 0; i < 8; ++i) {
        TY_GLOBAL const float* cell = light + cells->index[i] * floats;
        const float weight = factor * cells->weight[i];
        for (int j = 0; j < TY_LOOK_FLOATS; ++j) sum[j] += weight * cell[j];
    }
}

/* How far within a lattice a point is: 0 on its faces, 1 two cells away from them; negative outside. */
TY_FN float ty_look_depth(const ty_look_lattice* lattice, ty_vec p) {
    const float x = ty_minf(p.x - lattice->lower.x, lattice->upper.x - p.x);
    const float y = ty_minf(p.y - lattice->lower.y, lattice->upper.y - p.y);
    const float z = ty_minf(p.z - lattice->lower.z, lattice->upper.z - p.z);
    return ty_minf(ty_minf(x, ty_minf(y, z)) / (2.0f * lattice->cell), 1.0f);
}

/* The finest lattice at a point (half a cell around it counts), -1: none, and what the next one's share is: all of it
 * where the finer one ends, so that no edge shows. */
TY_FN int32_t ty_look_choose(const ty_look* look, ty_vec point, float* coarser) {
    *coarser = 0.0f;
    for (int32_t i = 0; i < look->count; ++i) {
        const float depth = ty_look_depth(&look->lattices[i], point);
        if (!(depth > -0.25f)) continue;
        if (i + 1 < look->count) *coarser = 1.0f - ty_maxf(depth, 0.0f);
        return i;
    }
    return -1;
}

/* What arrives on a surface: radiance of terms L_i, W m^-2, by the clamped cosine's bands; light travels against the
 * normal. */
TY_FN float ty_look_irradiance(const float band01[4], const float* band2, const float y[TY_SH_TERMS]) {
    float sum = ty_sh_cosine(0) * band01[0] * y[0];
    for (int i = 1; i < 4; ++i) sum += ty_sh_cosine(1) * band01[i] * y[i];
    for (int i = 0; i < 5 && band2 != NULL; ++i) sum += ty_sh_cosine(2) * band2[i] * y[4 + i];
    return ty_maxf(sum, 0.0f);
}

/* How far off a surface its light is looked up, m: by what a cell measures along the normal, so that the cell is on the
 * side that is asked for. */
TY_FN float ty_look_off(float cell, ty_vec normal) {
    return 0.5f * cell * (fabsf(normal.x) + fabsf(normal.y) + fabsf(normal.z));
}

/* Irradiance at a surface with a unit normal on the side that is asked for; 0 outside of all lattices. */
TY_FN void ty_look_at_surface(const ty_look* look, ty_vec point, ty_vec normal, float irradiance[3]) {
    float y[TY_SH_TERMS], coarser;
    for (int c = 0; c < 3; ++c) irradiance[c] = 0.0f;
    const int32_t finest = ty_look_choose(look, point, &coarser);
    if (finest < 0) return;
    ty_sh_at(ty_scale(normal, -1.0f), TY_SH_BANDS, y);
    for (int32_t i = finest; i < finest + (coarser > 0.0f ? 2 : 1); ++i) {
        const ty_look_lattice* lattice = &look->lattices[i];
        const float share = i == finest ? 1.0f - coarser : coarser;
        float sum[TY_LOOK_FLOATS_MAX];
        ty_look_cells cells;
        memset(sum, 0, sizeof sum);
        ty_look_locate(lattice, ty_mad(point, normal, ty_look_off(lattice->cell, normal)), &cells);
        ty_look_add(lattice, &cells, 0, share, sum);
        const bool third = lattice->floats > TY_LOOK_FLOATS;
        if (third) ty_look_add(lattice, &cells, TY_LOOK_FLOATS, share, sum + TY_LOOK_FLOATS);
        for (int c = 0; c < 3; ++c)
            irradiance[c] += ty_look_irradiance(sum + 4 * c, third ? sum + TY_LOOK_FLOATS + 5 * c : NULL, y);
    }
}

#endif
