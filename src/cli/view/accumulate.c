#include "cli/view/accumulate.h"

#include "base/luminance.k.h"
#include "cli/session/session.h"
#include "method/registry.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double batch_seconds = 0.3;
enum { BATCH_MAX = 1024, BLOCK = 8 };

bool view_accumulation_reset(view_accumulation* sum, int32_t width, int32_t height, bool unscattered) {
    const size_t values = 3 * (size_t)width * (size_t)height;
    if (width != sum->width || height != sum->height || sum->half[0] == NULL) {
        view_accumulation_free(sum);
        for (int i = 0; i < 2; ++i) sum->half[i] = malloc(values * sizeof(float));
        if (sum->half[0] == NULL || sum->half[1] == NULL) {
            view_accumulation_free(sum);
            return false;
        }
    }
    for (int i = 0; i < 2; ++i) memset(sum->half[i], 0, values * sizeof(float));
    sum->width = width;
    sum->height = height;
    sum->unscattered = unscattered;
    sum->enclosed = NULL;
    sum->spp[0] = sum->spp[1] = sum->seconds = 0;
    sum->batch = 1;
    sum->images = 0;
    return true;
}

void view_accumulation_free(view_accumulation* sum) {
    for (int i = 0; i < 2; ++i) free(sum->half[i]);
    *sum = (view_accumulation){.width = 0};
}

double view_accumulation_spp(const view_accumulation* sum) {
    return sum->spp[0] + sum->spp[1];
}

/* Independent seeds: the scene's and the number of the image, mixed. */
static uint64_t image_seed(uint64_t seed, uint64_t image) {
    return seed + (image + 1) * 0x9e3779b97f4a7c15u;
}

static ty_result render(const view_accumulation* sum, const ty_scene* scene, int32_t spp, uint64_t image,
                        ty_progress_fn progress, void* user, ty_image** out) {
    const ty_render_request request = {.spp = spp,
                                       .seed = image_seed(ty_scene_render_settings(scene).seed, image),
                                       .width = sum->width,
                                       .height = sum->height,
                                       .progress = progress,
                                       .progress_user = user};
    ty_path_def def;
    ty_result result = ty_request_path_def(scene, &request, &def);
    def.unscattered = sum->unscattered;
    def.enclosed = sum->enclosed;
    if (def.guide == TY_PATH_GUIDE_AUTO) def.guide = TY_PATH_GUIDE_NONE; /* no pilot for each image */
    *out = NULL;
    if (result == TY_OK) result = ty_path_render(scene, &def, out, NULL);
    if (result == TY_OK) return TY_OK;
    ty_image_destroy(*out);
    *out = NULL;
    return result;
}

static void add_image(view_accumulation* sum, int half, const ty_image* image, int32_t spp) {
    const float* planes[3];
    ty_image_rgb_planes(image, planes);
    const size_t pixels = (size_t)sum->width * (size_t)sum->height;
    for (size_t i = 0; i < pixels; ++i)
        for (size_t c = 0; c < 3; ++c) sum->half[half][3 * i + c] += (float)spp * planes[c][i];
    sum->spp[half] += spp;
}

ty_result view_accumulation_add(view_accumulation* sum, const ty_scene* scene, int32_t spp_max, ty_progress_fn progress,
                                void* user) {
    const double begun = cli_wall_seconds();
    const double left = (spp_max - view_accumulation_spp(sum)) / 2;
    const int32_t spp = (int32_t)fmax(1, fmin(sum->batch, left));
    ty_image* images[2] = {NULL, NULL};
    ty_result result = TY_OK;
    for (int i = 0; i < 2 && result == TY_OK; ++i)
        result = render(sum, scene, spp, sum->images + (uint64_t)i, progress, user, &images[i]);
    if (result == TY_OK) {
        for (int i = 0; i < 2; ++i) add_image(sum, i, images[i], spp);
        sum->images += 2;
        const double seconds = cli_wall_seconds() - begun;
        sum->seconds += seconds;
        if (seconds < batch_seconds / 2 && sum->batch < BATCH_MAX) sum->batch *= 2;
    }
    for (int i = 0; i < 2; ++i) ty_image_destroy(images[i]);
    return result;
}

void view_accumulation_mean(const view_accumulation* sum, float* rgb) {
    const size_t values = 3 * (size_t)sum->width * (size_t)sum->height;
    const double spp = view_accumulation_spp(sum);
    const float factor = spp > 0 ? (float)(1 / spp) : 0;
    for (size_t i = 0; i < values; ++i) rgb[i] = factor * (sum->half[0][i] + sum->half[1][i]);
}

static double luminance(const float* rgb) {
    return ty_luminance(rgb[0], rgb[1], rgb[2]);
}

/* Sums of luminance over one block: of the image, and of the means of both halves. */
static void sum_block(const view_accumulation* sum, const float* rgb, int32_t x0, int32_t y0, double out[3]) {
    out[0] = out[1] = out[2] = 0;
    for (int32_t y = y0; y < y0 + BLOCK; ++y)
        for (int32_t x = x0; x < x0 + BLOCK; ++x) {
            const size_t at = 3 * ((size_t)y * (size_t)sum->width + (size_t)x);
            out[0] += luminance(&rgb[at]);
            for (int i = 0; i < 2; ++i) out[1 + i] += luminance(&sum->half[i][at]) / sum->spp[i];
        }
}

bool view_accumulation_compare(const view_accumulation* sum, const float* rgb, view_difference* out) {
    if (!(sum->spp[0] > 0 && sum->spp[1] > 0) || sum->width < BLOCK || sum->height < BLOCK) return false;
    double image = 0, path = 0, squares = 0, noise = 0, block[3];
    int64_t blocks = 0;
    for (int32_t y = 0; y + BLOCK <= sum->height; y += BLOCK)
        for (int32_t x = 0; x + BLOCK <= sum->width; x += BLOCK, ++blocks) {
            sum_block(sum, rgb, x, y, block);
            const double mean = 0.5 * (block[1] + block[2]), half = 0.5 * (block[1] - block[2]);
            image += block[0];
            path += mean;
            squares += (block[0] - mean) * (block[0] - mean);
            noise += half * half;
        }
    if (!(path > 0) || !isfinite(squares) || !isfinite(noise)) return false;
    const double to_relative = 1 / path * (double)blocks; /* of root mean squares over blocks */
    out->mean_ratio = image / path;
    out->rmse = sqrt(squares / (double)blocks) * to_relative;
    out->noise = sqrt(noise / (double)blocks) * to_relative;
    return true;
}
