/* Choice among the candidates of each pixel by their estimated errors, and the error of what was chosen. */
#include "image/denoise/job.h"

#include <math.h>

enum { VARIANCE_RADIUS = 2, CHOICE_RADIUS = 2, BLEND_RADIUS = 2, ERROR_RADIUS = 5 };

/* Softening over the square of the mean. */
static const double soft = 1e-6;

/* Weight of a pixel's own light among predictions, whose weights are up to 1. */
static const float own_weight = 1e-3f;

/* ---- variance ---- */

static void square_differences(void* user, int64_t y, int32_t worker) {
    (void)worker;
    ty_denoise_job* job = user;
    const size_t first = (size_t)y * (size_t)job->width;
    for (size_t i = first; i < first + (size_t)job->width; ++i) {
        float sum = 0;
        for (int32_t c = 0; c < job->light.channels; ++c) {
            const float difference = job->light.color[0][c][i] - job->light.color[1][c][i];
            sum += difference * difference;
        }
        job->light.variance[i] = 0.5f * sum;
    }
}

void ty_denoise_estimate_variance(ty_denoise_job* job) {
    double sum = 0;
    ty_denoise_rows(job, square_differences);
    ty_denoise_box(job, job->light.variance, VARIANCE_RADIUS, job->light.variance);
    for (int32_t c = 0; c < job->light.channels; ++c) {
        double mean = 0;
        for (size_t i = 0; i < job->pixels; ++i)
            mean += 0.5 * fabs((double)job->light.color[0][c][i] + (double)job->light.color[1][c][i]);
        mean /= (double)job->pixels;
        sum += mean * mean;
    }
    job->light.softening = (float)fmax(soft * sum, 1e-30);
}

/* ---- choice ---- */

/* Means of the candidates' predictions, in place of their sums. */
static void divide_sums(void* user, int64_t y, int32_t worker) {
    (void)worker;
    ty_denoise_job* job = user;
    const size_t first = (size_t)y * (size_t)job->width;
    for (int h = 0; h < 2; ++h)
        for (int k = 0; k < TY_DENOISE_CANDIDATES; ++k)
            for (size_t i = first; i < first + (size_t)job->width; ++i) {
                float* const* sums = job->light.sums[h][k];
                const float inverse = 1 / (sums[3][i] + own_weight);
                for (int c = 0; c < 3; ++c)
                    sums[c][i] = (sums[c][i] + own_weight * job->light.color[h][c][i]) * inverse;
            }
}

/* The mean square error of the halves' mean (a + b) / 2 by the noisy halves, without bias where these are independent:
 * each denoised half against the other noisy one, less the latter's variance and half of the variance of the former. */
static inline float square_error(float a, float b, float noisy_a, float noisy_b) {
    const float across_a = a - noisy_b, across_b = b - noisy_a, noise = noisy_a - noisy_b, apart = a - b;
    return 0.5f * (across_a * across_a + across_b * across_b - noise * noise) - 0.25f * apart * apart;
}

/* Errors of the candidates over variance, in place of their weights in the even half. */
static void find_errors(void* user, int64_t y, int32_t worker) {
    (void)worker;
    ty_denoise_job* job = user;
    const ty_denoise_light* light = &job->light;
    const size_t first = (size_t)y * (size_t)job->width;
    for (int k = 0; k < TY_DENOISE_CANDIDATES; ++k)
        for (size_t i = first; i < first + (size_t)job->width; ++i) {
            float sum = 0;
            for (int c = 0; c < 3; ++c)
                sum += square_error(light->sums[0][k][c][i], light->sums[1][k][c][i], light->color[0][c][i],
                                    light->color[1][c][i]);
            light->sums[0][k][3][i] = sum / (light->variance[i] + light->softening);
        }
}

/* The choice of each pixel, as 0 or 1 in place of the errors. */
static void choose_least(void* user, int64_t y, int32_t worker) {
    (void)worker;
    ty_denoise_job* job = user;
    const size_t first = (size_t)y * (size_t)job->width;
    for (size_t i = first; i < first + (size_t)job->width; ++i) {
        int best = 0;
        for (int k = 1; k < TY_DENOISE_CANDIDATES; ++k)
            if (job->light.sums[0][k][3][i] < job->light.sums[0][best][3][i]) best = k;
        for (int k = 0; k < TY_DENOISE_CANDIDATES; ++k) job->light.sums[0][k][3][i] = k == best ? 1 : 0;
    }
}

static void blend(void* user, int64_t y, int32_t worker) {
    (void)worker;
    ty_denoise_job* job = user;
    const ty_denoise_light* light = &job->light;
    const size_t first = (size_t)y * (size_t)job->width;
    for (int h = 0; h < 2; ++h)
        for (int c = 0; c < 3; ++c)
            for (size_t i = first; i < first + (size_t)job->width; ++i) {
                float value = 0;
                for (int k = 0; k < TY_DENOISE_CANDIDATES; ++k)
                    value += light->sums[0][k][3][i] * light->sums[h][k][c][i];
                job->denoised[h][c][i] += value;
                job->raw[h][c][i] += light->color[h][c][i];
            }
}

