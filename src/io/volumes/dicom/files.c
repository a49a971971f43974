/* DICOM files of a folder. */
#define _DEFAULT_SOURCE
#include "io/volumes/dicom/dicom.h"

#include "base/context.h"
#include "io/file.h"

#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

bool ty_is_dicom_file(const char* path) {
    enum { HEAD_SIZE = 132 };
    uint8_t head[HEAD_SIZE];
    return ty_is_dicom(head, ty_read_head(path, head, sizeof head));
}

static int compare_paths(const void* a, const void* b) {
    return strcmp(*(char* const*)a, *(char* const*)b);
}

/* Adds a file to the list, which owns its path from then on. */
static ty_result add_path(ty_context* context, char* path, ty_dicom_list* out) {
    if (path != NULL && ty_grow_array(context, (void**)&out->paths, &out->capacity, out->count, sizeof(char*))) {
        out->paths[out->count++] = path;
        return TY_OK;
    }
    ty_free_text(context, path);
    return TY_ERROR_MEMORY;
}

static ty_result read_folder(ty_context* context, DIR* stream, const char* folder, ty_dicom_list* out) {
    enum { FILES_MAX = 1 << 15 };
    for (const struct dirent* entry; (entry = readdir(stream)) != NULL;) {
        if (entry->d_name[0] == '.') continue;
        char* path = ty_join_path(context, folder, entry->d_name);
        if (path == NULL) return TY_ERROR_MEMORY;
        if (!ty_is_dicom_file(path)) {
            ty_free_text(context, path);
            continue;
        }
        const ty_result result = add_path(context, path, out);
        if (result != TY_OK) return result;
        if (out->count > FILES_MAX)
            return ty_fail(context, TY_ERROR_INPUT, "%s: more than %d DICOM files", folder, FILES_MAX);
    }
    return TY_OK;
}

ty_result ty_dicom_list_files(ty_context* context, const char* path, ty_dicom_list* out) {
    *out = (ty_dicom_list){0};
    const bool folder_given = ty_is_folder(path);
    char* folder = folder_given ? ty_copy_text(context, path) : ty_folder_of(context, path);
    if (folder == NULL) return TY_ERROR_MEMORY;
    DIR* stream = opendir(folder[0] != '\0' ? folder : ".");
    ty_result result = TY_OK;
    if (stream == NULL)
        result = ty_fail(context, errno == ENOMEM ? TY_ERROR_MEMORY : TY_ERROR_FILE, "cannot open %s: %s",
                         folder[0] != '\0' ? folder : ".", strerror(errno));
    if (result == TY_OK) {
        result = read_folder(context, stream, folder, out);
        closedir(stream);
    }
    ty_free_text(context, folder);
    if (result == TY_OK && out->count > 1) qsort(out->paths, out->count, sizeof(char*), compare_paths);
    return result;
}

void ty_dicom_free_list(ty_context* context, ty_dicom_list* list) {
    for (size_t i = 0; i < list->count; ++i) ty_free_text(context, list->paths[i]);
    ty_free_array(context, list->paths, list->capacity, sizeof(char*));
    *list = (ty_dicom_list){0};
}
