/* Lightmaps without noise: each layer of light is denoised in the texels of its charts, by position and normal. */
#include "bake/atlas/atlas.h"

#include "base/context.h"

#include <tyndall/denoise.h>

#include <math.h>

typedef struct denoiser {
    const ty_atlas* atlas;
    const ty_bake_light* halves[2];
    ty_bake_light* out;
    int32_t* charts; /* per texel; -1: none, or its light is not usable */
    ty_image *light, *position, *normal;
} denoiser;

static ty_result create_images(denoiser* job) {
    static const char* const names[] = {"R", "G", "B", "half.R", "half.G", "half.B"};
    ty_context* context = job->atlas->context;
    const int32_t width = job->atlas->width, height = job->atlas->height;
    ty_result result = ty_image_create(context, width, height, 6, names, &job->light);
    if (result == TY_OK) result = ty_image_set_number(job->light, "tyndall.spp", 2);
    if (result == TY_OK) result = ty_image_create_rgb(context, width, height, &job->position);
    if (result == TY_OK) result = ty_image_create_rgb(context, width, height, &job->normal);
    job->charts = ty_alloc_array(context, ty_atlas_texels(job->atlas), sizeof *job->charts, false);
    return result == TY_OK && job->charts == NULL ? TY_ERROR_MEMORY : result;
}

static void fill_geometry(denoiser* job) {
    const ty_atlas* atlas = job->atlas;
    for (size_t texel = 0; texel < ty_atlas_texels(atlas); ++texel) job->charts[texel] = -1;
    for (int64_t i = 0; i < atlas->count; ++i) {
        const int32_t texel = atlas->texels[i];
        if (ty_atlas_is_lit(&job->halves[0][i]) && ty_atlas_is_lit(&job->halves[1][i]))
            job->charts[texel] = atlas->charts[i];
        for (int a = 0; a < 3; ++a) {
            ty_image_plane(job->position, a)[texel] = atlas->receivers[i].position[a];
            ty_image_plane(job->normal, a)[texel] = atlas->receivers[i].normal[a];
        }
    }
}

/* Means of both halves, and of what is not denoised, too. */
static void fill_means(denoiser* job) {
    for (int64_t i = 0; i < job->atlas->count; ++i) {
        const ty_bake_light *a = &job->halves[0][i], *b = &job->halves[1][i];
        ty_bake_light* out = &job->out[i];
        *out = a->samples >= b->samples ? *a : *b; /* one half alone where the other has no light to use */
        if (!ty_atlas_is_lit(a) || !ty_atlas_is_lit(b)) continue;
        out->samples = a->samples + b->samples;
        out->blocked = 0.5f * (a->blocked + b->blocked);
        for (int c = 0; c < 3; ++c) {
            out->fluence[c] = 0.5f * (a->fluence[c] + b->fluence[c]);
            out->variance[c] = 0;
            for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer)
                for (int axis = 0; axis < 3; ++axis)
                    out->vector_irradiance[layer][c][axis] =
                        0.5f * (a->vector_irradiance[layer][c][axis] + b->vector_irradiance[layer][c][axis]);
        }
    }
}

static void fill_light(denoiser* job, int layer) {
    const ty_atlas* atlas = job->atlas;
    for (int c = 0; c < 3; ++c) {
        float *mean = ty_image_plane(job->light, c), *even = ty_image_plane(job->light, 3 + c);
        for (int64_t i = 0; i < atlas->count; ++i) {
            const float a = job->halves[0][i].irradiance[layer][c], b = job->halves[1][i].irradiance[layer][c];
            const bool finite = isfinite(a) && isfinite(b);
            mean[atlas->texels[i]] = finite ? 0.5f * (a + b) : 0;
            even[atlas->texels[i]] = finite ? a : 0;
        }
    }
}

/* Errors add up over layers, as biases do; variance holds the sum until all are there. */
static void take_light(denoiser* job, const ty_image* denoised, int layer) {
    const ty_atlas* atlas = job->atlas;
    for (int c = 0; c < 3; ++c) {
        const float *light = ty_image_plane_const(denoised, c), *error = ty_image_plane_const(denoised, 3 + c);
        for (int64_t i = 0; i < atlas->count; ++i) {
            const int32_t texel = atlas->texels[i];
            if (job->charts[texel] < 0) continue;
            job->out[i].irradiance[layer][c] = light[texel];
            job->out[i].variance[c] += error[texel];
        }
    }
}

static ty_result denoise_layer(denoiser* job, int layer) {
    ty_denoise_def def = ty_default_denoise_def();
    ty_image* denoised = NULL;
    def.features[0] = job->position;
    def.features[1] = job->normal;
    def.charts = job->charts;
    def.parts = false;
    fill_light(job, layer);
    const ty_result result = ty_denoise_image(job->atlas->context, job->light, &def, &denoised, NULL);
    if (result == TY_OK) take_light(job, denoised, layer);
    ty_image_destroy(denoised);
    return result;
}

ty_result ty_atlas_denoise(const ty_atlas* atlas, const ty_bake_light* even, const ty_bake_light* odd,
                           ty_bake_light* out) {
    denoiser job = {.atlas = atlas, .halves = {even, odd}, .out = out};
    if (atlas == NULL) return TY_ERROR_ARGUMENT;
    if (even == NULL || odd == NULL || out == NULL)
        return ty_fail(atlas->context, TY_ERROR_ARGUMENT, "ty_atlas_denoise: an argument is NULL");
    ty_result result = create_images(&job);
    if (result == TY_OK) {
        fill_geometry(&job);
        fill_means(&job);
    }
    for (int layer = 0; layer < TY_BAKE_LAYERS && result == TY_OK; ++layer) result = denoise_layer(&job, layer);
    for (int64_t i = 0; i < atlas->count && result == TY_OK; ++i)
        for (int c = 0; c < 3 && job.charts[atlas->texels[i]] >= 0; ++c) out[i].variance[c] *= out[i].variance[c];
    ty_free_array(atlas->context, job.charts, ty_atlas_texels(atlas), sizeof *job.charts);
    ty_image_destroy(job.light);
    ty_image_destroy(job.position);
    ty_image_destroy(job.normal);
    return result;
}
