/* Planes of denoising: their channels in the image, halves, and box filters. */
#include "base/context.h"
#include "base/parallel.h"
#include "image/denoise/job.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

float* ty_denoise_plane(ty_denoise_job* job) {
    return ty_alloc_array(job->context, job->pixels, sizeof(float), true);
}

void ty_denoise_free_plane(ty_denoise_job* job, float* plane) {
    ty_free_array(job->context, plane, job->pixels, sizeof(float));
}

void ty_denoise_rows(ty_denoise_job* job, ty_parallel_fn body) {
    ty_parallel_flushed(job->context, job->height, body, job);
}

/* ---- box filters ---- */

enum { STRIP = 64 };

typedef struct box_job {
    int32_t width, height, radius;
    const float* in;
    float *rows, *out;
} box_job;

/* Number of pixels of [at - radius, at + radius] in [0, size). */
static int32_t box_count(int32_t at, int32_t radius, int32_t size) {
    const int32_t first = at - radius > 0 ? at - radius : 0, last = at + radius < size - 1 ? at + radius : size - 1;
    return last - first + 1;
}

static void box_row(void* user, int64_t y, int32_t worker) {
    (void)worker;
    const box_job* job = user;
    const float* in = job->in + (size_t)y * (size_t)job->width;
    float* out = job->rows + (size_t)y * (size_t)job->width;
    const int32_t r = job->radius;
    double sum = 0;
    for (int32_t x = 0; x < r && x < job->width; ++x) sum += (double)in[x];
    for (int32_t x = 0; x < job->width; ++x) {
        if (x + r < job->width) sum += (double)in[x + r];
        if (x - r - 1 >= 0) sum -= (double)in[x - r - 1];
        out[x] = (float)(sum / box_count(x, r, job->width));
    }
}

static void box_strip(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const box_job* job = user;
    const int32_t begin = (int32_t)index * STRIP, r = job->radius;
    const int32_t count = job->width - begin < STRIP ? job->width - begin : STRIP;
    const size_t pitch = (size_t)job->width;
    const float* in = job->rows + begin;
    double sum[STRIP] = {0};
    for (int32_t y = 0; y < r && y < job->height; ++y)
        for (int32_t x = 0; x < count; ++x) sum[x] += (double)in[(size_t)y * pitch + (size_t)x];
    for (int32_t y = 0; y < job->height; ++y) {
        float* out = job->out + (size_t)y * pitch + begin;
        const double scale = 1.0 / box_count(y, r, job->height);
        if (y + r < job->height)
            for (int32_t x = 0; x < count; ++x) sum[x] += (double)in[(size_t)(y + r) * pitch + (size_t)x];
        if (y - r - 1 >= 0)
            for (int32_t x = 0; x < count; ++x) sum[x] -= (double)in[(size_t)(y - r - 1) * pitch + (size_t)x];
        for (int32_t x = 0; x < count; ++x) out[x] = (float)(sum[x] * scale);
    }
}

void ty_denoise_box(ty_denoise_job* job, const float* in, int32_t radius, float* out) {
    box_job box = {job->width, job->height, radius, in, job->scratch[0], out};
    ty_parallel_flushed(job->context, box.height, box_row, &box);
    ty_parallel_flushed(job->context, (box.width + STRIP - 1) / STRIP, box_strip, &box);
}

/* ---- channels ---- */

const float* ty_denoise_find(const ty_denoise_job* job, const char* name, bool half) {
    char full[64];
    snprintf(full, sizeof full, "%s%s", half ? "half." : "", name);
    const int32_t channel = ty_image_find_channel(job->image, full);
    return channel >= 0 ? ty_image_plane_const(job->image, channel) : NULL;
}

/* Values beyond this overflow where they are squared. */
static const float largest = 1e15f;

static float finite(float value) {
    return value >= -largest && value <= largest ? value : 0.0f;
}

void ty_denoise_split(const ty_denoise_job* job, const float* all, const float* even, float* const out[2]) {
    for (size_t i = 0; i < job->pixels; ++i) {
        const double n = job->samples != NULL ? (double)job->samples[i] : job->spp;
        const double evens = ceil(0.5 * n), mean = (double)finite(all[i]);
        const double value = even != NULL ? (double)finite(even[i]) : mean;
        out[0][i] = (float)value;
        out[1][i] = (float)(even != NULL && n > evens ? (n * mean - evens * value) / (n - evens) : mean);
    }
}

ty_result ty_denoise_check_image(ty_denoise_job* job) {
    static const char* const needed[] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c) {
        if (ty_denoise_find(job, needed[c], false) == NULL)
            return ty_fail(job->context, TY_ERROR_INPUT, "the image has no channel %s to denoise", needed[c]);
        if (ty_denoise_find(job, needed[c], true) == NULL)
            return ty_fail(job->context, TY_ERROR_INPUT,
                           "the image has no channel half.%s, by which noise is told from detail; render it with the "
                           "channel \"half\"",
                           needed[c]);
    }
    const char* spp = ty_image_get_metadata(job->image, "tyndall.spp");
    job->samples = ty_denoise_find(job, "samples.N", false);
    job->spp = spp != NULL ? strtod(spp, NULL) : 2;
    double fewest = job->spp;
    for (size_t i = 0; job->samples != NULL && i < job->pixels; ++i)
        fewest = i == 0 ? (double)job->samples[0] : fmin(fewest, (double)job->samples[i]);
    if (!(fewest >= 2))
        return ty_fail(job->context, TY_ERROR_INPUT, "the image has %g samples in some pixel, and denoising needs 2",
                       fewest);
    return TY_OK;
}
