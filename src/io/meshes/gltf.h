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

/* Range of a glTF mesh's primitives among the model's meshes, in the pose without skin and morph weights. */
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
    ty_gltf_buffer* views; /* unpacked content of compressed buffer views */
    ty_gltf_mesh* meshes;
    int32_t *images, *textures; /* index in the model plus one; 0: not loaded; textures: as colours, then as numbers */
    bool* visited;              /* per node */
    int32_t* parents;           /* per node; -1: a root */
    int64_t triangles;          /* over all instances so far */
    size_t skipped;             /* primitives that are not triangles */
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

/* The number of a node, -1 for any other value. */
int64_t ty_gltf_node_number(const ty_gltf* gltf, const json_t* value);

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

#define TY_GLTF_FILE_MAX ((size_t)1 << 36)

/* Decodes "a%20b" to "a b" in place; false for an invalid escape or a zero byte. */
bool ty_gltf_decode_percent(char* text);
/* Loads the bytes of a data URI (base64), or of a file of at most `limit` bytes and (unless inspect is NULL) of a known
 * form; freed with ty_free_file. */
ty_result ty_gltf_load_uri(const ty_gltf* gltf, const ty_json_path* json_path, const char* uri, size_t limit,
                           ty_file_form_fn inspect, uint8_t** bytes, size_t* size);
ty_result ty_gltf_open_buffer(ty_gltf* gltf, size_t index, const ty_gltf_buffer** out);
/* Bytes of a buffer view, and its stride (0: packed). */
ty_result ty_gltf_open_view(ty_gltf* gltf, size_t index, const uint8_t** data, size_t* size, size_t* stride);
void ty_gltf_free_buffers(ty_gltf* gltf);

/* ---- gltf_meshopt.c: compressed buffer views ---- */

/* Extension of a buffer view that is compressed, or NULL. */
const json_t* ty_gltf_packed_view(const json_t* view);
/* Bytes of a compressed buffer view, decoded on first use. */
ty_result ty_gltf_unpack_view(ty_gltf* gltf, size_t index, const uint8_t** data, size_t* size);

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
    size_t components; /* 1..4, or 16 in columns of four */
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

/* ---- primitives ---- */

/* Content of a Draco mesh: arrays of floats and indices. */
typedef struct ty_gltf_unpacked {
    float* arrays[16];
    size_t widths[16]; /* floats per vertex */
    size_t count, vertices;
} ty_gltf_unpacked;

/* A primitive's accessors and indices. */
typedef struct ty_gltf_primitive {
    const json_t* json;
    ty_json_path json_path;
    int64_t mode;
    ty_gltf_accessor positions, normals, uv[2], colors, tangents;
    bool has_normals, has_uv[2], has_colors, has_tangents;
    uint32_t* corners; /* vertex index per corner; NULL: all vertices in order */
    size_t corner_count;
    size_t first, last;     /* range of vertices in use */
    size_t number;          /* index in the mesh */
    struct ty_draco* draco; /* compressed content, or NULL */
    ty_gltf_unpacked unpacked;
} ty_gltf_primitive;

/* Opens an attribute if present; it must have low to high components, and as many elements as positions. */
ty_result ty_gltf_open_attribute(ty_gltf* gltf, ty_gltf_primitive* p, const char* name, size_t low, size_t high,
                                 ty_gltf_accessor* accessor, bool* found);

/* gltf_draco.c: decodes a primitive that is there in compressed form only, with its corners. */
ty_result ty_gltf_open_draco(ty_gltf* gltf, ty_gltf_primitive* p);
/* Makes an opened accessor refer to the decoded attribute of that name, if there is one. */
ty_result ty_gltf_unpack_attribute(ty_gltf* gltf, ty_gltf_primitive* p, const char* name, ty_gltf_accessor* accessor);
void ty_gltf_close_draco(ty_gltf* gltf, ty_gltf_primitive* p);

/* ---- gltf_pose.c: skins and morph targets ---- */

/* Rest pose of a mesh at a node. */
typedef struct ty_gltf_pose {
    ty_affine transform;              /* node to scene, for primitives without joints */
    double* weights;                  /* of morph targets */
    ty_affine* joints;                /* joint matrices times inverse bind matrices */
    size_t weight_count, joint_count; /* 0: the mesh has no such pose */
} ty_gltf_pose;

/* *pose must be freed after the call, whatever the result. */
ty_result ty_gltf_read_pose(ty_gltf* gltf, const json_t* node, const ty_json_path* json_path, size_t mesh,
                            const ty_affine* transform, ty_gltf_pose* pose);
void ty_gltf_free_pose(ty_gltf* gltf, ty_gltf_pose* pose);
/* Moves a mesh's vertices, normals and tangents into the pose; with a skin, they are then in scene space. */
ty_result ty_gltf_apply_pose(ty_gltf* gltf, ty_gltf_primitive* p, const ty_gltf_pose* pose, ty_model_mesh* mesh);

/* ---- parts of the model ---- */

/* gltf_mesh.c: reads the primitives of a mesh in a pose, or (NULL) once without. */
ty_result ty_gltf_read_mesh(ty_gltf* gltf, size_t index, const ty_gltf_pose* pose, ty_gltf_mesh* out);
/* gltf_material.c: reads all materials, and adds a default one for primitives without. */
ty_result ty_gltf_read_materials(ty_gltf* gltf);
/* gltf_scene.c: reads the scene's nodes with meshes, lights and cameras. */
ty_result ty_gltf_read_scene(ty_gltf* gltf);
/* Transform of a node to its parent. */
ty_result ty_gltf_read_transform(const ty_gltf* gltf, const json_t* json, const ty_json_path* json_path,
                                 ty_affine* out);
/* gltf_instancing.c: transforms of a node's instances to the node (EXT_mesh_gpu_instancing), freed by the caller with
 * ty_free_array; *count is 0 if the node has none. */
ty_result ty_gltf_read_instances(ty_gltf* gltf, const json_t* node, ty_affine** out, size_t* count);
/* Transform by scale, then rotation by a quaternion x, y, z, w, then translation. */
ty_affine ty_gltf_compose(const double translation[3], const double quaternion[4], const double scale[3]);

#endif
