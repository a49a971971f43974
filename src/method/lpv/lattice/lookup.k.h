/* Interpolation of a lattice's light: of the eight cells around a point, those that a blocked link separates from the
 * point's own cell are left out. */
#ifndef TY_METHOD_LPV_LATTICE_LOOKUP_K_H
#define TY_METHOD_LPV_LATTICE_LOOKUP_K_H

#include "method/lpv/lattice/lattice.h"

/* The cells around a point and their weights, which sum to 1. */
typedef struct ty_lattice_cells {
    int32_t index[8];
    float weight[8];
} ty_lattice_cells;

/* Blend of two cascades; the finer one's weight falls to 0 at its border. */
typedef struct ty_lattice_cascade_weights {
    int32_t lattice[2]; /* -1: none */
    float weight[2];
} ty_lattice_cascade_weights;

/* Width of the blend at the border of a finer cascade, cells. */
#define TY_LATTICE_BLEND 2.0f

/* A surface point moved into the cells on its lit side. */
TY_FN ty_vec ty_lattice_lift(ty_vec point, ty_vec normal, float cell) {
    const float size = fabsf(normal.x) + fabsf(normal.y) + fabsf(normal.z);
    return ty_mad(point, normal, 0.5f * cell * size);
}

/* The displacement of a point, in cells, away from the surfaces that it lies in front of but its cell's center lies
 * behind, so far that the center of the new cell is in front, too. */
TY_FN ty_vec ty_surface_depths_leave(TY_GLOBAL const int32_t* surface_depth_index,
                                     TY_GLOBAL const ty_surface_depths* surface_depths, const int32_t size[3],
                                     ty_vec place) {
    ty_vec displacement = ty_vec_make(0.0f, 0.0f, 0.0f);
    if (surface_depth_index == NULL) return displacement;
    const int32_t x = (int32_t)ty_clampf(place.x, 0.0f, (float)size[0] - 0.5f);
    const int32_t y = (int32_t)ty_clampf(place.y, 0.0f, (float)size[1] - 0.5f);
    const int32_t z = (int32_t)ty_clampf(place.z, 0.0f, (float)size[2] - 0.5f);
    const int32_t which = surface_depth_index[x + size[0] * (y + size[1] * z)];
    const ty_vec off = ty_vec_make(place.x - (float)x - 0.5f, place.y - (float)y - 0.5f, place.z - (float)z - 0.5f);
    for (int side = 0; side < TY_SURFACE_SIDES && which >= 0; ++side) {
        TY_GLOBAL const float* plane = surface_depths[which].plane[side];
        const ty_vec normal = ty_vec_make(plane[0], plane[1], plane[2]);
        const float clearance = 0.5f * (fabsf(normal.x) + fabsf(normal.y) + fabsf(normal.z));
        const float height = ty_dot(ty_add(off, displacement), normal) - plane[3];
        if (clearance > 0.0f && height > -0.02f && height < clearance)
            displacement = ty_mad(displacement, normal, clearance - height);
    }
    return displacement;
}

/* A point in cell coordinates. */
TY_FN ty_vec ty_lattice_coordinates(const ty_lattice* lattice, ty_vec point) {
    const float scale = 1.0f / lattice->cell;
    const double* lower = lattice->box.lower;
    return ty_vec_make((float)((double)point.x - lower[0]) * scale, (float)((double)point.y - lower[1]) * scale,
                       (float)((double)point.z - lower[2]) * scale);
}

/* The lookup point of a surface point. */
TY_FN ty_vec ty_lattice_lit_side(const ty_lattice* lattice, ty_vec point, ty_vec normal) {
    const ty_vec off = ty_lattice_lift(point, normal, lattice->cell);
    const ty_vec leave = ty_surface_depths_leave(lattice->surface_depth_index, lattice->surface_depths,
                                                 lattice->box.size, ty_lattice_coordinates(lattice, off));
    return ty_mad(off, leave, lattice->cell);
}

/* Linear interpolation along an axis: the cell that contains the coordinate, the step to the other cell, and its
 * weight. At the border the step and the weight are 0. */
typedef struct ty_lattice_pair {
    int32_t cell, step;
    float weight;
} ty_lattice_pair;

TY_FN ty_lattice_pair ty_lattice_pair_at(float place, int32_t size) {
    const float inside = ty_clampf(place, 0.0f, (float)size);
    ty_lattice_pair pair;
    pair.cell = (int32_t)inside;
    if (pair.cell > size - 1) pair.cell = size - 1;
    const float off = inside - (float)pair.cell - 0.5f;
    pair.step = off < 0.0f ? -1 : 1;
    pair.weight = fabsf(off);
    const int32_t other = pair.cell + pair.step;
    if (other < 0 || other >= size) {
        pair.step = 0;
        pair.weight = 0.0f;
    }
    return pair;
}

