/* Decomposition of shapes into quads and spheres for ray tracing and light sampling. */
#ifndef TY_SCENE_SURFACES_SHAPE_H
#define TY_SCENE_SURFACES_SHAPE_H

#include "scene/surfaces/surface.k.h"

#include <tyndall/scene.h>

/* Number of quads of a shape: 1 for a quad, 6 for a box, 0 for a sphere. */
int32_t ty_shape_quad_count(const ty_shape_def* shape);
/* Quad i in world space: corner and edges, front on the u x v side. */
void ty_shape_quad(const ty_shape_def* shape, int32_t i, double origin[3], double u[3], double v[3]);
/* Unit normal on the u x v side. */
ty_vec ty_shape_normal(const double u[3], const double v[3]);
/* Center of a sphere in world space; returns its radius. */
double ty_shape_sphere(const ty_shape_def* shape, double center[3]);
/* Extends a box, m, to contain a shape. */
void ty_shape_extent(const ty_shape_def* shape, double lower[3], double upper[3]);

/* Fails unless ty_scene_add_shape accepts the shape. */
ty_result ty_shape_check(ty_context* context, const ty_shape_def** given, ty_shape_def* own);
bool ty_shape_emits(const ty_shape_def* shape);

/* Texture of a shape, by ty_gloss_texture; TY_GLOSS_TEXTURES: that of its albedo. */
const ty_texture_use* ty_shape_texture(const ty_shape_def* shape, int32_t i);
bool ty_shape_is_textured(const ty_shape_def* shape);
/* Texture coordinates of the faces of a shape, by ty_shape_quad; spheres have one face (shape_faces.c). */
enum { TY_SHAPE_FACES = 6 };
void ty_shape_get_faces(const ty_shape_def* shape, ty_axis up, ty_shape_face faces[TY_SHAPE_FACES]);

#endif
