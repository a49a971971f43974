/* Textures of images: checks, levels, and the choice of the file's format. */
#include "base/context.h"
#include "io/images/image_file.h"
#include "io/textures/textures.h"
#include "option/option.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

enum { ZSTD_LEVEL_MAX = 22 };

static const char* const format_names[] = {"bc6h", "bc6h-signed", "half", "float", "rgb9e5", "rgbe", "rgbm", NULL};

static const ty_option options[] = {
    {TY_OPTION_FIELD(ty_texels_def, format), .type = TY_OPTION_WORD, .words = format_names, .doc = "Texels."},
    {TY_OPTION_FIELD(ty_texels_def, slices), .type = TY_OPTION_INT, .min = 0, .max = TY_TEXTURE_SIDE_MAX_3D,
     .doc = "Slices of a volume, one below the other in the image; 0: two dimensions."},
    {TY_OPTION_FIELD(ty_texels_def, mipmaps), .type = TY_OPTION_BOOL, .doc = "Smaller levels."},
    {TY_OPTION_FIELD(ty_texels_def, zstd), .type = TY_OPTION_INT, .min = 0, .max = ZSTD_LEVEL_MAX,
     .doc = "Level of Zstandard's compression; 0: none."},
    {TY_OPTION_FIELD(ty_texels_def, range), .type = TY_OPTION_DOUBLE, .min = 0, .max = 1e30,
     .doc = "Largest value of RGBM; 0: that of the image."},
};

static const ty_option_table table = TY_OPTION_TABLE("texels", ty_texels_def, "ty_default_texels_def", options);

void ty_init_texels_def(void* def, size_t bytes) {
    ty_options_init(&table, def, bytes);
}

static bool ends_with(const char* path, const char* extension) {
    const size_t length = strlen(path), tail = strlen(extension);
    return length > tail && strcasecmp(path + length - tail, extension) == 0;
}

/* ---- Levels ---- */

/* The floats of a level, four a texel. */
typedef struct float_level {
    float* rgba;
    size_t texels;
    int32_t size[3];
} float_level;

static ty_result open_level(ty_context* context, const int32_t size[3], float_level* out) {
    *out = (float_level){.texels = (size_t)size[0] * (size_t)size[1] * (size_t)size[2],
                         .size = {size[0], size[1], size[2]}};
    out->rgba = ty_alloc_array(context, out->texels, 4 * sizeof *out->rgba, false);
    return out->rgba == NULL ? TY_ERROR_MEMORY : TY_OK;
}

static void close_level(ty_context* context, float_level* level) {
    if (level->rgba != NULL) ty_free_array(context, level->rgba, level->texels, 4 * sizeof *level->rgba);
    level->rgba = NULL;
}

/* Slices of an image lie one below the other, as those of a volume do in memory. */
static ty_result first_level(ty_context* context, const ty_image* image, const int32_t size[3], float_level* out) {
    const float* planes[3];
    const int32_t alpha = ty_image_find_channel(image, "A");
    if (!ty_image_rgb_planes(image, planes))
        return ty_fail(context, TY_ERROR_ARGUMENT, "a texture needs the channels R, G and B");
    const ty_result result = open_level(context, size, out);
    if (result != TY_OK) return result;
    const float* alphas = alpha < 0 ? NULL : ty_image_plane_const(image, alpha);
    for (size_t i = 0; i < out->texels; ++i)
        for (size_t c = 0; c < 4; ++c) {
            const float value = c < 3 ? planes[c][i] : alphas == NULL ? 1.0f : alphas[i];
            out->rgba[4 * i + c] = isfinite(value) ? value : 0;
        }
    return TY_OK;
}

/* Means over 2 texels along each axis; the last texel of an odd side counts alone. */
static ty_result next_level(ty_context* context, const float_level* from, float_level* out) {
    int32_t size[3];
    for (int a = 0; a < 3; ++a) size[a] = from->size[a] > 1 ? from->size[a] / 2 : 1;
    const ty_result result = open_level(context, size, out);
    if (result != TY_OK) return result;
    for (size_t i = 0; i < 4 * out->texels; ++i) {
        const size_t texel = i / 4, width = (size_t)size[0], height = (size_t)size[1];
        const size_t at[3] = {texel % width, texel / width % height, texel / (width * height)};
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            size_t source[3];
            for (int a = 0; a < 3; ++a) {
                const size_t moved = 2 * at[a] + (size_t)(corner >> a & 1), last = (size_t)from->size[a] - 1;
                source[a] = moved < last ? moved : last;
            }
            const size_t index = (source[2] * (size_t)from->size[1] + source[1]) * (size_t)from->size[0] + source[0];
            sum += (double)from->rgba[4 * index + i % 4];
        }
        out->rgba[i] = (float)(sum / 8);
    }
    return TY_OK;
}

