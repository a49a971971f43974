/* Writing KTX2 (Khronos, KTX File Format Specification 2.0), with Zstandard or without. */
#include "base/context.h"
#include "io/file.h"
#include "io/textures/textures.h"

#include <stdio.h>
#include <string.h>

enum {
    HEADER = 80,      /* with the index of what follows the levels' index */
    LEVEL_INDEX = 24, /* a level */
    DESCRIPTOR = 28,  /* of the format, with its length, without samples */
    SAMPLE = 16,
    SAMPLES_MAX = 6,
    VALUES_MAX = 160, /* bytes of keys and values */
    ZSTANDARD = 2
};

/* One sample of a format's descriptor: a channel's bits (Khronos Data Format Specification 1.3, Sec. 5). */
typedef struct sample {
    int32_t offset, length; /* bits */
    uint8_t type;           /* channel and qualifiers: 0x80 float, 0x40 signed, 0x20 exponent */
    uint32_t lower, upper;
} sample;

typedef struct vk_format {
    uint32_t number; /* VkFormat */
    uint32_t type_size;
    uint8_t model, block; /* color model; texels along a block, less 1 */
    uint8_t block_bytes;
    int32_t sample_count;
    sample samples[SAMPLES_MAX];
} vk_format;

#define ONE 0x3f800000u
#define MINUS_ONE 0xbf800000u
#define BYTES                                                                                                          \
    {                                                                                                                  \
        37, 1, 1, 0, 4, 4, {                                                                                           \
            {0, 8, 0, 0, 255}, {8, 8, 1, 0, 255}, {16, 8, 2, 0, 255}, {                                                \
                24, 8, 15, 0, 255                                                                                      \
            }                                                                                                          \
        }                                                                                                              \
    }

static const vk_format formats[] = {
    [TY_TEXELS_BC6H] = {143, 1, 133, 3, 16, 1, {{0, 128, 0x80, 0, ONE}}},
    [TY_TEXELS_BC6H_SIGNED] = {144, 1, 133, 3, 16, 1, {{0, 128, 0xc0, MINUS_ONE, ONE}}},
    [TY_TEXELS_HALF] = {97,
                        2,
                        1,
                        0,
                        8,
                        4,
                        {{0, 16, 0xc0, MINUS_ONE, ONE},
                         {16, 16, 0xc1, MINUS_ONE, ONE},
                         {32, 16, 0xc2, MINUS_ONE, ONE},
                         {48, 16, 0xcf, MINUS_ONE, ONE}}},
    [TY_TEXELS_FLOAT] = {109,
                         4,
                         1,
                         0,
                         16,
                         4,
                         {{0, 32, 0xc0, MINUS_ONE, ONE},
                          {32, 32, 0xc1, MINUS_ONE, ONE},
                          {64, 32, 0xc2, MINUS_ONE, ONE},
                          {96, 32, 0xcf, MINUS_ONE, ONE}}},
    [TY_TEXELS_RGB9E5] = {123,
                          4,
                          1,
                          0,
                          4,
                          6,
                          {{0, 9, 0, 0, 8448},
                           {27, 5, 0x20, 15, 31},
                           {9, 9, 1, 0, 8448},
                           {27, 5, 0x21, 15, 31},
                           {18, 9, 2, 0, 8448},
                           {27, 5, 0x22, 15, 31}}},
    [TY_TEXELS_RGBE] = BYTES,
    [TY_TEXELS_RGBM] = BYTES,
};

static void put_descriptor(const vk_format* format, uint8_t* at) {
    const uint32_t size = DESCRIPTOR + (uint32_t)(SAMPLE * format->sample_count);
    memset(at, 0, size);
    ty_put_le32(at, size);
    ty_put_le32(at + 8, 2u | (size - 4) << 16); /* version of the descriptor, its size */
    at[12] = format->model;
    at[13] = 1; /* primaries of BT.709 */
    at[14] = 1; /* linear */
    at[16] = at[17] = format->block;
    at[20] = format->block_bytes;
    for (int32_t i = 0; i < format->sample_count; ++i) {
        const sample* s = &format->samples[i];
        uint8_t* to = at + DESCRIPTOR + SAMPLE * i;
        ty_put_le32(to, (uint32_t)s->offset | (uint32_t)(s->length - 1) << 16 | (uint32_t)s->type << 24);
        ty_put_le32(to + 8, s->lower);
        ty_put_le32(to + 12, s->upper);
    }
}

/* Appends a key and a text; both end with a zero, and the pair is padded to four bytes. */
static size_t put_value(uint8_t* bytes, size_t at, const char* key, const char* value) {
    const size_t length = strlen(key) + 1 + strlen(value) + 1;
    ty_put_le32(bytes + at, (uint32_t)length);
    memcpy(bytes + at + 4, key, strlen(key) + 1);
    memcpy(bytes + at + 4 + strlen(key) + 1, value, strlen(value) + 1);
    return at + 4 + ((length + 3) & ~(size_t)3);
}

