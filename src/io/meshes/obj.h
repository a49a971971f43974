/* Internal interface of the OBJ reader's files. */
#ifndef TY_IO_OBJ_H
#define TY_IO_OBJ_H

#include "io/meshes/model.h"
#include "io/meshes/model_text.h"

/* Corner of a triangle: indices of a position, and of texture coordinates and a normal (-1: none). */
typedef struct ty_obj_corner {
    int32_t position, uv, normal;
} ty_obj_corner;

typedef struct ty_obj_triangle {
    ty_obj_corner corners[3];
    int32_t material;
} ty_obj_triangle;

/* Content of an OBJ file in file order. */
typedef struct ty_obj {
    ty_context* context;
    const char* path;
    const char* folder;
    unsigned want;
    ty_model* model;
    size_t line; /* current line, from 1 */
    float (*positions)[3];
    float (*colors)[3]; /* one per position */
    float (*uv)[2];
    float (*normals)[3];
    ty_obj_triangle* triangles;
    size_t position_count, color_count, uv_count, normal_count, triangle_count;
    size_t position_capacity, color_capacity, uv_capacity, normal_capacity, triangle_capacity;
    bool colored;     /* true if any position has a color */
    int32_t material; /* current material */
    size_t skipped;   /* lines, points, curves, degenerate faces */
    size_t unknown;   /* uses of undefined materials */
    size_t dangling;  /* corners with references to normals or texture vertices that are not in the file */
    size_t position_reach, position_reach_line; /* highest position in use plus one, and the line that names it */
} ty_obj;

/* obj_material.c: adds the materials of an .mtl text, which is followed by a zero byte not counted in size. */
ty_result ty_read_mtl(ty_context* context, const char* path, const char* folder, const char* text, size_t size,
                      ty_model* model);
/* obj_maps.c: puts decoded maps of one number into the channels in which glTF has them: opacity into the alpha of the
 * base colour, roughness into green and metallic into blue of one texture. Maps of bumps are taken for normals. */
ty_result ty_obj_join_maps(ty_model* model, const char* path);
/* obj_mesh.c: builds one mesh per material from the triangles. */
ty_result ty_obj_build_meshes(ty_obj* obj);

#endif
