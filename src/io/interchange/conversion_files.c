/* Files that a conversion reads, refers to and writes. */
#define _XOPEN_SOURCE 700
#include "io/interchange/conversion.h"

#include "base/context.h"
#include "io/file.h"
#include "io/volumes/inflate.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- reading ---- */

#define FILE_MAX ((size_t)1 << 34)

static ty_result refuse(ty_conversion* conversion, const char* location, const char* name) {
    return ty_fail(conversion->context, TY_ERROR_INPUT, "%s: no files may be named here, as \"%.200s\" is", location,
                   name);
}

/* Inflates a gzip file, whose last four bytes tell its length up to 4 GiB. */
static ty_result inflate_file(ty_conversion* conversion, const char* path, uint8_t** bytes, size_t* size) {
    const uint8_t* tail = *bytes + *size - 4;
    const size_t length = (size_t)tail[0] | (size_t)tail[1] << 8 | (size_t)tail[2] << 16 | (size_t)tail[3] << 24;
    if (length / TY_INFLATE_RATIO_MAX > *size)
        return ty_fail(conversion->context, TY_ERROR_INPUT, "%s: the compressed data are damaged", path);
    uint8_t* inflated = ty_alloc_array(conversion->context, length + 1, 1, false);
    if (inflated == NULL) return TY_ERROR_MEMORY;
    uint64_t got = 0;
    if (ty_inflate_gzip(*bytes, *size, 0, inflated, length, &got) != TY_INFLATED_WHOLE) {
        ty_free_file(conversion->context, inflated, length);
        return ty_fail(conversion->context, TY_ERROR_INPUT, "%s: the compressed data are damaged", path);
    }
    inflated[length] = 0;
    ty_free_file(conversion->context, *bytes, *size);
    *bytes = inflated;
    *size = length;
    return TY_OK;
}

ty_result ty_conversion_read_file(ty_conversion* conversion, const char* location, const char* name, uint8_t** bytes,
                                  size_t* size) {
    char *path = NULL, *reference = NULL;
    *bytes = NULL;
    ty_result result = ty_conversion_find_file(conversion, location, name, &path, &reference);
    ty_free_text(conversion->context, reference);
    if (result != TY_OK || path == NULL) return result;
    result = ty_read_file(conversion->context, path, FILE_MAX, bytes, size);
    if (result == TY_OK && *size > 18 && (*bytes)[0] == 0x1f && (*bytes)[1] == 0x8b) {
        result = inflate_file(conversion, path, bytes, size);
        if (result != TY_OK) {
            ty_free_file(conversion->context, *bytes, *size);
            *bytes = NULL;
        }
    }
    ty_free_text(conversion->context, path);
    return result;
}

/* ---- references ---- */

/* The path from one absolute folder to a file: "../" for each folder to leave. Lengths are below PATH_MAX. */
static void relate(const char* folder, const char* path, char* out, size_t size) {
    size_t common = 0;
    for (size_t i = 0;; ++i) {
        const bool folder_ends = folder[i] == '/' || folder[i] == '\0', path_ends = path[i] == '/' || path[i] == '\0';
        if (folder_ends && path_ends) common = i;
        if (folder[i] != path[i] || folder[i] == '\0') break;
    }
    size_t used = 0;
    out[0] = '\0';
    for (const char* at = folder + common; *at != '\0'; ++at)
        if (*at == '/' && at[1] != '\0' && used + 4 < size) used += (size_t)snprintf(out + used, size - used, "../");
    const char* rest = path + common;
    while (*rest == '/') ++rest;
    snprintf(out + used, size - used, "%s", rest);
}

static char* refer(ty_conversion* conversion, const char* path) {
    if (conversion->output == NULL) return ty_copy_text(conversion->context, path);
    char* folder = ty_folder_of(conversion->context, conversion->output);
    if (folder == NULL) return NULL;
    char* from = realpath(folder[0] == '\0' ? "." : folder, NULL);
    char* to = realpath(path, NULL);
    char text[2 * PATH_MAX];
    if (from != NULL && to != NULL)
        relate(from, to, text, sizeof text);
    else
        snprintf(text, sizeof text, "%s", path);
    free(from);
    free(to);
    ty_free_text(conversion->context, folder);
    return ty_copy_text(conversion->context, text);
}

ty_result ty_conversion_find_file(ty_conversion* conversion, const char* location, const char* name, char** path,
                                  char** reference) {
    *path = *reference = NULL;
    if (conversion->folder == NULL) return refuse(conversion, location, name);
    char* joined = ty_join_path(conversion->context, conversion->folder, name);
    if (joined == NULL) return TY_ERROR_MEMORY;
    struct stat state;
    if (stat(joined, &state) != 0 || !S_ISREG(state.st_mode)) {
        const int error = errno;
        ty_free_text(conversion->context, joined);
        if (!conversion->partial)
            return ty_fail(conversion->context, TY_ERROR_INPUT, "%s: the file \"%.200s\" cannot be read: %s", location,
                           name, strerror(error));
        ty_conversion_leave_out(conversion, "the file \"%.200s\", which is missing", name);
        return TY_OK;
    }
    *reference = refer(conversion, joined);
    *path = joined;
    if (*reference != NULL) return TY_OK;
    ty_free_text(conversion->context, joined);
    *path = NULL;
    return TY_ERROR_MEMORY;
}

