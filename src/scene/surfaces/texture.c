/* Textures: checks, storage, lookup from outside kernels. */
#include "scene/surfaces/texture.h"

#include "base/context.h"
#include "base/check.h"

#include <stdatomic.h>

enum { SIDE_MAX = 32768 };

struct ty_texture {
    ty_context* context;
    _Atomic int32_t owners;
    int32_t width, height;
    ty_wrap wrap[2];
    bool nearest;
    uint8_t* rgba8; /* one of the two is set */
    float* floats;
    float decode[256];
};

void ty_init_texture_def(void* def, size_t bytes) {
    const ty_texture_def own = {0};
    ty_init_def(def, bytes, &own, sizeof own);
}

static ty_result check_def(ty_context* context, const ty_texture_def** given, ty_texture_def* own) {
    *own = ty_default_texture_def();
    const ty_result result = ty_take_def(context, *given, "ty_default_texture_def", own, sizeof *own);
    const ty_texture_def* def = *given = own;
    if (result != TY_OK) return result;
    if ((def->rgba8 == NULL) == (def->image == NULL))
        return ty_fail(context, TY_ERROR_ARGUMENT, "texture: give one of rgba8 and image");
    if (def->rgba8 != NULL && (def->width < 1 || def->height < 1 || def->width > SIDE_MAX || def->height > SIDE_MAX))
        return ty_fail(context, TY_ERROR_ARGUMENT, "texture: %d x %d is not a size in 1..%d", def->width, def->height,
                       (int)SIDE_MAX);
    const float* planes[3];
    if (def->image != NULL && !ty_image_rgb_planes(def->image, planes))
        return ty_fail(context, TY_ERROR_ARGUMENT, "texture: the image has neither R, G and B nor one channel");
    for (int a = 0; a < 2; ++a)
        if (def->wrap[a] != TY_WRAP_REPEAT && def->wrap[a] != TY_WRAP_CLAMP && def->wrap[a] != TY_WRAP_MIRROR)
            return ty_fail(context, TY_ERROR_ARGUMENT, "texture.wrap[%d]: %d is not a ty_wrap", a, (int)def->wrap[a]);
    return TY_OK;
}

/* Inverse sRGB transfer function (IEC 61966-2-1) for 8-bit codes, or their own values. */
static void fill_decode(bool linear, float decode[256]) {
    for (int code = 0; code < 256; ++code) {
        const double value = code / 255.0;
        const double decoded = value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4);
        decode[code] = (float)(linear ? value : decoded);
    }
}

static float sanitize(float value) {
    return isfinite(value) && value > 0 ? fminf(value, (float)TY_COLOR_MAX) : 0.0f;
}

static void copy_image(ty_texture* texture, const ty_image* image) {
    const float* planes[3];
    ty_image_rgb_planes(image, planes);
    const float* alpha = ty_image_plane_const(image, ty_image_find_channel(image, "A"));
    const size_t count = (size_t)texture->width * (size_t)texture->height;
    for (size_t i = 0; i < count; ++i) {
        for (int c = 0; c < 3; ++c) texture->floats[4 * i + (size_t)c] = sanitize(planes[c][i]);
        texture->floats[4 * i + 3] = alpha != NULL ? fminf(sanitize(alpha[i]), 1.0f) : 1.0f;
    }
}

ty_result ty_texture_create(ty_context* context, const ty_texture_def* def, ty_texture** out) {
    ty_texture_def own;
    const ty_result result = check_def(context, &def, &own);
    if (result != TY_OK) return result;
    ty_texture* texture = ty_alloc_array(context, 1, sizeof *texture, true);
    if (texture == NULL) return TY_ERROR_MEMORY;
    texture->context = context;
    atomic_init(&texture->owners, 1);
    texture->width = def->image != NULL ? ty_image_width(def->image) : def->width;
    texture->height = def->image != NULL ? ty_image_height(def->image) : def->height;
    memcpy(texture->wrap, def->wrap, sizeof texture->wrap);
    texture->nearest = def->nearest;
    fill_decode(def->linear, texture->decode);
    const size_t count = (size_t)texture->width * (size_t)texture->height;
    if (def->image != NULL)
        texture->floats = ty_alloc_array(context, count, 4 * sizeof(float), false);
    else
        texture->rgba8 = ty_alloc_array(context, count, 4, false);
    if (texture->floats == NULL && texture->rgba8 == NULL) {
        ty_texture_release(texture);
        return TY_ERROR_MEMORY;
    }
    if (def->image != NULL)
        copy_image(texture, def->image);
    else
        memcpy(texture->rgba8, def->rgba8, 4 * count);
    *out = texture;
    return TY_OK;
}

ty_texture* ty_texture_retain(ty_texture* texture) {
    if (texture != NULL) atomic_fetch_add(&texture->owners, 1);
    return texture;
}

void ty_texture_release(ty_texture* texture) {
    if (texture == NULL || atomic_fetch_sub(&texture->owners, 1) > 1) return;
    const size_t count = (size_t)texture->width * (size_t)texture->height;
    ty_free_array(texture->context, texture->rgba8, count, 4);
    ty_free_array(texture->context, texture->floats, count, 4 * sizeof(float));
    ty_free_array(texture->context, texture, 1, sizeof *texture);
}

int32_t ty_texture_owners(const ty_texture* texture) {
    return atomic_load(&texture->owners);
}

ty_texture_view ty_texture_get_view(const ty_texture* texture) {
    if (texture == NULL) return (ty_texture_view){.rgba8 = NULL};
    return (ty_texture_view){.rgba8 = texture->rgba8,
                             .decode = texture->decode,
                             .floats = texture->floats,
                             .width = texture->width,
                             .height = texture->height,
                             .wrap = {(int32_t)texture->wrap[0], (int32_t)texture->wrap[1]},
                             .nearest = texture->nearest};
}

size_t ty_texture_bytes(const ty_texture* texture) {
    const size_t texel = texture->floats != NULL ? 4 * sizeof(float) : 4;
    return sizeof *texture + texel * (size_t)texture->width * (size_t)texture->height;
}

void ty_texture_sample(const ty_texture* texture, double u, double v, float rgba[4]) {
    const ty_texture_view view = ty_texture_get_view(texture);
    ty_texture_lookup(&view, (float)u, (float)v, rgba);
}
