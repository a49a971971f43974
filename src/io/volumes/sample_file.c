/* Raw voxel samples in a file: the parts that a grid is made of in turn. */
#define _POSIX_C_SOURCE 200809L
#include "io/volumes/sample_file.h"

#include "base/context.h"
#include "io/file.h"

#include <errno.h>
#include <string.h>

ty_result ty_sample_file_open(ty_context* context, const char* path, uint64_t start, ty_sample_file* file) {
    uint64_t size = 0;
    *file = (ty_sample_file){.context = context, .path = path, .start = start};
    return ty_open_file(context, path, &file->stream, &size);
}

static bool reserve(ty_sample_file* file, size_t size) {
    if (size <= file->capacity) return true;
    ty_free_array(file->context, file->bytes, file->capacity, 1);
    file->bytes = ty_alloc_array(file->context, size, 1, false);
    file->capacity = file->bytes != NULL ? size : 0;
    return file->bytes != NULL;
}

ty_result ty_sample_file_read(void* user, size_t at, size_t size, const uint8_t** bytes) {
    ty_sample_file* file = user;
    if (!reserve(file, size)) return TY_ERROR_MEMORY;
    errno = 0;
    if (fseeko(file->stream, (off_t)(file->start + at), SEEK_SET) != 0 ||
        fread(file->bytes, 1, size, file->stream) != size) {
        const char* cause = errno != 0 ? strerror(errno) : "it became shorter meanwhile";
        return ty_fail(file->context, TY_ERROR_FILE, "cannot read %s: %s", file->path, cause);
    }
    *bytes = file->bytes;
    return TY_OK;
}

void ty_sample_file_close(ty_sample_file* file) {
    ty_free_array(file->context, file->bytes, file->capacity, 1);
    fclose(file->stream);
}
