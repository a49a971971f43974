/* Shapes as ray tracing takes them: quads and spheres in single precision. */
#ifndef TY_SCENE_SURFACES_TRACED_SHAPES_H
#define TY_SCENE_SURFACES_TRACED_SHAPES_H

#include "scene/surfaces/hit.k.h"

#include <tyndall/scene.h>

/* Quads of all quad and box shapes, and the number of spheres. */
size_t ty_traced_quad_count(const ty_shape_def* shapes, size_t count);
size_t ty_traced_sphere_count(const ty_shape_def* shapes, size_t count);
/* Faces of those quads, and their corners: 12 floats each, counter-clockwise seen from the front. */
void ty_traced_quads(const ty_shape_def* shapes, size_t count, ty_quad_face* faces, float* corners);
/* Faces of those spheres, and their centres and radii: 4 floats each. */
void ty_traced_spheres(const ty_shape_def* shapes, size_t count, ty_sphere_face* faces, float* points);

#endif
