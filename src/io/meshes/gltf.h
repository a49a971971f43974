/* Internal interface of the glTF reader's files. */
#ifndef TY_IO_GLTF_H
#define TY_IO_GLTF_H

#include "io/json_locate.h"
#include "io/meshes/model.h"

#include <jansson.h>

/* Bytes of a buffer; data is NULL until it is loaded. */
typedef struct ty_gltf_buffer {
    const uint8_t* data;
    size_t size;
    uint8_t* owned; /* data, unless it is part of the GLB */
    size_t owned_size;
} ty_gltf_buffer;

/* Range of a glTF mesh's primitives among the model's meshes. */
typedef struct ty_gltf_mesh {
    bool read;
    size_t first, count;
} ty_gltf_mesh;

typedef struct ty_gltf {
    ty_context* context;
    const char* path;   /* for messages */
    const char* folder; /* of referenced files; NULL: references to files are refused */
    unsigned want;
    ty_model* model;
    json_t* root;
    const uint8_t* chunk; /* binary chunk of a GLB, or NULL */
    size_t chunk_size;
    /* One element per element of the array in the file. */
    ty_gltf_buffer* buffers;
    ty_gltf_mesh* meshes;
    int32_t *images, *textures; /* index in the model plus one; 0: not loaded */
    bool* visited;              /* per node */
    int64_t triangles;          /* over all instances so far */
    size_t skipped;             /* primitives that are not triangles */
    bool morphs;                /* true if a primitive has morph targets */
} ty_gltf;

/* ---- gltf.c: the container ---- */

/* Finds the JSON and the binary chunk, which are referenced in place in `bytes`. */
ty_result ty_gltf_open(ty_gltf* gltf, const uint8_t* bytes, size_t size);
/* Validates the top-level structure and creates the tables above. */
ty_result ty_gltf_create_tables(ty_gltf* gltf);
void ty_gltf_close(ty_gltf* gltf);

/* ---- gltf_json.c: validated values ---- */

/* Fails with a message such as "level.gltf: accessors[3].count: ...". */
ty_result ty_gltf_fail(const ty_gltf* gltf, const ty_json_path* json_path, const char* format, ...)
    __attribute__((format(printf, 3, 4)));
/* JSON path of an element of a top-level array, and of one of its members. */
ty_json_path ty_gltf_json_path(const char* array, size_t index);
/* Fails unless the top-level arrays are arrays of objects. */
ty_result ty_gltf_check_shape(const ty_gltf* gltf);
size_t ty_gltf_count(const ty_gltf* gltf, const char* array);
const json_t* ty_gltf_item(const ty_gltf* gltf, const char* array, size_t index);
const json_t* ty_gltf_extension(const json_t* object, const char* name);

/* Each reader leaves *out unchanged if the key is missing, and fails if its value is invalid. */
ty_result ty_gltf_read_integer(const ty_gltf* gltf, const json_t* object, const ty_json_path* json_path,
                               const char* key, int64_t low, int64_t high, int64_t* out);
ty_result ty_gltf_read_number(const ty_gltf* gltf, const json_t* object, const ty_json_path* json_path, const char* key,
                              double low, double high, double* out);
ty_result ty_gltf_read_numbers(const ty_gltf* gltf, const json_t* object, const ty_json_path* json_path,
                               const char* key, size_t count, double low, double high, double* out);
/* Index of an element of a top-level array; *out is -1 if the key is missing. */
ty_result ty_gltf_read_reference(const ty_gltf* gltf, const json_t* object, const ty_json_path* json_path,
                                 const char* key, const char* array, int64_t* out);

/* ---- gltf_buffer.c: bytes ---- */

/* Decodes "a%20b" to "a b" in place; false for an invalid escape or a zero byte. */
bool ty_gltf_decode_percent(char* text);
/* Loads the bytes of a data URI (base64) or of a file; freed with ty_free_file. */
ty_result ty_gltf_load_uri(const ty_gltf* gltf, const ty_json_path* json_path, const char* uri, uint8_t** bytes,
                           size_t* size);
ty_result ty_gltf_open_buffer(ty_gltf* gltf, size_t index, const ty_gltf_buffer** out);
/* Bytes of a buffer view, and its stride (0: packed). */
ty_result ty_gltf_open_view(ty_gltf* gltf, size_t index, const uint8_t** data, size_t* size, size_t* stride);
void ty_gltf_free_buffers(ty_gltf* gltf);

/* ---- gltf_accessor.c: arrays ---- */

/* Component types by their glTF numbers. */
enum {
    TY_GLTF_I8 = 5120,
    TY_GLTF_U8 = 5121,
    TY_GLTF_I16 = 5122,
    TY_GLTF_U16 = 5123,
    TY_GLTF_U32 = 5125,
    TY_GLTF_F32 = 5126
};

/* An accessor with a validated byte range. */
typedef struct ty_gltf_accessor {
    ty_json_path json_path;
    size_t count;
    size_t components; /* 1..4 */
    int32_t type;      /* of components */
    bool normalized;
    const uint8_t* data; /* NULL: all zero */
    size_t stride;
    size_t sparse_count;
    int32_t sparse_type;
    const uint8_t *sparse_indices, *sparse_values;
} ty_gltf_accessor;

ty_result ty_gltf_open_accessor(ty_gltf* gltf, size_t index, ty_gltf_accessor* accessor);
/* Reads elements [first, first + count) as floats, `width` per element of out; components that the accessor lacks
 * are left unchanged. */
void ty_gltf_read_floats(const ty_gltf_accessor* accessor, size_t first, size_t count, size_t width, float* out);
/* Reads all elements of a scalar accessor of unsigned integers. */
void ty_gltf_read_indices(const ty_gltf_accessor* accessor, uint32_t* out);

/* ---- parts of the model ---- */

/* gltf_mesh.c: reads the primitives of a mesh, once. */
ty_result ty_gltf_read_mesh(ty_gltf* gltf, size_t index);
/* gltf_material.c: reads all materials, and adds a default one for primitives without. */
ty_result ty_gltf_read_materials(ty_gltf* gltf);
/* gltf_scene.c: reads the scene's nodes with meshes, lights and cameras. */
ty_result ty_gltf_read_scene(ty_gltf* gltf);

#endif
