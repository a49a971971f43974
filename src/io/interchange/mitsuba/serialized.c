/* Mitsuba's .serialized meshes: a head, a zlib stream for each shape, and at the end of the file a table of their
 * offsets. */
#include "io/interchange/mitsuba/serialized.h"

#include "base/context.h"
#include "io/file.h"
#include "io/volumes/inflate.h"

#include <math.h>
#include <string.h>

enum { MAGIC = 0x041c, HEAD = 4, NORMALS = 1, UV = 2, COLORS = 8, DOUBLES = 0x2000, NAME_MAX_BYTES = 1 << 16 };

static uint64_t load(const uint8_t* bytes, int count) {
    uint64_t value = 0;
    for (int i = 0; i < count; ++i) value |= (uint64_t)bytes[i] << (8 * i);
    return value;
}

/* The inflated bytes of a shape. */
typedef struct stream {
    ty_context* context;
    const char* path;
    const uint8_t *at, *end;
} stream;

static ty_result damaged(const stream* s) {
    return ty_fail(s->context, TY_ERROR_INPUT, "%s: the serialized mesh is damaged or cut short", s->path);
}

/* Offset of a shape's head in the file. */
static ty_result find_shape(const stream* file, size_t size, int32_t index, int version, size_t* offset) {
    const uint8_t* bytes = file->at;
    const uint64_t count = load(bytes + size - 4, 4), width = version == 4 ? 8 : 4;
    *offset = 0;
    if (index == 0) return TY_OK;
    if (index < 0 || (uint64_t)index >= count || count * width + 4 > size)
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: there is no shape %d", file->path, (int)index);
    *offset = (size_t)load(bytes + size - 4 - (count - (uint64_t)index) * width, (int)width);
    return *offset + HEAD < size ? TY_OK : damaged(file);
}

/* Reads `count` numbers as floats; without an array they are passed. */
static ty_result read_numbers(stream* s, bool doubles, size_t count, float* out) {
    const size_t width = doubles ? 8 : 4;
    if ((size_t)(s->end - s->at) / width < count) return damaged(s);
    for (size_t i = 0; i < count && out != NULL; ++i) {
        double wide;
        float narrow;
        if (doubles)
            memcpy(&wide, s->at + 8 * i, 8);
        else
            memcpy(&narrow, s->at + 4 * i, 4);
        out[i] = doubles ? (float)wide : narrow;
        if (!isfinite(out[i])) return damaged(s);
    }
    s->at += count * width;
    return TY_OK;
}

static ty_result read_indices(stream* s, size_t vertices, size_t count, uint32_t* out) {
    const int width = vertices > UINT32_MAX ? 8 : 4;
    if ((size_t)(s->end - s->at) / (size_t)width < count) return damaged(s);
    for (size_t i = 0; i < count; ++i) {
        const uint64_t index = load(s->at + (size_t)width * i, width);
        if (index >= vertices) return damaged(s);
        out[i] = (uint32_t)index;
    }
    return TY_OK;
}

/* The content of an inflated shape of version 3 or 4. */
static ty_result read_shape(stream* s, int version, ty_model_mesh* out) {
    if (s->end - s->at < 4) return damaged(s);
    const uint64_t flags = load(s->at, 4);
    s->at += 4;
    if (version == 4) { /* a name that ends with a zero */
        const uint8_t* zero = memchr(s->at, 0, (size_t)(s->end - s->at));
        if (zero == NULL || zero - s->at > NAME_MAX_BYTES) return damaged(s);
        s->at = zero + 1;
    }
    if (s->end - s->at < 16) return damaged(s);
    const uint64_t vertices = load(s->at, 8), triangles = load(s->at + 8, 8);
    s->at += 16;
    const size_t left = (size_t)(s->end - s->at);
    const bool doubles = (flags & DOUBLES) != 0;
    if (vertices > left / 12 || triangles > left / 12) return damaged(s);
    *out = (ty_model_mesh){
        .vertex_count = (size_t)vertices, .triangle_count = (size_t)triangles, .material = -1, .primitive = -1};
    ty_result result = ty_model_alloc_mesh(s->context, out, (flags & NORMALS) != 0, (flags & UV) != 0, false, false);
    if (result != TY_OK) return result;
    result = read_numbers(s, doubles, 3 * (size_t)vertices, out->positions);
    if (result == TY_OK && out->normals != NULL) result = read_numbers(s, doubles, 3 * (size_t)vertices, out->normals);
    if (result == TY_OK && out->uv[0] != NULL) result = read_numbers(s, doubles, 2 * (size_t)vertices, out->uv[0]);
    if (result == TY_OK && (flags & COLORS) != 0) result = read_numbers(s, doubles, 3 * (size_t)vertices, NULL);
    if (result == TY_OK) result = read_indices(s, (size_t)vertices, 3 * (size_t)triangles, out->indices);
    for (size_t i = 0; i < out->vertex_count && out->uv[0] != NULL; ++i) /* v points down in meshes of ours */
        out->uv[0][2 * i + 1] = 1 - out->uv[0][2 * i + 1];
    if (result != TY_OK) ty_model_free_mesh(s->context, out);
    return result;
}

/* Inflates the stream that begins at `from`, of unknown length. */
static ty_result inflate_shape(const stream* file, const uint8_t* from, size_t size, uint8_t** out, size_t* out_size,
                               size_t* out_room) {
    enum { FIRST = 1 << 16 };
    for (size_t room = FIRST;; room *= 4) {
        uint64_t got = 0;
        *out = ty_alloc_array(file->context, room + 1, 1, false);
        if (*out == NULL) return TY_ERROR_MEMORY;
        const ty_inflated state = ty_inflate_gzip(from, size, 0, *out, room, &got);
        if (state == TY_INFLATED_WHOLE || state == TY_INFLATED_SHORT || (state == TY_INFLATED_DAMAGED && got > 0)) {
            /* another shape, or the table, follows the stream, and ends the inflating; what is missing is found later
             */
            *out_size = (size_t)got;
            *out_room = room;
            return TY_OK;
        }
        ty_free_file(file->context, *out, room);
        *out = NULL;
        if (state == TY_INFLATED_DAMAGED || room / TY_INFLATE_RATIO_MAX > size) return damaged(file);
    }
}

ty_result ty_read_serialized(ty_context* context, const char* path, const uint8_t* bytes, size_t size, int32_t index,
                             ty_model_mesh* out) {
    stream file = {context, path, bytes, bytes + size};
    size_t offset = 0, length = 0, room = 0;
    uint8_t* inflated = NULL;
    *out = (ty_model_mesh){0};
    if (size < HEAD + 4 || load(bytes, 2) != MAGIC) return damaged(&file);
    const int version = (int)load(bytes + 2, 2);
    if (version != 3 && version != 4)
        return ty_fail(context, TY_ERROR_INPUT, "%s: serialized meshes of version %d are not known", path, version);
    ty_result result = find_shape(&file, size, index, version, &offset);
    if (result == TY_OK)
        result = inflate_shape(&file, bytes + offset + HEAD, size - offset - HEAD, &inflated, &length, &room);
    if (result != TY_OK) return result;
    stream shape = {context, path, inflated, inflated + length};
    result = read_shape(&shape, version, out);
    ty_free_file(context, inflated, room);
    return result;
}
