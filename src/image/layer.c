/* Layers: groups of channels with a common name prefix, "layer.NAME". */
#include "image/image.h"

#include "base/context.h"

#include <stdio.h>
#include <string.h>
#include <tyndall/io.h>

enum { LIST_SIZE = 256 };

/* The name of a channel within a layer; NULL: it is not in the layer. */
static const char* name_within(const char* channel, const char* layer) {
    const size_t length = strlen(layer);
    if (length == 0) return strchr(channel, '.') == NULL ? channel : NULL;
    const bool within = strncmp(channel, layer, length) == 0 && channel[length] == '.' && channel[length + 1] != '\0';
    return within ? channel + length + 1 : NULL;
}

/* The length of a channel's layer name: everything before the last dot, or "". */
static size_t layer_length(const char* channel) {
    const char* dot = strrchr(channel, '.');
    return dot == NULL ? 0 : (size_t)(dot - channel);
}

static bool named_before(const ty_image* image, int32_t channel, size_t length) {
    for (int32_t i = 0; i < channel; ++i)
        if (layer_length(image->names[i]) == length && strncmp(image->names[i], image->names[channel], length) == 0)
            return true;
    return false;
}

/* Lists every layer once, in quotes, as far as the text has space. */
static void list_layers(const ty_image* image, char list[LIST_SIZE]) {
    size_t used = 0;
    for (int32_t i = 0; i < image->channel_count; ++i) {
        const size_t length = layer_length(image->names[i]);
        if (named_before(image, i, length)) continue;
        if (used + length + sizeof ", \"\", ..." > LIST_SIZE) {
            memcpy(list + used, ", ...", sizeof ", ...");
            return;
        }
        used += (size_t)snprintf(list + used, LIST_SIZE - used, "%s\"%.*s\"", used == 0 ? "" : ", ", (int)length,
                                 image->names[i]);
    }
}

static ty_result create_layer(ty_context* context, const ty_image* image, const char* const* names, int32_t count,
                              const char* layer, ty_image** out) {
    ty_image* created = NULL;
    ty_result result = ty_image_create(context, image->width, image->height, count, names, &created);
    if (result == TY_OK) result = ty_image_copy_metadata(image, created);
    if (result != TY_OK) {
        ty_image_destroy(created);
        return result;
    }
    memcpy(created->frame, image->frame, sizeof created->frame);
    for (int32_t i = 0, to = 0; i < image->channel_count; ++i)
        if (name_within(image->names[i], layer) != NULL)
            memcpy(ty_image_plane(created, to++), ty_image_plane_const(image, i),
                   (size_t)image->width * (size_t)image->height * sizeof(float));
    *out = created;
    return TY_OK;
}

ty_result ty_image_create_layer(ty_context* context, const ty_image* image, const char* layer, ty_image** out) {
    if (image == NULL || layer == NULL || out == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_image_create_layer: an argument is NULL");
    const size_t capacity = (size_t)image->channel_count;
    const char** names = ty_alloc_array(context, capacity, sizeof *names, false);
    if (names == NULL) return TY_ERROR_MEMORY;
    int32_t count = 0;
    for (int32_t i = 0; i < image->channel_count; ++i) {
        const char* name = name_within(image->names[i], layer);
        if (name != NULL) names[count++] = name;
    }
    ty_result result;
    if (count > 0) {
        result = create_layer(context, image, names, count, layer, out);
    } else {
        char list[LIST_SIZE] = "";
        list_layers(image, list);
        result = ty_fail(context, TY_ERROR_ARGUMENT, "the image has no layer \"%s\"; it has %s", layer, list);
    }
    ty_free_array(context, names, capacity, sizeof *names);
    return result;
}

/* ---- all channels but one ---- */

static ty_result copy_without(ty_context* context, const ty_image* image, int32_t left_out, ty_image** out) {
    const size_t capacity = (size_t)image->channel_count;
    const char** names = ty_alloc_array(context, capacity, sizeof *names, false);
    if (names == NULL) return TY_ERROR_MEMORY;
    int32_t kept = 0;
    for (int32_t i = 0; i < image->channel_count; ++i)
        if (i != left_out) names[kept++] = image->names[i];
    const ty_result result = ty_image_create(context, image->width, image->height, kept, names, out);
    ty_free_array(context, names, capacity, sizeof *names);
    if (result != TY_OK) return result;
    memcpy((*out)->frame, image->frame, sizeof image->frame);
    for (int32_t i = 0; i < kept; ++i)
        memcpy(ty_image_plane(*out, i), ty_image_plane_const(image, i < left_out ? i : i + 1),
               sizeof(float) * (size_t)image->width * (size_t)image->height);
    return TY_OK;
}

ty_result ty_image_drop_channel(ty_context* context, ty_image** image, const char* name) {
    const int32_t channel = ty_image_find_channel(*image, name);
    if (channel < 0) return TY_OK;
    ty_image* rest = NULL;
    const ty_result result = copy_without(context, *image, channel, &rest);
    if (result != TY_OK) return result;
    ty_image_destroy(*image);
    *image = rest;
    return TY_OK;
}

/* ---- some channels of two images ---- */

ty_result ty_image_select(ty_context* context, const ty_image* first, const ty_image* second, int32_t count,
                          const char* const* names, ty_image** out) {
    ty_image* image = NULL;
    ty_result result = ty_image_create(context, first->width, first->height, count, names, &image);
    if (result == TY_OK) result = ty_image_copy_metadata(first, image);
    if (result != TY_OK) {
        ty_image_destroy(image);
        return result;
    }
    memcpy(image->frame, first->frame, sizeof image->frame);
    for (int32_t i = 0; i < count; ++i) {
        const int32_t of_second = ty_image_find_channel(second, names[i]);
        const float* from = of_second >= 0 ? ty_image_plane_const(second, of_second)
                                           : ty_image_plane_const(first, ty_image_find_channel(first, names[i]));
        memcpy(ty_image_plane(image, i), from, sizeof(float) * (size_t)image->width * (size_t)image->height);
    }
    *out = image;
    return TY_OK;
}
