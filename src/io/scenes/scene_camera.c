/* Camera of a scene file: from the file itself, from a glTF file, or a default that looks at the origin. */
#include "base/context.h"
#include "io/scenes/scene_reader.h"
#include "io/schema_text.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

static ty_result check_view(const ty_scene_reader* reader, const ty_json_path* path, const double position[3],
                            const double target[3], const double given_up[3]) {
    double view[3], across[3];
    for (int a = 0; a < 3; ++a) view[a] = target[a] - position[a];
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        across[a] = view[b] * given_up[c] - view[c] * given_up[b];
    }
    const double distance = hypot(hypot(view[0], view[1]), view[2]);
    const double up = hypot(hypot(given_up[0], given_up[1]), given_up[2]);
    if (!(distance > 0)) return ty_reader_fail(reader, path, TY_ERROR_INPUT, "position and target are the same point");
    if (!(hypot(hypot(across[0], across[1]), across[2]) > 1e-6 * distance * up))
        return ty_reader_fail(reader, path, TY_ERROR_INPUT, "up points along the view, from position to target");
    return TY_OK;
}

static ty_camera_def default_camera(const ty_scene_reader* reader) {
    ty_camera_def def = ty_default_camera_def();
    if (reader->up_axis == TY_AXIS_Z) {
        const double position[3] = {0, -def.position[2], 0}, up[3] = {0, 0, 1};
        memcpy(def.position, position, sizeof position);
        memcpy(def.up, up, sizeof up);
    }
    for (int a = 0; a < 3; ++a) {
        def.position[a] *= reader->unit;
        def.target[a] *= reader->unit;
    }
    return def;
}

/* ---- cameras of glTF files ---- */

static bool is_gltf(const char* file) {
    return ty_has_extension(file, ty_gltf_extensions);
}

/* First geometry item that references a file; NULL if none does. */
static const json_t* find_geometry(const ty_scene_reader* reader, const char* file, ty_json_path* path) {
    const ty_json_path root = {.depth = 0};
    const ty_json_path geometry = ty_json_path_key(&root, "geometry");
    size_t i;
    json_t* item;
    json_array_foreach(json_object_get(reader->root, "geometry"), i, item) {
        const char* name = json_string_value(json_object_get(item, "file"));
        *path = ty_json_path_index(&geometry, i);
        if (name != NULL && strcmp(name, file) == 0) return item;
    }
    return NULL;
}

static void describe_source(const ty_scene_reader* reader, const char* file, const char* name) {
    char text[512] = "";
    if (name != NULL) {
        ty_append_quoted(text, sizeof text, name);
        ty_append(text, sizeof text, " of %s", file);
    } else {
        ty_append(text, sizeof text, "the first of %s", file);
    }
    ty_scene_set_camera_source(reader->scene, text);
}

/* Sets *def from the camera of the given name, or the first, of a file. */
static ty_result find_camera(ty_scene_reader* reader, const ty_asset_file* file, const ty_mesh_file_def* placement,
                             const char* name, ty_camera_def* def, bool* found) {
    ty_asset camera = {.kind = TY_ASSET_CAMERA,
                       .file = file,
                       .placement = placement->transform,
                       .to_z_up = placement->to_z_up,
                       .camera_name = name != NULL ? name : ""};
    const ty_asset* kept = ty_assets_find(reader->assets, &camera);
    ty_result result = TY_OK;
    if (kept == NULL) {
        camera.camera = *def;
        result = ty_mesh_file_camera(reader->context, file->path, placement, name, &camera.camera, &camera.has_camera);
        if (result == TY_OK) result = ty_assets_keep(reader->assets, &camera);
        kept = &camera;
    }
    if (result != TY_OK) return result;
    *found = kept->has_camera;
    if (*found) *def = kept->camera;
    return TY_OK;
}

/* Sets *def from the camera of the given name, or the first, in the file of `item`, an object at `path`; messages
 * about the camera refer to json_path. */
static ty_result read_file_camera(ty_scene_reader* reader, const json_t* item, const ty_json_path* path,
                                  const ty_json_path* json_path, const char* name, ty_camera_def* def, bool* found) {
    const char* file = json_string_value(json_object_get(item, "file"));
    const ty_json_path file_json_path = ty_json_path_key(path, "file");
    ty_mesh_file_def placement = ty_default_mesh_file_def();
    const ty_asset_file* found_file = NULL;
    ty_result result = ty_read_mesh_placement(reader, item, path, 1, &placement);
    if (result == TY_OK) result = ty_find_file(reader, &file_json_path, file, &found_file);
    if (result == TY_OK)
        result =
            ty_reader_prefix_error(reader, json_path, find_camera(reader, found_file, &placement, name, def, found));
    if (result == TY_OK && *found) describe_source(reader, file, name);
    return result;
}