static size_t put_values(const ty_stored_texture* texture, uint8_t* bytes) {
    char number[32];
    memset(bytes, 0, VALUES_MAX);
    size_t at = put_value(bytes, 0, "KTXorientation", texture->size[2] > 0 ? "rdi" : "rd"); /* keys are in order */
    at = put_value(bytes, at, "KTXwriter", "tyndall");
    if (texture->format == TY_TEXELS_RGBE) at = put_value(bytes, at, "encoding", "rgbe");
    if (texture->format != TY_TEXELS_RGBM) return at;
    at = put_value(bytes, at, "encoding", "rgbm");
    snprintf(number, sizeof number, "%.9g", texture->range);
    return put_value(bytes, at, "rgbm_range", number);
}

/* A level as it is in the file. */
typedef struct stored_level {
    const uint8_t* bytes;
    uint8_t* packed; /* NULL: not compressed */
    size_t capacity, count;
    uint64_t offset;
} stored_level;

static ty_result store_levels(ty_context* context, const ty_stored_texture* texture, stored_level* stored) {
    ty_result result = TY_OK;
    for (int32_t i = 0; i < texture->level_count && result == TY_OK; ++i) {
        const ty_texture_level* level = &texture->levels[i];
        stored[i] = (stored_level){.bytes = level->bytes, .count = level->count};
        if (texture->zstd == 0) continue;
        stored[i].capacity = ty_zstd_bound(level->count);
        stored[i].packed = ty_alloc_array(context, stored[i].capacity, 1, false);
        if (stored[i].packed == NULL) return TY_ERROR_MEMORY;
        stored[i].bytes = stored[i].packed;
        result = ty_zstd_compress(context, texture->zstd, level->bytes, level->count, stored[i].packed,
                                  stored[i].capacity, &stored[i].count);
    }
    return result;
}

/* Levels lie from the smallest to the largest, aligned to texels and to four bytes unless they are compressed. */
static void place_levels(const ty_stored_texture* texture, uint64_t at, stored_level* stored) {
    const uint64_t alignment = texture->zstd > 0 ? 1 : formats[texture->format].block_bytes;
    for (int32_t i = texture->level_count - 1; i >= 0; --i) {
        at = (at + alignment - 1) / alignment * alignment;
        stored[i].offset = at;
        at += stored[i].count;
    }
}

static ty_result write_file(ty_context* context, const ty_stored_texture* texture, stored_level* stored,
                            const char* path) {
    static const uint8_t identifier[12] = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n'};
    const vk_format* format = &formats[texture->format];
    uint8_t head[HEADER + LEVEL_INDEX * TY_TEXTURE_LEVELS_MAX] = {0};
    uint8_t descriptor[DESCRIPTOR + SAMPLE * SAMPLES_MAX], values[VALUES_MAX];
    const size_t descriptor_size = DESCRIPTOR + SAMPLE * (size_t)format->sample_count;
    const size_t head_size = HEADER + LEVEL_INDEX * (size_t)texture->level_count;
    const size_t values_size = put_values(texture, values);
    put_descriptor(format, descriptor);
    place_levels(texture, head_size + descriptor_size + values_size, stored);
    memcpy(head, identifier, sizeof identifier);
    const uint32_t words[] = {format->number,
                              format->type_size,
                              (uint32_t)texture->size[0],
                              (uint32_t)texture->size[1],
                              (uint32_t)texture->size[2],
                              0, /* not an array */
                              1, /* one face */
                              (uint32_t)texture->level_count,
                              texture->zstd > 0 ? ZSTANDARD : 0,
                              (uint32_t)head_size,
                              (uint32_t)descriptor_size,
                              (uint32_t)(head_size + descriptor_size),
                              (uint32_t)values_size};
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i) ty_put_le32(head + 12 + 4 * i, words[i]);
    for (int32_t i = 0; i < texture->level_count; ++i) {
        uint8_t* at = head + HEADER + LEVEL_INDEX * i;
        ty_put_le64(at, stored[i].offset);
        ty_put_le64(at + 8, stored[i].count);
        ty_put_le64(at + 16, texture->levels[i].count);
    }
    ty_output output;
    const ty_result result = ty_output_open(context, path, &output);
    if (result != TY_OK) return result;
    ty_output_write(&output, head, head_size);
    ty_output_write(&output, descriptor, descriptor_size);
    ty_output_write(&output, values, values_size);
    for (int32_t i = texture->level_count - 1; i >= 0; --i) {
        static const uint8_t zeros[16] = {0};
        ty_output_write(&output, zeros, (size_t)(stored[i].offset - ty_output_position(&output)));
        ty_output_write(&output, stored[i].bytes, stored[i].count);
    }
    return ty_output_commit(context, &output);
}

ty_result ty_write_ktx2(ty_context* context, const ty_stored_texture* texture, const char* path) {
    stored_level stored[TY_TEXTURE_LEVELS_MAX] = {{.bytes = NULL}};
    ty_result result = store_levels(context, texture, stored);
    if (result == TY_OK) result = write_file(context, texture, stored, path);
    for (int32_t i = 0; i < texture->level_count; ++i)
        if (stored[i].packed != NULL) ty_free_array(context, stored[i].packed, stored[i].capacity, 1);
    return result;
}
