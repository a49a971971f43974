/* What rays see of media: at half of the resolution, or for pixels by themselves. */
#include "method/lpv/frame.h"

/* Ray (x, y) goes through one of the four pixels that it stands for: which one takes turns, so that edges of surfaces
 * are met on both sides. */
void ty_lpv_air_place(int32_t x, int32_t y, int32_t full[2]) {
    full[0] = 2 * x + ((x + (y >> 1)) & 1);
    full[1] = 2 * y + ((y + (x >> 1)) & 1);
}

/* Of any four neighbours two by two, one is in each quarter: means over them are all but free of what steps do. */
float ty_lpv_air_offset(const ty_lpv_frame* frame, int32_t x, int32_t y) {
    static const float order[4][4] = {{0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
    const float place = (order[y & 3][x & 3] + 0.5f) * 0.0625f + 0.618033989f * (float)frame->sample + frame->first;
    return 1.0f - (place - floorf(place));
}

ty_fog_way ty_lpv_air_way(const ty_lpv_frame* frame, int32_t x, int32_t y, float offset) {
    const float distance = frame->distance[ty_lpv_kept(frame, x, y)];
    return (ty_fog_way){.origin = frame->camera.origin,
                        .direction = ty_camera_direction(&frame->camera, (float)x + frame->dx, (float)y + frame->dy),
                        .far = ty_minf(distance, TY_FLOAT_MAX),
                        .offset = offset};
}

static ty_fog_way way_of(const ty_lpv_frame* frame, int32_t x, int32_t y) {
    int32_t full[2] = {x, y};
    if (frame->shrink > 1) ty_lpv_air_place(x, y, full);
    full[0] = full[0] < frame->width ? full[0] : frame->width - 1;
    full[1] = full[1] < frame->height ? full[1] : frame->height - 1;
    return ty_lpv_air_way(frame, full[0], full[1], ty_lpv_air_offset(frame, x, y));
}

ty_lpv_seen ty_lpv_seen_of(const ty_fog* fog, float distance) {
    ty_lpv_seen seen = {.distance = distance};
    memcpy(seen.transmittance, fog->transmittance, sizeof seen.transmittance);
    memcpy(seen.multiple, fog->multiple, sizeof seen.multiple);
    memcpy(seen.scattered, fog->scattered, sizeof seen.scattered);
    memcpy(seen.glow, fog->glow, sizeof seen.glow);
    return seen;
}

static void take_fog(const ty_fog* fog, float far, ty_lpv_air* air) {
    *air = (ty_lpv_air){.seen = ty_lpv_seen_of(fog, far < TY_FLOAT_MAX ? far : INFINITY)};
    memcpy(air->extinction, fog->extinction, sizeof air->extinction);
    memcpy(air->multiple_rise, fog->multiple_rise, sizeof air->multiple_rise);
    memcpy(air->scattered_rise, fog->scattered_rise, sizeof air->scattered_rise);
}

void ty_lpv_march_tile(ty_lpv_frame* frame, int32_t x, int32_t y, int32_t right, int32_t bottom) {
    ty_fog_way ways[TY_TILE];
    ty_fog fog[TY_TILE];
    for (int32_t row = y; row < bottom; ++row) {
        ty_lpv_air* air = ty_lpv_kept_air(frame, 0, row);
        for (int32_t i = x; i < right; ++i) ways[i - x] = way_of(frame, i, row);
        frame->kernels->fog(&frame->fog, ways, right - x, fog);
        for (int32_t i = x; i < right; ++i) take_fog(&fog[i - x], ways[i - x].far, &air[i]);
    }
    atomic_fetch_add(&frame->marched, (int64_t)(right - x) * (bottom - y));
}

void ty_lpv_single_tile(ty_lpv_frame* frame, int32_t x, int32_t y, int32_t right, int32_t bottom) {
    ty_air_ray rays[TY_TILE_PIXELS];
    float single[TY_TILE_PIXELS][3];
    int32_t count = 0, next = 0;
    for (int32_t row = y; row < bottom; ++row)
        for (int32_t i = x; i < right; ++i) {
            const ty_fog_way way = way_of(frame, i, row);
            rays[count++] = (ty_air_ray){.direction = way.direction, .far = way.far, .offset = way.offset};
        }
    if (count == 0) return;
    ty_airlight_rays(frame->job->airlight, frame->camera.origin, rays, count, single, NULL);
    for (int32_t row = y; row < bottom; ++row)
        for (int32_t i = x; i < right; ++i)
            memcpy(ty_lpv_kept_air(frame, i, row)->seen.single, single[next++], sizeof single[0]);
}
