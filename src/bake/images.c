/* Images of baked light at vertices and probes. */
#include "base/context.h"

#include <math.h>
#include <stdio.h>
#include <tyndall/bake.h>

enum { SIDE_MAX = 65536, NAME_SIZE = 24 };

static const char* const layer_names[TY_BAKE_LAYERS] = {"direct", "indirect", "single", "multiple"};
static const char colors[] = "RGB";

static float finite_or_zero(float value) {
    return isfinite(value) ? value : 0;
}

/* Channels of an image being assembled: names, then planes in the same order. */
typedef struct channel_list {
    char (*names)[NAME_SIZE];
    const char** pointers;
    int32_t count, capacity;
} channel_list;

static ty_result open_list(ty_context* context, int32_t capacity, channel_list* list) {
    *list = (channel_list){.capacity = capacity};
    list->names = ty_alloc_array(context, (size_t)capacity, sizeof *list->names, true);
    list->pointers = ty_alloc_array(context, (size_t)capacity, sizeof *list->pointers, true);
    if (list->names == NULL || list->pointers == NULL) return TY_ERROR_MEMORY;
    for (int32_t i = 0; i < capacity; ++i) list->pointers[i] = list->names[i];
    return TY_OK;
}

static void close_list(ty_context* context, channel_list* list) {
    ty_free_array(context, list->names, (size_t)list->capacity, sizeof *list->names);
    ty_free_array(context, list->pointers, (size_t)list->capacity, sizeof *list->pointers);
}

/* "PREFIXR", "PREFIXG", "PREFIXB". */
static void add_colors(channel_list* list, const char* prefix) {
    for (int c = 0; c < 3; ++c)
        snprintf(list->names[list->count++], NAME_SIZE, "%.*s%c", NAME_SIZE - 2, prefix, colors[c]);
}

static void add_one(channel_list* list, const char* name) {
    snprintf(list->names[list->count++], NAME_SIZE, "%s", name);
}

/* ---- surfaces ---- */

enum { LIGHT_CHANNELS = 3 + 3 * TY_BAKE_LAYERS + 9 + 1 + 3, PROBE_EXTRAS = 3 + 5 };

static void list_light_channels(channel_list* list) {
    char prefix[NAME_SIZE];
    add_colors(list, "");
    for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer) {
        snprintf(prefix, sizeof prefix, "%s.", layer_names[layer]);
        add_colors(list, prefix);
    }
    for (int c = 0; c < 3; ++c)
        for (int axis = 0; axis < 3; ++axis)
            snprintf(list->names[list->count++], NAME_SIZE, "L1.%c%c", colors[c], "XYZ"[axis]);
    add_one(list, "samples.N");
    add_colors(list, "variance.");
}

/* The vector irradiance divided by the fluence, which bounds its length. */
static void write_direction(const ty_bake_light* light, int c, float out[3]) {
    float vector[3] = {0, 0, 0}, square = 0;
    for (int axis = 0; axis < 3; ++axis) {
        for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer)
            vector[axis] += finite_or_zero(light->vector_irradiance[layer][c][axis]);
        square += vector[axis] * vector[axis];
    }
    const float norm = fmaxf(finite_or_zero(light->fluence[c]), sqrtf(square));
    for (int axis = 0; axis < 3; ++axis) out[axis] = norm > 0 ? vector[axis] / norm : 0;
}

static void light_values(const ty_bake_light* light, float values[LIGHT_CHANNELS]) {
    for (int c = 0; c < 3; ++c) {
        values[c] = 0;
        for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer) {
            const float irradiance = finite_or_zero(light->irradiance[layer][c]);
            values[3 + 3 * layer + c] = irradiance;
            values[c] += irradiance;
        }
        write_direction(light, c, values + 3 + 3 * TY_BAKE_LAYERS + 3 * c);
        values[LIGHT_CHANNELS - 3 + c] = finite_or_zero(light->variance[c]);
    }
    values[LIGHT_CHANNELS - 4] = (float)light->samples;
}

static ty_result check_size(ty_context* context, int64_t width, int64_t height) {
    if (width >= 1 && height >= 1 && width <= SIDE_MAX && height <= SIDE_MAX) return TY_OK;
    return ty_fail(context, TY_ERROR_ARGUMENT, "an image of %lld x %lld pixels: sides are 1..65536", (long long)width,
                   (long long)height);
}

