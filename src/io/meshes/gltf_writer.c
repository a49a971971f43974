/* Writing a copy of a glTF file, to which attributes are added. */
#include "io/meshes/gltf_writer.h"

#include "base/context.h"
#include "io/file.h"
#include "io/images/image_file.h"

#include <stdio.h>
#include <string.h>

enum { GLB_HEAD = 12, CHUNK_HEAD = 8, CHUNK_JSON = 0x4e4f534a, CHUNK_BIN = 0x004e4942 };

/* ---- binary chunk ---- */

/* Appends `size` bytes (zeros if bytes is NULL) aligned to four; *at is their offset. */
ty_result ty_gltf_append(ty_gltf_writer* w, const void* bytes, size_t size, size_t* at) {
    const size_t start = (w->size + 3) & ~(size_t)3, past = start + size;
    if (past > UINT32_MAX - 1024)
        return ty_fail(w->gltf.context, TY_ERROR_INPUT, "%s: with %s it would be larger than a GLB can be (4 GiB)",
                       w->gltf.path, w->what);
    if (past > w->capacity) {
        const size_t capacity = past > 2 * w->capacity ? past : 2 * w->capacity;
        uint8_t* grown = ty_alloc_array(w->gltf.context, capacity, 1, true);
        if (grown == NULL) return TY_ERROR_MEMORY;
        if (w->size > 0) memcpy(grown, w->body, w->size);
        ty_free_array(w->gltf.context, w->body, w->capacity, 1);
        w->body = grown;
        w->capacity = capacity;
    }
    if (bytes != NULL && size > 0) memcpy(w->body + start, bytes, size);
    *at = start;
    w->size = past;
    return TY_OK;
}

/* ---- JSON ---- */

ty_result ty_gltf_no_memory(const ty_gltf_writer* w) {
    return ty_fail(w->gltf.context, TY_ERROR_MEMORY, "%s: not enough memory", w->gltf.path);
}

/* A top-level array, created if missing. NULL: out of memory. */
static json_t* top_array(ty_gltf_writer* w, const char* name) {
    json_t* array = json_object_get(w->root, name);
    if (array != NULL) return array;
    json_t* made = json_array();
    return json_object_set_new(w->root, name, made) == 0 ? made : NULL;
}

/* Appends value to a top-level array and takes over its reference; *index is its index. */
ty_result ty_gltf_add_item(ty_gltf_writer* w, const char* name, json_t* value, int64_t* index) {
    json_t* array = top_array(w, name);
    if (array == NULL || value == NULL) {
        json_decref(value);
        return ty_gltf_no_memory(w);
    }
    *index = (int64_t)json_array_size(array);
    return json_array_append_new(array, value) == 0 ? TY_OK : ty_gltf_no_memory(w);
}

ty_result ty_gltf_add_view(ty_gltf_writer* w, size_t at, size_t size, int64_t* index) {
    return ty_gltf_add_item(
        w, "bufferViews",
        json_pack("{s:i, s:I, s:I}", "buffer", 0, "byteOffset", (json_int_t)at, "byteLength", (json_int_t)size), index);
}

/* Stores floats in little-endian order, as glTF requires. */
void ty_gltf_put_floats(const float* in, size_t count, uint8_t* out) {
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits;
        memcpy(&bits, &in[i], sizeof bits);
        for (size_t b = 0; b < 4; ++b) out[4 * i + b] = (uint8_t)(bits >> (8 * b));
    }
}

/* ---- existing content ---- */

/* Concatenates all buffers; views of the first keep their offsets. */
static ty_result gather_buffers(ty_gltf_writer* w) {
    const size_t count = ty_gltf_count(&w->gltf, "buffers");
    json_t* views = json_object_get(w->root, "bufferViews");
    for (size_t i = 0; i < count; ++i) {
        const ty_gltf_buffer* buffer = NULL;
        size_t at = 0, k;
        json_t* view;
        ty_result result = ty_gltf_open_buffer(&w->gltf, i, &buffer);
        if (result == TY_OK) result = ty_gltf_append(w, buffer->data, buffer->size, &at);
        if (result != TY_OK) return result;
        json_array_foreach(views, k, view) {
            const json_t* old = ty_gltf_item(&w->gltf, "bufferViews", k);
            if (i == 0 || json_integer_value(json_object_get(old, "buffer")) != (json_int_t)i) continue;
            const json_int_t offset = json_integer_value(json_object_get(old, "byteOffset"));
            if (json_object_set_new(view, "buffer", json_integer(0)) != 0 ||
                json_object_set_new(view, "byteOffset", json_integer(offset + (json_int_t)at)) != 0)
                return ty_gltf_no_memory(w);
        }
    }
    return TY_OK;
}