static ty_result encode_level(ty_context* context, const float_level* from, ty_stored_texture* texture) {
    ty_texture_level* level = &texture->levels[texture->level_count];
    memcpy(level->size, from->size, sizeof level->size);
    level->count = ty_texel_bytes(texture->format, from->size);
    level->bytes = ty_alloc_array(context, level->count, 1, false);
    if (level->bytes == NULL) return TY_ERROR_MEMORY;
    ++texture->level_count;
    return ty_encode_texels(context, texture->format, texture->range, from->rgba, from->size, level->bytes);
}

static ty_result encode_levels(ty_context* context, float_level* level, bool mipmaps, ty_stored_texture* texture) {
    ty_result result = encode_level(context, level, texture);
    while (result == TY_OK && mipmaps && (level->size[0] > 1 || level->size[1] > 1 || level->size[2] > 1)) {
        float_level smaller;
        result = next_level(context, level, &smaller);
        close_level(context, level);
        *level = smaller;
        if (result == TY_OK) result = encode_level(context, level, texture);
    }
    return result;
}

static void free_levels(ty_context* context, ty_stored_texture* texture) {
    for (int32_t i = 0; i < texture->level_count; ++i)
        ty_free_array(context, texture->levels[i].bytes, texture->levels[i].count, 1);
}

/* ---- Files ---- */

static ty_result check(ty_context* context, const ty_image* image, const ty_texels_def* def, const char* path) {
    const bool ktx2 = ends_with(path, ".ktx2"), png = ends_with(path, ".png");
    if (!ktx2 && !png && !ends_with(path, ".dds"))
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: a texture goes to .ktx2, .dds or .png", path);
    if (png && ((def->format != TY_TEXELS_RGBE && def->format != TY_TEXELS_RGBM) || def->slices > 0 || def->mipmaps))
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "%s: a PNG holds rgbe and rgbm, in two dimensions and without smaller levels", path);
    if (def->zstd > 0 && !ktx2)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: Zstandard is of .ktx2 files alone", path);
    if (def->zstd > 0 && !ty_has_zstd())
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: this build was made without Zstandard", path);
    if (def->slices == 0) return TY_OK;
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    if (height % def->slices != 0)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: %d rows cannot be divided into %d slices", path, (int)height,
                       (int)def->slices);
    if (width > TY_TEXTURE_SIDE_MAX_3D || height / def->slices > TY_TEXTURE_SIDE_MAX_3D)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: a volume has at most %d texels a side", path,
                       TY_TEXTURE_SIDE_MAX_3D);
    return TY_OK;
}

/* The range of RGBM, where none is given: the largest value. */
static double find_range(const float_level* level) {
    float largest = 0;
    for (size_t i = 0; i < 4 * level->texels; ++i)
        if (i % 4 < 3) largest = fmaxf(largest, level->rgba[i]);
    return largest > 0 ? (double)largest : 1;
}

static ty_result write_png(ty_context* context, const ty_stored_texture* texture, const char* path) {
    char range[32];
    snprintf(range, sizeof range, "%.9g", texture->range);
    return ty_write_png_rgba8(context, texture->levels[0].bytes, texture->size[0], texture->size[1],
                              texture->format == TY_TEXELS_RGBM ? range : NULL, path);
}

ty_result ty_texels_write(ty_context* context, const ty_image* image, const ty_texels_def* def, const char* path) {
    ty_texels_def own;
    if (image == NULL || path == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_texels_write: an argument is NULL");
    ty_result result = ty_options_take(context, &table, def, &own);
    if (result == TY_OK) result = check(context, image, &own, path);
    if (result != TY_OK) return result;
    const int32_t slices = own.slices > 0 ? own.slices : 1;
    const int32_t size[3] = {ty_image_width(image), ty_image_height(image) / slices, slices};
    ty_stored_texture texture = {.format = own.format, .size = {size[0], size[1], own.slices}, .zstd = own.zstd};
    float_level level = {.rgba = NULL};
    result = first_level(context, image, size, &level);
    if (result == TY_OK) {
        texture.range = own.range > 0 ? own.range : find_range(&level);
        result = encode_levels(context, &level, own.mipmaps, &texture);
    }
    close_level(context, &level);
    if (result == TY_OK)
        result = ends_with(path, ".ktx2")  ? ty_write_ktx2(context, &texture, path)
                 : ends_with(path, ".dds") ? ty_write_dds(context, &texture, path)
                                           : write_png(context, &texture, path);
    free_levels(context, &texture);
    return result;
}
