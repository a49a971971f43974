/* Light of the image before in a sequence, blended in where both agree. */
#include "image/denoise/job.h"
#include "image/image.h"

#include <math.h>

/* Pixels of the image before are taken from this far, and compared by patches of 3 x 3. */
enum { REACH = 2 };

/* Weight of the image before at equal errors, over that of this image: it holds light of those before it, too. */
static const float history = 4;

/* Differences at which pixels count as of other surfaces: of depth over depth, and of unit normals. */
static const float depth_scale = 0.1f, normal_scale = 0.3f;

typedef struct blending {
    ty_denoise_job* job;
    const float *light[3], *error[3];              /* of the image before */
    const float *geometry[4], *geometry_before[4]; /* depth and normal; NULL where one of both has none */
    float* own[3];                                 /* light of this image */
    float* weight;
} blending;

/* Returns false if the image before lacks some of its light or error. */
static bool find_planes(blending* b) {
    static const char* const light[3] = {"denoised.R", "denoised.G", "denoised.B"};
    static const char* const error[3] = {"denoised_error.R", "denoised_error.G", "denoised_error.B"};
    static const char* const geometry[4] = {"depth.Z", "normal.X", "normal.Y", "normal.Z"};
    const ty_image* before = b->job->def.previous;
    bool whole = true;
    for (int c = 0; c < 3; ++c) {
        b->light[c] = ty_image_plane_const(before, ty_image_find_channel(before, light[c]));
        b->error[c] = ty_image_plane_const(before, ty_image_find_channel(before, error[c]));
        whole = whole && b->light[c] != NULL && b->error[c] != NULL;
    }
    for (int g = 0; g < 4; ++g) {
        b->geometry[g] = ty_denoise_find(b->job, geometry[g], false);
        b->geometry_before[g] = ty_image_plane_const(before, ty_image_find_channel(before, geometry[g]));
    }
    return whole;
}

static int32_t within(int32_t at, int32_t size) {
    return at < 0 ? 0 : at < size ? at : size - 1;
}

/* Squared difference of the surfaces in units of their scales. */
static float geometry_distance(const blending* b, size_t here, size_t there) {
    float sum = 0;
    for (int g = 0; g < 4; ++g) {
        if (b->geometry[g] == NULL || b->geometry_before[g] == NULL) continue;
        const float now = b->geometry[g][here], before = b->geometry_before[g][there];
        const float scale = g == 0 ? depth_scale * fmaxf(fabsf(now), fabsf(before)) + 1e-6f : normal_scale;
        sum += (now - before) * (now - before) / (scale * scale);
    }
    return sum;
}

/* Squared difference of 3 x 3 pixels of both images less their errors, over these: as between patches of one image. */
static float light_distance(const blending* b, int32_t x, int32_t y, int32_t dx, int32_t dy) {
    const ty_denoise_job* job = b->job;
    float above = 0, below = 9 * job->light.softening;
    for (int32_t k = 0; k < 9; ++k) {
        const int32_t px = x + k % 3 - 1, py = y + k / 3 - 1;
        const size_t here = (size_t)within(py, job->height) * (size_t)job->width + (size_t)within(px, job->width);
        const size_t there =
            (size_t)within(py + dy, job->height) * (size_t)job->width + (size_t)within(px + dx, job->width);
        for (int c = 0; c < 3; ++c) {
            const float difference = b->own[c][here] - b->light[c][there];
            const float errors = job->error[c][here] + b->error[c][there] * b->error[c][there];
            above += difference * difference - errors;
            below += errors;
        }
    }
    return fmaxf(above / below, 0);
}

static void blend_pixel(const blending* b, int32_t x, int32_t y) {
    const ty_denoise_job* job = b->job;
    const size_t here = (size_t)y * (size_t)job->width + (size_t)x;
    float sum = 0, largest = 0, light[3] = {0}, square[3] = {0};
    for (int32_t dy = -REACH; dy <= REACH; ++dy)
        for (int32_t dx = -REACH; dx <= REACH; ++dx) {
            const int32_t px = x + dx, py = y + dy;
            if (px < 0 || py < 0 || px >= job->width || py >= job->height) continue;
            const size_t there = (size_t)py * (size_t)job->width + (size_t)px;
            /* Of pixels that are alike the nearest are the likeliest to be the same point. */
            const float far = 0.5f * (float)(dx * dx + dy * dy);
            const float near = expf(-(geometry_distance(b, here, there) + light_distance(b, x, y, dx, dy)));
            const float weight = near * expf(-far);
            largest = fmaxf(largest, near);
            sum += weight;
            for (int c = 0; c < 3; ++c) {
                light[c] += weight * b->light[c][there];
                square[c] += weight * b->error[c][there] * b->error[c][there];
            }
        }
    b->weight[here] = 0;
    if (!(sum > 1e-6f)) return;
    for (int c = 0; c < 3; ++c) {
        const float error = job->error[c][here], before = square[c] / sum;
        const float weight = largest * history * error / (history * error + before + 1e-30f), rest = 1 - weight;
        const float value = rest * b->own[c][here] + weight * light[c] / sum;
        job->denoised[0][c][here] = job->denoised[1][c][here] = value;
        /* Noise of both is independent and bias is not; all counts as bias. */
        const float together = rest * sqrtf(error) + weight * sqrtf(before);
        job->scratch[1 + c][here] = together * together;
        b->weight[here] += weight / 3;
    }
}

static void blend_row(void* user, int64_t y, int32_t worker) {
    (void)worker;
    const blending* b = user;
    for (int c = 0; c < 3; ++c)
        for (int32_t x = 0; x < b->job->width; ++x) {
            const size_t i = (size_t)y * (size_t)b->job->width + (size_t)x;
            b->job->scratch[1 + c][i] = b->job->error[c][i];
        }
    for (int32_t x = 0; x < b->job->width; ++x) blend_pixel(b, x, (int32_t)y);
}

bool ty_denoise_has_previous(ty_denoise_job* job) {
    blending b = {.job = job};
    return find_planes(&b);
}

void ty_denoise_blend_previous(ty_denoise_job* job) {
    blending b = {.job = job, .weight = job->scratch[0]};
    find_planes(&b);
    for (int c = 0; c < 3; ++c) {
        b.own[c] = job->light.sums[0][0][c];
        for (size_t i = 0; i < job->pixels; ++i) b.own[c][i] = 0.5f * (job->denoised[0][c][i] + job->denoised[1][c][i]);
    }
    ty_parallel_for(job->context, job->height, blend_row, &b);
    double weight = 0;
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < job->pixels; ++i) job->error[c][i] = job->scratch[1 + c][i];
    for (size_t i = 0; i < job->pixels; ++i) weight += (double)b.weight[i];
    job->stats.previous = weight / (double)job->pixels;
}
