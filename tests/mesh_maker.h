/* Shared by the tests of mesh files: a context that keeps its warnings, glTF text and GLB files made on the spot. */
#ifndef TY_TESTS_MESH_MAKER_H
#define TY_TESTS_MESH_MAKER_H

#include "files.h"
#include "model_check.h"

typedef struct log_book {
    int warnings, infos;
    char text[1024]; /* of the last warning */
} log_book;

static inline void keep_line(void* user, ty_log_level level, const char* text) {
    log_book* book = user;
    if (level == TY_LOG_INFO) ++book->infos;
    if (level != TY_LOG_WARNING) return;
    ++book->warnings;
    snprintf(book->text, sizeof book->text, "%s", text);
}

static inline ty_context* logged_context(log_book* book, int32_t threads) {
    ty_context_def def = ty_default_context_def();
    def.threads = threads;
    def.log = keep_line;
    def.log_user = book;
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&def, &context), TY_OK);
    return context;
}

/* JSON with ' for ", in a buffer that the next call uses again. */
static inline const char* quoted(const char* text) {
    static char json[1 << 16];
    const size_t length = strlen(text);
    assert_true(length < sizeof json);
    for (size_t i = 0; i <= length; ++i) json[i] = (char)(text[i] == '\'' ? '"' : text[i]);
    return json;
}

/* The text with the first occurrence of a part replaced; to be freed. */
static inline char* with_part(const char* text, const char* part, const char* by) {
    const char* at = strstr(text, part);
    assert_non_null(at);
    char* out = malloc(strlen(text) + strlen(by) + 1);
    assert_non_null(out);
    const size_t before = (size_t)(at - text);
    memcpy(out, text, before);
    strcpy(out + before, by);
    strcat(out, at + strlen(part));
    return out;
}

static inline void put_text(const char* path, const char* text) {
    put_file(path, text, strlen(text));
}

static inline size_t put_u32(uint8_t* to, uint32_t value) {
    for (int i = 0; i < 4; ++i) to[i] = (uint8_t)(value >> 8 * i);
    return 4;
}

/* A GLB of JSON (with ' for ") and binary data; to be freed. */
static inline uint8_t* make_glb(const char* text, const void* data, size_t data_size, size_t* size) {
    const char* json = quoted(text);
    const size_t length = strlen(json), padded = (length + 3) / 4 * 4, data_padded = (data_size + 3) / 4 * 4;
    *size = 12 + 8 + padded + 8 + data_padded;
    uint8_t* glb = calloc(1, *size);
    assert_non_null(glb);
    memcpy(glb, "glTF", 4);
    size_t at = 4;
    at += put_u32(glb + at, 2);
    at += put_u32(glb + at, (uint32_t)*size);
    at += put_u32(glb + at, (uint32_t)padded);
    at += put_u32(glb + at, 0x4e4f534a);
    memset(glb + at, ' ', padded);
    memcpy(glb + at, json, length);
    at += padded;
    at += put_u32(glb + at, (uint32_t)data_padded);
    at += put_u32(glb + at, 0x004e4942);
    memcpy(glb + at, data, data_size);
    return glb;
}

static inline void assert_floats(const float* values, const float* expected, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (!(fabsf(values[i] - expected[i]) <= 1e-6f * (1 + fabsf(expected[i]))))
            fail_msg("number %zu is %g, not %g", i, (double)values[i], (double)expected[i]);
}

static inline void assert_doubles(const double* values, const double* expected, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (!(fabs(values[i] - expected[i]) <= 1e-9 * (1 + fabs(expected[i]))))
            fail_msg("number %zu is %.12g, not %.12g", i, values[i], expected[i]);
}

#endif
