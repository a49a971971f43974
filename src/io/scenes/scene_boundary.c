/* Boundaries of a scene file, and the commit that checks them. */
#include "io/scenes/scene_reader.h"

ty_result ty_read_boundary(ty_scene_reader* reader) {
    const ty_json_path root = {.depth = 0};
    const ty_json_path path = ty_json_path_key(&root, "boundary");
    const json_t* boundary = json_object_get(reader->root, "boundary");
    ty_periodic_def def = ty_default_periodic_def();
    size_t i;
    json_t* axis;
    if (boundary == NULL) return TY_OK;
    json_array_foreach(json_object_get(boundary, "periodic"), i, axis) {
        def.axes[json_string_value(axis)[0] - 'x'] = true;
    }
    ty_result result = TY_OK;
    if (json_object_get(boundary, "cell") != NULL)
        result = ty_read_box(reader, boundary, &path, "cell", reader->unit, def.lower, def.upper);
    return result == TY_OK ? ty_reader_prefix_error(reader, &path, ty_scene_set_periodic(reader->scene, &def)) : result;
}

ty_result ty_reader_commit(const ty_scene_reader* reader) {
    const ty_result result = ty_scene_commit(reader->scene);
    const ty_json_path root = {.depth = 0};
    const ty_json_path path = ty_json_path_key(&root, "boundary");
    return result == TY_ERROR_ARGUMENT ? ty_reader_prefix_error(reader, &path, result) : result;
}
