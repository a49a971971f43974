/* Reading WebP through libwebp: still images, with or without alpha. */
#include "io/images/image_file.h"

#include "base/context.h"

#if TYNDALL_WEBP

#include <webp/decode.h>

ty_result ty_read_webp(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_samples* out) {
    WebPBitstreamFeatures features;
    if (WebPGetFeatures(bytes, size, &features) != VP8_STATUS_OK)
        return ty_fail(context, TY_ERROR_INPUT, "%s: the WebP header is damaged or cut short", path);
    if (features.has_animation)
        return ty_fail(context, TY_ERROR_INPUT, "%s: an animated WebP; only still images can be read", path);
    const int32_t channels = features.has_alpha ? 4 : 3;
    ty_result result = ty_check_image_size(context, path, size, features.width, features.height, channels);
    ty_samples samples;
    if (result == TY_OK)
        result = ty_create_samples(context, features.width, features.height, channels, false, &samples);
    if (result != TY_OK) return result;
    const int stride = features.width * channels;
    const uint8_t* decoded = channels == 4 ? WebPDecodeRGBAInto(bytes, size, samples.data, samples.size, stride)
                                           : WebPDecodeRGBInto(bytes, size, samples.data, samples.size, stride);
    if (decoded == NULL) {
        ty_free_samples(context, &samples);
        return ty_fail(context, TY_ERROR_INPUT, "%s: cannot decode this WebP: it is damaged or cut short", path);
    }
    *out = samples;
    return TY_OK;
}

#else

ty_result ty_read_webp(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_samples* out) {
    (void)bytes;
    (void)size;
    (void)out;
    return ty_fail(context, TY_ERROR_INPUT,
                   "%s: a WebP image, which this build was made without; \"dwebp\" converts it to PNG", path);
}

#endif
