/* Features: channels of first hits and the caller's images, smoothed by NL-means where they are noisy, and scaled. */
#include "image/denoise/job.h"

#include <math.h>

/* Noise that any feature is taken to have, over its variance in the image. */
static const double ridge_min = 1e-5;

/* Features whose scaled values differ by less are one. */
static const float same = 0.02f;

static const struct {
    const char* names[3];
    int32_t count;
} groups[] = {
    {{"normal.X", "normal.Y", "normal.Z"}, 3},
    {{"depth.Z"}, 1},
    {{"transmittance.R", "transmittance.G", "transmittance.B"}, 3},
    {{"albedo.R", "albedo.G", "albedo.B"}, 3},
    {{"surface_albedo.R", "surface_albedo.G", "surface_albedo.B"}, 3},
};
enum { GROUPS = sizeof groups / sizeof groups[0] };

/* Inverse depth, which is linear in the image over planes: 0 without a surface. */
static void invert_depths(const ty_denoise_job* job, float* const halves[2]) {
    double sum = 0, count = 0;
    for (size_t i = 0; i < job->pixels; ++i) {
        sum += (double)halves[0][i];
        count += halves[0][i] > 0;
    }
    const float mean = count > 0 ? (float)(sum / count) : 1;
    for (int h = 0; h < 2; ++h)
        for (size_t i = 0; i < job->pixels; ++i) {
            const float depth = halves[h][i];
            halves[h][i] = depth > 0 ? mean / (mean + depth) : 0;
        }
}

/* ---- smoothing ---- */

/* Smooths the colors of light, which hold the feature's halves, in place of its first sums. */
static void smooth_tile(ty_denoise_job* job, ty_denoise_tile* tile, int32_t x, int32_t y) {
    const ty_denoise_light* light = &job->light;
    const int32_t channels = light->channels;
    for (int32_t c = 0; c < channels; ++c)
        for (int h = 0; h < 2; ++h) ty_denoise_load(job, light->color[h][c], x, y, tile->color[h][c]);
    ty_denoise_load(job, light->variance, x, y, tile->variance);
    const bool noisy = ty_denoise_is_noisy(tile);
    if (noisy) {
        ty_denoise_load_charts(job, x, y, tile);
        job->kernels->smooth(tile, channels);
    }
    for (int h = 0; h < 2; ++h)
        for (int32_t c = 0; c < channels; ++c)
            for (int32_t row = 0; row < tile->height; ++row)
                for (int32_t k = 0; k < tile->width; ++k) {
                    const size_t to = (size_t)(y + row) * (size_t)job->width + (size_t)(x + k);
                    const float* sums = tile->sums[h][0][c] + row * TY_DENOISE_REACH + k;
                    const float* weights = tile->sums[h][0][3] + row * TY_DENOISE_REACH + k;
                    light->sums[h][0][c][to] = noisy && *weights > 0 ? *sums / *weights : light->color[h][c][to];
                }
}

/* ---- scaling ---- */

static bool is_known(const ty_denoise_job* job, const float* plane) {
    for (int32_t k = 0; k < job->feature_count; ++k) {
        float positive = 0, negative = 0; /* largest difference from the feature, and from its opposite */
        for (size_t i = 0; i < job->pixels; ++i) {
            positive = fmaxf(positive, fabsf(plane[i] - job->features[k][i]));
            negative = fmaxf(negative, fabsf(plane[i] + job->features[k][i]));
        }
        if (fminf(positive, negative) < same) return true;
    }
    return false;
}

/* Adds the mean of two halves as a feature of mean 0 and variance 1, unless it is constant or there already. */
static ty_result add_feature(ty_denoise_job* job, const float* const halves[2]) {
    double sum = 0, square = 0, noise = 0;
    if (job->feature_count == TY_DENOISE_PLANES_MAX) return TY_OK;
    for (size_t i = 0; i < job->pixels; ++i) {
        const double a = (double)halves[0][i], b = (double)halves[1][i], mean = 0.5 * (a + b);
        sum += mean;
        square += mean * mean;
        noise += 0.25 * (a - b) * (a - b);
    }
    const double n = (double)job->pixels, mean = sum / n, variance = square / n - mean * mean;
    if (!(variance > 1e-10 * (square / n))) return TY_OK;
    float* plane = ty_denoise_plane(job);
    if (plane == NULL) return TY_ERROR_MEMORY;
    const double scale = 1 / sqrt(variance);
    for (size_t i = 0; i < job->pixels; ++i)
        plane[i] = (float)((0.5 * ((double)halves[0][i] + (double)halves[1][i]) - mean) * scale);
    if (is_known(job, plane)) {
        ty_denoise_free_plane(job, plane);
        return TY_OK;
    }
    job->ridge[job->feature_count] = (float)(ridge_min + noise / n * scale * scale);
    job->features[job->feature_count++] = plane;
    return TY_OK;
}

static ty_result add_group(ty_denoise_job* job, int group) {
    ty_denoise_light* light = &job->light;
    const int32_t count = light->channels = groups[group].count;
    for (int32_t c = 0; c < count; ++c) {
        const float* all = ty_denoise_find(job, groups[group].names[c], false);
        if (all == NULL) return TY_OK;
        float* const halves[2] = {light->color[0][c], light->color[1][c]};
        ty_denoise_split(job, all, ty_denoise_find(job, groups[group].names[c], true), halves);
        if (count == 1) invert_depths(job, halves);
    }
    ty_denoise_estimate_variance(job);
    ty_denoise_tiles(job, false, smooth_tile);
    ty_result result = TY_OK;
    for (int32_t c = 0; c < count && result == TY_OK; ++c)
        result = add_feature(job, (const float* const[2]){light->sums[0][0][c], light->sums[1][0][c]});
    return result;
}

ty_result ty_denoise_make_features(ty_denoise_job* job) {
    ty_result result = TY_OK;
    for (int f = 0; f < TY_DENOISE_FEATURES_MAX && result == TY_OK; ++f) {
        const float* planes[3];
        if (job->def.features[f] == NULL || !ty_image_rgb_planes(job->def.features[f], planes)) continue;
        for (int c = 0; c < 3 && result == TY_OK; ++c) {
            float* const halves[2] = {job->light.color[0][c], job->light.color[1][c]};
            ty_denoise_split(job, planes[c], NULL, halves);
            result = add_feature(job, (const float* const[2]){halves[0], halves[1]});
        }
    }
    for (int g = 0; g < GROUPS && result == TY_OK; ++g) result = add_group(job, g);
    job->stats.features = job->feature_count;
    return result;
}
