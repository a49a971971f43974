/* Output image of a run: its channels and their values. */
#include "method/path/aov.h"

#include "image/aovs.h"

#include <math.h>

bool ty_aovs_need_classes(uint32_t aovs) {
    return (aovs & ~(uint32_t)(TY_AOV_VARIANCE | TY_AOV_SAMPLES)) != 0;
}

bool ty_aovs_need_first_hit(uint32_t aovs) {
    return (aovs & (uint32_t)(TY_AOV_TRANSMITTANCE | TY_AOV_DEPTH | TY_AOV_NORMAL | TY_AOV_ALBEDO |
                              TY_AOV_SURFACE_ALBEDO)) != 0;
}

size_t ty_aovs_pixel_size(uint32_t aovs) {
    const char* names[TY_AOV_CHANNELS_MAX];
    return sizeof(float) * (size_t)ty_aov_names(aovs, names);
}

ty_result ty_path_image_create(const ty_path_run* run, ty_image** out) {
    const char* names[TY_AOV_CHANNELS_MAX];
    const int32_t* crop = run->request.crop;
    ty_image* image = NULL;
    ty_result result =
        ty_image_create(run->context, crop[2], crop[3], ty_aov_names(run->def->aovs, names), names, &image);
    if (result != TY_OK) return result;
    result = ty_image_set_frame(image, crop[0], crop[1], run->request.width, run->height);
    if (result == TY_OK)
        *out = image;
    else
        ty_image_destroy(image);
    return result;
}

static double unit_normal(const ty_path_aov_sums* aov_sums, int c) {
    const double* n = aov_sums->normal;
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    return length > 0 ? n[c] / length : 0;
}

/* aov_sums may be NULL only for channels that do not read it. */
static double mean_value(uint32_t aov, const ty_path_item* item, const ty_path_aov_sums* aov_sums, int c) {
    const double n = item->count > 0 ? item->count : 1;
    switch (aov) {
    case TY_AOV_VARIANCE: return ty_path_item_variance(item, c);
    case TY_AOV_TRANSMITTANCE: return aov_sums->transmittance[c] / n;
    case TY_AOV_DEPTH: return aov_sums->hits > 0 ? aov_sums->depth / aov_sums->hits : 0;
    case TY_AOV_NORMAL: return unit_normal(aov_sums, c);
    case TY_AOV_ALBEDO: return aov_sums->albedo[c] / n;
    case TY_AOV_SURFACE_ALBEDO: return aov_sums->surface_albedo[c] / n;
    case TY_AOV_SINGLE: return aov_sums->single[c] / n;
    case TY_AOV_MULTIPLE: return aov_sums->multiple[c] / n;
    case TY_AOV_SAMPLES: return item->count;
    default: return ty_path_item_mean(item, c);
    }
}

/* The same of the even samples. */
static double half_value(uint32_t aov, const ty_path_item* item, const ty_path_half* half, int c) {
    ty_path_item even = {.count = (item->count + 1) / 2};
    for (int k = 0; k < 3; ++k) even.sums.mean[k] = half->mean[k];
    return mean_value(aov, &even, &half->aov_sums, c);
}

void ty_path_image_fill(const ty_path_run* run, ty_image* image) {
    int32_t channel = 0;
    for (int g = 0; g < TY_AOV_GROUPS; ++g)
        for (int c = 0; ty_aov_is_requested(&ty_aov_groups[g], run->def->aovs) && c < ty_aov_groups[g].count; ++c) {
            float* plane = ty_image_plane(image, channel++);
            const uint32_t aov = ty_aov_groups[g].aov & ~(uint32_t)TY_AOV_HALF;
            const bool half = aov != ty_aov_groups[g].aov;
            for (int64_t i = 0; i < run->item_count; ++i)
                plane[i] = (float)(half ? half_value(aov, &run->items[i], &run->halves[i], c)
                                        : mean_value(aov, &run->items[i],
                                                     run->aov_sums != NULL ? &run->aov_sums[i] : NULL, c));
        }
}
