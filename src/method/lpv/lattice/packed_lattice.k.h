/* Trilinear lookups in packed lattices, which images do for every pixel. Of the eight cells around a point, those that
 * a blocked link separates from the point's own cell are left out. */
#ifndef TY_METHOD_LPV_LATTICE_PACKED_LATTICE_K_H
#define TY_METHOD_LPV_LATTICE_PACKED_LATTICE_K_H

#include "method/lpv/lattice/lookup.k.h"

/* Floats of a cell: four terms per channel and four of padding; with three bands five more terms per channel and one of
 * padding. */
enum { TY_PACKED_FLOATS = 16, TY_PACKED_FLOATS_MAX = 32 };
/* Bytes per cell: the transmission from neighbour dx + 3 dy + 9 dz + 13. */
enum { TY_PACKED_LINKS = 32, TY_PACKED_SELF = 13 };

typedef struct ty_packed_lattice {
    int32_t size[3];
    int32_t floats;
    float cell, per_metre; /* m; 1 / m */
    ty_vec lower;          /* m */
    ty_vec upper;
    TY_GLOBAL const float* light;
    TY_GLOBAL const uint8_t* blocked;             /* per cell: whether any of its links is blocked; NULL: no blockers */
    TY_GLOBAL const uint8_t* links;               /* TY_PACKED_LINKS bytes per cell */
    TY_GLOBAL const int32_t* surface_depth_index; /* as in ty_lattice; NULL: none */
    TY_GLOBAL const ty_surface_depths* surface_depths;
} ty_packed_lattice;

/* All cascades, finest first. */
typedef struct ty_packed_lattices {
    int32_t count;
    ty_packed_lattice lattices[TY_LPV_CASCADES_MAX];
} ty_packed_lattices;

typedef struct ty_packed_cells {
    TY_GLOBAL const float* light[8];
    float weight[8];
} ty_packed_cells;

/* The lower of the two cells around a coordinate, measured in cells from the first cell's center, and the interpolation
 * fraction. */
TY_FN int32_t ty_packed_axis(float place, int32_t size, float* fraction) {
    const float clamped = ty_clampf(place, 0.0f, (float)(size - 1));
    const int32_t last = size > 1 ? size - 2 : 0, cell = (int32_t)clamped, base = cell < last ? cell : last;
    *fraction = clamped - (float)base;
    return base;
}

/* Multiplies the weights by the transmission into the point's own cell, and normalises them. */
TY_FN void ty_packed_mask_blocked(TY_GLOBAL const uint8_t* links, const int32_t own[3], float weight[8]) {
    TY_GLOBAL const uint8_t* first = links + (TY_PACKED_SELF - own[0] - 3 * own[1] - 9 * own[2]);
    uint8_t transmission[8];
    for (int i = 0; i < 4; ++i) memcpy(transmission + 2 * i, first + 3 * (i & 1) + 9 * (i >> 1), 2); /* pairs along x */
#pragma omp simd
    for (int i = 0; i < 8; ++i) weight[i] *= (float)transmission[i];
    const float sum =
        ((weight[0] + weight[1]) + (weight[2] + weight[3])) + ((weight[4] + weight[5]) + (weight[6] + weight[7]));
    const float scale = 1.0f / sum;
#pragma omp simd
    for (int i = 0; i < 8; ++i) weight[i] *= scale;
}

/* A point in cell coordinates, relative to the first cell's center. */
TY_FN ty_vec ty_packed_coordinates(const ty_packed_lattice* lattice, ty_vec point) {
    const ty_vec p = ty_scale(ty_sub(point, lattice->lower), lattice->per_metre);
    return ty_vec_make(p.x - 0.5f, p.y - 0.5f, p.z - 0.5f);
}

/* The eight cells from `base` on, and their weights at the interpolation fractions x, y and z. */
TY_FN void ty_packed_cells_around(const ty_packed_lattice* lattice, int32_t base, float x, float y, float z,
                                  ty_packed_cells* cells) {
    const int32_t *size = lattice->size, nx = size[0], nxy = size[0] * size[1];
    const int32_t dx = nx > 1 ? 1 : 0, dy = size[1] > 1 ? nx : 0, dz = size[2] > 1 ? nxy : 0;
    /* 1 - x or x, as side + sign * x. */
    static const float side[8] = {1, 0, 1, 0, 1, 0, 1, 0}, sign[8] = {-1, 1, -1, 1, -1, 1, -1, 1};
    static const float side_y[8] = {1, 1, 0, 0, 1, 1, 0, 0}, sign_y[8] = {-1, -1, 1, 1, -1, -1, 1, 1};
    static const float side_z[8] = {1, 1, 1, 1, 0, 0, 0, 0}, sign_z[8] = {-1, -1, -1, -1, 1, 1, 1, 1};
    const size_t floats = (size_t)lattice->floats;
    TY_GLOBAL const float* first = lattice->light + (size_t)base * floats;
    TY_GLOBAL const float* behind = first + (size_t)dz * floats;
    const size_t along = (size_t)dx * floats, down = (size_t)dy * floats;
    cells->light[0] = first;
    cells->light[1] = first + along;
    cells->light[2] = first + down;
    cells->light[3] = first + down + along;
    cells->light[4] = behind;
    cells->light[5] = behind + along;
    cells->light[6] = behind + down;
    cells->light[7] = behind + down + along;
#pragma omp simd
    for (int i = 0; i < 8; ++i)
        cells->weight[i] = (side[i] + sign[i] * x) * (side_y[i] + sign_y[i] * y) * (side_z[i] + sign_z[i] * z);
    if (lattice->blocked == NULL) return;
    const int32_t own[3] = {x >= 0.5f ? 1 : 0, y >= 0.5f ? 1 : 0, z >= 0.5f ? 1 : 0};
    const size_t self = (size_t)(base + own[0] * dx + own[1] * dy + own[2] * dz);
    if (lattice->blocked[self] != 0)
        ty_packed_mask_blocked(lattice->links + self * TY_PACKED_LINKS, own, cells->weight);
}

