/* Tyndall: shadow maps and reflective shadow maps. Apache-2.0. */
#ifndef TYNDALL_RSM_H
#define TYNDALL_RSM_H

#include <tyndall/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What one light meets first of the surfaces, as engines have it: a shadow map, and with normals and flux a reflective
 * one. Arrays are the caller's. faces x side x side texels, row by row; texel (x, y) covers [x, x + 1] x [y, y + 1] of
 * side; its middle counts. Directional: one face; a point at `origin + right * s + up * t` (s, t from -1 to 1 over the
 * map, rows from t = -1 up) is where a ray along `forward` begins. Spot: one face around the cone, or six as points
 * have (any six that cover all directions once); rays begin at the light and go along `forward + right * s + up * t` of
 * their face. */
typedef struct ty_rsm {
    int32_t side;                 /* texels, 1..8192 */
    int32_t faces;                /* directional: 1; point: 6; spot: either */
    double origin[3];             /* directional: see above, m; before all surfaces. Else not looked at */
    double forward[6][3];         /* per face, unit; directional: the way light travels */
    double right[6][3], up[6][3]; /* per face; directional: half of the map's sides, m; else times the tangent
                                     of half of the field of view. At right angles to one another and to
                                     forward */
    const float* depth;           /* along forward, m, to the first surface; INFINITY: none */
    const float* normal;          /* 3 a texel, unit, on the lit side; NULL: shadows only, nothing reflects */
    const float* albedo;          /* 3 a texel, 0..1; with normals */
} ty_rsm;

#ifdef __cplusplus
}
#endif
#endif
