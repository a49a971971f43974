/* The image of a run: which channels there are and what they hold. */
#include "method/path/aov.h"

#include <math.h>

enum { CHANNELS_MAX = 26, NO_AOV = 0 };

/* Channels that belong together, in the order of the image. */
typedef struct channel_group {
    uint32_t aov;
    int count;
    const char* names[3];
} channel_group;

static const channel_group groups[] = {
    {NO_AOV, 3, {"R", "G", "B"}},
    {TY_AOV_VARIANCE, 3, {"variance.R", "variance.G", "variance.B"}},
    {TY_AOV_TRANSMITTANCE, 3, {"transmittance.R", "transmittance.G", "transmittance.B"}},
    {TY_AOV_DEPTH, 1, {"depth.Z"}},
    {TY_AOV_NORMAL, 3, {"normal.X", "normal.Y", "normal.Z"}},
    {TY_AOV_ALBEDO, 3, {"albedo.R", "albedo.G", "albedo.B"}},
    {TY_AOV_SINGLE, 3, {"single.R", "single.G", "single.B"}},
    {TY_AOV_MULTIPLE, 3, {"multiple.R", "multiple.G", "multiple.B"}},
    {TY_AOV_SAMPLES, 1, {"samples.N"}},
};
enum { GROUP_COUNT = sizeof groups / sizeof groups[0] };

static bool asked(const channel_group* group, uint32_t aovs) {
    return group->aov == NO_AOV || (group->aov & aovs) != 0;
}

bool ty_aovs_need_parts(uint32_t aovs) {
    return (aovs & ~(uint32_t)(TY_AOV_VARIANCE | TY_AOV_SAMPLES)) != 0;
}

bool ty_aovs_need_look(uint32_t aovs) {
    return (aovs & (uint32_t)(TY_AOV_TRANSMITTANCE | TY_AOV_DEPTH | TY_AOV_NORMAL | TY_AOV_ALBEDO)) != 0;
}

/* The names of all channels; returns how many there are. */
static int32_t list_channels(uint32_t aovs, const char* names[CHANNELS_MAX]) {
    int32_t count = 0;
    for (int g = 0; g < GROUP_COUNT; ++g)
        for (int c = 0; asked(&groups[g], aovs) && c < groups[g].count; ++c) names[count++] = groups[g].names[c];
    return count;
}

size_t ty_aovs_pixel_size(uint32_t aovs) {
    const char* names[CHANNELS_MAX];
    return sizeof(float) * (size_t)list_channels(aovs, names);
}

ty_result ty_path_image_create(const ty_path_run* run, ty_image** out) {
    const char* names[CHANNELS_MAX];
    const int32_t* crop = run->request.crop;
    ty_image* image = NULL;
    ty_result result =
        ty_image_create(run->context, crop[2], crop[3], list_channels(run->def->aovs, names), names, &image);
    if (result != TY_OK) return result;
    result = ty_image_set_frame(image, crop[0], crop[1], run->request.width, run->height);
    if (result == TY_OK)
        *out = image;
    else
        ty_image_destroy(image);
    return result;
}

static double unit_normal(const ty_path_parts* parts, int c) {
    const double* n = parts->normal;
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    return length > 0 ? n[c] / length : 0;
}

/* parts is NULL only for channels that need none. */
static double pixel_value(uint32_t aov, const ty_path_item* item, const ty_path_parts* parts, int c) {
    const double n = item->count > 0 ? item->count : 1;
    switch (aov) {
    case TY_AOV_VARIANCE: return ty_path_item_variance(item, c);
    case TY_AOV_TRANSMITTANCE: return parts->transmittance[c] / n;
    case TY_AOV_DEPTH: return parts->hits > 0 ? parts->depth / parts->hits : 0;
    case TY_AOV_NORMAL: return unit_normal(parts, c);
    case TY_AOV_ALBEDO: return parts->albedo[c] / n;
    case TY_AOV_SINGLE: return parts->single[c] / n;
    case TY_AOV_MULTIPLE: return parts->multiple[c] / n;
    case TY_AOV_SAMPLES: return item->count;
    default: return ty_path_item_mean(item, c);
    }
}

void ty_path_image_fill(const ty_path_run* run, ty_image* image) {
    int32_t channel = 0;
    for (int g = 0; g < GROUP_COUNT; ++g)
        for (int c = 0; asked(&groups[g], run->def->aovs) && c < groups[g].count; ++c) {
            float* plane = ty_image_plane(image, channel++);
            for (int64_t i = 0; i < run->item_count; ++i)
                plane[i] =
                    (float)pixel_value(groups[g].aov, &run->items[i], run->parts != NULL ? &run->parts[i] : NULL, c);
        }
}
