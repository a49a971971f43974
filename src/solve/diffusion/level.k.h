/* Equation of one cell of a multigrid level. */
#ifndef TY_SOLVE_DIFFUSION_LEVEL_K_H
#define TY_SOLVE_DIFFUSION_LEVEL_K_H

#include "base/kernel.h"

/* Lower bound of the diagonal, for cells with neither exchange nor sink. */
#define TY_LEVEL_MIN_DIFFUSIVITY 1e-30f

/* Couplings to the lower and upper neighbours along each axis. */
typedef struct ty_level_faces {
    float x0, x1, y0, y1, z0, z1;
} ty_level_faces;

/* Item i of a row, from couplings stored per lower face. */
TY_FN ty_level_faces ty_level_faces_stored(TY_GLOBAL const float* gx, TY_GLOBAL const float* gy,
                                           TY_GLOBAL const float* gz, ptrdiff_t row, ptrdiff_t plane, ptrdiff_t i) {
    const ty_level_faces faces = {gx[i], gx[i + 1], gy[i], gy[i + row], gz[i], gz[i + plane]};
    return faces;
}

/* The same from D, whose ghosts are -D of the cell beside them, which makes couplings at the box's faces 0. */
TY_FN ty_level_faces ty_level_faces_made(TY_GLOBAL const float* d, float kx, float ky, float kz, ptrdiff_t row,
                                         ptrdiff_t plane, ptrdiff_t i) {
    const float here = d[i];
    const ty_level_faces faces = {kx * (here + d[i - 1]),   kx * (here + d[i + 1]),     ky * (here + d[i - row]),
                                  ky * (here + d[i + row]), kz * (here + d[i - plane]), kz * (here + d[i + plane])};
    return faces;
}

/* Diagonal entry: sink plus couplings. */
TY_FN float ty_level_diagonal(ty_level_faces c, float sink) {
    return ty_maxf(sink + (c.x0 + c.x1) + (c.y0 + c.y1) + (c.z0 + c.z1), TY_LEVEL_MIN_DIFFUSIVITY);
}

/* sink e + sum g (e - e_s). */
TY_FN float ty_level_apply(ty_level_faces c, float sink, TY_GLOBAL const float* e, ptrdiff_t row, ptrdiff_t plane,
                           ptrdiff_t i) {
    const float here = e[i];
    return sink * here + c.x0 * (here - e[i - 1]) + c.x1 * (here - e[i + 1]) + c.y0 * (here - e[i - row]) +
           c.y1 * (here - e[i + row]) + c.z0 * (here - e[i - plane]) + c.z1 * (here - e[i + plane]);
}

/* Gauss-Seidel value of e. */
TY_FN float ty_level_relax(ty_level_faces c, float sink, float f, TY_GLOBAL const float* e, ptrdiff_t row,
                           ptrdiff_t plane, ptrdiff_t i) {
    const float sum = f + c.x0 * e[i - 1] + c.x1 * e[i + 1] + c.y0 * e[i - row] + c.y1 * e[i + row] +
                      c.z0 * e[i - plane] + c.z1 * e[i + plane];
    return sum / ty_level_diagonal(c, sink);
}

#endif
