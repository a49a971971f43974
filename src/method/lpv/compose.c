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

/* ---- weights ---- */

/* Solves three linear equations by elimination; the matrix is symmetric and positive. */
static void solve_three(double m[3][4], double out[3]) {
    for (int c = 0; c < 3; ++c)
        for (int r = c + 1; r < 3; ++r) {
            const double factor = m[r][c] / m[c][c];
            for (int k = c; k < 4; ++k) m[r][k] -= factor * m[c][k];
        }
    for (int r = 3; r-- > 0;) {
        out[r] = m[r][3];
        for (int k = r + 1; k < 3; ++k) out[r] -= m[r][k] * out[k];
        out[r] /= m[r][r];
    }
}

/* Changes weights (which add up to 1) of places by as little as brings their mean to the pixel at (0, 0). */
static void centre_weights(const double places[4][2], float weight[4]) {
    double m[3][4] = {{0}}, change[3];
    for (int i = 0; i < 4; ++i) {
        const double row[4] = {1, places[i][0], places[i][1], 0}, w = (double)weight[i];
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c) m[r][c] += w * row[r] * row[c];
            if (r > 0) m[r][3] -= w * row[r];
        }
    }
    solve_three(m, change);
    for (int i = 0; i < 4; ++i)
        weight[i] *= (float)(1 + change[0] + change[1] * places[i][0] + change[2] * places[i][1]);
}

static void bilinear(float along, float down, float weight[4]) {
    for (int i = 0; i < 4; ++i) weight[i] = (i % 2 != 0 ? along : 1.0f - along) * (i / 2 != 0 ? down : 1.0f - down);
}

void ty_lpv_find_weights(ty_lpv_frame* frame) {
    enum { PERIOD = TY_AIR_PERIOD };
    for (int32_t y = 0; y < PERIOD; ++y)
        for (int32_t x = 0; x < PERIOD; ++x) {
            /* One period on, so that nothing is cut at the image's edges. */
            const int32_t at[2] = {x + PERIOD, y + PERIOD};
            float* weight = frame->weights[y][x];
            int32_t columns[2], rows[2];
            double places[4][2];
            const float along = find_pair(at[0], INT32_MAX, columns), down = find_pair(at[1], INT32_MAX, rows);
            bilinear(along, down, weight);
            for (int i = 0; i < 4; ++i) {
                int32_t full[2];
                ty_lpv_air_place(columns[i % 2], rows[i / 2], full);
                for (int a = 0; a < 2; ++a) places[i][a] = full[a] - at[a];
            }
            centre_weights(places, weight);
        }
}

/* ---- upsampling ---- */

/* Adds a share of what a ray brings, as if it went `farther` (m) than it does, which is little. */
static void add_share(const ty_lpv_air* air, float share, float farther, ty_lpv_air* sum) {
    for (int c = 0; c < 3; ++c) {
        const float depth = air->fog.extinction[c] * farther, fades = 1.0f - depth * (1.0f - 0.5f * depth);
        const float risen = share * farther * (1.0f - 0.5f * depth);
        sum->fog.transmittance[c] += share * air->fog.transmittance[c] * fades;
        sum->fog.multiple[c] += share * air->fog.multiple[c] + risen * air->fog.multiple_rise[c];
        sum->fog.scattered[c] += share * air->fog.scattered[c] + risen * air->fog.scattered_rise[c];
        sum->fog.glow[c] += share * air->fog.glow[c];
        sum->single[c] += share * air->single[c];
    }
}

/* false: none of the rays around went about as far. */
static bool upsample(const ty_lpv_frame* frame, int32_t x, int32_t y, float distance, ty_lpv_air* out) {
    int32_t columns[2], rows[2];
    float weight[4], like[4], sum = 0.0f, least = 1.0f;
    const float along = find_pair(x, frame->air_width, columns), down = find_pair(y, frame->air_height, rows);
    const ty_lpv_air* air[4];
    for (int i = 0; i < 4; ++i) {
        air[i] = &frame->air[(size_t)rows[i / 2] * (size_t)frame->air_width + (size_t)columns[i % 2]];
        like[i] = likeness(distance, air[i]->distance);
        least = ty_minf(least, like[i]);
    }
    if (least > 0.5f && columns[0] < columns[1] && rows[0] < rows[1])
        memcpy(weight, frame->weights[y % TY_AIR_PERIOD][x % TY_AIR_PERIOD], sizeof weight);
    else
        bilinear(along, down, weight);
    for (int i = 0; i < 4; ++i) {
        weight[i] *= like[i];
        sum += weight[i];
    }
    if (!(sum >= enough)) return false;
    *out = (ty_lpv_air){.distance = distance};
    for (int i = 0; i < 4; ++i)
        if (weight[i] != 0.0f)
            add_share(air[i], weight[i] / sum, isinf(distance) ? 0.0f : distance - air[i]->distance, out);
    for (int c = 0; c < 3; ++c) {
        out->fog.multiple[c] = ty_maxf(out->fog.multiple[c], 0.0f);
        out->fog.scattered[c] = ty_maxf(out->fog.scattered[c], 0.0f);
    }
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