void ty_denoise_choose(ty_denoise_job* job) {
    ty_denoise_rows(job, divide_sums);
    ty_denoise_rows(job, find_errors);
    for (int k = 0; k < TY_DENOISE_CANDIDATES; ++k)
        ty_denoise_box(job, job->light.sums[0][k][3], CHOICE_RADIUS, job->light.sums[0][k][3]);
    ty_denoise_rows(job, choose_least);
    for (int k = 0; k < TY_DENOISE_CANDIDATES; ++k)
        ty_denoise_box(job, job->light.sums[0][k][3], BLEND_RADIUS, job->light.sums[0][k][3]);
    ty_denoise_rows(job, blend);
}

/* ---- error ---- */

/* Radii of the box filters behind which the error is estimated. */
enum { SCALES = 3 };
static const int32_t scales[SCALES] = {0, 1, 3};

/* Sums over the image and its channels. */
typedef struct error_sums {
    double error, square, variance;
} error_sums;

/* The errors of low-passed light. Boxes correlate (2 radius + 1)^2 pixels, and channels have their noise in common. */
static error_sums sum_errors(ty_denoise_job* job, int32_t radius) {
    float* const* planes = job->light.sums[0][0];
    error_sums sums = {0};
    for (int c = 0; c < 3; ++c) {
        ty_denoise_box(job, job->denoised[0][c], radius, planes[0]);
        ty_denoise_box(job, job->denoised[1][c], radius, planes[1]);
        ty_denoise_box(job, job->raw[0][c], radius, planes[2]);
        ty_denoise_box(job, job->raw[1][c], radius, planes[3]);
        for (size_t i = 0; i < job->pixels; ++i) {
            const double error = (double)square_error(planes[0][i], planes[1][i], planes[2][i], planes[3][i]);
            const double apart = (double)planes[0][i] - (double)planes[1][i];
            sums.error += error;
            sums.square += error * error;
            sums.variance += 0.25 * apart * apart;
        }
    }
    sums.square *= 3.0 * (2 * radius + 1) * (2 * radius + 1);
    return sums;
}

/* The mean square error over the image. Its unbiased estimate is itself noisy, by the noise of one half times that of
 * the other. Behind a box filter it is far less so, and then lacks the bias in what the filter removes. Hence the
 * largest over several filters, each with the variance that it removes, and with one standard deviation of the estimate
 * added where that is less than the error that coarser filters found, else subtracted. */
static double total_error(ty_denoise_job* job) {
    error_sums sums[SCALES];
    for (int i = 0; i < SCALES; ++i) sums[i] = sum_errors(job, scales[i]);
    double largest = sums[0].variance;
    for (int i = SCALES - 1; i >= 0; --i) {
        const double deviation = sqrt(sums[i].square);
        const double error = sums[i].error + sums[0].variance - sums[i].variance;
        const bool precise = i == SCALES - 1 || deviation < largest;
        largest = fmax(largest, precise ? error + deviation : error - deviation);
    }
    return largest / (3 * (double)job->pixels);
}

/* Smoothed errors of a channel: its variance, and where they are significant the errors beyond it. */
static double smooth_error(ty_denoise_job* job, int c) {
    const float *a = job->denoised[0][c], *b = job->denoised[1][c], *noisy_a = job->raw[0][c],
                *noisy_b = job->raw[1][c];
    float *error = job->error[c], *variance = job->scratch[1], *square = job->scratch[2];
    const float pixels = (2 * ERROR_RADIUS + 1) * (2 * ERROR_RADIUS + 1);
    double sum = 0;
    for (size_t i = 0; i < job->pixels; ++i) {
        const float apart = a[i] - b[i], of_pixel = square_error(a[i], b[i], noisy_a[i], noisy_b[i]);
        variance[i] = 0.25f * apart * apart;
        error[i] = of_pixel - variance[i];
        square[i] = of_pixel * of_pixel / pixels;
    }
    for (int pass = 0; pass < 2; ++pass) {
        ty_denoise_box(job, error, ERROR_RADIUS, error);
        ty_denoise_box(job, variance, ERROR_RADIUS, variance);
        ty_denoise_box(job, square, ERROR_RADIUS, square);
    }
    for (size_t i = 0; i < job->pixels; ++i) {
        error[i] = fmaxf(variance[i], 0) + fmaxf(error[i] - sqrtf(fmaxf(square[i], 0)), 0);
        sum += (double)error[i];
    }
    return sum;
}

void ty_denoise_estimate_error(ty_denoise_job* job) {
    const double total = total_error(job), n = 3 * (double)job->pixels;
    double of_layers = 0, raw = 0, mean = 0;
    for (int c = 0; c < 3; ++c) {
        of_layers += smooth_error(job, c);
        for (size_t i = 0; i < job->pixels; ++i) {
            const double noise = (double)job->raw[0][c][i] - (double)job->raw[1][c][i];
            raw += 0.25 * noise * noise;
            mean += 0.5 * ((double)job->denoised[0][c][i] + (double)job->denoised[1][c][i]);
        }
    }
    const float scale = of_layers > 0 ? (float)(total * n / of_layers) : 1;
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < job->pixels; ++i) job->error[c][i] *= scale;
    job->stats.error = mean > 0 ? sqrt(total) / (mean / n) : 0;
    job->stats.raw_error = mean > 0 ? sqrt(raw / n) / (mean / n) : 0;
}
