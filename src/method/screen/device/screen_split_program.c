/* Level 0 on devices: light that stays in its pixels, light that is passed on, counts. */
#include "device/entry.k.h"
#include "method/screen/device/launch.h"

TY_FN float split_distance(TY_GLOBAL const ty_screen_launch* launch, int64_t pixel, ty_screen_device_counts* counts) {
    TY_GLOBAL const ty_screen_params* params = &launch->params;
    const int64_t pixels = (int64_t)params->width * params->height;
    float distance = launch->image[3 * pixels + pixel];
    int32_t missing;
    if (params->planar != 0)
        distance *=
            ty_screen_distance_per_depth(*params, (int32_t)(pixel % params->width), (int32_t)(pixel / params->width));
    distance = ty_screen_distance(distance, params->unknown, &missing);
    counts->missing_depth += missing;
    return distance;
}

TY_FN void split_pixel(TY_GLOBAL const ty_screen_launch* launch, int64_t pixel, ty_screen_device_counts* counts) {
    TY_GLOBAL const ty_screen_params* params = &launch->params;
    const int64_t pixels = (int64_t)params->width * params->height;
    const float distance = split_distance(launch, pixel, counts);
    int32_t changed = 0, oversized = 0;
    for (int32_t c = 0; c < 3; ++c) {
        const float radiance = ty_screen_sanitize(launch->image[c * pixels + pixel], TY_SCREEN_RADIANCE_MAX, &changed);
        const float measure = ty_screen_variance(params->slope[c], params->curvature[c], distance);
        const ty_screen_transport transport =
            ty_screen_transport_at(params->sigma_s[c], params->sigma_a[c], params->airlight[c], params->forward[c],
                                   launch->level.down_fraction[c], distance, measure);
        const float passed = transport.passed * radiance;
        launch->out[c * pixels + pixel] = transport.stays * radiance + transport.airlight;
        launch->passed[c * pixels + pixel] = passed;
        launch->passed[(3 + c) * pixels + pixel] = passed * measure;
        oversized |= measure > launch->limit[c] ? 1 : 0;
        counts->largest[c] = ty_maxf(counts->largest[c], measure);
    }
    counts->nonfinite_fixed += changed;
    counts->oversized += oversized;
}

TY_DEVICE_ENTRY(screen_split, ty_screen_launch) {
    const int64_t pixels = (int64_t)arguments->params.width * arguments->params.height;
    ty_screen_device_counts counts = {0, 0, 0, {0.0f, 0.0f, 0.0f}};
    for (int64_t pixel = index; pixel < pixels; pixel += arguments->threads) split_pixel(arguments, pixel, &counts);
    arguments->counts[index] = counts;
}