static const char* image_type(const uint8_t* bytes, size_t size) {
    if (size >= 4 && memcmp(bytes, "\x89PNG", 4) == 0) return "image/png";
    if (size >= 3 && memcmp(bytes, "\xff\xd8\xff", 3) == 0) return "image/jpeg";
    return NULL;
}

static ty_result embed_image(ty_gltf_writer* w, size_t index, json_t* image, const char* uri) {
    const ty_json_path json_path = ty_gltf_json_path("images", index);
    uint8_t* bytes = NULL;
    size_t size = 0, at = 0;
    int64_t view = 0;
    ty_result result = ty_gltf_load_uri(&w->gltf, &json_path, uri, TY_GLTF_FILE_MAX, ty_inspect_image, &bytes, &size);
    if (result != TY_OK) return result;
    const char* type = image_type(bytes, size);
    result = ty_gltf_append(w, bytes, size, &at);
    ty_free_file(w->gltf.context, bytes, size);
    if (result == TY_OK) result = ty_gltf_add_view(w, at, size, &view);
    if (result != TY_OK) return result;
    json_object_del(image, "uri");
    bool done = json_object_set_new(image, "bufferView", json_integer(view)) == 0;
    if (type != NULL) done = done && json_object_set_new(image, "mimeType", json_string(type)) == 0;
    return done ? TY_OK : ty_gltf_no_memory(w);
}

