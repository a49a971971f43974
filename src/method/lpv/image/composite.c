/* The composite of surfaces behind media: half-resolution media samples are upsampled with regard to the distance of
 * their rays. */
#include "method/lpv/image/composite.h"

#include "method/lpv/image/media_pass.h"

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

/* The smallest change of weights, which sum to 1, that moves the mean of their positions to the pixel at (0, 0). */
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

void ty_lpv_find_upsample_weights(ty_lpv_march_state* state) {
    enum { PERIOD = TY_LPV_UPSAMPLE_PERIOD };
    for (int32_t y = 0; y < PERIOD; ++y)
        for (int32_t x = 0; x < PERIOD; ++x) {
            /* One period from the corner, so that no ray is clamped at the image's border. */
            const int32_t at[2] = {x + PERIOD, y + PERIOD};
            float* weight = state->upsample.weights[y][x];
            int32_t columns[2], rows[2];
            double places[4][2];
            const float along = ty_lpv_upsample_pair(at[0], INT32_MAX, columns),
                        down = ty_lpv_upsample_pair(at[1], INT32_MAX, rows);
            ty_lpv_upsample_bilinear(along, down, weight);
            for (int i = 0; i < 4; ++i) {
                int32_t full[2];
                ty_lpv_media_ray_pixel(columns[i % 2], rows[i / 2], full);
                for (int a = 0; a < 2; ++a) places[i][a] = full[a] - at[a];
            }
            centre_weights(places, weight);
        }
}

/* ---- pixels ---- */

static void ray_march_pixel(ty_lpv_march_state* state, int32_t x, int32_t y, ty_lpv_media_radiance* out) {
    const ty_media_ray media_ray = ty_lpv_media_ray_of(state, x, y, ty_lpv_step_offset(state, x, y));
    ty_ray_march_result ray_march;
    state->kernels->ray_march(&state->ray_march, &media_ray, 1, &ray_march);
    *out = ty_lpv_media_radiance_of(&ray_march, media_ray.far);
    if (state->job->airlight == NULL || (state->job->def->parts & TY_LPV_SINGLE) == 0) return;
    ty_airlight_ray(state->job->airlight, media_ray.origin, media_ray.direction, media_ray.far, media_ray.offset,
                    out->single, NULL);
    ty_lpv_add_uncollided(state, &media_ray, 1, &out->single);
}

/* Single scattering is computed anew for a pixel where it differs between the rays around it by more than this fraction
 * of the pixel's radiance, as at the edges of light shafts; where it differs by more than the whole radiance, as around
 * a visible light, by FINE x FINE rays. */
static const float edge_contrast = 0.1f, light_contrast = 1.0f;
enum { FINE = 4 };

/* Radiance of a pixel, sum of all channels. */
static float light_of(const ty_lpv_march_state* state, int32_t x, int32_t y, const ty_lpv_media_radiance* radiance) {
    const float* surface = state->surface + 3 * ty_lpv_band_index(state, x, y);
    float sum = 0.0f;
    for (int c = 0; c < 3; ++c)
        sum += surface[c] * radiance->transmittance[c] + radiance->emission[c] + radiance->single[c] +
               radiance->multiple[c];
    return sum;
}

static void single_scattering_pixel(ty_lpv_march_state* state, int32_t x, int32_t y, int32_t fine,
                                    ty_lpv_media_radiance* out) {
    const ty_media_ray media_ray = ty_lpv_media_ray_of(state, x, y, ty_lpv_step_offset(state, x, y));
    const float weight = 1.0f / (float)(fine * fine);
    for (int c = 0; c < 3; ++c) out->single[c] = 0.0f;
    for (int32_t i = 0; i < fine * fine; ++i) {
        const float dx = fine > 1 ? ((float)(i % fine) + 0.5f) / (float)fine : state->dx;
        const float dy = fine > 1 ? ((float)(i / fine) + 0.5f) / (float)fine : state->dy;
        float single[3];
        ty_airlight_ray(state->job->airlight, media_ray.origin,
                        ty_camera_direction(&state->camera, (float)x + dx, (float)y + dy), media_ray.far,
                        media_ray.offset, single, NULL);
        for (int c = 0; c < 3; ++c) out->single[c] += weight * single[c];
    }
    ty_lpv_add_uncollided(state, &media_ray, 1, &out->single);
}

