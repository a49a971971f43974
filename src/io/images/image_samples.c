/* Conversion of 8- and 16-bit samples of PNG, JPEG and WebP files to images and textures. */
#include "io/images/image_file.h"

#include "base/context.h"

ty_result ty_create_samples(ty_context* context, int32_t width, int32_t height, int32_t channels, bool wide,
                            ty_samples* out) {
    const size_t pixels = (size_t)width * (size_t)height, pixel_size = (size_t)channels * (wide ? 2 : 1);
    void* data = ty_alloc_array(context, pixels, pixel_size, false);
    if (data == NULL) return TY_ERROR_MEMORY;
    *out = (ty_samples){width, height, channels, wide, data, pixels * pixel_size};
    return TY_OK;
}

void ty_free_samples(ty_context* context, ty_samples* samples) {
    ty_free_array(context, samples->data, samples->size, 1);
    *samples = (ty_samples){0};
}

static uint32_t sample(const ty_samples* samples, size_t index) {
    return samples->wide ? ((const uint16_t*)samples->data)[index] : ((const uint8_t*)samples->data)[index];
}

/* Table of float values per sample value; a pow per pixel would take longer than reading the file. */
static void fill_table(float* table, uint32_t max, ty_sample_use use) {
    for (uint32_t i = 0; i <= max; ++i) {
        const float value = (float)i / (float)max;
        table[i] = use == TY_SAMPLES_WHOLE ? (float)i : use == TY_SAMPLES_RAW ? value : ty_linear_from_srgb(value);
    }
}

ty_result ty_image_from_samples(ty_context* context, const ty_samples* samples, ty_sample_use use, ty_image** out) {
    static const char* const names[4][4] = {{"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
    const uint32_t max = samples->wide ? 65535 : 255;
    const int32_t channels = samples->channels;
    float* table = ty_alloc_array(context, max + 1, sizeof *table, false);
    if (table == NULL) return TY_ERROR_MEMORY;
    ty_image* image = NULL;
    const ty_result result =
        ty_image_create(context, samples->width, samples->height, channels, names[channels - 1], &image);
    for (int32_t c = 0; result == TY_OK && c < channels; ++c) {
        const bool alpha = c + 1 == channels && channels % 2 == 0;
        float* plane = ty_image_plane(image, c);
        if (c == 0 || alpha) fill_table(table, max, alpha && use == TY_SAMPLES_LINEAR ? TY_SAMPLES_RAW : use);
        for (size_t i = 0; i < (size_t)samples->width * (size_t)samples->height; ++i)
            plane[i] = table[sample(samples, i * (size_t)channels + (size_t)c)];
    }
    ty_free_array(context, table, max + 1, sizeof *table);
    if (result == TY_OK) *out = image;
    return result;
}

static uint8_t byte_sample(const ty_samples* samples, size_t index) {
    const uint32_t value = sample(samples, index);
    return (uint8_t)(samples->wide ? (value + 128) / 257 : value);
}

/* Expands gray to R, G and B, and missing alpha to opaque. */
static void spread_rgba(const ty_samples* samples, uint8_t* rgba8) {
    const size_t channels = (size_t)samples->channels;
    const size_t colours = channels < 3 ? 1 : 3;
    for (size_t i = 0; i < (size_t)samples->width * (size_t)samples->height; ++i) {
        for (size_t c = 0; c < 3; ++c) rgba8[4 * i + c] = byte_sample(samples, i * channels + c % colours);
        rgba8[4 * i + 3] = channels > colours ? byte_sample(samples, i * channels + colours) : 255;
    }
}

static ty_result read_samples(ty_context* context, const char* path, const uint8_t* bytes, size_t size,
                              ty_samples* out) {
    switch (ty_image_format_of(bytes, size)) {
    case TY_IMAGE_PNG: return ty_read_png(context, path, bytes, size, out);
    case TY_IMAGE_JPEG: return ty_read_jpeg(context, path, bytes, size, out);
    case TY_IMAGE_WEBP: return ty_read_webp(context, path, bytes, size, out);
    default: return ty_fail(context, TY_ERROR_INPUT, "%s: neither a PNG, a JPEG nor a WebP image", path);
    }
}

ty_result ty_decode_rgba8(ty_context* context, const char* path, const uint8_t* bytes, size_t size, int32_t* width,
                          int32_t* height, uint8_t** rgba8) {
    ty_samples samples;
    const ty_result result = read_samples(context, path, bytes, size, &samples);
    if (result != TY_OK) return result;
    uint8_t* spread = ty_alloc_array(context, (size_t)samples.width * (size_t)samples.height, 4, false);
    if (spread != NULL) {
        spread_rgba(&samples, spread);
        *width = samples.width;
        *height = samples.height;
        *rgba8 = spread;
    }
    ty_free_samples(context, &samples);
    return spread == NULL ? TY_ERROR_MEMORY : TY_OK;
}
