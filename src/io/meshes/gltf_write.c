/* Writing a copy of a glTF file with vertex colors. */
#include "base/context.h"
#include "io/meshes/gltf_writer.h"

#include <stdio.h>
#include <string.h>

enum { COLORS_MAX = 1000 };

/* A color array for all primitives with the same positions and node; each fills a range of it. */
typedef struct shared_colors {
    int64_t positions; /* accessor of the positions */
    int32_t node;
    int64_t accessor;   /* accessor of the colors */
    size_t at;          /* offset of the colors in the body */
    size_t first, past; /* range of vertices with colors */
} shared_colors;

typedef struct color_list {
    shared_colors* items;
    size_t count, capacity;
} color_list;

/* ---- colors ---- */

/* Renames the primitive's existing color attribute. */
static ty_result move_colors(ty_gltf_writer* w, json_t* attributes) {
    char name[32];
    json_t* old = json_object_get(attributes, "COLOR_0");
    for (int i = 1; old != NULL && i < COLORS_MAX; ++i) {
        snprintf(name, sizeof name, "COLOR_%d", i);
        if (json_object_get(attributes, name) != NULL) continue;
        if (json_object_set(attributes, name, old) != 0) return ty_gltf_no_memory(w);
        old = NULL;
    }
    return TY_OK;
}

/* Adds a color array for `total` positions, all 0. */
static ty_result add_colors(ty_gltf_writer* w, color_list* list, int32_t node, int64_t positions, int64_t total,
                            shared_colors** out) {
    const size_t size = (size_t)total * 3 * sizeof(float);
    int64_t view = 0;
    shared_colors made = {.positions = positions, .node = node};
    ty_result result = ty_gltf_append(w, NULL, size, &made.at);
    if (result == TY_OK) result = ty_gltf_add_view(w, made.at, size, &view);
    if (result == TY_OK)
        result = ty_gltf_add_item(w, "accessors",
                                  json_pack("{s:I, s:i, s:I, s:s}", "bufferView", (json_int_t)view, "componentType",
                                            (int)TY_GLTF_F32, "count", (json_int_t)total, "type", "VEC3"),
                                  &made.accessor);
    if (result != TY_OK) return result;
    if (!ty_grow_array(w->gltf.context, (void**)&list->items, &list->capacity, list->count, sizeof *list->items))
        return TY_ERROR_MEMORY;
    list->items[list->count] = made;
    *out = &list->items[list->count++];
    return TY_OK;
}

/* Color array for a primitive's vertices up to `past`: an existing one for other vertices of the same positions, or
 * a new one. */
static ty_result find_colors(ty_gltf_writer* w, color_list* list, const ty_mesh_origin* origin, int64_t positions,
                             size_t past, shared_colors** out) {
    for (size_t i = list->count; i-- > 0;) {
        shared_colors* shared = &list->items[i];
        if (shared->positions != positions || shared->node != origin->node) continue;
        if ((size_t)origin->first_vertex < shared->past && past > shared->first) continue;
        *out = shared;
        return TY_OK;
    }
    return add_colors(w, list, origin->node, positions, origin->vertex_total, out);
}

static ty_result color_mesh(ty_gltf_writer* w, color_list* list, const ty_mesh_colors* colors) {
    const ty_mesh_origin* origin = &colors->origin;
    json_t* mesh = NULL;
    ty_result result = ty_gltf_node_mesh(w, origin, &mesh);
    if (result != TY_OK) return result;
    json_t* primitive = json_array_get(json_object_get(mesh, "primitives"), (size_t)origin->primitive);
    json_t* attributes = json_object_get(primitive, "attributes");
    const json_t* number = json_object_get(attributes, "POSITION");
    const int64_t positions = json_is_integer(number) ? json_integer_value(number) : -1;
    const json_t* accessor =
        positions < 0 ? NULL : json_array_get(json_object_get(w->root, "accessors"), (size_t)positions);
    if (json_integer_value(json_object_get(accessor, "count")) != origin->vertex_total || origin->vertex_total < 1)
        return ty_gltf_fail_changed(w, origin);
    const size_t first = (size_t)origin->first_vertex, past = first + (size_t)colors->count;
    shared_colors* shared = NULL;
    result = move_colors(w, attributes);
    if (result == TY_OK) result = find_colors(w, list, origin, positions, past, &shared);
    if (result != TY_OK) return result;
    ty_gltf_put_floats(colors->rgb, 3 * (size_t)colors->count, w->body + shared->at + first * 3 * sizeof(float));
    const bool empty = shared->first == shared->past;
    shared->first = empty || first < shared->first ? first : shared->first;
    shared->past = empty || past > shared->past ? past : shared->past;
    return json_object_set_new(attributes, "COLOR_0", json_integer(shared->accessor)) == 0 ? TY_OK
                                                                                           : ty_gltf_no_memory(w);
}

static ty_result check_colors(ty_context* context, const ty_mesh_colors* colors, int64_t count) {
    for (int64_t i = 0; i < count; ++i) {
        const ty_mesh_origin* origin = &colors[i].origin;
        if (origin->node < 0 || origin->primitive < 0 || origin->first_vertex < 0 || colors[i].count < 1 ||
            colors[i].rgb == NULL || colors[i].count > origin->vertex_total ||
            origin->first_vertex > origin->vertex_total - colors[i].count)
            return ty_fail(context, TY_ERROR_ARGUMENT, "colors[%lld]: not those of a mesh from a glTF file",
                           (long long)i);
    }
    return TY_OK;
}

ty_result ty_mesh_file_write_colors(ty_context* context, const char* from, const ty_mesh_colors* colors, int64_t count,
                                    const char* extras, const char* path) {
    if (from == NULL || path == NULL || count < 0 || (count > 0 && colors == NULL))
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_mesh_file_write_colors: an argument is NULL or negative");
    ty_result result = check_colors(context, colors, count);
    if (result != TY_OK) return result;
    ty_gltf_writer w;
    color_list list = {.items = NULL};
    result = ty_gltf_writer_open(&w, context, from, "colours");
    for (int64_t i = 0; i < count && result == TY_OK; ++i) result = color_mesh(&w, &list, &colors[i]);
    if (result == TY_OK) result = ty_gltf_writer_finish(&w, extras, path);
    ty_gltf_writer_close(&w);
    ty_free_array(context, list.items, list.capacity, sizeof *list.items);
    return result;
}
