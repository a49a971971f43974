#include "choose/trial.h"

#include "base/context.h"

#include <math.h>
#include <string.h>

enum { ACROSS = 4, DOWN = 3, BLOCKS = ACROSS * DOWN };

const double ty_trial_failed = 10;

/* Means of three planes over the blocks of an image. */
static void find_means(const ty_image* image, const float* const planes[3], double out[BLOCKS]) {
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    double counts[BLOCKS] = {0};
    memset(out, 0, BLOCKS * sizeof *out);
    for (int32_t i = 0; i < width * height; ++i) {
        const int32_t x = i % width, y = i / width, block = y * DOWN / height * ACROSS + x * ACROSS / width;
        counts[block] += 3;
        for (int c = 0; c < 3; ++c) out[block] += (double)planes[c][i];
    }
    for (int b = 0; b < BLOCKS; ++b) out[b] /= fmax(counts[b], 1);
}

static void image_means(const ty_image* image, double out[BLOCKS]) {
    const float* planes[3];
    ty_image_rgb_planes(image, planes);
    find_means(image, planes, out);
}

static double mean_of(const double means[BLOCKS]) {
    double sum = 0;
    for (int b = 0; b < BLOCKS; ++b) sum += means[b] / BLOCKS;
    return sum;
}

double ty_trial_noise(const ty_pilot* pilot) {
    static const char* const names[3] = {"variance.R", "variance.G", "variance.B"};
    const float* planes[3];
    double means[BLOCKS], variances[BLOCKS];
    for (int c = 0; c < 3; ++c)
        planes[c] = ty_image_plane_const(pilot->all, ty_image_find_channel(pilot->all, names[c]));
    image_means(pilot->all, means);
    find_means(pilot->all, planes, variances);
    const double mean = mean_of(means), pixels = (double)pilot->width * pilot->height / BLOCKS;
    return mean > 0 ? sqrt(mean_of(variances) / pixels) / mean : 0;
}

static double find_difference(const ty_image* image, const ty_image* truth) {
    double means[BLOCKS], others[BLOCKS], squares = 0;
    image_means(truth, means);
    image_means(image, others);
    for (int b = 0; b < BLOCKS; ++b) squares += (others[b] - means[b]) * (others[b] - means[b]) / BLOCKS;
    const double mean = mean_of(means), difference = mean > 0 ? sqrt(squares) / mean : 0;
    return difference < ty_trial_failed ? difference : ty_trial_failed; /* also if it is not a number */
}

double ty_trial(const ty_scene* scene, const ty_method* method, const ty_pilot* pilot) {
    const ty_render_request request = {.spp = pilot->spp, .width = pilot->width, .height = pilot->height};
    ty_method_run run = {.own_seconds = 0};
    ty_image* image = NULL;
    void* light = NULL;
    ty_result result = method->solve(scene, &request, TY_SOLVE_COARSE, &light, &run);
    if (result == TY_OK)
        result = method->view(light, scene, &request, method->takes_surfaces ? pilot->unscattered : NULL, &image, &run);
    const double difference = result == TY_OK ? find_difference(image, pilot->all) : ty_trial_failed;
    if (result != TY_OK) ty_take_error(ty_scene_context(scene));
    ty_image_destroy(image);
    if (light != NULL) method->destroy(light);
    return difference;
}
