/* Denoising of an image: parts of its light one after another, and their sum. */
#include "base/context.h"
#include "image/denoise/job.h"
#include "image/image.h"

#include <math.h>
#include <string.h>

/* ---- memory ---- */

enum { LIGHT_PLANES = 6 + 1 + 2 * TY_DENOISE_CANDIDATES * 4, OWN_PLANES = 6 + 6 + 3 + 4, OUT_PLANES = 6 };

/* Stores the addresses of all planes; returns their number. */
static int list_planes(ty_denoise_job* job, float** planes[LIGHT_PLANES + OWN_PLANES]) {
    int count = 0;
    for (int h = 0; h < 2; ++h)
        for (int c = 0; c < 3; ++c) {
            planes[count++] = &job->light.color[h][c];
            planes[count++] = &job->raw[h][c];
            planes[count++] = &job->denoised[h][c];
        }
    for (int c = 0; c < 3; ++c) {
        planes[count++] = &job->error[c];
    }
    planes[count++] = &job->light.variance;
    for (int i = 0; i < 4; ++i) planes[count++] = &job->scratch[i];
    for (int i = 0; i < 2 * TY_DENOISE_CANDIDATES * 4; ++i)
        planes[count++] = &job->light.sums[i / (TY_DENOISE_CANDIDATES * 4)][i / 4 % TY_DENOISE_CANDIDATES][i % 4];
    return count;
}

