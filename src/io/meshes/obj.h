/* What the parts of the OBJ reader share. */
#ifndef TY_IO_OBJ_H
#define TY_IO_OBJ_H

#include "io/meshes/model.h"
#include "io/meshes/model_text.h"

/* A corner of a triangle: a position, and texture coordinates and a normal or -1. */
typedef struct ty_obj_corner {
    int32_t position, uv, normal;
} ty_obj_corner;

typedef struct ty_obj_triangle {
    ty_obj_corner corners[3];
    int32_t material;
} ty_obj_triangle;

/* What an OBJ file holds, as listed there. */
typedef struct ty_obj {
    ty_context* context;
    const char* path;
    const char* folder;
    unsigned want;
    ty_model* model;
    size_t line; /* being read, from 1 */
    float (*positions)[3];
    float (*colors)[3]; /* one for each position */
    float (*uv)[2];
    float (*normals)[3];
    ty_obj_triangle* triangles;
    size_t position_count, color_count, uv_count, normal_count, triangle_count;
    size_t position_capacity, color_capacity, uv_capacity, normal_capacity, triangle_capacity;
    bool colored;     /* whether any position has a colour */
    int32_t material; /* in use */
    size_t skipped;   /* lines, points, curves, faces without area */
    size_t unknown;   /* uses of materials that are nowhere */
} ty_obj;

/* obj_material.c: adds the materials of an .mtl file's text, which ends with a zero that size does not count. */
ty_result ty_read_mtl(ty_context* context, const char* path, const char* folder, const char* text, size_t size,
                      ty_model* model);
/* obj_mesh.c: makes meshes of the triangles, one for each material. */
ty_result ty_obj_build_meshes(ty_obj* obj);

#endif
