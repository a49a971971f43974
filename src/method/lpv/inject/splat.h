/* Splatting of light into cells, summed in an order that does not depend on the number of threads. */
#ifndef TY_METHOD_LPV_INJECT_SPLAT_H
#define TY_METHOD_LPV_INJECT_SPLAT_H

#include "method/lpv/lattice/lattice.h"

/* A lobe of light in a cell. */
typedef struct ty_splat {
    int32_t cell;
    int32_t slab;   /* set by ty_splats_add */
    float power[3]; /* W */
    ty_vec axis;    /* unit */
} ty_splat;

/* Rows of at most `most` splats each. */
typedef struct ty_splat_rows {
    int64_t rows;
    int32_t max_splats;
    const void* user;
    int32_t (*row)(const void* user, int64_t row,
                   ty_splat* out); /* called from any thread; returns the number of splats */
    float band[TY_LPV_BANDS_MAX];  /* coefficients of the lobes about the axes; the first is 1 */
    bool anisotropic;              /* whether band l is also multiplied by g^l of the lattice's medium */
} ty_splat_rows;

/* Adds the splats to propagated_sh and their power, W per channel, to `power`. Errors: TY_ERROR_MEMORY. */
ty_result ty_splats_add(ty_lattice* lattice, const ty_splat_rows* rows, double power[3]);

/* The cell lookup of a lattice. */
typedef struct ty_splat_cells {
    float lower[3], per_cell; /* m, 1/m */
    int32_t size[3];
} ty_splat_cells;

static inline ty_splat_cells ty_splat_cells_of(const ty_lattice* lattice) {
    ty_splat_cells out = {.per_cell = 1.0f / lattice->cell};
    for (int a = 0; a < 3; ++a) {
        out.lower[a] = (float)lattice->box.lower[a];
        out.size[a] = lattice->box.size[a];
    }
    return out;
}

/* The cell that contains a point; -1 outside the lattice. */
static inline int32_t ty_splat_cell(const ty_splat_cells* cells, ty_vec point) {
    const float x = (point.x - cells->lower[0]) * cells->per_cell, y = (point.y - cells->lower[1]) * cells->per_cell;
    const float z = (point.z - cells->lower[2]) * cells->per_cell;
    const bool inside = x >= 0.0f && y >= 0.0f && z >= 0.0f && x < (float)cells->size[0] && y < (float)cells->size[1] &&
                        z < (float)cells->size[2];
    return inside ? (int32_t)x + cells->size[0] * ((int32_t)y + cells->size[1] * (int32_t)z) : -1;
}

/* Distance from a surface (unit normal) beyond which the center of a point's cell is on the same side, m. */
static inline float ty_splat_clearance(const ty_lattice* lattice, ty_vec normal) {
    return 0.5f * lattice->cell * (fabsf(normal.x) + fabsf(normal.y) + fabsf(normal.z));
}

#endif
