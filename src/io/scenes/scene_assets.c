/* Files referenced by a scene: located from its folder, hashed, read once. */
#include "base/context.h"
#include "io/file.h"
#include "io/scenes/scene_reader.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

const char* const ty_gltf_extensions[] = {".gltf", ".glb", NULL};
const char* const ty_mesh_extensions[] = {".gltf", ".glb", ".obj", ".ply", NULL};
const char* const ty_volume_extensions[] = {".vdb", ".nvdb", ".nrrd", ".nhdr", NULL};

bool ty_has_extension(const char* file, const char* const* extensions) {
    const size_t length = strlen(file);
    for (; *extensions != NULL; ++extensions) {
        const size_t size = strlen(*extensions);
        if (length >= size && strcasecmp(file + length - size, *extensions) == 0) return true;
    }
    return false;
}

/* ---- records ---- */

/* Path of a file; freed with ty_free_text, or handed to add_asset. */
static ty_result join_path(const ty_scene_reader* reader, const ty_json_path* json_path, const char* file, char** out) {
    if (reader->folder == NULL)
        return ty_reader_fail(reader, json_path, TY_ERROR_INPUT, "this scene may not name files");
    *out = ty_join_path(reader->context, reader->folder, file);
    return *out != NULL ? TY_OK : TY_ERROR_MEMORY;
}

/* First record of a path; NULL if there is none. */
static ty_scene_asset* first_asset(const ty_scene_reader* reader, const char* path) {
    for (size_t i = 0; i < reader->asset_count; ++i)
        if (strcmp(reader->assets[i].path, path) == 0) return &reader->assets[i];
    return NULL;
}

/* Adds a record and takes over its path, which is freed on failure. A file not yet recorded extends the hash. */
static ty_result add_asset(ty_scene_reader* reader, const ty_json_path* json_path, char* path, ty_scene_asset** out) {
    ty_result result = TY_OK;
    if (first_asset(reader, path) == NULL)
        result =
            ty_reader_prefix_error(reader, json_path, ty_hash_file_and_names(reader->context, path, &reader->hash));
    if (result == TY_OK && !ty_grow_array(reader->context, (void**)&reader->assets, &reader->asset_capacity,
                                          reader->asset_count, sizeof *reader->assets))
        result = TY_ERROR_MEMORY;
    if (result != TY_OK) {
        ty_free_text(reader->context, path);
        return result;
    }
    *out = &reader->assets[reader->asset_count++];
    **out = (ty_scene_asset){.path = path};
    return TY_OK;
}

void ty_free_assets(ty_scene_reader* reader) {
    for (size_t i = 0; i < reader->asset_count; ++i) {
        ty_free_text(reader->context, reader->assets[i].path);
        ty_grid_release(reader->assets[i].grid);
        ty_image_destroy(reader->assets[i].image);
        ty_closed_mesh_release(reader->assets[i].shell);
    }
    ty_free_array(reader->context, reader->assets, reader->asset_capacity, sizeof *reader->assets);
}

ty_result ty_find_file(ty_scene_reader* reader, const ty_json_path* json_path, const char* file, const char** path) {
    char* joined = NULL;
    ty_result result = join_path(reader, json_path, file, &joined);
    if (result != TY_OK) return result;
    ty_scene_asset* asset = first_asset(reader, joined);
    if (asset != NULL)
        ty_free_text(reader->context, joined);
    else
        result = add_asset(reader, json_path, joined, &asset);
    if (result == TY_OK) *path = asset->path;
    return result;
}

/* ---- images and meshes ---- */

ty_result ty_read_map(ty_scene_reader* reader, const ty_json_path* json_path, const char* file, const ty_image** out) {
    char* path = NULL;
    ty_result result = join_path(reader, json_path, file, &path);
    if (result != TY_OK) return result;
    for (size_t i = 0; i < reader->asset_count; ++i) {
        if (reader->assets[i].image == NULL || strcmp(reader->assets[i].path, path) != 0) continue;
        ty_free_text(reader->context, path);
        *out = reader->assets[i].image;
        return TY_OK;
    }
    ty_scene_asset* asset = NULL;
    result = add_asset(reader, json_path, path, &asset);
    if (result == TY_OK)
        result = ty_reader_prefix_error(reader, json_path, ty_image_read(reader->context, asset->path, &asset->image));
    if (result == TY_OK) *out = asset->image;
    return result;
}

