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

/* ---- reading in parts ---- */

enum { PART_MAX = 1 << 16 }; /* bytes of base64 that are decoded at once where they are left out */

struct ty_vtk_reader {
    const ty_vtk_image* image;
    const ty_vtk_array* array;
    size_t needed;                       /* bytes of the values */
    stream start, s;                     /* behind the sizes; as far as it was read */
    size_t at;                           /* bytes of the values that were read */
    uint64_t count, size, last, largest; /* of blocks; last: bytes of the last block, or 0 if it is a whole one */
    uint64_t* packed;                    /* packed bytes of each block; NULL: not compressed */
    uint64_t next;                       /* block */
    uint8_t *scratch, *block;
    size_t waiting; /* bytes at the end of the block that was inflated last */
    uint8_t* bytes; /* the part that was asked for last */
    size_t capacity;
};

static uint64_t block_size(const ty_vtk_reader* r, uint64_t i) {
    return i + 1 == r->count && r->last > 0 ? r->last : r->size;
}

static bool inflate_next(ty_vtk_reader* r) {
    if (r->next >= r->count) return false;
    const uint64_t size = block_size(r, r->next), packed = r->packed[r->next++];
    uLongf got = size;
    r->waiting = size;
    return take(&r->s, r->scratch, packed) && uncompress(r->block, &got, r->scratch, packed) == Z_OK && got == size;
}

/* Reads bytes that follow; `to` is NULL where they are left out. */
static bool read_next(ty_vtk_reader* r, uint8_t* to, size_t size) {
    uint8_t left_out[PART_MAX];
    r->at += size;
    while (size > 0) {
        size_t part = size;
        if (r->packed == NULL) {
            if (to == NULL && part > PART_MAX) part = PART_MAX;
            if (!take(&r->s, to != NULL ? to : left_out, part)) return false;
        } else {
            if (r->waiting == 0 && !inflate_next(r)) return false;
            if (part > r->waiting) part = r->waiting;
            const uint64_t block = block_size(r, r->next - 1);
            if (to != NULL) memcpy(to, r->block + (block - r->waiting), part);
            r->waiting -= part;
        }
        if (to != NULL) to += part;
        size -= part;
    }
    return true;
}

/* As `read` of ty_samples. Reads that go back begin anew. */
static ty_result read_part(void* user, size_t at, size_t size, const uint8_t** bytes) {
    ty_vtk_reader* r = user;
    if (size > r->capacity) {
        ty_free_array(r->image->context, r->bytes, r->capacity, 1);
        r->bytes = ty_alloc_array(r->image->context, size, 1, false);
        r->capacity = r->bytes != NULL ? size : 0;
        if (r->bytes == NULL) return TY_ERROR_MEMORY;
    }
    if (at < r->at) {
        r->s = r->start;
        r->at = r->next = r->waiting = 0;
    }
    *bytes = r->bytes;
    return read_next(r, NULL, at - r->at) && read_next(r, r->bytes, size) ? TY_OK : cut_short(r->image, r->array);
}

static ty_result open_plain(ty_vtk_reader* r) {
    uint64_t size = 0;
    if (!take_word(r->image, &r->s, &size)) return cut_short(r->image, r->array);
    if (size != r->needed) return wrong_size(r->image, r->array, size, r->needed);
    return left(&r->s) < r->needed ? cut_short(r->image, r->array) : TY_OK;
}

/* Bytes of the room for an inflated block. */
static uint64_t room(const ty_vtk_reader* r) {
    return r->count == 1 ? r->needed : r->size;
}

static ty_result open_blocks(ty_vtk_reader* r) {
    const ty_vtk_image* image = r->image;
    if (!take_word(image, &r->s, &r->count) || !take_word(image, &r->s, &r->size) || !take_word(image, &r->s, &r->last))
        return cut_short(image, r->array);
    const uint64_t whole = r->count - (r->count > 0 && r->last > 0);
    uint64_t total = 0;
    if (__builtin_mul_overflow(whole, r->size, &total) || __builtin_add_overflow(total, r->last, &total) ||
        r->last > r->size || total != r->needed)
        return wrong_size(image, r->array, total, r->needed);
    /* Neither a block's own size nor its zlib stream takes less than a few bytes. */
    if (r->count > left(&r->s) / sizeof(uint32_t) || r->needed / RATIO_MAX > left(&r->s))
        return cut_short(image, r->array);
    r->packed = ty_alloc_array(image->context, r->count, sizeof *r->packed, false);
    if (r->packed == NULL) return TY_ERROR_MEMORY;
    for (uint64_t i = 0; i < r->count; ++i) {
        if (!take_word(image, &r->s, &r->packed[i])) return cut_short(image, r->array);
        if (r->packed[i] > r->largest) r->largest = r->packed[i];
    }
    if (r->largest > left(&r->s)) return cut_short(image, r->array);
    r->scratch = ty_alloc_array(image->context, r->largest, 1, false);
    r->block = r->scratch == NULL ? NULL : ty_alloc_array(image->context, room(r), 1, false);
    return r->block != NULL ? TY_OK : TY_ERROR_MEMORY;
}

ty_result ty_vtk_open(const ty_vtk_image* image, const ty_vtk_array* array, size_t needed, ty_samples* samples,
                      ty_vtk_reader** out) {
    const size_t end = array->end < image->size ? (size_t)array->end : image->size;
    *out = NULL;
    if (array->at > end) return cut_short(image, array);
    stream s = {image->bytes + array->at, image->bytes + end, array->form == TY_VTK_BASE64, {0}, 0};
    if (array->form == TY_VTK_PLAIN) {
        samples->bytes = s.at;
        return left(&s) < needed ? cut_short(image, array) : TY_OK;
    }
    ty_vtk_reader* r = ty_alloc_array(image->context, 1, sizeof *r, true);
    if (r == NULL) return TY_ERROR_MEMORY;
    *r = (ty_vtk_reader){.image = image, .array = array, .needed = needed, .s = s};
    *out = r;
    const ty_result result = image->compressed ? open_blocks(r) : open_plain(r);
    r->start = r->s;
    if (image->compressed || s.base64) {
        samples->read = read_part;
        samples->user = r;
    } else {
        samples->bytes = r->s.at;
    }
    return result;
}

ty_result ty_vtk_finish(ty_vtk_reader* r) {
    if (r == NULL || r->at == r->needed || (r->packed == NULL && !r->s.base64)) return TY_OK;
    return read_next(r, NULL, r->needed - r->at) ? TY_OK : cut_short(r->image, r->array);
}

void ty_vtk_close_reader(ty_vtk_reader* r) {
    if (r == NULL) return;
    ty_context* context = r->image->context;
    ty_free_array(context, r->packed, r->count, sizeof *r->packed);
    ty_free_array(context, r->scratch, r->largest, 1);
    ty_free_array(context, r->block, room(r), 1);
    ty_free_array(context, r->bytes, r->capacity, 1);
    ty_free_array(context, r, 1, sizeof *r);
}
