/* Whole files: reading with a size limit, writing through a temporary file, hashing, joining paths. */
#define _POSIX_C_SOURCE 200809L
#include "io/file.h"

#include "base/context.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/stat.h>
#include <tyndall/io.h>
#include <unistd.h>

enum {
    HASH_CHUNK = 1 << 16,
    HEAD_SIZE = 1 << 20,
    TEXT_CHUNK = 1 << 24,
    OUTPUT_BUFFER = 1 << 16,
    NAME_TRIES = 1000,
    OPEN_OUTPUTS_MAX = 64
};

/* Names of the temporary files of open outputs, and whether they are being removed because the process ends. */
static _Atomic(const char*) unfinished[OPEN_OUTPUTS_MAX];
static atomic_bool removing;

/* Opening may wait, on network file systems, and then be interrupted. */
static int open_uninterrupted(const char* path, int flags, mode_t mode) {
    int descriptor;
    do descriptor = open(path, flags, mode);
    while (descriptor < 0 && errno == EINTR);
    return descriptor;
}

/* O_NONBLOCK: opening a pipe for reading would block until it has a writer. It has no effect on regular files. */
FILE* ty_open_regular(const char* path, uint64_t* size) {
    const int descriptor = open_uninterrupted(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC, 0);
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

bool ty_is_folder(const char* path) {
    struct stat status;
    return stat(path, &status) == 0 && S_ISDIR(status.st_mode);
}

size_t ty_read_head(const char* path, void* out, size_t size) {
    uint64_t length = 0;
    FILE* stream = ty_open_regular(path, &length);
    if (stream == NULL) return 0;
    const size_t got = fread(out, 1, size, stream);
    fclose(stream);
    return got;
}

ty_result ty_open_file(ty_context* context, const char* path, FILE** stream, uint64_t* size) {
    if (path == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "a file name is NULL");
    *stream = ty_open_regular(path, size);
    if (*stream != NULL) return TY_OK;
    return ty_fail(context, errno == ENOMEM ? TY_ERROR_MEMORY : TY_ERROR_FILE, "cannot open %s: %s", path,
                   errno != 0 ? strerror(errno) : "not a regular file");
}

/* Fails if there is a zero byte in a part of a text that begins at an offset. */
static ty_result check_text(ty_context* context, const char* path, const uint8_t* part, size_t size, size_t offset) {
    const uint8_t* zero = memchr(part, 0, size);
    if (zero == NULL) return TY_OK;
    return ty_fail(context, TY_ERROR_INPUT, "%s: byte %zu is a zero, which no text has", path,
                   offset + (size_t)(zero - part));
}

/* Reads the stream into content, piece by piece if the form is that of text. */
static ty_result read_content(ty_context* context, const char* path, FILE* stream, const ty_file_form* form,
                              uint8_t* content, size_t size) {
    for (size_t got = 0; got < size;) {
        const size_t piece = form->text && size - got > TEXT_CHUNK ? TEXT_CHUNK : size - got;
        errno = 0;
        if (fread(content + got, 1, piece, stream) != piece)
            return ty_fail(context, TY_ERROR_FILE, "cannot read %s: %s", path,
                           errno != 0 ? strerror(errno) : "it became shorter meanwhile");
        const ty_result result = form->text ? check_text(context, path, content + got, piece, got) : TY_OK;
        if (result != TY_OK) return result;
        got += piece;
    }
    content[size] = 0;
    return TY_OK;
}

static ty_result read_stream(ty_context* context, const char* path, FILE* stream, const ty_file_form* form,
                             size_t length, uint8_t** bytes, size_t* size) {
    uint8_t* content = ty_alloc_array(context, length + 1, 1, false);
    if (content == NULL) return TY_ERROR_MEMORY;
    const ty_result result = read_content(context, path, stream, form, content, length);
    if (result != TY_OK) {
        ty_free_array(context, content, length + 1, 1);
        return result;
    }
    *bytes = content;
    *size = length;
    return TY_OK;
}

static const ty_file_form any_form = {.longest = UINT64_MAX};

/* Inspects the beginning of a file; the stream is at its begin before and afterwards. */
static ty_result inspect_stream(ty_context* context, const char* path, FILE* stream, uint64_t length,
                                ty_file_form_fn inspect, ty_file_form* form) {
    uint8_t* head = NULL;
    size_t size = 0;
    ty_result result = read_stream(context, path, stream, &any_form, HEAD_SIZE, &head, &size);
    if (result != TY_OK) return result;
    result = inspect(context, path, head, size, form);
    if (result == TY_OK && form->text) result = check_text(context, path, head, size, 0);
    ty_free_file(context, head, size);
    rewind(stream);
    if (result == TY_OK && length > form->longest)
        return ty_fail(context, TY_ERROR_INPUT, "%s: %llu bytes, of which its header accounts for %llu at most", path,
                       (unsigned long long)length, (unsigned long long)form->longest);
    return result;
}

ty_result ty_read_inspected_file(ty_context* context, const char* path, size_t limit, ty_file_form_fn inspect,
                                 uint8_t** bytes, size_t* size) {
    FILE* stream = NULL;
    uint64_t length = 0;
    ty_file_form form = any_form;
    ty_result result = ty_open_file(context, path, &stream, &length);
    if (result != TY_OK) return result;
    if (length > limit)
        result = ty_fail(context, TY_ERROR_INPUT, "%s: %llu bytes, more than the limit of %zu", path,
                         (unsigned long long)length, limit);
    if (result == TY_OK && inspect != NULL && length > TY_FILE_SLACK)
        result = inspect_stream(context, path, stream, length, inspect, &form);
    if (result == TY_OK) result = read_stream(context, path, stream, &form, (size_t)length, bytes, size);
    fclose(stream);
    return result;
}

ty_result ty_read_file(ty_context* context, const char* path, size_t limit, uint8_t** bytes, size_t* size) {
    return ty_read_inspected_file(context, path, limit, NULL, bytes, size);
}

ty_result ty_read_part(ty_context* context, const char* path, uint64_t offset, size_t limit, uint8_t** bytes,
                       size_t* size) {
    FILE* stream = NULL;
    uint64_t length = 0;
    ty_result result = ty_open_file(context, path, &stream, &length);
    if (result != TY_OK) return result;
    const uint64_t left = offset < length ? length - offset : 0;
    if (left > 0 && fseeko(stream, (off_t)offset, SEEK_SET) != 0)
        result = ty_fail(context, TY_ERROR_FILE, "cannot read %s: %s", path, strerror(errno));
    if (result == TY_OK)
        result = read_stream(context, path, stream, &any_form, left < limit ? (size_t)left : limit, bytes, size);
    fclose(stream);
    return result;
}

void ty_free_file(ty_context* context, uint8_t* bytes, size_t size) {
    ty_free_array(context, bytes, size + 1, 1);
}

static int list_unfinished(const char* temporary) {
    for (int slot = 0; slot < OPEN_OUTPUTS_MAX; ++slot) {
        const char* none = NULL;
        if (atomic_compare_exchange_strong(&unfinished[slot], &none, temporary)) return slot;
    }
    return -1;
}

/* The caller frees the name next, which a signal handler in another thread may have in its hands: the process then ends
 * before this returns. */
static void unlist(int slot) {
    if (slot < 0) return;
    atomic_store(&unfinished[slot], NULL);
    while (atomic_load(&removing)) pause();
}

void ty_remove_unfinished_outputs(void) {
    atomic_store(&removing, true);
    for (int slot = 0; slot < OPEN_OUTPUTS_MAX; ++slot) {
        const char* temporary = atomic_load(&unfinished[slot]);
        if (temporary != NULL) unlink(temporary);
    }
}

static void free_output(ty_context* context, ty_output* output) {
    unlist(output->slot);
    ty_free_text(context, output->path);
    ty_free_text(context, output->temporary);
    ty_free_array(context, output->buffer, OUTPUT_BUFFER, 1);
    *output = (ty_output){.descriptor = -1, .slot = -1};
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

/* Creates the temporary file: its descriptor, or -1 with the cause in errno (0: a message was stored). */
static int create_temporary(ty_context* context, ty_output* output) {
    for (int number = 0; number < NAME_TRIES; ++number) {
        output->temporary = temporary_name(context, output->path, number);
        if (output->temporary == NULL) {
            errno = 0;
            return -1;
        }
        const int descriptor = open_uninterrupted(output->temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor >= 0 || errno != EEXIST) return descriptor;
        ty_free_text(context, output->temporary);
        output->temporary = NULL;
    }
    return -1;
}

ty_result ty_output_open(ty_context* context, const char* path, ty_output* output) {
    if (path == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "a file name is NULL");
    /* A rename onto a device would replace it; onto a folder it would fail only at the end. */
    struct stat status;
    if (stat(path, &status) == 0 && !S_ISREG(status.st_mode))
        return ty_fail(context, TY_ERROR_FILE, "cannot write %s: not a regular file", path);
    *output = (ty_output){.path = ty_copy_text(context, path), .descriptor = -1, .slot = -1};
    output->buffer = output->path == NULL ? NULL : ty_alloc_array(context, OUTPUT_BUFFER, 1, false);
    ty_result result = TY_ERROR_MEMORY;
    if (output->buffer != NULL) {
        output->descriptor = create_temporary(context, output);
        if (output->descriptor >= 0) {
            output->slot = list_unfinished(output->temporary);
            return TY_OK;
        }
        if (errno != 0) result = ty_fail(context, TY_ERROR_FILE, "cannot write %s: %s", path, strerror(errno));
    }
    free_output(context, output);
    return result;
}

static bool write_all(ty_output* output, const uint8_t* bytes, size_t size) {
    while (size > 0 && output->error == 0) {
        const ssize_t written = pwrite(output->descriptor, bytes, size, (off_t)output->offset);
        if (written > 0) {
            bytes += written;
            size -= (size_t)written;
            output->offset += (uint64_t)written;
        } else if (written == 0 || errno != EINTR) {
            output->error = written == 0 ? ENOSPC : errno;
        }
    }
    return output->error == 0;
}

static bool flush_buffer(ty_output* output) {
    const size_t size = output->buffered;
    output->buffered = 0;
    return write_all(output, output->buffer, size);
}

bool ty_output_write(ty_output* output, const void* bytes, size_t size) {
    if (output->error != 0) return false;
    if (size > OUTPUT_BUFFER - output->buffered && !flush_buffer(output)) return false;
    if (size > OUTPUT_BUFFER) return write_all(output, bytes, size);
    if (size > 0) memcpy(output->buffer + output->buffered, bytes, size);
    output->buffered += size;
    return true;
}

uint64_t ty_output_position(const ty_output* output) {
    return output->offset + output->buffered;
}

bool ty_output_write_at(ty_output* output, const void* bytes, size_t size, uint64_t offset) {
    if (offset != ty_output_position(output)) {
        if (!flush_buffer(output)) return false;
        output->offset = offset;
    }
    return ty_output_write(output, bytes, size);
}

/* Some file systems cannot be told to write back, and say so by EINVAL or ENOTSUP. */
static void make_durable(ty_output* output) {
    while (output->error == 0 && fsync(output->descriptor) != 0) {
        if (errno == EINVAL || errno == ENOTSUP) return;
        if (errno != EINTR) output->error = errno;
    }
}

/* Linux closes a descriptor in an interrupted call, too. */
static void close_output(ty_output* output) {
    if (close(output->descriptor) != 0 && errno != EINTR && output->error == 0) output->error = errno;
    output->descriptor = -1;
}

ty_result ty_output_commit(ty_context* context, ty_output* output) {
    flush_buffer(output);
    make_durable(output);
    close_output(output);
    while (output->error == 0 && rename(output->temporary, output->path) != 0)
        if (errno != EINTR) output->error = errno;
    ty_result result = TY_OK;
    if (output->error != 0) {
        remove(output->temporary);
        result = ty_fail(context, TY_ERROR_FILE, "cannot write %s: %s", output->path, strerror(output->error));
    }
    free_output(context, output);
    return result;
}

void ty_output_discard(ty_context* context, ty_output* output) {
    close_output(output);
    remove(output->temporary);
    free_output(context, output);
}

ty_result ty_write_file(ty_context* context, const char* path, const void* bytes, size_t size) {
    ty_output output;
    const ty_result result = ty_output_open(context, path, &output);
    if (result != TY_OK) return result;
    ty_output_write(&output, bytes, size);
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
