/* Tyndall: reflective shadow maps (RSM). Apache-2.0.
 *
 * A lightmap, light stored on surfaces, is a different thing: see tyndall/bake.h. */
#ifndef TYNDALL_RSM_H
#define TYNDALL_RSM_H

#include <tyndall/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The first surface that each ray of a light hits, as graphics engines store it: a shadow map, and with normals and
 * albedo a reflective shadow map (Dachsbacher and Stamminger 2005). The caller owns the arrays. They hold faces x side
 * x side texels, row by row; texel (x, y) covers [x, x + 1] x [y, y + 1] of the face, and is sampled at its center.
 * Directional light: one face with parallel rays along `forward` that start at `origin + right * s + up * t` (s and t
 * from -1 to 1 over the face, rows start at t = -1). Spot light: one face around the cone, or six faces as for point
 * lights (any six that cover the sphere once); rays start at the light and go along `forward + right * s + up * t`. */
typedef struct ty_rsm {
    int32_t side;                 /* texels, 1..8192 */
    int32_t faces;                /* directional: 1; point: 6; spot: either */
    double origin[3];             /* directional lights: see above, m, in front of all surfaces; ignored for others */
    double forward[6][3];         /* per face, unit; directional lights: the direction of propagation */
    double right[6][3], up[6][3]; /* per face, orthogonal to one another and to forward; length: half the side of the
                                     map, m, for directional lights, the tangent of half the field of view for others */
    const float* depth;           /* distance along forward to the first surface, m; INFINITY: no surface */
    const float* normal; /* 3 a texel, unit, on the lit side; NULL: a shadow map, whose surfaces reflect nothing */
    const float* albedo; /* 3 a texel, 0..1; present exactly if normals are */
} ty_rsm;

#ifdef __cplusplus
}
#endif
#endif