ty_result ty_find_mesh_file(ty_scene_reader* reader, const ty_json_path* json_path, const char* file,
                            const char** path) {
    if (!ty_has_extension(file, ty_mesh_extensions))
        return ty_reader_fail(reader, json_path, TY_ERROR_INPUT,
                              "cannot read meshes of this type; known: .gltf, .glb, .obj, .ply");
    return ty_find_file(reader, json_path, file, path);
}

ty_result ty_read_shell(ty_scene_reader* reader, const ty_json_path* json_path, const char* path,
                        const ty_mesh_file_def* def, ty_closed_mesh** out) {
    for (size_t i = 0; i < reader->asset_count; ++i) {
        const ty_scene_asset* asset = &reader->assets[i];
        if (asset->shell == NULL || strcmp(asset->path, path) != 0) continue;
        if (memcmp(&asset->placement, &def->transform, sizeof asset->placement) != 0) continue;
        *out = asset->shell;
        return TY_OK;
    }
    char* copy = ty_copy_text(reader->context, path);
    if (copy == NULL) return TY_ERROR_MEMORY;
    ty_scene_asset* asset = NULL;
    ty_result result = add_asset(reader, json_path, copy, &asset);
    if (result != TY_OK) return result;
    asset->placement = def->transform;
    result = ty_reader_prefix_error(reader, json_path,
                                    ty_mesh_file_create_closed_mesh(reader->context, asset->path, def, &asset->shell));
    if (result == TY_OK) *out = asset->shell;
    return result;
}

/* ---- volumes ---- */

/* Size of a file name with its #s replaced. */
enum { NAME_MAX_SIZE = 4096 };

/* True if the file format may hold several named grids. */
static bool has_names(const json_t* volume) {
    static const char* const extensions[] = {".vdb", ".nvdb", NULL};
    return ty_has_extension(json_string_value(json_object_get(volume, "file")), extensions);
}

/* Known formats describe their content; other files need "raw". */
static ty_result check_volume_type(const ty_scene_reader* reader, const json_t* volume, const ty_json_path* json_path) {
    const ty_json_path grid = ty_json_path_key(json_path, "grid");
    if (json_object_get(volume, "grid") != NULL && !has_names(volume))
        return ty_reader_fail(reader, &grid, TY_ERROR_INPUT, "is for .vdb and .nvdb files; others hold one grid");
    const bool known = ty_has_extension(json_string_value(json_object_get(volume, "file")), ty_volume_extensions);
    const bool raw = json_object_get(volume, "raw") != NULL;
    const ty_json_path key = ty_json_path_key(json_path, raw ? "raw" : "file");
    if (known && raw)
        return ty_reader_fail(reader, &key, TY_ERROR_INPUT,
                              "is for raw files; .vdb, .nvdb, .nrrd and .nhdr tell what they hold");
    if (known || raw) return TY_OK;
    return ty_reader_fail(reader, &key, TY_ERROR_INPUT,
                          "cannot read volumes of this type; known: .vdb, .nvdb, .nrrd, .nhdr, and any file with the "
                          "key \"raw\" beside it");
}

static ty_volume_def describe_volume(const ty_scene_reader* reader, const json_t* volume, const char* grid_name) {
    ty_volume_def def = ty_default_volume_def();
    const char* name = json_string_value(json_object_get(volume, "grid"));
    def.grid = name != NULL ? name : has_names(volume) ? grid_name : "";
    def.frame = reader->frame;
    ty_read_int(volume, "frame", &def.frame);
    ty_read_int(volume, "component", &def.component);
    const json_t* raw = json_object_get(volume, "raw");
    if (raw == NULL) return def;
    double size[3] = {0, 0, 0}, offset = 0;
    ty_read_numbers(raw, "size", size);
    ty_read_number(raw, "offset", &offset);
    for (int a = 0; a < 3; ++a) def.raw_size[a] = (int32_t)size[a];
    def.raw_offset = (int64_t)offset;
    ty_read_numbers(raw, "spacing", def.raw_spacing);
    ty_read_bool(raw, "big_endian", &def.raw_big_endian);
    const char* type = json_string_value(json_object_get(raw, "type"));
    if (type != NULL) snprintf(def.raw_type, sizeof def.raw_type, "%s", type);
    return def;
}

/* True if two defs request the same grid of one path. The frame is part of the path already. */
static bool same_volume(const ty_volume_def* a, const ty_volume_def* b) {
    return strcmp(a->grid, b->grid) == 0 && a->component == b->component &&
           memcmp(a->raw_size, b->raw_size, sizeof a->raw_size) == 0 && strcmp(a->raw_type, b->raw_type) == 0 &&
           a->raw_big_endian == b->raw_big_endian && a->raw_offset == b->raw_offset &&
           memcmp(a->raw_spacing, b->raw_spacing, sizeof a->raw_spacing) == 0;
}

