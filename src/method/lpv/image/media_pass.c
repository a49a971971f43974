/* Media samples, at half of the resolution or for single pixels. */
#include "method/lpv/image/media_pass.h"

/* Ray (x, y) goes through one of its four pixels in a regular pattern, so that neighbouring rays sample both sides of
 * silhouette edges. */
void ty_lpv_media_ray_pixel(int32_t x, int32_t y, int32_t full[2]) {
    full[0] = 2 * x + ((x + (y >> 1)) & 1);
    full[1] = 2 * y + ((y + (x >> 1)) & 1);
}

/* Any 2 x 2 neighbours have offsets in different quarters of a step, so that their mean has almost no stepping error.
 */
float ty_lpv_step_offset(const ty_lpv_march_state* state, int32_t x, int32_t y) {
    static const float order[4][4] = {{0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
    const float place = (order[y & 3][x & 3] + 0.5f) * 0.0625f + 0.618033989f * (float)state->sample + state->first;
    return 1.0f - (place - floorf(place));
}

ty_media_ray ty_lpv_media_ray_of(const ty_lpv_march_state* state, int32_t x, int32_t y, float offset) {
    const float distance = state->distance[ty_lpv_band_index(state, x, y)];
    return (ty_media_ray){.origin = state->camera.origin,
                          .direction = ty_camera_direction(&state->camera, (float)x + state->dx, (float)y + state->dy),
                          .far = ty_minf(distance, TY_FLOAT_MAX),
                          .offset = offset};
}

static ty_media_ray media_ray_at(const ty_lpv_march_state* state, int32_t x, int32_t y) {
    int32_t full[2] = {x, y};
    if (state->pixels_per_ray > 1) ty_lpv_media_ray_pixel(x, y, full);
    full[0] = full[0] < state->width ? full[0] : state->width - 1;
    full[1] = full[1] < state->height ? full[1] : state->height - 1;
    return ty_lpv_media_ray_of(state, full[0], full[1], ty_lpv_step_offset(state, x, y));
}

ty_lpv_media_radiance ty_lpv_media_radiance_of(const ty_ray_march_result* ray_march, float distance) {
    ty_lpv_media_radiance radiance = {.distance = distance};
    memcpy(radiance.transmittance, ray_march->transmittance, sizeof radiance.transmittance);
    memcpy(radiance.multiple, ray_march->multiple, sizeof radiance.multiple);
    memcpy(radiance.scattered, ray_march->scattered, sizeof radiance.scattered);
    memcpy(radiance.emission, ray_march->emission, sizeof radiance.emission);
    return radiance;
}

static void store_media_sample(const ty_ray_march_result* ray_march, float far, ty_lpv_media_sample* media_samples) {
    *media_samples =
        (ty_lpv_media_sample){.radiance = ty_lpv_media_radiance_of(ray_march, far < TY_FLOAT_MAX ? far : INFINITY)};
    memcpy(media_samples->extinction, ray_march->extinction, sizeof media_samples->extinction);
    memcpy(media_samples->multiple_rise, ray_march->multiple_rise, sizeof media_samples->multiple_rise);
    memcpy(media_samples->scattered_rise, ray_march->scattered_rise, sizeof media_samples->scattered_rise);
}

void ty_lpv_ray_march_tile(ty_lpv_march_state* state, int32_t x, int32_t y, int32_t right, int32_t bottom) {
    ty_media_ray media_rays[TY_TILE];
    ty_ray_march_result ray_march[TY_TILE];
    for (int32_t row = y; row < bottom; ++row) {
        ty_lpv_media_sample* media_samples = ty_lpv_media_sample_at(state, 0, row);
        for (int32_t i = x; i < right; ++i) media_rays[i - x] = media_ray_at(state, i, row);
        state->kernels->ray_march(&state->ray_march, media_rays, right - x, ray_march);
        for (int32_t i = x; i < right; ++i)
            store_media_sample(&ray_march[i - x], media_rays[i - x].far, &media_samples[i]);
    }
    atomic_fetch_add(&state->marched, (int64_t)(right - x) * (bottom - y));
}

void ty_lpv_add_uncollided(const ty_lpv_march_state* state, const ty_media_ray* rays, int32_t count,
                           float (*single)[3]) {
    ty_ray_march_result ray_march[TY_TILE];
    if (state->uncollided_march.lattices == NULL) return;
    state->kernels->ray_march(&state->uncollided_march, rays, count, ray_march);
    for (int32_t i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c) single[i][c] += ray_march[i].multiple[c];
}

static void add_uncollided_tile(ty_lpv_march_state* state, int32_t x, int32_t y, int32_t right, int32_t bottom) {
    ty_media_ray media_rays[TY_TILE];
    float single[TY_TILE][3];
    for (int32_t row = y; row < bottom && x < right; ++row) {
        ty_lpv_media_sample* media_samples = ty_lpv_media_sample_at(state, 0, row);
        for (int32_t i = x; i < right; ++i) {
            media_rays[i - x] = media_ray_at(state, i, row);
            memcpy(single[i - x], media_samples[i].radiance.single, sizeof single[0]);
        }
        ty_lpv_add_uncollided(state, media_rays, right - x, single);
        for (int32_t i = x; i < right; ++i) memcpy(media_samples[i].radiance.single, single[i - x], sizeof single[0]);
    }
}

void ty_lpv_single_scattering_tile(ty_lpv_march_state* state, int32_t x, int32_t y, int32_t right, int32_t bottom) {
    ty_eye_ray rays[TY_TILE_PIXELS];
    float single[TY_TILE_PIXELS][3];
    int32_t count = 0, next = 0;
    for (int32_t row = y; row < bottom; ++row)
        for (int32_t i = x; i < right; ++i) {
            const ty_media_ray media_ray = media_ray_at(state, i, row);
            rays[count++] =
                (ty_eye_ray){.direction = media_ray.direction, .far = media_ray.far, .offset = media_ray.offset};
        }
    if (count == 0) return;
    ty_airlight_rays(state->job->airlight, state->camera.origin, rays, count, single, NULL);
    for (int32_t row = y; row < bottom; ++row)
        for (int32_t i = x; i < right; ++i)
            memcpy(ty_lpv_media_sample_at(state, i, row)->radiance.single, single[next++], sizeof single[0]);
    if (state->uncollided_march.lattices != NULL) add_uncollided_tile(state, x, y, right, bottom);
}
