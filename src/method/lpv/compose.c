/* Surfaces behind media: media seen at half of the resolution are brought to the full one with regard to how far their
 * rays went. */
#include "method/lpv/frame.h"

/* Distances that differ by more, relative to the lesser, are not alike at all. */
static const float alike_within = 0.1f;
/* Weight of all neighbours together below which a pixel is marched by itself. */
static const float enough = 1.0f / 64.0f;

static float likeness(float a, float b) {
    if (isinf(a) || isinf(b)) return isinf(a) && isinf(b) ? 1.0f : 0.0f;
    const float apart = fabsf(a - b), within = alike_within * ty_minf(a, b);
    if (!(apart < within)) return apart > 0.0f ? 0.0f : 1.0f;
    const float x = apart / within, left = 1.0f - x * x;
    return left * left;
}

/* The two rays around a pixel along a side, and the share of the second. Each stands for two pixels, and lies between
 * them. */
static float find_pair(int32_t pixel, int32_t count, int32_t pair[2]) {
    const int32_t first = (pixel + 1) / 2 - 1;
    pair[0] = first > 0 ? first : 0;
    pair[1] = first + 1 < count ? first + 1 : count - 1;
    return (pixel & 1) != 0 ? 0.25f : 0.75f;
}

enum { AIR_FLOATS = (sizeof(ty_fog) + 3 * sizeof(float)) / sizeof(float) };
_Static_assert(offsetof(ty_lpv_air, distance) == AIR_FLOATS * sizeof(float), "all that rays bring comes first");

/* false: none of the rays around went about as far. */
static bool upsample(const ty_lpv_frame* frame, int32_t x, int32_t y, float distance, ty_lpv_air* out) {
    int32_t columns[2], rows[2];
    float weight[4], sum = 0.0f, mean[AIR_FLOATS] = {0};
    const float along = find_pair(x, frame->air_width, columns), down = find_pair(y, frame->air_height, rows);
    const ty_lpv_air* air[4];
    for (int i = 0; i < 4; ++i) {
        air[i] = &frame->air[(size_t)rows[i / 2] * (size_t)frame->air_width + (size_t)columns[i % 2]];
        weight[i] = (i % 2 != 0 ? along : 1.0f - along) * (i / 2 != 0 ? down : 1.0f - down);
        weight[i] *= likeness(distance, air[i]->distance);
        sum += weight[i];
    }
    if (!(sum >= enough)) return false;
    for (int i = 0; i < 4; ++i) {
        const float* from = (const float*)air[i];
        for (int j = 0; j < AIR_FLOATS; ++j) mean[j] += weight[i] / sum * from[j];
    }
    memcpy(out, mean, sizeof mean);
    return true;
}

static void march_alone(ty_lpv_frame* frame, int32_t x, int32_t y, ty_lpv_air* out) {
    const ty_fog_way way = ty_lpv_air_way(frame, x, y, ty_lpv_air_offset(frame, x, y));
    *out = (ty_lpv_air){.distance = way.far};
    frame->kernels->fog(&frame->fog, &way, 1, &out->fog);
    if (frame->job->airlight != NULL && (frame->job->def->parts & TY_LPV_SINGLE) != 0)
        ty_airlight_ray(frame->job->airlight, way.origin, way.direction, way.far, way.offset, out->single, NULL);
}

static ty_lpv_air air_before(ty_lpv_frame* frame, int32_t x, int32_t y, float distance, int64_t* alone) {
    ty_lpv_air air = {.fog = {.transmittance = {1.0f, 1.0f, 1.0f}}};
    if (frame->air == NULL) return air;
    if (frame->shrink == 1) return frame->air[(size_t)y * (size_t)frame->air_width + (size_t)x];
    if (upsample(frame, x, y, distance, &air)) return air;
    march_alone(frame, x, y, &air);
    ++*alone;
    return air;
}

/* Sums of what callers hand in may be too large for a float. */
static float finite(float value) {
    return value > -TY_FLOAT_MAX && value < TY_FLOAT_MAX ? value : 0.0f;
}

static void add(float* const planes[3], size_t at, const float values[3]) {
    for (int c = 0; c < 3 && planes[c] != NULL; ++c) planes[c][at] += finite(values[c]);
}

static void add_pixel(const ty_lpv_frame* frame, size_t at, const ty_lpv_air* air) {
    const ty_fog* fog = &air->fog;
    const float* surface = frame->surface + 3 * at;
    float color[3];
    for (int c = 0; c < 3; ++c)
        color[c] = surface[c] * fog->transmittance[c] + fog->glow[c] + air->single[c] + fog->multiple[c];
    add(frame->planes.color, at, color);
    add(frame->planes.transmittance, at, fog->transmittance);
    add(frame->planes.albedo, at, fog->scattered);
    add(frame->planes.single, at, air->single);
    add(frame->planes.multiple, at, fog->multiple);
}

void ty_lpv_compose_tile(ty_lpv_frame* frame, int32_t x, int32_t y, int32_t right, int32_t bottom) {
    int64_t alone = 0;
    for (int32_t row = y; row < bottom; ++row)
        for (int32_t column = x; column < right; ++column) {
            const size_t at = (size_t)row * (size_t)frame->width + (size_t)column;
            const ty_lpv_air air = air_before(frame, column, row, frame->distance[at], &alone);
            add_pixel(frame, at, &air);
        }
    atomic_fetch_add(&frame->marched, alone);
}
