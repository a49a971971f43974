/* Images: named float planes and metadata. */
#include "image/image.h"

#include "base/context.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PLANE_ALIGNMENT = 16 };

static bool name_allowed(const char* name) {
    if (name == NULL) return false;
    const size_t length = strlen(name);
    return length >= 1 && length <= TY_IMAGE_NAME_MAX;
}

static ty_result check_names(ty_context* context, int32_t count, const char* const* names) {
    if (count < 1 || count > TY_IMAGE_CHANNELS_MAX || names == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "an image has %d channels, outside 1..%d", (int)count,
                       (int)TY_IMAGE_CHANNELS_MAX);
    for (int32_t i = 0; i < count; ++i) {
        if (!name_allowed(names[i]))
            return ty_fail(context, TY_ERROR_ARGUMENT, "the name of image channel %d is not 1..%d characters long",
                           (int)i, (int)TY_IMAGE_NAME_MAX);
        for (int32_t j = 0; j < i; ++j)
            if (strcmp(names[i], names[j]) == 0)
                return ty_fail(context, TY_ERROR_ARGUMENT, "two image channels are called \"%s\"", names[i]);
    }
    return TY_OK;
}

ty_result ty_image_create(ty_context* context, int32_t width, int32_t height, int32_t channel_count,
                          const char* const* names, ty_image** out) {
    if (out == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_image_create: out is NULL");
    if (width < 1 || height < 1 || width > TY_IMAGE_SIDE_MAX || height > TY_IMAGE_SIDE_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT, "an image is %d x %d, outside 1..%d", (int)width, (int)height,
                       (int)TY_IMAGE_SIDE_MAX);
    const ty_result result = check_names(context, channel_count, names);
    if (result != TY_OK) return result;

    ty_image* image = ty_alloc_array(context, 1, sizeof *image, true);
    if (image == NULL) return TY_ERROR_MEMORY;
    image->context = context;
    image->width = width;
    image->height = height;
    image->channel_count = channel_count;
    image->frame[2] = width;
    image->frame[3] = height;
    const size_t pixels = (size_t)width * (size_t)height;
    image->plane_stride = (pixels + PLANE_ALIGNMENT - 1) / PLANE_ALIGNMENT * PLANE_ALIGNMENT;
    image->names = ty_alloc_array(context, (size_t)channel_count, sizeof *image->names, true);
    bool complete = image->names != NULL;
    for (int32_t i = 0; complete && i < channel_count; ++i) {
        image->names[i] = ty_copy_text(context, names[i]);
        complete = image->names[i] != NULL;
    }
    if (complete)
        image->pixels = ty_alloc_array(context, image->plane_stride * (size_t)channel_count, sizeof(float), true);
    if (image->pixels == NULL) {
        ty_image_destroy(image);
        return TY_ERROR_MEMORY;
    }
    *out = image;
    return TY_OK;
}

ty_result ty_image_create_rgb(ty_context* context, int32_t width, int32_t height, ty_image** out) {
    static const char* const names[] = {"R", "G", "B"};
    return ty_image_create(context, width, height, 3, names, out);
}

void ty_image_destroy(ty_image* image) {
    if (image == NULL) return;
    ty_context* context = image->context;
    for (size_t i = 0; i < image->metadata_count; ++i) ty_free_text(context, image->metadata[i].text);
    ty_free_array(context, image->metadata, image->metadata_capacity, sizeof *image->metadata);
    for (int32_t i = 0; image->names != NULL && i < image->channel_count; ++i) ty_free_text(context, image->names[i]);
    ty_free_array(context, image->names, (size_t)image->channel_count, sizeof *image->names);
    ty_free_array(context, image->pixels, image->plane_stride * (size_t)image->channel_count, sizeof(float));
    ty_free_array(context, image, 1, sizeof *image);
}

int32_t ty_image_width(const ty_image* image) {
    return image->width;
}

int32_t ty_image_height(const ty_image* image) {
    return image->height;
}

int32_t ty_image_channel_count(const ty_image* image) {
    return image->channel_count;
}

const char* ty_image_channel_name(const ty_image* image, int32_t channel) {
    return channel >= 0 && channel < image->channel_count ? image->names[channel] : NULL;
}

int32_t ty_image_find_channel(const ty_image* image, const char* name) {
    for (int32_t i = 0; name != NULL && i < image->channel_count; ++i)
        if (strcmp(image->names[i], name) == 0) return i;
    return -1;
}

float* ty_image_plane(ty_image* image, int32_t channel) {
    if (channel < 0 || channel >= image->channel_count) return NULL;
    return image->pixels + image->plane_stride * (size_t)channel;
}

const float* ty_image_plane_const(const ty_image* image, int32_t channel) {
    if (channel < 0 || channel >= image->channel_count) return NULL;
    return image->pixels + image->plane_stride * (size_t)channel;
}

bool ty_image_rgb_planes(const ty_image* image, const float* planes[3]) {
    static const char* const names[] = {"R", "G", "B"};
    int32_t found[3];
    for (int c = 0; c < 3; ++c) found[c] = ty_image_find_channel(image, names[c]);
    if (found[0] < 0 || found[1] < 0 || found[2] < 0) {
        const bool luminance = ty_image_find_channel(image, "X") < 0; /* Y beside X is a coordinate */
        found[0] = image->channel_count == 1 ? 0 : luminance ? ty_image_find_channel(image, "Y") : -1;
        if (found[0] < 0) return false;
        found[1] = found[2] = found[0];
    }
    for (int c = 0; c < 3; ++c) planes[c] = ty_image_plane_const(image, found[c]);
    return true;
}

bool ty_metadata_key_allowed(const char* key) {
    static const char* const reserved[] = {
        "channels",           "compression",        "dataWindow", "displayWindow", "lineOrder", "pixelAspectRatio",
        "screenWindowCenter", "screenWindowWidth",  "tiles",      "type",          "name",      "version",
        "chunkCount",         "maxSamplesPerPixel", "view",       "multiView",     "preview",   "envmap",
        "deepImageState"};
    if (key == NULL) return false;
    const size_t length = strspn(key, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_.");
    if (length < 1 || length > TY_METADATA_KEY_MAX || key[length] != '\0') return false;
    for (size_t i = 0; i < sizeof reserved / sizeof *reserved; ++i)
        if (strcmp(key, reserved[i]) == 0) return false;
    return true;
}

static ty_metadata* find_metadata(const ty_image* image, const char* key) {
    for (size_t i = 0; key != NULL && i < image->metadata_count; ++i)
        if (strcmp(image->metadata[i].key, key) == 0) return &image->metadata[i];
    return NULL;
}

static ty_result set_metadata(ty_image* image, const char* key, const char* text, bool is_number, double number) {
    ty_context* context = image->context;
    if (!ty_metadata_key_allowed(key))
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "the metadata key \"%s\" is not 1..%d of A-Z a-z 0-9 _ . or is one that OpenEXR itself uses",
                       key == NULL ? "" : key, (int)TY_METADATA_KEY_MAX);
    char* copy = ty_copy_text(context, text);
    if (copy == NULL) return TY_ERROR_MEMORY;
    ty_metadata* entry = find_metadata(image, key);
    if (entry == NULL) {
        if (!ty_grow_array(context, (void**)&image->metadata, &image->metadata_capacity, image->metadata_count,
                           sizeof *image->metadata)) {
            ty_free_text(context, copy);
            return TY_ERROR_MEMORY;
        }
        entry = &image->metadata[image->metadata_count++];
        *entry = (ty_metadata){0};
        memcpy(entry->key, key, strlen(key) + 1);
    }
    ty_free_text(context, entry->text);
    entry->text = copy;
    entry->is_number = is_number;
    entry->number = number;
    return TY_OK;
}

ty_result ty_image_set_text(ty_image* image, const char* key, const char* value) {
    return set_metadata(image, key, value, false, 0);
}

void ty_number_text(double value, char text[TY_NUMBER_TEXT_SIZE]) {
    for (int digits = 1; digits <= 17; ++digits) {
        snprintf(text, TY_NUMBER_TEXT_SIZE, "%.*g", digits, value);
        if (strtod(text, NULL) == value) break;
    }
    const size_t point = strspn(text, "-0123456789");
    if (text[point] != '\0' && strchr("einEIN", text[point]) == NULL) text[point] = '.';
}

ty_result ty_image_set_number(ty_image* image, const char* key, double value) {
    char text[TY_NUMBER_TEXT_SIZE];
    ty_number_text(value, text);
    return set_metadata(image, key, text, true, value);
}

ty_result ty_image_copy_metadata(const ty_image* from, ty_image* to) {
    for (size_t i = 0; i < from->metadata_count; ++i) {
        const ty_metadata* entry = &from->metadata[i];
        const ty_result result = set_metadata(to, entry->key, entry->text, entry->is_number, entry->number);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

ty_result ty_image_create_like(ty_context* context, const ty_image* image, int32_t width, int32_t height,
                               ty_image** out) {
    ty_image* created = NULL;
    ty_result result =
        ty_image_create(context, width, height, image->channel_count, (const char* const*)image->names, &created);
    if (result == TY_OK) result = ty_image_copy_metadata(image, created);
    if (result != TY_OK) {
        ty_image_destroy(created);
        return result;
    }
    *out = created;
    return TY_OK;
}

int32_t ty_image_metadata_count(const ty_image* image) {
    return (int32_t)image->metadata_count;
}

const char* ty_image_metadata_key(const ty_image* image, int32_t index) {
    return index >= 0 && (size_t)index < image->metadata_count ? image->metadata[index].key : NULL;
}

bool ty_image_metadata_is_number(const ty_image* image, int32_t index) {
    return index >= 0 && (size_t)index < image->metadata_count && image->metadata[index].is_number;
}

const char* ty_image_get_metadata(const ty_image* image, const char* key) {
    const ty_metadata* entry = find_metadata(image, key);
    return entry == NULL ? NULL : entry->text;
}