/* Computes single scattering anew if the rays around a pixel disagree; returns whether they did. */
static bool sharpen(ty_lpv_march_state* state, int32_t x, int32_t y, float contrast, ty_lpv_media_radiance* out) {
    if (!(contrast > 0.0f)) return false;
    const float light = light_of(state, x, y, out);
    if (!(contrast > edge_contrast * light)) return false;
    single_scattering_pixel(state, x, y, contrast > light_contrast * light ? FINE : 1, out);
    return true;
}

/* The media in front of a row of pixels; returns the number of pixels that needed a ray of their own. */
static int64_t find_media_row(ty_lpv_march_state* state, int32_t x, int32_t y, int32_t count,
                              ty_lpv_media_radiance* out) {
    float contrast[TY_TILE];
    int64_t extra_rays = 0;
    if (state->pixels_per_ray > 1) {
        const float* distance = state->distance + ty_lpv_band_index(state, x, y);
        state->kernels->upsample(&state->upsample, x, y, count, distance, out, contrast);
    }
    for (int32_t i = 0; i < count; ++i) {
        if (state->pixels_per_ray == 1) {
            out[i] = ty_lpv_media_sample_at(state, x + i, y)->radiance;
        } else if (contrast[i] < 0.0f) {
            ray_march_pixel(state, x + i, y, &out[i]);
            ++extra_rays;
        } else if (sharpen(state, x + i, y, contrast[i], &out[i])) {
            ++extra_rays;
        }
    }
    return extra_rays;
}

/* Callers' values may overflow a float in sums. */
static float finite(float value) {
    return value > -TY_FLOAT_MAX && value < TY_FLOAT_MAX ? value : 0.0f;
}

static void add(float* const planes[3], size_t at, const float values[3]) {
    for (int c = 0; c < 3 && planes[c] != NULL; ++c) planes[c][at] += finite(values[c]);
}

/* Counts light that came to the place where it scatters by forward scattering as multiple scattering. */
static void split_scattering(const ty_lpv_march_state* state, int32_t x, int32_t y, ty_lpv_media_radiance* radiance) {
    const ty_media_ray ray = ty_lpv_media_ray_of(state, x, y, ty_lpv_step_offset(state, x, y));
    float all[3], single[3];
    if ((state->job->def->parts & TY_LPV_SINGLE) == 0) return;
    ty_airlight_ray(state->job->airlight, ray.origin, ray.direction, ray.far, ray.offset, all, NULL);
    ty_airlight_ray(state->job->single, ray.origin, ray.direction, ray.far, ray.offset, single, NULL);
    for (int c = 0; c < 3; ++c) {
        const float forward = ty_clampf(all[c] - single[c], 0.0f, radiance->single[c]);
        radiance->single[c] -= forward;
        radiance->multiple[c] += forward;
    }
}

static void add_pixel(const ty_lpv_march_state* state, int32_t x, int32_t y, const ty_lpv_media_radiance* radiance) {
    const float* surface = state->surface + 3 * ty_lpv_band_index(state, x, y);
    const size_t at = (size_t)y * (size_t)state->width + (size_t)x;
    float color[3];
    for (int c = 0; c < 3; ++c)
        color[c] = surface[c] * radiance->transmittance[c] + radiance->emission[c] + radiance->single[c] +
                   radiance->multiple[c];
    add(state->planes.color, at, color);
    ty_lpv_media_radiance split = *radiance;
    add(state->planes.transmittance, at, radiance->transmittance);
    add(state->planes.albedo, at, radiance->scattered);
    if (state->job->single != NULL && (state->planes.single[0] != NULL || state->planes.multiple[0] != NULL))
        split_scattering(state, x, y, &split);
    add(state->planes.single, at, split.single);
    add(state->planes.multiple, at, split.multiple);
}

void ty_lpv_composite_tile(ty_lpv_march_state* state, int32_t x, int32_t y, int32_t right, int32_t bottom) {
    ty_lpv_media_radiance radiance[TY_TILE];
    int64_t extra_rays = 0;
    for (int32_t i = 0; i < TY_TILE; ++i) radiance[i] = (ty_lpv_media_radiance){.transmittance = {1.0f, 1.0f, 1.0f}};
    for (int32_t row = y; row < bottom; ++row) {
        if (state->media_samples != NULL) extra_rays += find_media_row(state, x, row, right - x, radiance);
        for (int32_t i = 0; i < right - x; ++i) add_pixel(state, x + i, row, &radiance[i]);
    }
    atomic_fetch_add(&state->marched, extra_rays);
}
