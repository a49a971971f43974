/* A cube of equal cells for the diffusion solver. */
#ifndef TY_BENCH_FLD_BOX_H
#define TY_BENCH_FLD_BOX_H

#include "solve/diffusion/diffusion.h"

typedef struct fld_box {
    int32_t edge;                                      /* cells along it */
    size_t cells;                                      /* total number of cells */
    float *extinction, *absorption, *source, *fluence; /* 1/m, 1/m, W m^-3, W m^-2; x fastest */
    ty_diffusion_def def;                              /* problem over the arrays, with zero fluence on the faces */
} fld_box;

/* extent: of an edge, m; all values are 0. Errors: TY_ERROR_MEMORY. */
ty_result fld_make_box(ty_context* context, int32_t edge, double extent, fld_box* out);
void fld_free_box(ty_context* context, fld_box* box);

static inline size_t fld_box_at(const fld_box* box, int32_t x, int32_t y, int32_t z) {
    return ((size_t)z * (size_t)box->edge + (size_t)y) * (size_t)box->edge + (size_t)x;
}

#endif
