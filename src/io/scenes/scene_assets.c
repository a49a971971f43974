/* Files that a scene names, located from its folder, and noise; each is read or made once. */
#include "base/context.h"
#include "io/file.h"
#include "io/scenes/memory_files.h"
#include "io/scenes/scene_reader.h"
#include "io/volumes/dicom/dicom.h"
#include "io/volumes/volume_file.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

const char* const ty_gltf_extensions[] = {".gltf", ".glb", NULL};
const char* const ty_mesh_extensions[] = {".gltf", ".glb", ".obj", ".ply", NULL};
const char* const ty_volume_extensions[] = {".vdb",    ".nvdb", ".nrrd",  ".nhdr", ".vti",    ".vtk",    ".nc",
                                            ".cdf",    ".dcm",  ".dicom", ".ima",  ".nii",    ".nii.gz", ".hdr",
                                            ".hdr.gz", ".tif",  ".tiff",  ".vol",  ".bricks", NULL};

bool ty_has_extension(const char* file, const char* const* extensions) {
    const size_t length = strlen(file);
    for (; *extensions != NULL; ++extensions) {
        const size_t size = strlen(*extensions);
        if (length >= size && strcasecmp(file + length - size, *extensions) == 0) return true;
    }
    return false;
}

/* ---- files ---- */

static ty_result add_digest(ty_scene_reader* reader, uint64_t digest) {
    ty_file_digests* files = &reader->files[reader->section];
    for (size_t i = 0; i < files->count; ++i)
        if (files->values[i] == digest) return TY_OK;
    if (!ty_grow_array(reader->context, (void**)&files->values, &files->capacity, files->count, sizeof digest))
        return TY_ERROR_MEMORY;
    files->values[files->count++] = digest;
    return TY_OK;
}

void ty_free_digests(ty_scene_reader* reader) {
    for (int i = 0; i < TY_SECTIONS; ++i)
        ty_free_array(reader->context, reader->files[i].values, reader->files[i].capacity, sizeof(uint64_t));
}

ty_result ty_find_file(ty_scene_reader* reader, const ty_json_path* json_path, const char* name,
                       const ty_asset_file** file) {
    const bool memory = ty_is_memory_name(name);
    if (reader->folder == NULL && !memory)
        return ty_reader_fail(reader, json_path, TY_ERROR_INPUT, "this scene may not name files");
    char* path = memory ? ty_copy_text(reader->context, name) : ty_join_path(reader->context, reader->folder, name);
    if (path == NULL) return TY_ERROR_MEMORY;
    ty_result result = ty_reader_prefix_error(reader, json_path, ty_assets_file(reader->assets, path, file));
    ty_free_text(reader->context, path);
    return result == TY_OK ? add_digest(reader, (*file)->digest) : result;
}

/* ---- images, meshes, noise ---- */

/* The map of an image, which is destroyed, for `map` to be kept. */
static ty_result keep_map(ty_scene_reader* reader, const ty_json_path* json_path, ty_image* image, ty_asset* map) {
    ty_result result = ty_environment_map_create(reader->context, image, &map->map);
    ty_image_destroy(image);
    result = ty_reader_prefix_error(reader, json_path, result);
    return result == TY_OK ? ty_assets_keep(reader->assets, map) : result;
}

ty_result ty_read_map(ty_scene_reader* reader, const ty_json_path* json_path, const char* name,
                      ty_environment_map** out) {
    ty_asset map = {.kind = TY_ASSET_MAP};
    ty_result result = ty_find_file(reader, json_path, name, &map.file);
    if (result != TY_OK) return result;
    const ty_asset* found = ty_assets_find(reader->assets, &map);
    if (found != NULL) {
        *out = found->map;
        return TY_OK;
    }
    ty_image* image = NULL;
    result = map.file->memory != NULL ? ty_memory_image(reader->assets, map.file, &image)
                                      : ty_image_read(reader->context, map.file->path, &image);
    result = ty_reader_prefix_error(reader, json_path, result);
    if (result == TY_OK) result = keep_map(reader, json_path, image, &map);
    if (result == TY_OK) *out = map.map;
    return result;
}

ty_result ty_make_sky(ty_scene_reader* reader, const ty_json_path* json_path, const ty_sky_def* def,
                      ty_environment_map** out, float sun[3]) {
    ty_asset sky = {.kind = TY_ASSET_SKY, .sky = *def};
    const ty_asset* found = ty_assets_find(reader->assets, &sky);
    ty_result result = TY_OK;
    if (found == NULL) {
        ty_image* image = NULL;
        result = ty_reader_prefix_error(
            reader, json_path,
            ty_sky_create_image_with(reader->context, def, &reader->assets->sky_table, &image, sky.sun));
        if (result == TY_OK) result = keep_map(reader, json_path, image, &sky);
        found = &sky;
    }
    if (result != TY_OK) return result;
    *out = found->map;
    memcpy(sun, found->sun, sizeof found->sun);
    return TY_OK;
}

