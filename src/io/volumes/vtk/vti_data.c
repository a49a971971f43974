/* Values of arrays in .vti files: bytes as they are or in base64, behind their number; or blocks of zlib behind the
 * number of blocks, the size of a block, the size of the last one if it is smaller, and the packed size of each. */
#include "io/volumes/vtk/vtk.h"

#include "base/context.h"

#include <string.h>
#include <zlib.h>

enum { RATIO_MAX = 1032 }; /* maximum compression ratio of deflate */

/* Unread bytes. Each group of base64 that ends in padding ends one part of them; the next may follow. */
typedef struct stream {
    const uint8_t *at, *end;
    bool base64;
    uint8_t rest[3]; /* decoded bytes that are not taken yet, at rest[3 - waiting] and so on */
    int waiting;
} stream;

static int digit(uint8_t c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/* Decodes four digits to rest; false at the end or where there are none. */
static bool decode_group(stream* s) {
    while (s->at < s->end && memchr(" \t\r\n", *s->at, 4) != NULL) ++s->at;
    if (s->end - s->at < 4) return false;
    int digits[4], count = 4;
    while (count > 2 && s->at[count - 1] == '=') --count;
    for (int i = 0; i < 4; ++i) digits[i] = i < count ? digit(s->at[i]) : 0;
    for (int i = 0; i < 4; ++i)
        if (digits[i] < 0) return false;
    const uint32_t bits =
        (uint32_t)digits[0] << 18 | (uint32_t)digits[1] << 12 | (uint32_t)digits[2] << 6 | (uint32_t)digits[3];
    s->waiting = count - 1;
    for (int i = 0; i < s->waiting; ++i) s->rest[3 - s->waiting + i] = (uint8_t)(bits >> (16 - 8 * i));
    s->at += 4;
    return true;
}

static bool take(stream* s, void* to, size_t size) {
    if (!s->base64) {
        if ((size_t)(s->end - s->at) < size) return false;
        memcpy(to, s->at, size);
        s->at += size;
        return true;
    }
    for (uint8_t* out = to; size > 0; --size) {
        if (s->waiting == 0 && !decode_group(s)) return false;
        *out++ = s->rest[3 - s->waiting--];
    }
    return true;
}

/* Bytes that can be taken at most. */
static size_t left(const stream* s) {
    return (size_t)s->waiting + (size_t)(s->end - s->at);
}

static bool take_word(const ty_vtk_image* image, stream* s, uint64_t* word) {
    uint8_t bytes[sizeof *word];
    const size_t size = image->wide ? sizeof(uint64_t) : sizeof(uint32_t);
    if (!take(s, bytes, size)) return false;
    *word = 0;
    for (size_t i = 0; i < size; ++i) *word = *word << 8 | bytes[image->big_endian ? i : size - 1 - i];
    return true;
}

static ty_result wrong_size(const ty_vtk_image* image, const ty_vtk_array* array, uint64_t found, size_t needed) {
    return ty_fail(image->context, TY_ERROR_INPUT, "%s: array \"%s\" has %llu bytes; the extent and its type take %zu",
                   image->path, array->name, (unsigned long long)found, needed);
}

static ty_result cut_short(const ty_vtk_image* image, const ty_vtk_array* array) {
    return ty_vtk_damaged(image, array->name, "is damaged or cut short");
}

static ty_result load_plain(const ty_vtk_image* image, const ty_vtk_array* array, size_t needed, stream* s,
                            uint8_t** owned, const uint8_t** samples) {
    uint64_t size = 0;
    if (!take_word(image, s, &size)) return cut_short(image, array);
    if (size != needed) return wrong_size(image, array, size, needed);
    if (left(s) < needed) return cut_short(image, array);
    if (!s->base64) {
        *samples = s->at;
        return TY_OK;
    }
    *owned = ty_alloc_array(image->context, needed, 1, false);
    if (*owned == NULL) return TY_ERROR_MEMORY;
    *samples = *owned;
    return take(s, *owned, needed) ? TY_OK : cut_short(image, array);
}

typedef struct blocks {
    uint64_t count, size, last; /* last: bytes of the last block, or 0 if it is a whole one */
    uint64_t* packed;           /* packed bytes of each */
    uint64_t largest;
} blocks;

/* Inflates all blocks to `to`. */
static bool inflate_blocks(stream* s, const blocks* b, uint8_t* scratch, uint8_t* to) {
    for (uint64_t i = 0; i < b->count; ++i) {
        const uint64_t size = i + 1 == b->count && b->last > 0 ? b->last : b->size;
        uLongf got = size;
        if (!take(s, scratch, b->packed[i])) return false;
        if (uncompress(to, &got, scratch, b->packed[i]) != Z_OK || got != size) return false;
        to += size;
    }
    return true;
}

static ty_result load_blocks(const ty_vtk_image* image, const ty_vtk_array* array, size_t needed, stream* s, blocks* b,
                             uint8_t** owned) {
    for (uint64_t i = 0; i < b->count; ++i) {
        if (!take_word(image, s, &b->packed[i])) return cut_short(image, array);
        if (b->packed[i] > b->largest) b->largest = b->packed[i];
    }
    if (b->largest > left(s)) return cut_short(image, array);
    uint8_t* scratch = ty_alloc_array(image->context, b->largest, 1, false);
    *owned = scratch == NULL ? NULL : ty_alloc_array(image->context, needed, 1, false);
    ty_result result = *owned == NULL ? TY_ERROR_MEMORY : TY_OK;
    if (result == TY_OK && !inflate_blocks(s, b, scratch, *owned)) result = cut_short(image, array);
    ty_free_array(image->context, scratch, b->largest, 1);
    return result;
}

static ty_result load_packed(const ty_vtk_image* image, const ty_vtk_array* array, size_t needed, stream* s,
                             uint8_t** owned, const uint8_t** samples) {
    blocks b = {0};
    if (!take_word(image, s, &b.count) || !take_word(image, s, &b.size) || !take_word(image, s, &b.last))
        return cut_short(image, array);
    const uint64_t whole = b.count - (b.count > 0 && b.last > 0);
    uint64_t total = 0;
    if (__builtin_mul_overflow(whole, b.size, &total) || __builtin_add_overflow(total, b.last, &total) ||
        b.last > b.size || total != needed)
        return wrong_size(image, array, total, needed);
    /* Neither a block's own size nor its zlib stream takes less than a few bytes. */
    if (b.count > left(s) / sizeof(uint32_t) || needed / RATIO_MAX > left(s)) return cut_short(image, array);
    b.packed = ty_alloc_array(image->context, b.count, sizeof *b.packed, false);
    if (b.packed == NULL) return TY_ERROR_MEMORY;
    const ty_result result = load_blocks(image, array, needed, s, &b, owned);
    ty_free_array(image->context, b.packed, b.count, sizeof *b.packed);
    *samples = *owned;
    return result;
}

ty_result ty_vtk_load(const ty_vtk_image* image, const ty_vtk_array* array, size_t needed, uint8_t** owned,
                      const uint8_t** samples) {
    const size_t end = array->end < image->size ? (size_t)array->end : image->size;
    if (array->at > end) return cut_short(image, array);
    stream s = {image->bytes + array->at, image->bytes + end, array->form == TY_VTK_BASE64, {0}, 0};
    if (array->form == TY_VTK_PLAIN) {
        *samples = s.at;
        return left(&s) < needed ? cut_short(image, array) : TY_OK;
    }
    ty_result result = image->compressed ? load_packed(image, array, needed, &s, owned, samples)
                                         : load_plain(image, array, needed, &s, owned, samples);
    if (result == TY_OK || *owned == NULL) return result;
    ty_free_array(image->context, *owned, needed, 1);
    *owned = NULL;
    return result;
}