/* The cells around a point, which is clamped to the lattice. */
TY_FN void ty_packed_locate(const ty_packed_lattice* lattice, ty_vec place, ty_packed_cells* cells) {
    float x, y, z;
    const int32_t* size = lattice->size;
    const int32_t base =
        ty_packed_axis(place.x, size[0], &x) +
        size[0] * (ty_packed_axis(place.y, size[1], &y) + size[1] * ty_packed_axis(place.z, size[2], &z));
    ty_packed_cells_around(lattice, base, x, y, z, cells);
}

/* Weighted mean of the cells' floats from `first` on. */
TY_FN void ty_packed_mean(const ty_packed_cells* cells, int32_t first, float mean[TY_PACKED_FLOATS]) {
    TY_GLOBAL const float* c[8];
    const float* w = cells->weight;
    for (int i = 0; i < 8; ++i) c[i] = cells->light[i] + first;
#pragma omp simd
    for (int j = 0; j < TY_PACKED_FLOATS; ++j)
        mean[j] = ((w[0] * c[0][j] + w[1] * c[1][j]) + (w[2] * c[2][j] + w[3] * c[3][j])) +
                  ((w[4] * c[4][j] + w[5] * c[5][j]) + (w[6] * c[6][j] + w[7] * c[7][j]));
}

/* Depth of a point in a lattice: 0 on its faces, 1 from two cells inside on; negative outside. */
TY_FN float ty_packed_depth(const ty_packed_lattice* lattice, ty_vec p) {
    const float x = ty_minf(p.x - lattice->lower.x, lattice->upper.x - p.x);
    const float y = ty_minf(p.y - lattice->lower.y, lattice->upper.y - p.y);
    const float z = ty_minf(p.z - lattice->lower.z, lattice->upper.z - p.z);
    return ty_minf(ty_minf(x, ty_minf(y, z)) * 0.5f * lattice->per_metre, 1.0f);
}

/* The finest cascade at a point (including half a cell around it), -1 for none, and the weight of the next coarser one,
 * which is 1 at the border of the finer. */
TY_FN int32_t ty_packed_choose_cascade(const ty_packed_lattices* lattices, ty_vec point, float* coarser) {
    *coarser = 0.0f;
    for (int32_t i = 0; i < lattices->count; ++i) {
        const float depth = ty_packed_depth(&lattices->lattices[i], point);
        if (!(depth > -0.25f)) continue;
        if (i + 1 < lattices->count) *coarser = 1.0f - ty_maxf(depth, 0.0f);
        return i;
    }
    return -1;
}

/* Irradiance, W m^-2: radiance terms L_i times the bands of the clamped cosine. y: harmonics of the direction against
 * the normal. */
TY_FN float ty_packed_clamped_cosine(const float band01[4], const float* band2, const float y[TY_SH_TERMS]) {
    float sum = ty_sh_cosine(0) * band01[0] * y[0];
    for (int i = 1; i < 4; ++i) sum += ty_sh_cosine(1) * band01[i] * y[i];
    for (int i = 0; i < 5 && band2 != NULL; ++i) sum += ty_sh_cosine(2) * band2[i] * y[4 + i];
    return ty_maxf(sum, 0.0f);
}

/* Irradiance of a surface on the side of its unit normal; 0 outside all lattices. */
TY_FN void ty_packed_irradiance(const ty_packed_lattices* lattices, ty_vec point, ty_vec normal, float irradiance[3]) {
    float y[TY_SH_TERMS], coarser;
    for (int c = 0; c < 3; ++c) irradiance[c] = 0.0f;
    const int32_t finest = ty_packed_choose_cascade(lattices, point, &coarser);
    if (finest < 0) return;
    ty_sh_at(ty_scale(normal, -1.0f), lattices->lattices[0].floats > TY_PACKED_FLOATS ? TY_SH_BANDS : 2, y);
    for (int32_t i = finest; i < finest + (coarser > 0.0f ? 2 : 1); ++i) {
        const ty_packed_lattice* lattice = &lattices->lattices[i];
        const float fraction = i == finest ? 1.0f - coarser : coarser;
        float mean[TY_PACKED_FLOATS_MAX];
        ty_packed_cells cells;
        const ty_vec lifted = ty_lattice_lift(point, normal, lattice->cell);
        const ty_vec place = ty_scale(ty_sub(lifted, lattice->lower), lattice->per_metre);
        const ty_vec off =
            ty_mad(lifted,
                   ty_surface_depths_leave(lattice->surface_depth_index, lattice->surface_depths, lattice->size, place),
                   lattice->cell);
        if (!(ty_packed_depth(lattice, off) >= -0.25f)) continue;
        ty_packed_locate(lattice, ty_packed_coordinates(lattice, off), &cells);
        ty_packed_mean(&cells, 0, mean);
        const bool third = lattice->floats > TY_PACKED_FLOATS;
        if (third) ty_packed_mean(&cells, TY_PACKED_FLOATS, mean + TY_PACKED_FLOATS);
        for (int c = 0; c < 3; ++c)
            irradiance[c] +=
                fraction * ty_packed_clamped_cosine(mean + 4 * c, third ? mean + TY_PACKED_FLOATS + 5 * c : NULL, y);
    }
}

#endif