ty_result ty_find_mesh_file(ty_scene_reader* reader, const ty_json_path* json_path, const char* name,
                            const ty_asset_file** file) {
    if (!ty_has_extension(name, ty_mesh_extensions) && !ty_is_memory_name(name))
        return ty_reader_fail(reader, json_path, TY_ERROR_INPUT,
                              "cannot read meshes of this type; known: .gltf, .glb, .obj, .ply");
    return ty_find_file(reader, json_path, name, file);
}

ty_result ty_read_shell(ty_scene_reader* reader, const ty_json_path* json_path, const ty_asset_file* file,
                        const ty_mesh_file_def* def, ty_closed_mesh** out) {
    ty_asset shell = {.kind = TY_ASSET_SHELL, .file = file, .placement = def->transform, .to_z_up = def->to_z_up};
    const ty_asset* found = ty_assets_find(reader->assets, &shell);
    if (found != NULL) {
        *out = found->shell;
        return TY_OK;
    }
    ty_result result = file->memory != NULL
                           ? ty_memory_closed_mesh(reader->assets, file, def, &shell.shell)
                           : ty_mesh_file_create_closed_mesh(reader->context, file->path, def, &shell.shell);
    result = ty_reader_prefix_error(reader, json_path, result);
    if (result == TY_OK) result = ty_assets_keep(reader->assets, &shell);
    if (result == TY_OK) *out = shell.shell;
    return result;
}

static bool find_grid(const ty_scene_reader* reader, const ty_asset* asset, ty_grid** out) {
    const ty_asset* found = ty_assets_find(reader->assets, asset);
    if (found != NULL) *out = found->grid;
    return found != NULL;
}

/* Keeps a grid that was made, with the result `made`, for a key of the scene file. */
static ty_result keep_grid(ty_scene_reader* reader, const ty_json_path* json_path, ty_result made, ty_asset* asset,
                           ty_grid** out) {
    ty_result result = ty_reader_prefix_error(reader, json_path, made);
    if (result == TY_OK) result = ty_assets_keep(reader->assets, asset);
    if (result == TY_OK) *out = asset->grid;
    return result;
}

ty_result ty_make_noise(ty_scene_reader* reader, const ty_json_path* json_path, const ty_noise_def* def,
                        ty_grid** out) {
    ty_asset asset = {.kind = TY_ASSET_NOISE, .noise = *def};
    if (find_grid(reader, &asset, out)) return TY_OK;
    return keep_grid(reader, json_path, ty_grid_create_noise(reader->context, def, &asset.grid), &asset, out);
}

ty_result ty_make_exponential(ty_scene_reader* reader, const ty_json_path* json_path, const ty_exponential_density* def,
                              ty_grid** out) {
    ty_asset asset = {.kind = TY_ASSET_EXPONENTIAL, .exponential = *def};
    if (find_grid(reader, &asset, out)) return TY_OK;
    const ty_result made = ty_grid_create_exponential(reader->context, reader->up_axis, def->low, def->high,
                                                      def->scale_height, &asset.grid);
    return keep_grid(reader, json_path, made, &asset, out);
}

/* ---- volumes ---- */

/* Size of a file name with its #s replaced. */
enum { NAME_MAX_SIZE = 4096 };

/* True if the file format may hold several named grids. */
static bool has_names(const json_t* volume) {
    static const char* const extensions[] = {".vdb", ".nvdb", ".vti", ".vtk", ".nc", ".cdf", NULL};
    return ty_has_extension(json_string_value(json_object_get(volume, "file")), extensions);
}

/* True for folders and for files of DICOM, which often have no extension. */
static bool is_dicom(const ty_scene_reader* reader, const char* name) {
    char* path = reader->folder != NULL ? ty_join_path(reader->context, reader->folder, name) : NULL;
    const bool found = path != NULL && (ty_is_folder(path) || ty_is_dicom_file(path));
    ty_free_text(reader->context, path);
    return found;
}