static ty_result read_grid(ty_scene_reader* reader, const ty_json_path* json_path, const char* path,
                           const ty_volume_def* def, ty_grid** out) {
    for (size_t i = 0; i < reader->asset_count; ++i) {
        const ty_scene_asset* asset = &reader->assets[i];
        if (asset->grid == NULL || strcmp(asset->path, path) != 0 || !same_volume(&asset->volume, def)) continue;
        *out = asset->grid;
        return TY_OK;
    }
    char* copy = ty_copy_text(reader->context, path);
    if (copy == NULL) return TY_ERROR_MEMORY;
    ty_scene_asset* asset = NULL;
    ty_result result = add_asset(reader, json_path, copy, &asset);
    if (result != TY_OK) return result;
    asset->volume = *def;
    result = ty_reader_prefix_error(reader, json_path, ty_volume_read(reader->context, asset->path, def, &asset->grid));
    if (result == TY_OK) *out = asset->grid;
    return result;
}

/* Validation before a volume is read, its path with the frame number, and its values per voxel (1 if one component
 * was requested). */
static ty_result open_volume(ty_scene_reader* reader, const json_t* volume, const ty_json_path* json_path, bool filling,
                             ty_volume_def* def, const char** path, int32_t* components) {
    const ty_json_path file_json_path = ty_json_path_key(json_path, "file");
    ty_result result = check_volume_type(reader, volume, json_path);
    if (result != TY_OK) return result;
    if (def->raw_size[0] > 0 && !(def->raw_spacing[0] > 0) && !filling)
        return ty_reader_fail(reader, json_path, TY_ERROR_INPUT,
                              "a raw volume without spacing needs bounds that are a box, [[x,y,z],[x,y,z]]");
    char name[NAME_MAX_SIZE];
    const char* file = json_string_value(json_object_get(volume, "file"));
    result = ty_volume_path(reader->context, file, def->frame, name, sizeof name);
    result = ty_reader_prefix_error(reader, &file_json_path, result);
    if (result == TY_OK) result = ty_find_file(reader, &file_json_path, name, path);
    if (result != TY_OK) return result;
    *components = 1;
    if (json_object_get(volume, "component") != NULL) return TY_OK;
    return ty_reader_prefix_error(reader, &file_json_path,
                                  ty_volume_components(reader->context, *path, def, components));
}

ty_result ty_read_volume(ty_scene_reader* reader, const json_t* volume, const ty_json_path* json_path,
                         const char* grid_name, bool filling, ty_grid** out) {
    ty_volume_def def = describe_volume(reader, volume, grid_name);
    const ty_json_path file_json_path = ty_json_path_key(json_path, "file");
    const char* path = NULL;
    int32_t components = 1;
    ty_result result = open_volume(reader, volume, json_path, filling, &def, &path, &components);
    if (result != TY_OK) return result;
    if (components > 1)
        return ty_reader_fail(reader, json_path, TY_ERROR_INPUT,
                              "the volume has %d values per voxel; the key \"component\" is missing", (int)components);
    return read_grid(reader, &file_json_path, path, &def, out);
}

ty_result ty_read_volume_rgb(ty_scene_reader* reader, const json_t* volume, const ty_json_path* json_path,
                             const char* grid_name, bool filling, ty_grid* out[3]) {
    ty_volume_def def = describe_volume(reader, volume, grid_name);
    const ty_json_path file_json_path = ty_json_path_key(json_path, "file");
    const char* path = NULL;
    int32_t components = 1;
    ty_result result = open_volume(reader, volume, json_path, filling, &def, &path, &components);
    if (result != TY_OK) return result;
    if (components != 1 && components != 3)
        return ty_reader_fail(reader, json_path, TY_ERROR_INPUT,
                              "the volume has %d values per voxel, not 1 or 3; the key \"component\" is missing",
                              (int)components);
    ty_grid* grids[3] = {NULL, NULL, NULL};
    for (int32_t c = 0; c < components && result == TY_OK; ++c) {
        if (components == 3) def.component = c;
        result = read_grid(reader, &file_json_path, path, &def, &grids[c]);
    }
    for (int c = 0; c < 3 && result == TY_OK; ++c) out[c] = grids[components == 3 ? c : 0];
    return result;
}
