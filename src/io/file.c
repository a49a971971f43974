/* Whole files: reading with a size limit, writing through a temporary file, hashing, joining paths. */
#define _POSIX_C_SOURCE 200809L
#include "io/file.h"

#include "base/context.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>
#include <tyndall/io.h>
#include <unistd.h>

enum { HASH_CHUNK = 1 << 16, NAME_TRIES = 1000 };

/* O_NONBLOCK: opening a pipe for reading would block until it has a writer. It has no effect on regular files. */
FILE* ty_open_regular(const char* path, uint64_t* size) {
    const int descriptor = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (descriptor < 0) return NULL;
    struct stat status;
    const bool known = fstat(descriptor, &status) == 0;
    FILE* stream = known && S_ISREG(status.st_mode) ? fdopen(descriptor, "rb") : NULL;
    if (stream == NULL) {
        const int reason = !known || S_ISREG(status.st_mode) ? errno : 0;
        close(descriptor);
        errno = reason;
        return NULL;
    }
    *size = (uint64_t)status.st_size;
    return stream;
}

ty_result ty_open_file(ty_context* context, const char* path, FILE** stream, uint64_t* size) {
    if (path == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "a file name is NULL");
    *stream = ty_open_regular(path, size);
    if (*stream != NULL) return TY_OK;
    return ty_fail(context, TY_ERROR_FILE, "cannot open %s: %s", path,
                   errno != 0 ? strerror(errno) : "not a regular file");
}

ty_result ty_read_file(ty_context* context, const char* path, size_t limit, uint8_t** bytes, size_t* size) {
    FILE* stream = NULL;
    uint64_t length = 0;
    const ty_result opened = ty_open_file(context, path, &stream, &length);
    if (opened != TY_OK) return opened;
    if (length > limit) {
        fclose(stream);
        return ty_fail(context, TY_ERROR_INPUT, "%s: %llu bytes, more than the limit of %zu", path,
                       (unsigned long long)length, limit);
    }
    uint8_t* content = ty_alloc_array(context, (size_t)length + 1, 1, false);
    if (content == NULL) {
        fclose(stream);
        return TY_ERROR_MEMORY;
    }
    errno = 0;
    const size_t got = fread(content, 1, (size_t)length, stream);
    const int reason = errno;
    fclose(stream);
    if (got != length) {
        ty_free_array(context, content, (size_t)length + 1, 1);
        return ty_fail(context, TY_ERROR_FILE, "cannot read %s: %s", path,
                       reason != 0 ? strerror(reason) : "it became shorter meanwhile");
    }
    content[length] = 0;
    *bytes = content;
    *size = (size_t)length;
    return TY_OK;
}

void ty_free_file(ty_context* context, uint8_t* bytes, size_t size) {
    ty_free_array(context, bytes, size + 1, 1);
}

static void free_names(ty_context* context, ty_output* output) {
    ty_free_text(context, output->path);
    ty_free_text(context, output->temporary);
    *output = (ty_output){0};
}

static char* temporary_name(ty_context* context, const char* path, int number) {
    char suffix[48];
    snprintf(suffix, sizeof suffix, ".%ld-%d.tmp", (long)getpid(), number);
    const char* slash = strrchr(path, '/');
    const size_t start = slash == NULL ? 0 : (size_t)(slash - path) + 1, suffix_length = strlen(suffix);
    size_t length = strlen(path);
    /* The longest names lose their end, so that there is room for the suffix. */
    if (length - start > NAME_MAX - suffix_length) length = start + NAME_MAX - suffix_length;
    char* name = ty_alloc_array(context, length + suffix_length + 1, 1, false);
    if (name == NULL) return NULL;
    memcpy(name, path, length);
    memcpy(name + length, suffix, suffix_length + 1);
    return name;
}

ty_result ty_output_open(ty_context* context, const char* path, ty_output* output) {
    if (path == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "a file name is NULL");
    /* A rename onto a device would replace it; onto a folder it would fail only at the end. */
    struct stat status;
    if (stat(path, &status) == 0 && !S_ISREG(status.st_mode))
        return ty_fail(context, TY_ERROR_FILE, "cannot write %s: not a regular file", path);
    ty_output made = {.path = ty_copy_text(context, path)};
    if (made.path == NULL) return TY_ERROR_MEMORY;
    int descriptor = -1;
    for (int number = 0; number < NAME_TRIES; ++number) {
        made.temporary = temporary_name(context, path, number);
        if (made.temporary == NULL) {
            free_names(context, &made);
            return TY_ERROR_MEMORY;
        }
        descriptor = open(made.temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor >= 0 || errno != EEXIST) break;
        ty_free_text(context, made.temporary);
        made.temporary = NULL;
    }
    if (descriptor >= 0) made.stream = fdopen(descriptor, "w+b");
    if (made.stream == NULL) {
        const ty_result result = ty_fail(context, TY_ERROR_FILE, "cannot write %s: %s", path, strerror(errno));
        if (descriptor >= 0) {
            close(descriptor);
            remove(made.temporary);
        }
        free_names(context, &made);
        return result;
    }
    *output = made;
    return TY_OK;
}