static ty_result allocate(ty_denoise_job* job) {
    float** planes[LIGHT_PLANES + OWN_PLANES];
    const int count = list_planes(job, planes);
    const double bytes = (double)sizeof(float) * (double)job->pixels * (count + TY_DENOISE_PLANES_MAX + OUT_PLANES);
    ty_result result = ty_check_memory(job->context, bytes, "denoising");
    for (int i = 0; i < count && result == TY_OK; ++i)
        if ((*planes[i] = ty_denoise_plane(job)) == NULL) result = TY_ERROR_MEMORY;
    if (result != TY_OK) return result;
    job->tiles = ty_alloc_array(job->context, (size_t)ty_context_threads(job->context), sizeof *job->tiles, true);
    return job->tiles != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static void release(ty_denoise_job* job) {
    float** planes[LIGHT_PLANES + OWN_PLANES];
    const int count = list_planes(job, planes);
    for (int i = 0; i < count; ++i) ty_denoise_free_plane(job, *planes[i]);
    for (int32_t i = 0; i < job->feature_count; ++i) ty_denoise_free_plane(job, job->features[i]);
    ty_free_array(job->context, job->tiles, (size_t)ty_context_threads(job->context), sizeof *job->tiles);
}

/* ---- parts ---- */

/* Parts of light: scattered once by media, otherwise by media, and the remainder, or all. */
enum { SINGLE = 0, MULTIPLE = 1, REMAINDER = 2, PARTS = 3 };

static const char* const names[PARTS][3] = {
    {"single.R", "single.G", "single.B"}, {"multiple.R", "multiple.G", "multiple.B"}, {"R", "G", "B"}};

static bool has_parts(const ty_denoise_job* job) {
    bool all = job->def.parts;
    for (int part = 0; part < PARTS; ++part)
        for (int c = 0; c < 3; ++c)
            all = all && ty_denoise_find(job, names[part][c], false) != NULL &&
                  ty_denoise_find(job, names[part][c], true) != NULL;
    return all;
}

/* Sets the halves of one channel of a part. */
static void split_channel(ty_denoise_job* job, int part, int c, float* const out[2]) {
    ty_denoise_split(job, ty_denoise_find(job, names[part][c], false), ty_denoise_find(job, names[part][c], true), out);
}

/* Loads a part; false if it has no light. */
static bool load_part(ty_denoise_job* job, int part, bool parts) {
    bool lit = false;
    job->light.channels = 3;
    for (int c = 0; c < 3; ++c) {
        float* const halves[2] = {job->light.color[0][c], job->light.color[1][c]};
        split_channel(job, part, c, halves);
        for (int other = SINGLE; part == REMAINDER && parts && other < REMAINDER; ++other) {
            float* const taken[2] = {job->scratch[1], job->scratch[2]};
            split_channel(job, other, c, taken);
            for (int h = 0; h < 2; ++h)
                for (size_t i = 0; i < job->pixels; ++i) halves[h][i] -= taken[h][i];
        }
        for (int h = 0; h < 2; ++h)
            for (size_t i = 0; i < job->pixels; ++i) lit = lit || halves[h][i] != 0;
    }
    return lit;
}

static ty_result denoise_parts(ty_denoise_job* job) {
    const bool parts = has_parts(job);
    ty_result result = TY_OK;
    for (int part = parts ? SINGLE : REMAINDER; part < PARTS && result == TY_OK; ++part) {
        if (!load_part(job, part, parts)) continue;
        ++job->stats.parts;
        ty_denoise_estimate_variance(job);
        ty_denoise_predict(job);
        ty_denoise_choose(job);
        result = ty_part_show(&job->progress, "denoise", (double)(part + 1) / PARTS);
    }
    return result;
}

/* ---- result ---- */

static ty_result create_result(const ty_denoise_job* job, ty_image** out) {
    static const char* const channels[OUT_PLANES] = {"denoised.R",       "denoised.G",       "denoised.B",
                                                     "denoised_error.R", "denoised_error.G", "denoised_error.B"};
    ty_image* image = NULL;
    const ty_result result = ty_image_create(job->context, job->width, job->height, OUT_PLANES, channels, &image);
    if (result != TY_OK) return result;
    memcpy(image->frame, job->image->frame, sizeof image->frame);
    for (int c = 0; c < 3; ++c) {
        float *light = ty_image_plane(image, c), *error = ty_image_plane(image, 3 + c);
        for (size_t i = 0; i < job->pixels; ++i) {
            light[i] = fmaxf(0.5f * (job->denoised[0][c][i] + job->denoised[1][c][i]), 0);
            error[i] = sqrtf(job->error[c][i]);
        }
    }
    *out = image;
    return TY_OK;
}

static ty_result run(ty_denoise_job* job, ty_image** out) {
    const bool regression = job->def.denoiser == TY_DENOISER_REGRESSION;
    ty_result result = allocate(job);
    if (result == TY_OK && regression) result = ty_denoise_make_features(job);
    if (result == TY_OK) result = ty_part_show(&job->progress, "denoise", 0.2);
    if (result == TY_OK) result = regression ? denoise_parts(job) : ty_denoise_by_oidn(job);
    if (result != TY_OK) return result;
    ty_denoise_estimate_error(job);
    if (job->def.previous != NULL) ty_denoise_blend_previous(job);
    return create_result(job, out);
}

static ty_result check_images(ty_denoise_job* job) {
    for (int f = 0; f <= TY_DENOISE_FEATURES_MAX; ++f) {
        const bool previous = f == TY_DENOISE_FEATURES_MAX;
        const ty_image* image = previous ? job->def.previous : job->def.features[f];
        if (image != NULL && (image->width != job->width || image->height != job->height))
            return ty_fail(job->context, TY_ERROR_ARGUMENT, "denoise.%s: %d x %d pixels, and the image has %d x %d",
                           previous ? "previous" : "features", (int)image->width, (int)image->height, (int)job->width,
                           (int)job->height);
    }
    if (job->def.charts != NULL && job->def.denoiser == TY_DENOISER_OIDN)
        return ty_fail(job->context, TY_ERROR_ARGUMENT,
                       "denoise.charts: Open Image Denoise knows none; regression does");
    if (job->def.previous != NULL && !ty_denoise_has_previous(job))
        return ty_fail(job->context, TY_ERROR_ARGUMENT,
                       "denoise.previous: it has no denoised and denoised_error, which denoising adds to an image");
    return TY_OK;
}

ty_result ty_denoise_image(ty_context* context, const ty_image* image, const ty_denoise_def* def, ty_image** out,
                           ty_denoise_stats* stats) {
    ty_denoise_job job = {.context = context, .image = image, .kernels = TY_BEST_KERNELS(ty_denoise_kernels)};
    const double begun = ty_wall_seconds();
    if (image == NULL || out == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_denoise_image: an argument is NULL");
    ty_result result = ty_take_stats(context, stats, "ty_default_denoise_stats", &job.stats, sizeof job.stats);
    if (result == TY_OK) result = ty_denoise_take_def(context, def, &job.def);
    job.width = image->width;
    job.height = image->height;
    job.pixels = (size_t)job.width * (size_t)job.height;
    if (result == TY_OK) result = check_images(&job);
    if (result == TY_OK) result = ty_denoise_check_image(&job);
    if (result != TY_OK) return result;
    job.progress = ty_part_begin(job.def.progress, job.def.progress_user, 0, 1);
    result = run(&job, out);
    release(&job);
    if (result != TY_OK) return result;
    job.stats.seconds = ty_wall_seconds() - begun;
    job.stats.isa = ty_isa_name(ty_best_isa());
    ty_give_stats(&job.stats, sizeof job.stats, stats);
    return TY_OK;
}