/* Known formats describe their content; other files need "raw". */
static ty_result check_volume_type(const ty_scene_reader* reader, const json_t* volume, const ty_json_path* json_path) {
    const ty_json_path grid = ty_json_path_key(json_path, "grid"), series = ty_json_path_key(json_path, "series");
    if (json_object_get(volume, "grid") != NULL && !has_names(volume))
        return ty_reader_fail(reader, &grid, TY_ERROR_INPUT,
                              "is for .vdb, .nvdb, .vti, .vtk and .nc files; others hold one grid");
    const char* name = json_string_value(json_object_get(volume, "file"));
    const bool dicom = is_dicom(reader, name);
    const bool known = dicom || ty_has_extension(name, ty_volume_extensions) || ty_is_memory_name(name);
    if (json_object_get(volume, "series") != NULL && !dicom)
        return ty_reader_fail(reader, &series, TY_ERROR_INPUT, "is for folders and files of DICOM");
    const bool raw = json_object_get(volume, "raw") != NULL;
    const ty_json_path key = ty_json_path_key(json_path, raw ? "raw" : "file");
    if (known && raw)
        return ty_reader_fail(reader, &key, TY_ERROR_INPUT, "is for raw files; this one tells what it holds");
    if (known || raw) return TY_OK;
    return ty_reader_fail(reader, &key, TY_ERROR_INPUT,
                          "cannot read volumes of this type; known: .vdb, .nvdb, .nrrd, .nhdr, .vti, .vtk, .nc, "
                          ".dcm and folders of DICOM, .nii, .nii.gz, .hdr, .tif, .vol, .bricks, and any file with the "
                          "key \"raw\" beside it");
}

/* A number, or the name of a variable. */
static void read_companion(const json_t* object, const char* key, double* number, const char** name) {
    *name = json_string_value(json_object_get(object, key));
    ty_read_number(object, key, number);
}

static ty_result check_droplets(const ty_scene_reader* reader, const json_t* volume, const ty_json_path* json_path,
                                const char* grid_name) {
    static const char* const extensions[] = {".nc", ".cdf", NULL};
    const ty_json_path key = ty_json_path_key(json_path, "droplets");
    if (json_object_get(volume, "droplets") == NULL) return TY_OK;
    if (!ty_has_extension(json_string_value(json_object_get(volume, "file")), extensions))
        return ty_reader_fail(reader, &key, TY_ERROR_INPUT, "is for liquid water in .nc files");
    return strcmp(grid_name, "density") == 0
               ? TY_OK
               : ty_reader_fail(reader, &key, TY_ERROR_INPUT, "is for a density; droplets make an extinction");
}

static ty_grid_storage read_storage(const json_t* volume) {
    const char* name = json_string_value(json_object_get(volume, "storage"));
    if (name == NULL || strcmp(name, "auto") == 0) return TY_GRID_AUTO;
    if (strcmp(name, "paged") == 0) return TY_GRID_PAGED;
    return strcmp(name, "sparse") == 0 ? TY_GRID_SPARSE : TY_GRID_DENSE;
}

