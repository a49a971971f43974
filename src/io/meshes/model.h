/* Format-independent content of a mesh file: the readers fill a ty_model, mesh_file.c converts it to a scene. */
#ifndef TY_IO_MODEL_H
#define TY_IO_MODEL_H

#include "io/file.h"

#include <tyndall/scene.h>

/* Content to read. */
enum {
    TY_MODEL_MESHES = 1,    /* positions and triangles */
    TY_MODEL_SHADING = 2,   /* vertex normals, texture coordinates and colors */
    TY_MODEL_MATERIALS = 4, /* materials and textures */
    TY_MODEL_LIGHTS = 8,
    TY_MODEL_CAMERAS = 16,
    TY_MODEL_ALL = 31
};

/* Triangles of one material, counter-clockwise seen from the front. Arrays come from ty_alloc_array, have one
 * element per vertex, as in ty_mesh_def, and are NULL if optional and absent. Every index is below vertex_count,
 * every number finite, every color in 0..1. */
typedef struct ty_model_mesh {
    size_t vertex_count, triangle_count;
    float* positions;
    float* normals; /* unit, or zero where the file has no direction */
    float* uv[2];
    float* colors;
    float* tangents; /* unit, or zero; the fourth number, 1 or -1, is the sign of the bitangent */
    uint32_t* indices;
    int32_t material;  /* -1: none */
    int32_t primitive; /* this and the next fields: as in ty_mesh_origin */
    size_t first_vertex, vertex_total;
} ty_model_mesh;

/* An instance of a mesh; the map may be singular. */
typedef struct ty_model_instance {
    int32_t mesh;
    ty_affine transform; /* mesh to file */
    int32_t node;        /* glTF node, or -1 */
    char* name;
} ty_model_instance;

/* Texels, 4 bytes each, after decoding; before it, the bytes of an image file. */
typedef struct ty_model_image {
    char* name; /* for messages: "level.glb: images[2]" */
    uint8_t* encoded;
    size_t encoded_size;
    int32_t width, height;
    uint8_t* rgba8;
} ty_model_image;

typedef struct ty_model_texture {
    int32_t image; /* -1: the texture has no use */
    ty_wrap wrap[2];
    bool nearest;
    bool linear; /* numbers, not colours */
} ty_model_texture;

/* Maps of MTL files that hold one number, and bumps. */
typedef enum ty_single_map { TY_SINGLE_OPACITY, TY_SINGLE_ROUGHNESS, TY_SINGLE_METALLIC, TY_SINGLE_BUMP } ty_single_map;
enum { TY_SINGLE_MAPS = 4 };

/* def without textures, which are given by index; -1: none. */
typedef struct ty_model_material {
    char* name;
    bool plain; /* default material, not from the file */
    ty_material_def def;
    int32_t albedo_texture, emission_texture;
    int32_t gloss_textures[TY_GLOSS_TEXTURES];
    int32_t single_textures[TY_SINGLE_MAPS]; /* -1 once the file is read */
} ty_model_material;

/* Position and directions in file space; directions are unit. */
typedef struct ty_model_camera {
    char* name;
    double position[3], forward[3], up[3];
    double fov_y;      /* degrees */
    bool orthographic; /* fov_y is then 0 */
} ty_model_camera;

typedef struct ty_model {
    ty_context* context;
    ty_model_mesh* meshes;
    ty_model_instance* instances;
    ty_model_image* images;
    ty_model_texture* textures;
    ty_model_material* materials;
    ty_light_def* lights; /* in file space: point, spot, directional */
    ty_model_camera* cameras;
    size_t mesh_count, instance_count, image_count, texture_count, material_count, light_count, camera_count;
    size_t mesh_capacity, instance_capacity, image_capacity, texture_capacity, material_capacity, light_capacity,
        camera_capacity;
} ty_model;

/* Reads a model from bytes, which are followed by a zero byte not counted in size; `path` names the file in
 * messages. folder: location of referenced files ("": the current folder; NULL: references are refused). want:
 * TY_MODEL_... flags. *model must be freed after the call, whatever the result. */
ty_result ty_read_gltf(ty_context* context, const char* path, const char* folder, const uint8_t* bytes, size_t size,
                       unsigned want, ty_model* model);
ty_result ty_read_obj(ty_context* context, const char* path, const char* folder, const uint8_t* bytes, size_t size,
                      unsigned want, ty_model* model);
ty_result ty_read_ply(ty_context* context, const char* path, const uint8_t* bytes, size_t size, unsigned want,
                      ty_model* model);
/* Reads a model from a file; its format is detected from the content, OBJ from the extension. */
ty_result ty_read_model(ty_context* context, const char* path, unsigned want, ty_model* model);
void ty_model_free(ty_model* model);

/* Each function adds one element, filled as given, and takes over its strings and arrays, which are freed on
 * failure. */
ty_result ty_model_add_mesh(ty_model* model, ty_model_mesh* mesh);
/* name is copied; NULL: none. */
ty_result ty_model_add_instance(ty_model* model, size_t mesh, const ty_affine* transform, int32_t node,
                                const char* name);
ty_result ty_model_add_image(ty_model* model, ty_model_image* image);
ty_result ty_model_add_texture(ty_model* model, const ty_model_texture* texture);
ty_result ty_model_add_material(ty_model* model, ty_model_material* material);
ty_result ty_model_add_light(ty_model* model, const ty_light_def* light);
ty_result ty_model_add_camera(ty_model* model, ty_model_camera* camera);

/* Allocates the arrays of a mesh with vertex_count and triangle_count: positions and indices always. */
ty_result ty_model_alloc_mesh(ty_context* context, ty_model_mesh* mesh, bool normals, bool uv0, bool uv1, bool colors);
void ty_model_free_mesh(ty_context* context, ty_model_mesh* mesh);

/* Makes shading arrays conform to ty_model_mesh: normals and tangents unit, non-finite numbers 0, colors clamped. */
void ty_model_tidy_shading(ty_model_mesh* mesh);
/* A material with the given albedo and no textures. */
ty_model_material ty_model_plain_material(float albedo);
/* Decodes all images on the context's threads. */
ty_result ty_model_decode_images(ty_model* model);
/* Number of triangles over all instances. */
int64_t ty_model_triangles(const ty_model* model);

/* The same as ty_read_inspected_file for a file that another one names at `location`, which stands before the message.
 */
ty_result ty_model_read_reference(ty_context* context, const char* location, const char* path, size_t limit,
                                  ty_file_form_fn inspect, uint8_t** bytes, size_t* size);
/* Path of a file referenced by another one: folder/name. Absolute names and names that lead out of the folder are
 * refused, as are all if folder is NULL; `location` names the reference in messages. Freed with ty_free_text. */
ty_result ty_model_inner_path(ty_context* context, const char* location, const char* folder, const char* name,
                              char** out);

/* As ty_file_form_fn, for PLY files and for mesh files of any format. */
ty_result ty_inspect_ply(ty_context* context, const char* path, uint8_t* head, size_t size, ty_file_form* form);
ty_result ty_inspect_model(ty_context* context, const char* path, uint8_t* head, size_t size, ty_file_form* form);

#endif
