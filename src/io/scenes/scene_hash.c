/* Hashes of files including the files that they reference. References that cannot be resolved are skipped here; the
 * readers report them. */
#include "base/context.h"
#include "io/file.h"
#include "io/meshes/gltf.h"
#include "io/scenes/scene_reader.h"
#include "io/volumes/dicom/dicom.h"
#include "io/volumes/nifti/nifti.h"
#include "io/volumes/volume_file.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

enum { LINE_SIZE = 4096, GLTF_SIZE_MAX = 1 << 30 };

/* Path of a file referenced by the file at path, NULL if it does not exist; freed with ty_free_text. */
static ty_result find_named(ty_context* context, const char* path, const char* name, char** out) {
    *out = NULL;
    char* folder = ty_folder_of(context, path);
    char* found = folder != NULL ? ty_join_path(context, folder, name) : NULL;
    ty_free_text(context, folder);
    if (found == NULL) return TY_ERROR_MEMORY;
    struct stat status;
    if (stat(found, &status) == 0 && S_ISREG(status.st_mode))
        *out = found;
    else
        ty_free_text(context, found);
    return TY_OK;
}

/* ---- glTF ---- */

static ty_result hash_uris(ty_context* context, const char* path, const json_t* items, uint64_t* hash) {
    size_t i;
    json_t* item;
    ty_result result = TY_OK;
    json_array_foreach(items, i, item) {
        const char* uri = json_string_value(json_object_get(item, "uri"));
        if (uri == NULL || strncmp(uri, "data:", 5) == 0) continue;
        char name[LINE_SIZE], *found = NULL;
        snprintf(name, sizeof name, "%s", uri);
        if (ty_gltf_decode_percent(name)) result = find_named(context, path, name, &found);
        if (found != NULL) result = ty_hash_file(context, found, hash);
        ty_free_text(context, found);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

static ty_result hash_gltf_names(ty_context* context, const char* path, uint64_t* hash) {
    uint8_t* bytes = NULL;
    size_t size = 0;
    ty_result result = ty_read_file(context, path, GLTF_SIZE_MAX, &bytes, &size);
    if (result != TY_OK) return result;
    json_t* root = json_loadb((const char*)bytes, size, 0, NULL);
    ty_free_file(context, bytes, size);
    result = hash_uris(context, path, json_object_get(root, "buffers"), hash);
    if (result == TY_OK) result = hash_uris(context, path, json_object_get(root, "images"), hash);
    json_decref(root);
    return result;
}

/* ---- text files ---- */

/* The rest of a line after one of the keys (a list ended by NULL), or its last word if options precede it, as in
 * "-clamp on a.png". NULL if the line begins with none of them. The line is modified. */
static char* name_after(char* line, const char* const* keys) {
    char* start = line + strspn(line, " \t");
    start[strcspn(start, "\r\n")] = '\0';
    while (*keys != NULL && strncasecmp(start, *keys, strlen(*keys)) != 0) ++keys;
    if (*keys == NULL) return NULL;
    char* name = start + strlen(*keys);
    name += strspn(name, " \t");
    char* end = name + strlen(name);
    while (end > name && (end[-1] == ' ' || end[-1] == '\t')) *--end = '\0';
    char* last = strrchr(name, ' ');
    if (*name == '-' && last != NULL) name = last + 1;
    for (char* at = name; *at != '\0'; ++at)
        if (*at == '\\') *at = '/';
    return *name != '\0' ? name : NULL;
}

static ty_result hash_lines(ty_context* context, const char* path, const char* const* keys,
                            const char* const* inner_keys, uint64_t* hash) {
    FILE* stream = NULL;
    uint64_t size = 0;
    ty_result result = ty_open_file(context, path, &stream, &size);
    if (result != TY_OK) return result;
    char line[LINE_SIZE];
    while (result == TY_OK && fgets(line, sizeof line, stream) != NULL) {
        const char* name = name_after(line, keys);
        char* found = NULL;
        if (name != NULL) result = find_named(context, path, name, &found);
        if (found == NULL) continue;
        result = ty_hash_file(context, found, hash);
        if (result == TY_OK && inner_keys != NULL) result = hash_lines(context, found, inner_keys, NULL, hash);
        ty_free_text(context, found);
    }
    fclose(stream);
    return result;
}

/* ---- volumes ---- */

/* All DICOM files of a folder, or of that of a file. */
static ty_result hash_series(ty_context* context, const char* path, uint64_t* hash) {
    ty_dicom_list list;
    ty_result result = ty_dicom_list_files(context, path, &list);
    for (size_t i = 0; i < list.count && result == TY_OK; ++i) result = ty_hash_file(context, list.paths[i], hash);
    ty_dicom_free_list(context, &list);
    return result;
}

/* The voxels of a NIfTI pair. */
static ty_result hash_image(ty_context* context, const char* path, uint64_t* hash) {
    char* image = ty_nifti_image_path(context, path);
    if (image == NULL) return TY_ERROR_MEMORY;
    struct stat status;
    const bool there = strcmp(image, path) != 0 && stat(image, &status) == 0 && S_ISREG(status.st_mode);
    const ty_result result = there ? ty_hash_file(context, image, hash) : TY_OK;
    ty_free_text(context, image);
    return result;
}

ty_result ty_hash_file_and_names(ty_context* context, const char* path, uint64_t* hash) {
    static const char *const gltf[] = {".gltf", NULL}, *const obj[] = {".obj", NULL}, *const nhdr[] = {".nhdr", NULL};
    static const char* const libraries[] = {"mtllib ", "mtllib\t", NULL};
    static const char* const maps[] = {"map_Kd ", "map_Ke ", NULL};
    static const char* const data[] = {"data file:", "datafile:", NULL};
    static const char* const pair[] = {".hdr", ".hdr.gz", NULL};
    if (ty_is_folder(path) || ty_is_dicom_file(path)) return hash_series(context, path, hash);
    if (ty_bricks_hash(path, hash)) return TY_OK;
    const ty_result result = ty_hash_file(context, path, hash);
    if (result != TY_OK) return result;
    if (ty_has_extension(path, gltf)) return hash_gltf_names(context, path, hash);
    if (ty_has_extension(path, obj)) return hash_lines(context, path, libraries, maps, hash);
    if (ty_has_extension(path, nhdr)) return hash_lines(context, path, data, NULL, hash);
    if (ty_has_extension(path, pair)) return hash_image(context, path, hash);
    return TY_OK;
}
