/* Stream callbacks of OpenEXR's core C library: bytes in memory for reading, a file for writing. */
#include "io/images/exr.h"

#include "base/context.h"

#include <stdlib.h>
#include <string.h>

/* Stream of the calling thread's file. Writing calls the error handler with the context's lock held, which
 * exr_get_user_data would wait for: the handler must find the stream without the context. */
static _Thread_local ty_exr_stream* current_stream;

static void store_message(exr_const_context_t exr, exr_result_t code, const char* text) {
    (void)exr;
    (void)code;
    if (current_stream != NULL && current_stream->message[0] == '\0')
        strncpy(current_stream->message, text, TY_EXR_MESSAGE_SIZE - 1);
}

static int64_t read_bytes(exr_const_context_t exr, void* user, void* buffer, uint64_t size, uint64_t offset,
                          exr_stream_error_func_ptr_t fail) {
    (void)exr;
    (void)fail;
    const ty_exr_stream* s = user;
    const uint64_t left = offset < s->size ? s->size - offset : 0;
    const uint64_t count =
        size < left ? size : left; /* the library reads ahead of the header, so short reads are no error */
    if (count > 0) memcpy(buffer, s->bytes + offset, count);
    return (int64_t)count;
}

static int64_t byte_count(exr_const_context_t exr, void* user) {
    (void)exr;
    return (int64_t)((const ty_exr_stream*)user)->size;
}

static int64_t write_bytes(exr_const_context_t exr, void* user, const void* buffer, uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t fail) {
    const ty_exr_stream* s = user;
    if (ty_output_write_at(s->output, buffer, size, offset)) return (int64_t)size;
    fail(exr, EXR_ERR_WRITE_IO, strerror(s->output->error));
    return -1;
}

/* Without memory the library may skip an attribute of a header, such as the data window, and go on. */
static void* allocate(size_t size) {
    void* block = malloc(size);
    if (block == NULL && current_stream != NULL) {
        current_stream->out_of_memory = true;
        current_stream->refused_size = size;
    }
    return block;
}

exr_context_initializer_t ty_exr_initializer(ty_exr_stream* stream) {
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    current_stream = stream;
    setup.error_handler_fn = store_message;
    setup.user_data = stream;
    setup.alloc_fn = allocate;
    setup.free_fn = free;
    setup.read_fn = read_bytes;
    setup.size_fn = byte_count;
    setup.write_fn = write_bytes;
    setup.max_image_width = setup.max_image_height = TY_IMAGE_SIDE_MAX;
    setup.max_tile_width = setup.max_tile_height = TY_IMAGE_SIDE_MAX;
    setup.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    return setup;
}

void ty_exr_stream_end(void) {
    current_stream = NULL;
}

ty_result ty_exr_fail(ty_context* context, ty_result result, const char* path, const ty_exr_stream* stream,
                      exr_result_t code) {
    /* Compression shrinks data 1,032 times at most (deflate): what asks for more is a damaged header. */
    const bool implausible = !stream->out_of_memory || stream->refused_size / 1032 > stream->size;
    if (code == EXR_ERR_OUT_OF_MEMORY && stream->bytes != NULL && implausible)
        return ty_fail(context, TY_ERROR_INPUT, "%s: it declares more than fits into memory", path);
    /* The library calls a block corrupt for which zlib found no memory. */
    const bool unpacked = stream->output != NULL && stream->output->error == 0 && code == EXR_ERR_CORRUPT_CHUNK;
    if (code == EXR_ERR_OUT_OF_MEMORY || stream->out_of_memory || unpacked)
        return ty_fail(context, TY_ERROR_MEMORY, "%s: not enough memory for OpenEXR", path);
    return ty_fail(context, result, "%s: %s", path,
                   stream->message[0] != '\0' ? stream->message : exr_get_default_error_message(code));
}
