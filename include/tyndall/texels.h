/// @file texels.h
/// Textures that graphics interfaces load as they are: KTX2, DDS, and encodings of high dynamic range in PNG.
///
/// docs/engines.md explains the formats and what engines make of them. Apache-2.0.
#ifndef TYNDALL_TEXELS_H
#define TYNDALL_TEXELS_H

#include <tyndall/base.h>
#include <tyndall/image.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The texels of a texture. All hold linear values.
typedef enum ty_texel_format {
    TY_TEXELS_BC6H = 0,        ///< BC6H without signs, 1 byte a texel: 0..65504, below 0 becomes 0. KTX2, DDS.
    TY_TEXELS_BC6H_SIGNED = 1, ///< BC6H with signs, 1 byte a texel: -65504..65504. KTX2, DDS.
    TY_TEXELS_HALF = 2,        ///< Four half floats, 8 bytes a texel. KTX2, DDS.
    TY_TEXELS_FLOAT = 3,       ///< Four floats, 16 bytes a texel. KTX2, DDS.
    TY_TEXELS_RGB9E5 = 4, ///< Three mantissas of 9 bits and a common exponent, 4 bytes a texel: 0..65408. KTX2, DDS.
    TY_TEXELS_RGBE = 5,   ///< Three bytes and an exponent: byte 2^(a - 136). KTX2, DDS, PNG.
    TY_TEXELS_RGBM = 6    ///< Three bytes and a multiplier: byte a range / 255^2. KTX2, DDS, PNG.
} ty_texel_format;

/// The form of a texture. Create it with ty_default_texels_def().
typedef struct ty_texels_def {
    uint32_t cookie;        ///< Set by ty_default_texels_def() and checked.
    uint32_t bytes;         ///< Set by ty_default_texels_def() to the size of the structure, and checked.
    ty_texel_format format; ///< Default TY_TEXELS_BC6H.
    int32_t slices; ///< Slices of a volume, which lie one below the other in the image, 1..4096, a divisor of its
                    ///< height; default 0: the image is a texture of two dimensions.
    bool mipmaps;   ///< True: smaller levels, each the mean of the one before; default false.
    int32_t zstd;   ///< KTX2: level of Zstandard's compression, 1..22; default 0: none.
    double range;   ///< TY_TEXELS_RGBM: the largest value, > 0; default 0: that of the image.
} ty_texels_def;

/// Sets the `bytes` bytes of a ty_texels_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_texels_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_texels_def ty_default_texels_def(void) {
    ty_texels_def def;
    ty_init_texels_def(&def, sizeof def);
    return def;
}

/// Writes the channels R, G, B and A (1 without one) of an image as a texture, to .ktx2, .dds or .png by the extension.
/// The first row is v = 0. Values that are not finite become 0. Volumes have at most 4096 texels a side. RGBM's range
/// is in KTX2 and PNG files as `rgbm_range`. Errors: TY_ERROR_ARGUMENT (no RGB, slices that do not divide the height, a
/// format that the file cannot hold, Zstandard in a build without it), TY_ERROR_MEMORY, TY_ERROR_FILE.
TY_API ty_result ty_texels_write(ty_context* context, const ty_image* image, const ty_texels_def* def,
                                 const char* path);

#ifdef __cplusplus
}
#endif
#endif
