/* Internal interface of the PLY reader's files. */
#ifndef TY_IO_PLY_H
#define TY_IO_PLY_H

#include "io/meshes/model.h"
#include "io/meshes/model_text.h"

typedef enum ty_ply_format { TY_PLY_ASCII, TY_PLY_LITTLE, TY_PLY_BIG } ty_ply_format;

typedef enum ty_ply_type {
    TY_PLY_I8,
    TY_PLY_U8,
    TY_PLY_I16,
    TY_PLY_U16,
    TY_PLY_I32,
    TY_PLY_U32,
    TY_PLY_F32,
    TY_PLY_F64,
    TY_PLY_TYPES
} ty_ply_type;

/* Vertex properties that are read: their indices in a row of numbers. */
enum {
    TY_PLY_X,
    TY_PLY_NORMAL = 3,
    TY_PLY_UV = 6,
    TY_PLY_COLOR = 8,
    TY_PLY_ALPHA = 11,
    TY_PLY_ROW = 12,
    TY_PLY_CORNERS, /* vertex index list of a face */
    TY_PLY_NOTHING
};

typedef struct ty_ply_property {
    ty_ply_type type;
    bool list;
    ty_ply_type count_type; /* of lists */
    int32_t role;
} ty_ply_property;

typedef enum ty_ply_kind { TY_PLY_VERTEX, TY_PLY_FACE, TY_PLY_OTHER } ty_ply_kind;

typedef struct ty_ply_element {
    ty_ply_kind kind;
    size_t count;
    size_t first, property_count; /* of the properties */
} ty_ply_element;

typedef struct ty_ply {
    ty_context* context;
    const char* path;
    ty_ply_format format;
    ty_ply_element* elements;
    ty_ply_property* properties;
    size_t element_count, element_capacity, property_count, property_capacity;
    ty_words data; /* bytes after the header */
} ty_ply;

/* ply_header.c; ply->data is the whole file before the call, and the bytes after the header afterwards. */
ty_result ty_ply_read_header(ty_ply* ply);
size_t ty_ply_type_size(ty_ply_type type);

#endif
