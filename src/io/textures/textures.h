/* Textures: their levels as bytes, and the files that hold them. */
#ifndef TY_IO_TEXTURES_TEXTURES_H
#define TY_IO_TEXTURES_TEXTURES_H

#include <tyndall/texels.h>

enum { TY_TEXTURE_LEVELS_MAX = 17, TY_TEXTURE_SIDE_MAX_3D = 4096 };

/* The texels of one level: rows from the top, slice by slice, BC6H in blocks. */
typedef struct ty_texture_level {
    int32_t size[3]; /* depth 1 for textures of two dimensions */
    uint8_t* bytes;
    size_t count; /* bytes */
} ty_texture_level;

typedef struct ty_stored_texture {
    ty_texel_format format;
    int32_t size[3]; /* depth 0 for textures of two dimensions */
    int32_t level_count;
    ty_texture_level levels[TY_TEXTURE_LEVELS_MAX];
    double range; /* of RGBM */
    int32_t zstd; /* 0: none */
} ty_stored_texture;

/* ---- texels.c ---- */

/* Bytes of a level of so many texels. */
size_t ty_texel_bytes(ty_texel_format format, const int32_t size[3]);
/* Encodes width x height x depth texels of four floats, which are finite. */
ty_result ty_encode_texels(ty_context* context, ty_texel_format format, double range, const float* rgba,
                           const int32_t size[3], uint8_t* out);

/* ---- ktx2.c, dds.c ---- */

ty_result ty_write_ktx2(ty_context* context, const ty_stored_texture* texture, const char* path);
ty_result ty_write_dds(ty_context* context, const ty_stored_texture* texture, const char* path);

/* ---- zstd.c ---- */

/* Tells whether this build has Zstandard. */
bool ty_has_zstd(void);
/* Bytes that `size` bytes may become, at most. */
size_t ty_zstd_bound(size_t size);
/* Compresses; *written are the bytes of `out`, which holds `capacity`. */
ty_result ty_zstd_compress(ty_context* context, int32_t level, const uint8_t* bytes, size_t size, uint8_t* out,
                           size_t capacity, size_t* written);

/* Stores a number in little-endian order. */
static inline void ty_put_le32(uint8_t* at, uint32_t value) {
    for (int i = 0; i < 4; ++i) at[i] = (uint8_t)(value >> 8 * i);
}

static inline void ty_put_le64(uint8_t* at, uint64_t value) {
    for (int i = 0; i < 8; ++i) at[i] = (uint8_t)(value >> 8 * i);
}

#endif