ty_result ty_bake_create_light_image(ty_context* context, const ty_bake_light* light, int64_t count, int32_t width,
                                     ty_image** out) {
    const int64_t height = width > 0 ? (count + width - 1) / width : 0;
    ty_result result = check_size(context, width, height);
    if (result == TY_OK && (light == NULL || out == NULL))
        result = ty_fail(context, TY_ERROR_ARGUMENT, "ty_bake_create_light_image: light or out is NULL");
    if (result != TY_OK) return result;
    channel_list list;
    ty_image* image = NULL;
    result = open_list(context, LIGHT_CHANNELS, &list);
    if (result == TY_OK) {
        list_light_channels(&list);
        result = ty_image_create(context, width, (int32_t)height, list.count, list.pointers, &image);
    }
    for (int64_t i = 0; i < count && result == TY_OK; ++i) {
        float values[LIGHT_CHANNELS];
        light_values(&light[i], values);
        for (int32_t channel = 0; channel < LIGHT_CHANNELS; ++channel)
            ty_image_plane(image, channel)[i] = values[channel];
    }
    close_list(context, &list);
    if (result == TY_OK) *out = image;
    return result;
}

/* ---- probes ---- */

static void list_probe_channels(channel_list* list, int32_t terms) {
    char prefix[NAME_SIZE];
    add_colors(list, "");
    for (int layer = -1; layer < TY_BAKE_LAYERS; ++layer)
        for (int32_t t = 0; t < terms; ++t) {
            snprintf(prefix, sizeof prefix, "%s%ssh%d.", layer < 0 ? "" : layer_names[layer], layer < 0 ? "" : ".",
                     (int)t);
            add_colors(list, prefix);
        }
    add_one(list, "blocked.Z");
    add_one(list, "samples.N");
    add_colors(list, "variance.");
}

void ty_bake_probe_sum(const ty_bake_probe* probe, float sh[3][TY_BAKE_SH_TERMS]) {
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < TY_BAKE_SH_TERMS; ++t) {
            sh[c][t] = 0;
            for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer) sh[c][t] += finite_or_zero(probe->sh[layer][c][t]);
        }
}

/* Writes one probe in the order of the channels. */
static void write_probe(const ty_bake_probe* probe, int32_t terms, ty_image* image, int64_t pixel) {
    static const float mean_of_first = 0.28209479f; /* ratio of a constant radiance to its first coefficient */
    float sum[3][TY_BAKE_SH_TERMS];
    int32_t at = 0;
    ty_bake_probe_sum(probe, sum);
    for (int c = 0; c < 3; ++c) ty_image_plane(image, at++)[pixel] = mean_of_first * sum[c][0];
    for (int layer = -1; layer < TY_BAKE_LAYERS; ++layer)
        for (int32_t t = 0; t < terms; ++t)
            for (int c = 0; c < 3; ++c)
                ty_image_plane(image, at++)[pixel] = layer < 0 ? sum[c][t] : finite_or_zero(probe->sh[layer][c][t]);
    ty_image_plane(image, at++)[pixel] = probe->blocked;
    ty_image_plane(image, at++)[pixel] = (float)probe->samples;
    for (int c = 0; c < 3; ++c) ty_image_plane(image, at++)[pixel] = finite_or_zero(probe->variance[c]);
}

ty_result ty_bake_create_probe_image(ty_context* context, const ty_bake_probe* probes, const int32_t size[3],
                                     int32_t terms, ty_image** out) {
    if (probes == NULL || out == NULL || (terms != 9 && terms != TY_BAKE_SH_TERMS))
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "ty_bake_create_probe_image: probes or out is NULL, or terms are neither 9 nor 25");
    const int64_t height = (int64_t)size[1] * size[2];
    ty_result result = size[1] < 1 || size[2] < 1 ? check_size(context, 0, 0) : check_size(context, size[0], height);
    if (result != TY_OK) return result;
    channel_list list;
    ty_image* image = NULL;
    result = open_list(context, PROBE_EXTRAS + 3 * terms * (1 + TY_BAKE_LAYERS), &list);
    if (result == TY_OK) {
        list_probe_channels(&list, terms);
        result = ty_image_create(context, size[0], (int32_t)height, list.count, list.pointers, &image);
    }
    for (int64_t i = 0; i < size[0] * height && result == TY_OK; ++i) write_probe(&probes[i], terms, image, i);
    close_list(context, &list);
    if (result == TY_OK) *out = image;
    return result;
}