/* The camera that the section names; if the geometry has the same file, the camera is transformed with it. */
static ty_result read_named(ty_scene_reader* reader, const json_t* camera, const ty_json_path* path,
                            ty_camera_def* def) {
    const char* file = json_string_value(json_object_get(camera, "file"));
    const char* name = json_string_value(json_object_get(camera, "name"));
    const ty_json_path json_path = ty_json_path_key(path, name != NULL ? "name" : "file");
    if (file == NULL)
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT, "the key \"file\" is missing beside it");
    if (!is_gltf(file)) {
        const ty_json_path file_json_path = ty_json_path_key(path, "file");
        return ty_reader_fail(reader, &file_json_path, TY_ERROR_INPUT,
                              "cannot read cameras of files of this type; known: .gltf, .glb");
    }
    ty_json_path item_path;
    const json_t* item = find_geometry(reader, file, &item_path);
    if (item == NULL) {
        item = camera;
        item_path = *path;
    }
    bool found = false;
    const ty_result result = read_file_camera(reader, item, &item_path, &json_path, name, def, &found);
    if (result != TY_OK || found) return result;
    return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT, "there is no camera in this file");
}

/* First camera in the geometry's files, if there is one. */
static ty_result read_first(ty_scene_reader* reader, ty_camera_def* def) {
    const ty_json_path root = {.depth = 0};
    const ty_json_path geometry = ty_json_path_key(&root, "geometry");
    size_t i;
    json_t* item;
    json_array_foreach(json_object_get(reader->root, "geometry"), i, item) {
        const char* file = json_string_value(json_object_get(item, "file"));
        if (file == NULL || !is_gltf(file)) continue;
        const ty_json_path path = ty_json_path_index(&geometry, i);
        const ty_json_path json_path = ty_json_path_key(&path, "file");
        bool found = false;
        const ty_result result = read_file_camera(reader, item, &path, &json_path, NULL, def, &found);
        if (result != TY_OK) return result;
        if (!found) continue;
        ty_log(reader->context, TY_LOG_INFO, "%s: the camera is the first of %s", reader->name, file);
        return TY_OK;
    }
    return TY_OK;
}

/* ---- camera section ---- */

/* The pose at which the shutter closes; what it lacks is as it was when the shutter opened. */
static ty_result read_motion(const ty_scene_reader* reader, const json_t* camera, const ty_json_path* path,
                             ty_camera_def* def) {
    const json_t* motion = json_object_get(camera, "motion");
    const ty_json_path motion_path = ty_json_path_key(path, "motion");
    if (motion == NULL) return TY_OK;
    def->moves = 1;
    memcpy(def->end_position, def->position, sizeof def->end_position);
    memcpy(def->end_target, def->target, sizeof def->end_target);
    memcpy(def->end_up, def->up, sizeof def->end_up);
    ty_read_vector(motion, "position", reader->unit, def->end_position);
    ty_read_vector(motion, "target", reader->unit, def->end_target);
    const ty_result result = ty_read_direction(reader, motion, &motion_path, "up", def->end_up);
    if (result != TY_OK) return result;
    return check_view(reader, &motion_path, def->end_position, def->end_target, def->end_up);
}

static void read_lens(const ty_scene_reader* reader, const json_t* camera, ty_camera_def* def) {
    const json_t* shift = json_object_get(camera, "shift");
    for (size_t a = 0; a < 2 && shift != NULL; ++a) def->shift[a] = json_number_value(json_array_get(shift, a));
    ty_read_number(camera, "aperture_radius", &def->aperture_radius);
    ty_read_number(camera, "focus_distance", &def->focus_distance);
    def->aperture_radius *= reader->unit;
    def->focus_distance *= reader->unit;
}

ty_result ty_read_camera(ty_scene_reader* reader) {
    const ty_json_path root = {.depth = 0};
    const ty_json_path path = ty_json_path_key(&root, "camera");
    const json_t* camera = json_object_get(reader->root, "camera");
    ty_camera_def def = default_camera(reader);
    const bool placed = json_object_get(camera, "position") != NULL || json_object_get(camera, "target") != NULL;
    const bool named = json_object_get(camera, "file") != NULL || json_object_get(camera, "name") != NULL;
    ty_result result = TY_OK;
    if (named)
        result = read_named(reader, camera, &path, &def);
    else if (!placed)
        result = read_first(reader, &def);
    if (result != TY_OK) return result;
    ty_read_vector(camera, "position", reader->unit, def.position);
    ty_read_vector(camera, "target", reader->unit, def.target);
    result = ty_read_direction(reader, camera, &path, "up", def.up);
    if (result == TY_OK) result = check_view(reader, &path, def.position, def.target, def.up);
    if (result == TY_OK) result = read_motion(reader, camera, &path, &def);
    if (result != TY_OK) return result;
    read_lens(reader, camera, &def);
    ty_read_number(camera, "fov_y", &def.fov_y);
    ty_read_number(camera, "exposure", &def.exposure);
    const json_t* resolution = json_object_get(camera, "resolution");
    for (size_t a = 0; a < 2 && resolution != NULL; ++a)
        def.resolution[a] = (int32_t)json_number_value(json_array_get(resolution, a));
    return ty_reader_prefix_error(reader, &path, ty_scene_set_camera(reader->scene, &def));
}