/* The cells around a point. False, with zero weights, if the point is more than half a cell outside the lattice. */
TY_FN bool ty_lattice_find(const ty_lattice* lattice, ty_vec point, ty_lattice_cells* cells) {
    const int32_t* size = lattice->box.size;
    const ty_vec p = ty_lattice_coordinates(lattice, point);
    if (!(p.x >= -0.5f && p.y >= -0.5f && p.z >= -0.5f && p.x <= (float)size[0] + 0.5f &&
          p.y <= (float)size[1] + 0.5f && p.z <= (float)size[2] + 0.5f)) {
        memset(cells, 0, sizeof *cells);
        return false;
    }
    const ty_lattice_pair x = ty_lattice_pair_at(p.x, size[0]), y = ty_lattice_pair_at(p.y, size[1]),
                          z = ty_lattice_pair_at(p.z, size[2]);
    const int32_t row = size[0], plane = size[0] * size[1];
    const int32_t own = x.cell + y.cell * row + z.cell * plane;
    float sum = 0.0f;
    for (int32_t i = 0; i < 8; ++i) {
        const int32_t dx = (i & 1) != 0 ? x.step : 0, dy = (i & 2) != 0 ? y.step : 0, dz = (i & 4) != 0 ? z.step : 0;
        const int32_t cell = own + dx + dy * row + dz * plane;
        float weight = ((i & 1) != 0 ? x.weight : 1.0f - x.weight) * ((i & 2) != 0 ? y.weight : 1.0f - y.weight) *
                       ((i & 4) != 0 ? z.weight : 1.0f - z.weight);
        if (lattice->blocked && (dx != 0 || dy != 0 || dz != 0))
            weight *= (float)lattice->transmission[ty_lpv_link(dx, dy, dz)][cell] * (1.0f / 255.0f);
        cells->index[i] = cell;
        cells->weight[i] = weight;
        sum += weight;
    }
    const float scale = 1.0f / sum; /* at least 1/8, the weight of the point's own cell */
    for (int32_t i = 0; i < 8; ++i) cells->weight[i] *= scale;
    return true;
}

/* Interpolates a plane of values. */
TY_FN float ty_lattice_mean(const ty_lattice_cells* cells, TY_GLOBAL const float* plane) {
    float sum = 0.0f;
    for (int32_t i = 0; i < 8; ++i) sum += cells->weight[i] * plane[cells->index[i]];
    return sum;
}

/* Interpolates the first `terms` terms of a channel's light, W m^-2 sr^-1. */
TY_FN void ty_lattice_values(const ty_lattice* lattice, const ty_lattice_cells* cells, int32_t channel, int32_t terms,
                             float values[TY_SH_TERMS]) {
    for (int32_t t = 0; t < terms; ++t) values[t] = ty_lattice_mean(cells, lattice->light[channel][t]);
}

/* Distance of a point to the lattice's border, in cells; negative outside. */
TY_FN float ty_lattice_depth(const ty_lattice* lattice, ty_vec place) {
    const int32_t* size = lattice->box.size;
    const float x = ty_minf(place.x, (float)size[0] - place.x), y = ty_minf(place.y, (float)size[1] - place.y);
    return ty_minf(ty_minf(x, y), ty_minf(place.z, (float)size[2] - place.z));
}

/* The cascades that light a point; lattices: finest first. */
TY_FN ty_lattice_cascade_weights ty_lattice_choose_cascades(ty_lattice* const* lattices, int32_t count, ty_vec point) {
    ty_lattice_cascade_weights mix = {.lattice = {-1, -1}};
    for (int32_t i = 0; i < count; ++i) {
        const float depth = ty_lattice_depth(lattices[i], ty_lattice_coordinates(lattices[i], point));
        const bool last = i == count - 1;
        if (!(depth > (last ? -0.5f : 0.0f))) continue;
        const float weight = last ? 1.0f : ty_clampf(depth * (1.0f / TY_LATTICE_BLEND), 0.0f, 1.0f);
        mix.lattice[0] = i;
        mix.weight[0] = weight;
        mix.lattice[1] = weight < 1.0f ? i + 1 : -1;
        mix.weight[1] = 1.0f - weight;
        return mix;
    }
    return mix;
}

#endif
