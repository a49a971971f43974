/* A mesh file as a scene of its own. */
#define _GNU_SOURCE
#include "cli/bake/mesh_scene.h"
#include "cli/text/text_file.h"

#include <stdlib.h>
#include <string.h>

ty_result cli_load_mesh_scene(cli_session* session, const char* path, const cli_list* overrides, ty_scene** out) {
    const char* slash = strrchr(path, '/');
    const size_t folder_length = slash == NULL ? 0 : (size_t)(slash - path) + 1;
    cli_text memory;
    if (!cli_text_open(&memory)) return TY_ERROR_MEMORY;
    json_writer json = json_begin(memory.file);
    json_open_object(&json, NULL);
    json_int(&json, "tyndall", 1);
    json_open_array(&json, "geometry");
    json_open_object(&json, NULL);
    json_text(&json, "file", path + folder_length);
    json_close_object(&json);
    json_close_array(&json);
    json_close_object(&json);
    char *text = cli_text_close(&memory), *folder = strndup(path, folder_length);
    ty_result result = TY_ERROR_MEMORY;
    if (text != NULL && folder != NULL)
        result =
            ty_scene_parse(session->context, text, memory.size, path, folder, overrides->items, overrides->count, out);
    free(text);
    free(folder);
    return result;
}

bool cli_same_node(const ty_mesh_def* a, const ty_mesh_def* b) {
    return a->origin.node >= 0 && a->origin.node == b->origin.node && a->origin.file != NULL &&
           b->origin.file != NULL && strcmp(a->origin.file, b->origin.file) == 0;
}