ty_result ty_output_commit(ty_context* context, ty_output* output) {
    errno = 0;
    bool good = fflush(output->stream) == 0 && !ferror(output->stream);
    int reason = errno;
    if (fclose(output->stream) != 0 && good) {
        good = false;
        reason = errno;
    }
    if (good && rename(output->temporary, output->path) != 0) {
        good = false;
        reason = errno;
    }
    ty_result result = TY_OK;
    if (!good) {
        remove(output->temporary);
        result = ty_fail(context, TY_ERROR_FILE, "cannot write %s: %s", output->path,
                         reason != 0 ? strerror(reason) : "writing failed");
    }
    free_names(context, output);
    return result;
}

void ty_output_discard(ty_context* context, ty_output* output) {
    fclose(output->stream);
    remove(output->temporary);
    free_names(context, output);
}

ty_result ty_write_file(ty_context* context, const char* path, const void* bytes, size_t size) {
    ty_output output;
    const ty_result result = ty_output_open(context, path, &output);
    if (result != TY_OK) return result;
    /* A short write sets the stream's error flag, which the commit checks. */
    if (size > 0) fwrite(bytes, 1, size, output.stream);
    return ty_output_commit(context, &output);
}

ty_result ty_bytes_read(ty_context* context, const char* path, size_t limit, uint8_t** bytes, size_t* size) {
    if (bytes == NULL || size == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_bytes_read: bytes or size is NULL");
    return ty_read_file(context, path, limit, bytes, size);
}

void ty_bytes_destroy(ty_context* context, uint8_t* bytes, size_t size) {
    ty_free_file(context, bytes, size);
}

ty_result ty_bytes_write(ty_context* context, const char* path, const void* bytes, size_t size) {
    if (bytes == NULL && size > 0) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_bytes_write: bytes is NULL");
    return ty_write_file(context, path, bytes, size);
}

uint64_t ty_hash_bytes(uint64_t hash, const void* bytes, size_t size) {
    const uint8_t* p = bytes;
    for (size_t i = 0; i < size; ++i) hash = (hash ^ p[i]) * 0x100000001b3ull;
    return hash;
}

ty_result ty_hash_file(ty_context* context, const char* path, uint64_t* hash) {
    FILE* stream = NULL;
    uint64_t length = 0;
    ty_result result = ty_open_file(context, path, &stream, &length);
    if (result != TY_OK) return result;
    uint8_t* chunk = ty_alloc_array(context, HASH_CHUNK, 1, false);
    if (chunk == NULL) {
        fclose(stream);
        return TY_ERROR_MEMORY;
    }
    uint64_t value = *hash;
    size_t got;
    while ((got = fread(chunk, 1, HASH_CHUNK, stream)) > 0) value = ty_hash_bytes(value, chunk, got);
    if (ferror(stream))
        result = ty_fail(context, TY_ERROR_FILE, "cannot read %s: %s", path, strerror(errno));
    else
        *hash = value;
    ty_free_array(context, chunk, HASH_CHUNK, 1);
    fclose(stream);
    return result;
}

char* ty_join_path(ty_context* context, const char* folder, const char* relative) {
    if (relative[0] == '/' || folder == NULL || folder[0] == '\0') return ty_copy_text(context, relative);
    const size_t length = strlen(folder);
    const size_t rest = strlen(relative);
    char* joined = ty_alloc_array(context, length + rest + 2, 1, false);
    if (joined == NULL) return NULL;
    memcpy(joined, folder, length);
    joined[length] = '/';
    memcpy(joined + length + 1, relative, rest + 1);
    return joined;
}

char* ty_folder_of(ty_context* context, const char* path) {
    const char* slash = strrchr(path, '/');
    if (slash == NULL) return ty_copy_text(context, "");
    const size_t length = slash == path ? 1 : (size_t)(slash - path);
    char* folder = ty_alloc_array(context, length + 1, 1, false);
    if (folder == NULL) return NULL;
    memcpy(folder, path, length);
    folder[length] = '\0';
    return folder;
}
