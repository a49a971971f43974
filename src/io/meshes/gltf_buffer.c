/* glTF buffers, from the GLB, from separate files or from base64, and their views. */
#include "base/context.h"
#include "io/file.h"
#include "io/meshes/gltf.h"

#include <stdio.h>
#include <string.h>

/* ---- URIs ---- */

/* Value of a base64 digit in either common alphabet, -1 for any other character. */
static int digit_value(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

/* Decodes base64 text to `to`, which holds 3/4 of length; false if invalid. */
static bool decode_base64(const char* text, size_t length, uint8_t* to, size_t* size) {
    while (length > 0 && text[length - 1] == '=') --length;
    uint32_t bits = 0;
    size_t count = 0;
    for (size_t i = 0; i < length; ++i) {
        const int value = digit_value(text[i]);
        if (value < 0) return false;
        bits = bits << 6 | (uint32_t)value;
        if (i % 4 == 0) continue;
        to[count++] = (uint8_t)(bits >> (6 - 2 * (i % 4)));
    }
    *size = count;
    return length % 4 != 1;
}

static ty_result load_data(const ty_gltf* gltf, const ty_json_path* json_path, const char* uri, uint8_t** bytes,
                           size_t* size) {
    static const char mark[] = ";base64,";
    const char* start = strstr(uri, mark);
    if (start == NULL) return ty_gltf_fail(gltf, json_path, "a data: URI that is not base64");
    start += sizeof mark - 1;
    const size_t length = strlen(start), capacity = length / 4 * 3 + 3;
    uint8_t* decoded = ty_alloc_array(gltf->context, capacity, 1, false);
    if (decoded == NULL) return TY_ERROR_MEMORY;
    size_t count = 0;
    const bool valid = decode_base64(start, length, decoded, &count);
    uint8_t* content = valid ? ty_alloc_array(gltf->context, count + 1, 1, false) : NULL;
    if (content != NULL) memcpy(content, decoded, count);
    ty_free_array(gltf->context, decoded, capacity, 1);
    if (!valid) return ty_gltf_fail(gltf, json_path, "a data: URI with damaged base64");
    if (content == NULL) return TY_ERROR_MEMORY;
    content[count] = 0;
    *bytes = content;
    *size = count;
    return TY_OK;
}

static int hex_value(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    c |= 0x20;
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

bool ty_gltf_decode_percent(char* text) {
    char* to = text;
    for (const char* at = text; *at != '\0'; ++at) {
        if (*at != '%') {
            *to++ = *at;
            continue;
        }
        const int high = hex_value(at[1]), low = high < 0 ? -1 : hex_value(at[2]);
        if (low < 0 || high + low == 0) return false;
        *to++ = (char)(16 * high + low);
        at += 2;
    }
    *to = '\0';
    return true;
}

static ty_result load_file(const ty_gltf* gltf, const ty_json_path* json_path, const char* uri, size_t limit,
                           ty_file_form_fn inspect, uint8_t** bytes, size_t* size) {
    char* name = ty_copy_text(gltf->context, uri);
    if (name == NULL) return TY_ERROR_MEMORY;
    char where[256], message[512], *path = NULL;
    const size_t length = strlen(name) + 1; /* decoding shortens the text */
    ty_json_path_text(json_path, where, sizeof where);
    snprintf(message, sizeof message, "%s: %s", gltf->path, where);
    ty_result result = ty_gltf_decode_percent(name)
                           ? ty_model_inner_path(gltf->context, message, gltf->folder, name, &path)
                           : ty_gltf_fail(gltf, json_path, "a URI with a damaged %% escape");
    ty_free_array(gltf->context, name, length, 1);
    if (result == TY_OK) result = ty_model_read_reference(gltf->context, message, path, limit, inspect, bytes, size);
    ty_free_text(gltf->context, path);
    return result;
}

ty_result ty_gltf_load_uri(const ty_gltf* gltf, const ty_json_path* json_path, const char* uri, size_t limit,
                           ty_file_form_fn inspect, uint8_t** bytes, size_t* size) {
    const ty_json_path here = ty_json_path_key(json_path, "uri");
    return strncmp(uri, "data:", 5) == 0 ? load_data(gltf, &here, uri, bytes, size)
                                         : load_file(gltf, &here, uri, limit, inspect, bytes, size);
}

/* ---- buffers and views ---- */

ty_result ty_gltf_open_buffer(ty_gltf* gltf, size_t index, const ty_gltf_buffer** out) {
    ty_gltf_buffer* buffer = &gltf->buffers[index];
    *out = buffer;
    if (buffer->data != NULL) return TY_OK;
    const ty_json_path json_path = ty_gltf_json_path("buffers", index);
    const json_t* json = ty_gltf_item(gltf, "buffers", index);
    const json_t* uri = json_object_get(json, "uri");
    int64_t length = 0;
    ty_result result = ty_gltf_read_integer(gltf, json, &json_path, "byteLength", 1, INT64_MAX, &length);
    if (result != TY_OK) return result;
    if (length == 0) return ty_gltf_fail(gltf, &json_path, "byteLength is missing");
    const uint8_t* data = gltf->chunk;
    size_t size = gltf->chunk_size;
    if (uri != NULL && !json_is_string(uri)) return ty_gltf_fail(gltf, &json_path, "the uri is not a string");
    if (uri == NULL && (index > 0 || gltf->chunk == NULL))
        return ty_gltf_fail(gltf, &json_path, "it has no uri, and there is no binary chunk for it");
    if (uri != NULL) {
        const uint64_t longest = (uint64_t)length < TY_GLTF_FILE_MAX ? (uint64_t)length + TY_FILE_SLACK : 0;
        if (longest == 0) return ty_gltf_fail(gltf, &json_path, "byteLength is %lld", (long long)length);
        result = ty_gltf_load_uri(gltf, &json_path, json_string_value(uri), (size_t)longest, NULL, &buffer->owned,
                                  &buffer->owned_size);
        if (result != TY_OK) return result;
        data = buffer->owned;
        size = buffer->owned_size;
    }
    if ((uint64_t)length > size)
        return ty_gltf_fail(gltf, &json_path, "byteLength is %lld, but there are %zu bytes", (long long)length, size);
    buffer->data = data;
    buffer->size = (size_t)length;
    return TY_OK;
}

ty_result ty_gltf_open_view(ty_gltf* gltf, size_t index, const uint8_t** data, size_t* size, size_t* stride) {
    const ty_json_path json_path = ty_gltf_json_path("bufferViews", index);
    const json_t* json = ty_gltf_item(gltf, "bufferViews", index);
    int64_t from = 0, offset = 0, length = 0, apart = 0;
    ty_result result = ty_gltf_read_reference(gltf, json, &json_path, "buffer", "buffers", &from);
    if (result == TY_OK) result = ty_gltf_read_integer(gltf, json, &json_path, "byteOffset", 0, INT64_MAX, &offset);
    if (result == TY_OK) result = ty_gltf_read_integer(gltf, json, &json_path, "byteLength", 1, INT64_MAX, &length);
    if (result == TY_OK) result = ty_gltf_read_integer(gltf, json, &json_path, "byteStride", 1, 252, &apart);
    if (result != TY_OK) return result;
    if (from < 0 || length == 0)
        return ty_gltf_fail(gltf, &json_path, "%s is missing", from < 0 ? "buffer" : "byteLength");
    *stride = (size_t)apart;
    if (ty_gltf_packed_view(json) != NULL) return ty_gltf_unpack_view(gltf, index, data, size);
    const ty_gltf_buffer* buffer = NULL;
    result = ty_gltf_open_buffer(gltf, (size_t)from, &buffer);
    if (result != TY_OK) return result;
    if ((uint64_t)offset > buffer->size || (uint64_t)length > buffer->size - (uint64_t)offset)
        return ty_gltf_fail(gltf, &json_path, "reaches past the end of its buffer");
    *data = buffer->data + offset;
    *size = (size_t)length;
    return TY_OK;
}

static void free_buffers(ty_gltf* gltf, ty_gltf_buffer* buffers, size_t count) {
    for (size_t i = 0; i < count && buffers != NULL; ++i)
        if (buffers[i].owned != NULL) ty_free_file(gltf->context, buffers[i].owned, buffers[i].owned_size);
    ty_free_array(gltf->context, buffers, count, sizeof *buffers);
}

void ty_gltf_free_buffers(ty_gltf* gltf) {
    free_buffers(gltf, gltf->buffers, ty_gltf_count(gltf, "buffers"));
    free_buffers(gltf, gltf->views, ty_gltf_count(gltf, "bufferViews"));
    gltf->buffers = gltf->views = NULL;
}
