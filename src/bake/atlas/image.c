/* Lightmaps: conversion of light at texels to an image. */
#include "bake/atlas/atlas.h"

#include "base/context.h"

#include <math.h>

enum {
    SUM = 0,
    LAYERS = 3,
    L1 = LAYERS + 3 * TY_BAKE_LAYERS,
    COVERAGE = L1 + 9,
    SAMPLES = COVERAGE + 1,
    VARIANCE = SAMPLES + 1,
};

static const char* const channel_names[TY_ATLAS_CHANNELS] = {
    "R",          "G",         "B",          "direct.R",   "direct.G",   "direct.B",   "indirect.R", "indirect.G",
    "indirect.B", "single.R",  "single.G",   "single.B",   "multiple.R", "multiple.G", "multiple.B", "L1.RX",
    "L1.RY",      "L1.RZ",     "L1.GX",      "L1.GY",      "L1.GZ",      "L1.BX",      "L1.BY",      "L1.BZ",
    "coverage.A", "samples.N", "variance.R", "variance.G", "variance.B"};

typedef struct finisher {
    const ty_atlas* atlas;
    const ty_bake_light* light;
    ty_image* image;
    float* work[TY_ATLAS_PLANES]; /* channel planes in progress */
    float* channels[TY_ATLAS_CHANNELS];
    bool* valid;
    int32_t* source;
} finisher;

/* Until the last step R, G and B hold the fluence and L1 the vector irradiance: both are linear in light and may be
 * averaged. */
static void assign_planes(finisher* job) {
    for (int i = 0; i < TY_ATLAS_CHANNELS; ++i) job->channels[i] = ty_image_plane(job->image, i);
    for (int i = 0; i < 3 * TY_BAKE_LAYERS; ++i) job->work[TY_ATLAS_LAYERS + i] = job->channels[LAYERS + i];
    for (int i = 0; i < 9; ++i) job->work[TY_ATLAS_VECTOR_IRRADIANCE + i] = job->channels[L1 + i];
    for (int i = 0; i < 3; ++i) job->work[TY_ATLAS_FLUENCE + i] = job->channels[SUM + i];
}

/* The light of one receiver, in the order of the planes in progress. */
static void planes_from_light(const ty_bake_light* light, float values[TY_ATLAS_PLANES]) {
    for (int i = 0; i < TY_ATLAS_PLANES; ++i) values[i] = 0;
    for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer)
        for (int c = 0; c < 3; ++c) {
            values[TY_ATLAS_LAYERS + 3 * layer + c] = light->irradiance[layer][c];
            for (int axis = 0; axis < 3; ++axis)
                values[TY_ATLAS_VECTOR_IRRADIANCE + 3 * c + axis] += light->vector_irradiance[layer][c][axis];
        }
    for (int c = 0; c < 3; ++c) values[TY_ATLAS_FLUENCE + c] = light->fluence[c];
}

enum { BLOCK = 4096 };

static void load_light(void* user, int64_t index, int32_t worker) {
    (void)worker;
    finisher* job = user;
    const int64_t end = (index + 1) * BLOCK < job->atlas->count ? (index + 1) * BLOCK : job->atlas->count;
    for (int64_t i = index * BLOCK; i < end; ++i) {
        const ty_bake_light* light = &job->light[i];
        const int32_t texel = job->atlas->texels[i];
        float values[TY_ATLAS_PLANES];
        planes_from_light(light, values);
        bool valid = ty_atlas_is_lit(light);
        for (int plane = 0; plane < TY_ATLAS_PLANES; ++plane) {
            const bool finite = isfinite(values[plane]);
            valid &= finite;
            job->work[plane][texel] = finite ? values[plane] : 0.0f;
        }
        job->valid[i] = valid;
        job->channels[COVERAGE][texel] = job->atlas->coverage[i];
        job->channels[SAMPLES][texel] = valid ? (float)light->samples : 0.0f;
        for (int c = 0; c < 3; ++c)
            job->channels[VARIANCE + c][texel] = valid && isfinite(light->variance[c]) ? light->variance[c] : 0.0f;
    }
}

/* Fills the texels around charts, except those that seams have filled. Source texels stay unchanged. */
static void pad_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    finisher* job = user;
    const size_t width = (size_t)job->atlas->width;
    for (size_t texel = (size_t)index * width; texel < ((size_t)index + 1) * width; ++texel) {
        const int32_t source = job->source[texel];
        if (source < 0 || source == (int32_t)texel) continue;
        for (int plane = 0; plane < TY_ATLAS_PLANES; ++plane) job->work[plane][texel] = job->work[plane][source];
    }
}

/* Converts the planes in progress to the named channels. */
static void finish_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    finisher* job = user;
    const size_t width = (size_t)job->atlas->width;
    for (size_t texel = (size_t)index * width; texel < ((size_t)index + 1) * width; ++texel)
        for (int c = 0; c < 3; ++c) {
            float* vector[3];
            float square = 0, sum = 0;
            for (int axis = 0; axis < 3; ++axis) {
                vector[axis] = &job->channels[L1 + 3 * c + axis][texel];
                square += *vector[axis] * *vector[axis];
            }
            const float norm = fmaxf(job->channels[SUM + c][texel], sqrtf(square));
            for (int axis = 0; axis < 3; ++axis) *vector[axis] = norm > 0 ? *vector[axis] / norm : 0.0f;
            for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer) sum += job->channels[LAYERS + 3 * layer + c][texel];
            job->channels[SUM + c][texel] = sum;
        }
}

static ty_result finish(finisher* job) {
    const ty_atlas* atlas = job->atlas;
    ty_parallel_for(atlas->context, (atlas->count + BLOCK - 1) / BLOCK, load_light, job);
    ty_result result = ty_atlas_inpaint(atlas, job->valid, job->work);
    if (result == TY_OK) result = ty_atlas_pad(atlas, atlas->padding, job->source);
    if (result == TY_OK) result = ty_atlas_close_seams(atlas, job->source, job->work);
    if (result != TY_OK) return result;
    ty_parallel_for(atlas->context, atlas->height, pad_row, job);
    ty_parallel_for(atlas->context, atlas->height, finish_row, job);
    return TY_OK;
}

ty_result ty_atlas_create_image(const ty_atlas* atlas, const ty_bake_light* light, ty_image** out) {
    finisher job = {.atlas = atlas, .light = light};
    ty_result result =
        ty_image_create(atlas->context, atlas->width, atlas->height, TY_ATLAS_CHANNELS, channel_names, &job.image);
    if (result != TY_OK) return result;
    assign_planes(&job);
    const size_t all = ty_atlas_texels(atlas), count = (size_t)atlas->count;
    job.valid = ty_alloc_array(atlas->context, count, sizeof *job.valid, false);
    job.source = ty_alloc_array(atlas->context, all, sizeof *job.source, false);
    result = job.valid != NULL && job.source != NULL ? finish(&job) : TY_ERROR_MEMORY;
    ty_free_array(atlas->context, job.valid, count, sizeof *job.valid);
    ty_free_array(atlas->context, job.source, all, sizeof *job.source);
    if (result == TY_OK)
        *out = job.image;
    else
        ty_image_destroy(job.image);
    return result;
}