static ty_volume_def describe_volume(const ty_scene_reader* reader, const json_t* volume, const char* grid_name) {
    static const char* const exact[] = {".vdb", ".nvdb", NULL}; /* whose names are binding anyway */
    ty_volume_def def = ty_default_volume_def();
    const char* name = json_string_value(json_object_get(volume, "grid"));
    def.grid = name != NULL ? name : has_names(volume) ? grid_name : "";
    def.exact_grid = name != NULL && !ty_has_extension(json_string_value(json_object_get(volume, "file")), exact);
    def.meters_per_unit = reader->unit;
    def.storage = read_storage(volume);
    const json_t* droplets = json_object_get(volume, "droplets");
    read_companion(droplets, "effective_radius", &def.droplet_radius, &def.effective_radius);
    read_companion(droplets, "air_density", &def.air_density_value, &def.air_density);
    def.frame = reader->frame;
    ty_read_int(volume, "frame", &def.frame);
    ty_read_int(volume, "component", &def.component);
    const char* series = json_string_value(json_object_get(volume, "series"));
    if (series != NULL) def.series = series;
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

static ty_result read_grid(ty_scene_reader* reader, const ty_json_path* json_path, const ty_asset_file* file,
                           const ty_volume_def* def, double* radius, ty_grid** out) {
    if (file->memory != NULL)
        return ty_reader_prefix_error(reader, json_path, ty_memory_grid(reader->assets, file, def->component, out));
    ty_asset volume = {.kind = TY_ASSET_GRID, .file = file, .volume = *def};
    const ty_asset* found = ty_assets_find(reader->assets, &volume);
    if (found != NULL) {
        *radius = found->droplet_radius;
        *out = found->grid;
        return TY_OK;
    }
    ty_result result = ty_reader_prefix_error(
        reader, json_path,
        ty_volume_read_droplets(reader->context, file->path, def, &volume.droplet_radius, &volume.grid));
    if (result == TY_OK) result = ty_assets_keep(reader->assets, &volume);
    if (result != TY_OK) return result;
    *radius = volume.droplet_radius;
    *out = volume.grid;
    return TY_OK;
}

static ty_result count_components(ty_scene_reader* reader, const ty_json_path* json_path, const ty_asset_file* file,
                                  const ty_volume_def* def, int32_t* components) {
    if (file->memory != NULL)
        return ty_reader_prefix_error(reader, json_path, ty_memory_components(reader->assets, file, components));
    ty_asset volume = {.kind = TY_ASSET_COMPONENTS, .file = file, .volume = *def};
    const ty_asset* found = ty_assets_find(reader->assets, &volume);
    if (found != NULL) {
        *components = found->components;
        return TY_OK;
    }
    ty_result result = ty_volume_components(reader->context, file->path, def, &volume.components);
    result = ty_reader_prefix_error(reader, json_path, result);
    *components = volume.components;
    return result == TY_OK ? ty_assets_keep(reader->assets, &volume) : result;
}

/* Validation before a volume is read, its file with the frame number, and its values per voxel (1 if one component
 * was requested). */
static ty_result open_volume(ty_scene_reader* reader, const json_t* volume, const ty_json_path* json_path,
                             const char* grid_name, bool filling, ty_volume_def* def, const ty_asset_file** file,
                             int32_t* components) {
    const ty_json_path file_json_path = ty_json_path_key(json_path, "file");
    ty_result result = check_volume_type(reader, volume, json_path);
    if (result == TY_OK) result = check_droplets(reader, volume, json_path, grid_name);
    if (result != TY_OK) return result;
    if (def->raw_size[0] > 0 && !(def->raw_spacing[0] > 0) && !filling)
        return ty_reader_fail(reader, json_path, TY_ERROR_INPUT,
                              "a raw volume without spacing needs bounds that are a box, [[x,y,z],[x,y,z]]");
    char name[NAME_MAX_SIZE];
    result = ty_volume_path(reader->context, json_string_value(json_object_get(volume, "file")), def->frame, name,
                            sizeof name);
    result = ty_reader_prefix_error(reader, &file_json_path, result);
    if (result == TY_OK) result = ty_find_file(reader, &file_json_path, name, file);
    if (result != TY_OK) return result;
    *components = 1;
    if (json_object_get(volume, "component") != NULL) return TY_OK;
    return count_components(reader, &file_json_path, *file, def, components);
}

ty_result ty_read_droplets(ty_scene_reader* reader, const json_t* volume, const ty_json_path* json_path,
                           const char* grid_name, bool filling, double* radius, ty_grid** out) {
    ty_volume_def def = describe_volume(reader, volume, grid_name);
    const ty_json_path file_json_path = ty_json_path_key(json_path, "file");
    const ty_asset_file* file = NULL;
    int32_t components = 1;
    ty_result result = open_volume(reader, volume, json_path, grid_name, filling, &def, &file, &components);
    if (result != TY_OK) return result;
    if (components > 1)
        return ty_reader_fail(reader, json_path, TY_ERROR_INPUT,
                              "the volume has %d values per voxel; the key \"component\" is missing", (int)components);
    return read_grid(reader, &file_json_path, file, &def, radius, out);
}

ty_result ty_read_volume(ty_scene_reader* reader, const json_t* volume, const ty_json_path* json_path,
                         const char* grid_name, bool filling, ty_grid** out) {
    double radius = 0;
    return ty_read_droplets(reader, volume, json_path, grid_name, filling, &radius, out);
}

ty_result ty_read_volume_rgb(ty_scene_reader* reader, const json_t* volume, const ty_json_path* json_path,
                             const char* grid_name, bool filling, ty_grid* out[3]) {
    ty_volume_def def = describe_volume(reader, volume, grid_name);
    const ty_json_path file_json_path = ty_json_path_key(json_path, "file");
    const ty_asset_file* file = NULL;
    int32_t components = 1;
    double radius = 0;
    ty_result result = open_volume(reader, volume, json_path, grid_name, filling, &def, &file, &components);
    if (result != TY_OK) return result;
    if (components != 1 && components != 3)
        return ty_reader_fail(reader, json_path, TY_ERROR_INPUT,
                              "the volume has %d values per voxel, not 1 or 3; the key \"component\" is missing",
                              (int)components);
    ty_grid* grids[3] = {NULL, NULL, NULL};
    for (int32_t c = 0; c < components && result == TY_OK; ++c) {
        if (components == 3) def.component = c;
        result = read_grid(reader, &file_json_path, file, &def, &radius, &grids[c]);
    }
    for (int c = 0; c < 3 && result == TY_OK; ++c) out[c] = grids[components == 3 ? c : 0];
    return result;
}
