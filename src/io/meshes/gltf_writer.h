/* Copies of glTF files to which attributes of vertices are added: JSON and one binary chunk. */
#ifndef TY_IO_MESHES_GLTF_WRITER_H
#define TY_IO_MESHES_GLTF_WRITER_H

#include "io/meshes/gltf.h"

#include <tyndall/io.h>

typedef struct ty_gltf_writer {
    ty_gltf gltf;     /* source file */
    const char* what; /* is added, for messages: "colours" */
    json_t* root;     /* output JSON */
    uint8_t* body;    /* output binary chunk */
    size_t size, capacity;
    int32_t* mesh_nodes; /* per mesh: node whose attributes it has, plus one; 0: none */
    size_t mesh_count;
    uint8_t* bytes; /* of the source */
    size_t byte_count;
    char* folder;
} ty_gltf_writer;

/* Reads a file and copies its JSON and buffers. To be closed after an error, too. */
ty_result ty_gltf_writer_open(ty_gltf_writer* w, ty_context* context, const char* from, const char* what);
/* Writes the GLB; extras: the text of a JSON object for extras.tyndall, or NULL. */
ty_result ty_gltf_writer_finish(ty_gltf_writer* w, const char* extras, const char* path);
void ty_gltf_writer_close(ty_gltf_writer* w);

/* Appends `size` bytes (zeros if bytes is NULL) aligned to four; *at is their offset. */
ty_result ty_gltf_append(ty_gltf_writer* w, const void* bytes, size_t size, size_t* at);
/* Appends value to a top-level array and takes over its reference; *index is its index. */
ty_result ty_gltf_add_item(ty_gltf_writer* w, const char* name, json_t* value, int64_t* index);
ty_result ty_gltf_add_view(ty_gltf_writer* w, size_t at, size_t size, int64_t* index);
ty_result ty_gltf_no_memory(const ty_gltf_writer* w);
/* The error of a file that has no longer what the mesh was read from. */
ty_result ty_gltf_fail_changed(const ty_gltf_writer* w, const ty_mesh_origin* origin);
/* The mesh of a node, exclusive to it: a copy if another node has the original. */
ty_result ty_gltf_node_mesh(ty_gltf_writer* w, const ty_mesh_origin* origin, json_t** out);
/* Stores floats in little-endian order, as glTF requires. */
void ty_gltf_put_floats(const float* in, size_t count, uint8_t* out);

#endif