ty_result ty_conversion_new_file(ty_conversion* conversion, const char* kind, const char* extension, char** path,
                                 char** reference) {
    *path = *reference = NULL;
    if (conversion->output == NULL) return TY_OK;
    if (!conversion->files_made && mkdir(conversion->files, 0777) != 0 && errno != EEXIST)
        return ty_fail(conversion->context, TY_ERROR_FILE, "cannot make the folder %s: %s", conversion->files,
                       strerror(errno));
    conversion->files_made = true;
    char name[64];
    snprintf(name, sizeof name, "%s_%d%s", kind, ++conversion->file_count, extension);
    *path = ty_join_path(conversion->context, conversion->files, name);
    *reference = ty_join_path(conversion->context, conversion->files_name, name);
    if (*path != NULL && *reference != NULL) return TY_OK;
    ty_free_text(conversion->context, *path);
    ty_free_text(conversion->context, *reference);
    *path = *reference = NULL;
    return TY_ERROR_MEMORY;
}

/* ---- writing ---- */

/* Gives up the name of a file that could not be written. */
static ty_result close_file(ty_conversion* conversion, ty_result result, char* path, char** reference) {
    ty_free_text(conversion->context, path);
    if (result == TY_OK) return TY_OK;
    ty_free_text(conversion->context, *reference);
    *reference = NULL;
    return result;
}

ty_result ty_conversion_write_exr(ty_conversion* conversion, const ty_image* image, char** reference) {
    char* path = NULL;
    ty_result result = ty_conversion_new_file(conversion, "environment", ".exr", &path, reference);
    if (result == TY_OK && path != NULL) result = ty_image_write_exr(conversion->context, image, path);
    return close_file(conversion, result, path, reference);
}

/* Decodes sRGB (IEC 61966-2-1). */
static float from_srgb(float x) {
    return x <= 0.04045f ? x / 12.92f : powf((x + 0.055f) / 1.055f, 2.4f);
}

ty_result ty_conversion_write_png(ty_conversion* conversion, ty_image* image, bool linear, char** reference) {
    char* path = NULL;
    ty_result result = ty_conversion_new_file(conversion, "texture", ".png", &path, reference);
    const size_t count = (size_t)ty_image_width(image) * (size_t)ty_image_height(image);
    if (linear)
        for (int32_t c = 0; c < ty_image_channel_count(image); ++c) {
            float* plane = ty_image_plane(image, c);
            for (size_t i = 0; i < count; ++i) plane[i] = from_srgb(fminf(fmaxf(plane[i], 0), 1));
        }
    if (result == TY_OK && path != NULL) result = ty_image_write_png(conversion->context, image, 0, TY_TONE_CLIP, path);
    return close_file(conversion, result, path, reference);
}

/* A grid whose first voxel's centre is half a voxel inside of the box, and 0 outside of it. */
static ty_result make_grid(ty_context* context, const int32_t size[3], const float* values, const double box[2][3],
                           ty_grid** out) {
    ty_grid_def def = ty_default_grid_def();
    def.values = values;
    def.placed = true;
    for (int a = 0; a < 3; ++a) {
        const double spacing = (box[1][a] - box[0][a]) / size[a];
        def.size[a] = size[a];
        def.index_to_local.m[5 * a] = spacing;
        def.index_to_local.m[4 * a + 3] = box[0][a] + 0.5 * spacing;
    }
    return ty_grid_create(context, &def, out);
}

ty_result ty_conversion_write_volume(ty_conversion* conversion, const char* grid, const int32_t size[3],
                                     const float* const values[3], int components, const double box[2][3],
                                     char** reference) {
    char* path = NULL;
    ty_grid* grids[3] = {NULL, NULL, NULL};
    ty_result result = ty_conversion_new_file(conversion, "volume", ".vdb", &path, reference);
    for (int c = 0; c < components && result == TY_OK; ++c)
        result = make_grid(conversion->context, size, values[c], box, &grids[c]);
    const ty_volume_field field = {.name = grid, .components = components, .grids = {grids[0], grids[1], grids[2]}};
    if (result == TY_OK && path != NULL) result = ty_volume_write(conversion->context, &field, 1, NULL, path);
    for (int c = 0; c < 3; ++c) ty_grid_release(grids[c]);
    return close_file(conversion, result, path, reference);
}