static ty_result embed_images(ty_gltf_writer* w) {
    size_t i;
    json_t* image;
    json_array_foreach(json_object_get(w->root, "images"), i, image) {
        const char* uri = json_string_value(json_object_get(image, "uri"));
        if (uri == NULL || strncmp(uri, "data:", 5) == 0) continue;
        const ty_result result = embed_image(w, i, image, uri);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

ty_result ty_gltf_fail_changed(const ty_gltf_writer* w, const ty_mesh_origin* origin) {
    return ty_fail(w->gltf.context, TY_ERROR_INPUT,
                   "%s: node %d has no primitive %d with %lld positions; the file is not the one that was read",
                   w->gltf.path, (int)origin->node, (int)origin->primitive, (long long)origin->vertex_total);
}

/* The mesh of a node, exclusive to it: a copy if another node has the original. */
ty_result ty_gltf_node_mesh(ty_gltf_writer* w, const ty_mesh_origin* origin, json_t** out) {
    json_t* node = json_array_get(json_object_get(w->root, "nodes"), (size_t)origin->node);
    json_t* meshes = json_object_get(w->root, "meshes");
    const json_t* number = json_object_get(node, "mesh");
    int64_t index = json_is_integer(number) ? json_integer_value(number) : -1;
    *out = index < 0 ? NULL : json_array_get(meshes, (size_t)index);
    if (*out == NULL) return ty_gltf_fail_changed(w, origin);
    if ((size_t)index >= w->mesh_count) return TY_OK; /* the copy is already this node's */
    if (w->mesh_nodes[index] == 0) w->mesh_nodes[index] = origin->node + 1;
    if (w->mesh_nodes[index] == origin->node + 1) return TY_OK;
    const ty_result result = ty_gltf_add_item(w, "meshes", json_deep_copy(*out), &index);
    if (result != TY_OK) return result;
    *out = json_array_get(meshes, (size_t)index);
    return json_object_set_new(node, "mesh", json_integer(index)) == 0 ? TY_OK : ty_gltf_no_memory(w);
}

/* ---- whole file ---- */

static ty_result set_extras(ty_gltf_writer* w, const char* text) {
    if (text == NULL) return TY_OK;
    json_t* value = json_loads(text, 0, NULL);
    if (!json_is_object(value)) {
        json_decref(value);
        return ty_fail(w->gltf.context, TY_ERROR_ARGUMENT, "extras: not a JSON object");
    }
    json_t* extras = json_object_get(w->root, "extras");
    if (!json_is_object(extras)) {
        extras = json_object();
        if (json_object_set_new(w->root, "extras", extras) != 0) extras = NULL;
    }
    if (extras != NULL && json_object_set(extras, "tyndall", value) == 0) {
        json_decref(value);
        return TY_OK;
    }
    json_decref(value);
    return ty_gltf_no_memory(w);
}

/* The single output buffer, with the keys of the first buffer except its uri. */
static ty_result set_buffer(ty_gltf_writer* w) {
    const json_t* first = ty_gltf_item(&w->gltf, "buffers", 0);
    json_t* buffer = first == NULL ? json_object() : json_deep_copy(first);
    json_object_del(buffer, "uri");
    if (buffer != NULL && json_object_set_new(buffer, "byteLength", json_integer((json_int_t)w->size)) == 0 &&
        json_object_set_new(w->root, "buffers", json_pack("[o]", buffer)) == 0)
        return TY_OK;
    return ty_gltf_no_memory(w);
}

static void put_u32(uint8_t* at, size_t value) {
    for (size_t b = 0; b < 4; ++b) at[b] = (uint8_t)(value >> (8 * b));
}

static void write_chunk(ty_output* output, uint32_t type, const void* bytes, size_t size, char filler) {
    uint8_t head[CHUNK_HEAD];
    const size_t rest = (4 - size % 4) % 4;
    put_u32(head, size + rest);
    put_u32(head + 4, type);
    ty_output_write(output, head, sizeof head);
    ty_output_write(output, bytes, size);
    for (size_t i = 0; i < rest; ++i) ty_output_write(output, &filler, 1);
}

static ty_result write_glb(ty_gltf_writer* w, const char* path) {
    char* text = json_dumps(w->root, JSON_COMPACT);
    if (text == NULL) return ty_gltf_no_memory(w);
    const size_t length = strlen(text), body = (w->size + 3) & ~(size_t)3;
    const size_t total = GLB_HEAD + 2 * CHUNK_HEAD + ((length + 3) & ~(size_t)3) + body;
    ty_output output;
    ty_result result = total <= UINT32_MAX ? ty_output_open(w->gltf.context, path, &output)
                                           : ty_fail(w->gltf.context, TY_ERROR_INPUT,
                                                     "%s: larger than a GLB can be (4 GiB)", w->gltf.path);
    if (result == TY_OK) {
        uint8_t head[GLB_HEAD] = {'g', 'l', 'T', 'F', 2};
        put_u32(head + 8, total);
        /* The commit reports write errors. */
        ty_output_write(&output, head, sizeof head);
        write_chunk(&output, CHUNK_JSON, text, length, ' ');
        write_chunk(&output, CHUNK_BIN, w->body, w->size, '\0');
        result = ty_output_commit(w->gltf.context, &output);
    }
    free(text);
    return result;
}

/* Vertices of compressed meshes have no place in the file to which attributes could be added. */
static ty_result refuse_compressed(const ty_gltf_writer* w) {
    static const char* const names[] = {"EXT_meshopt_compression", "KHR_draco_mesh_compression"};
    size_t i;
    json_t* used;
    json_array_foreach(json_object_get(w->gltf.root, "extensionsUsed"), i, used) {
        for (size_t k = 0; k < sizeof names / sizeof *names; ++k)
            if (json_is_string(used) && strcmp(json_string_value(used), names[k]) == 0)
                return ty_fail(w->gltf.context, TY_ERROR_INPUT,
                               "%s: %s cannot be added to a file with %s; \"gltf-transform copy\" decompresses it",
                               w->gltf.path, w->what, names[k]);
    }
    return TY_OK;
}

static ty_result open_file(ty_gltf_writer* w) {
    ty_result result = ty_gltf_open(&w->gltf, w->bytes, w->byte_count);
    if (result == TY_OK) result = refuse_compressed(w);
    if (result == TY_OK) result = ty_gltf_create_tables(&w->gltf);
    if (result != TY_OK) return result;
    w->root = json_deep_copy(w->gltf.root);
    if (w->root == NULL) return ty_gltf_no_memory(w);
    w->mesh_count = ty_gltf_count(&w->gltf, "meshes");
    w->mesh_nodes = ty_alloc_array(w->gltf.context, w->mesh_count, sizeof *w->mesh_nodes, true);
    if (w->mesh_nodes == NULL) return TY_ERROR_MEMORY;
    result = gather_buffers(w);
    return result == TY_OK ? embed_images(w) : result;
}

ty_result ty_gltf_writer_open(ty_gltf_writer* w, ty_context* context, const char* from, const char* what) {
    *w = (ty_gltf_writer){.gltf = {.context = context, .path = from}, .what = what};
    ty_result result =
        ty_read_inspected_file(context, from, TY_GLTF_FILE_MAX, ty_inspect_model, &w->bytes, &w->byte_count);
    if (result != TY_OK) return result;
    w->folder = ty_folder_of(context, from);
    w->gltf.folder = w->folder;
    return w->folder == NULL ? TY_ERROR_MEMORY : open_file(w);
}

ty_result ty_gltf_writer_finish(ty_gltf_writer* w, const char* extras, const char* path) {
    ty_result result = set_extras(w, extras);
    if (result == TY_OK) result = set_buffer(w);
    return result == TY_OK ? write_glb(w, path) : result;
}

void ty_gltf_writer_close(ty_gltf_writer* w) {
    ty_context* context = w->gltf.context;
    json_decref(w->root);
    ty_gltf_close(&w->gltf);
    ty_free_array(context, w->mesh_nodes, w->mesh_count, sizeof *w->mesh_nodes);
    ty_free_array(context, w->body, w->capacity, 1);
    ty_free_text(context, w->folder);
    if (w->bytes != NULL) ty_free_file(context, w->bytes, w->byte_count);
}
