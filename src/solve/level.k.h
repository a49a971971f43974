/* One cell of a level of multigrid. */
#ifndef TY_SOLVE_LEVEL_K_H
#define TY_SOLVE_LEVEL_K_H

#include "base/kernel.h"

/* Where nothing leaves a cell and nothing takes light away in it. */
#define TY_LEVEL_LEAST 1e-30f

/* (d + sum g) e - sum g e_s at item i of a row; gx, gy, gz: of faces below, rows of items apart. */
TY_FN float ty_level_apply(TY_GLOBAL const float* gx, TY_GLOBAL const float* gy, TY_GLOBAL const float* gz,
                           TY_GLOBAL const float* d, TY_GLOBAL const float* e, ptrdiff_t row, ptrdiff_t plane,
                           ptrdiff_t i) {
    const float here = e[i];
    return d[i] * here + gx[i] * (here - e[i - 1]) + gx[i + 1] * (here - e[i + 1]) + gy[i] * (here - e[i - row]) +
           gy[i + row] * (here - e[i + row]) + gz[i] * (here - e[i - plane]) + gz[i + plane] * (here - e[i + plane]);
}

/* e that satisfies the cell's equation. */
TY_FN float ty_level_relax(TY_GLOBAL const float* gx, TY_GLOBAL const float* gy, TY_GLOBAL const float* gz,
                           TY_GLOBAL const float* d, TY_GLOBAL const float* f, TY_GLOBAL const float* e, ptrdiff_t row,
                           ptrdiff_t plane, ptrdiff_t i) {
    const float x0 = gx[i], x1 = gx[i + 1], y0 = gy[i], y1 = gy[i + row], z0 = gz[i], z1 = gz[i + plane];
    const float sum = f[i] + x0 * e[i - 1] + x1 * e[i + 1] + y0 * e[i - row] + y1 * e[i + row] + z0 * e[i - plane] +
                      z1 * e[i + plane];
    return sum / ty_maxf(d[i] + (x0 + x1) + (y0 + y1) + (z0 + z1), TY_LEVEL_LEAST);
}

#endif
