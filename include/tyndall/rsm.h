/// @file rsm.h
/// Shadow maps and reflective shadow maps of one light. Apache-2.0.
#ifndef TYNDALL_RSM_H
#define TYNDALL_RSM_H

#include <tyndall/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The first surfaces that one light meets, as engines store them: a shadow map, or with normals and albedo a
/// reflective shadow map. All arrays belong to the caller, and must outlive the objects that are made with the map.
///
/// The arrays have faces x side x side texels, row by row. Texel (x, y) covers [x, x + 1] x [y, y + 1] of the side and
/// is sampled at its centre. With s and t from -1 to 1 over the map, rows going up from t = -1: a directional light has
/// one face, and rays along `forward` begin at origin + s right + t up. A spot light has one face around its cone, or
/// six as point lights have, any that cover all directions once; rays begin at the light and go along forward + s right
/// + t up of their face.
typedef struct ty_rsm {
    int32_t side;         ///< Texels along a side, 1..8192.
    int32_t faces;        ///< Directional lights: 1; point lights: 6; spot lights: either.
    double origin[3];     ///< Directional lights: as above, m, in front of all surfaces. Not read for others.
    double forward[6][3]; ///< Per face, unit; directional lights: the direction in which light travels.
    double right[6][3];  ///< Per face, at right angles to `forward`; length: half of the map's side, m, for directional
                         ///< lights, else the tangent of half the field of view.
    double up[6][3];     ///< Per face, at right angles to both; length as for `right`.
    const float* depth;  ///< Distance to the first surface along `forward`, m; INFINITY without a surface.
    const float* normal; ///< 3 per texel, unit, on the lit side; NULL: a shadow map, from which no light is reflected.
    const float* albedo; ///< 3 per texel, 0..1; given with `normal`.
} ty_rsm;

#ifdef __cplusplus
}
#endif
#endif
