/* Inflating of deflated data in memory. */
#include "io/volumes/inflate.h"

#include "base/context.h"

#include <string.h>
#include <zlib.h>

static uInt at_most(uint64_t size) {
    return size > UINT32_MAX ? UINT32_MAX : (uInt)size;
}

ty_inflated ty_inflate_gzip(const uint8_t* from, size_t from_size, uint64_t skip, uint8_t* to, size_t to_size,
                            uint64_t* got) {
    enum { WINDOW_DETECT = 15 + 32, SCRATCH = 1 << 15 };
    z_stream z = {0};
    uint8_t scratch[SCRATCH]; /* data to leave out, and one byte beyond the limit */
    const uint64_t total = skip + to_size;
    *got = 0;
    if (inflateInit2(&z, WINDOW_DETECT) != Z_OK) return TY_INFLATED_DAMAGED;
    size_t in = 0;
    int status = Z_OK;
    while (status == Z_OK && *got <= total) {
        const bool keep = *got >= skip && *got < total;
        const uint64_t room = *got < skip ? skip - *got : keep ? total - *got : 1;
        const uInt in_part = at_most(from_size - in);
        const uInt out_part = keep || room < SCRATCH ? at_most(room) : (uInt)SCRATCH;
        z.next_in = (Bytef*)(uintptr_t)(from + in);
        z.avail_in = in_part;
        z.next_out = keep ? to + (*got - skip) : scratch;
        z.avail_out = out_part;
        status = inflate(&z, Z_NO_FLUSH);
        in += in_part - z.avail_in;
        *got += out_part - z.avail_out;
        if (status == Z_STREAM_END && from_size - in > 1 && *got < total) status = inflateReset(&z);
    }
    inflateEnd(&z);
    if (*got > total) return TY_INFLATED_MORE;
    if (status != Z_STREAM_END) return TY_INFLATED_DAMAGED;
    return *got < total ? TY_INFLATED_SHORT : TY_INFLATED_WHOLE;
}

/* Bytes of unknown number. */
typedef struct buffer {
    uint8_t* bytes;
    size_t size, capacity;
} buffer;

/* Moves the bytes into an array of another capacity; false, with a message, if memory runs out. */
static bool resize(ty_context* context, buffer* b, size_t capacity) {
    uint8_t* bytes = ty_alloc_array(context, capacity, 1, false);
    if (bytes == NULL) return false;
    if (b->size > 0) memcpy(bytes, b->bytes, b->size);
    ty_free_array(context, b->bytes, b->capacity, 1);
    b->bytes = bytes;
    b->capacity = capacity;
    return true;
}

static ty_result inflate_buffer(ty_context* context, const char* path, z_stream* z, size_t from_size, size_t limit,
                                buffer* b) {
    enum { FIRST = 1 << 16 };
    size_t in = 0;
    int status = Z_OK;
    while (status == Z_OK) {
        if (b->size == b->capacity) {
            if (b->capacity >= limit)
                return ty_fail(context, TY_ERROR_INPUT, "%s: more than %zu bytes when it is inflated", path, limit);
            const size_t doubled = b->capacity == 0 ? FIRST : 2 * b->capacity;
            if (!resize(context, b, doubled < limit ? doubled : limit)) return TY_ERROR_MEMORY;
        }
        const uInt in_part = at_most(from_size - in), out_part = at_most(b->capacity - b->size);
        z->avail_in = in_part;
        z->next_out = b->bytes + b->size;
        z->avail_out = out_part;
        status = inflate(z, Z_NO_FLUSH);
        in += in_part - z->avail_in;
        b->size += out_part - z->avail_out;
    }
    if (status == Z_STREAM_END) return resize(context, b, b->size + 1) ? TY_OK : TY_ERROR_MEMORY;
    return ty_fail(context, TY_ERROR_INPUT, "%s: the deflated data is damaged or cut short", path);
}

ty_result ty_inflate_bare(ty_context* context, const char* path, const uint8_t* from, size_t from_size, size_t limit,
                          uint8_t** to, size_t* to_size) {
    enum { WINDOW_BARE = -15 };
    z_stream z = {.next_in = (Bytef*)(uintptr_t)from};
    if (inflateInit2(&z, WINDOW_BARE) != Z_OK)
        return ty_fail(context, TY_ERROR_MEMORY, "%s: not enough memory to inflate it", path);
    buffer b = {0};
    const ty_result result = inflate_buffer(context, path, &z, from_size, limit, &b);
    inflateEnd(&z);
    if (result != TY_OK) {
        ty_free_array(context, b.bytes, b.capacity, 1);
        return result;
    }
    b.bytes[b.size] = 0;
    *to = b.bytes;
    *to_size = b.size;
    return TY_OK;
}
