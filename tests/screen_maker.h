/* Shared by the tests of screen-space scattering: pictures with their distances, fogs, and all variants. */
#ifndef TY_TESTS_SCREEN_MAKER_H
#define TY_TESTS_SCREEN_MAKER_H

#include "checks.h"

#include <math.h>

/* Planar: color and out have three planes of width * height floats, distance (m) has one. */
typedef struct picture {
    int32_t width, height;
    float *color, *distance, *out;
} picture;

static inline int32_t pixel_count(const picture* p) {
    return p->width * p->height;
}

/* Black, everywhere `distance` away, and with an outcome that no method gives. */
static inline picture make_picture(int32_t width, int32_t height, double distance) {
    picture p = {.width = width, .height = height};
    const size_t pixels = (size_t)width * (size_t)height;
    p.color = calloc(3 * pixels, sizeof(float));
    p.distance = calloc(pixels, sizeof(float));
    p.out = calloc(3 * pixels, sizeof(float));
    assert_true(p.color != NULL && p.distance != NULL && p.out != NULL);
    for (size_t i = 0; i < pixels; ++i) p.distance[i] = (float)distance;
    for (size_t i = 0; i < 3 * pixels; ++i) p.out[i] = -1;
    return p;
}

static inline void free_picture(picture* p) {
    free(p->color);
    free(p->distance);
    free(p->out);
}

static inline void set_pixel(picture* p, int32_t x, int32_t y, double r, double g, double b) {
    const double color[3] = {r, g, b};
    for (int c = 0; c < 3; ++c) p->color[(c * p->height + y) * p->width + x] = (float)color[c];
}

static inline void fill_color(picture* p, double r, double g, double b) {
    for (int32_t i = 0; i < pixel_count(p); ++i) set_pixel(p, i % p->width, i / p->width, r, g, b);
}

/* Radiances from 0.01 to 100 and distances between two, both evenly spread on a log scale. */
static inline void fill_random(picture* p, double nearest, double farthest, uint64_t seed) {
    for (int32_t i = 0; i < 3 * pixel_count(p); ++i) p->color[i] = (float)pow(10, uniform_in(&seed, -2, 2));
    for (int32_t i = 0; i < pixel_count(p); ++i)
        p->distance[i] = (float)(nearest * pow(farthest / nearest, uniform(&seed)));
}

static inline ty_screen_planes planar(float* first, int32_t width, int32_t height) {
    const ptrdiff_t plane = (ptrdiff_t)width * height;
    return (ty_screen_planes){{first, first + plane, first + 2 * plane}, 1, width};
}

static inline ty_screen_image image_of(const picture* p) {
    ty_screen_image image = ty_default_screen_image();
    image.width = p->width;
    image.height = p->height;
    image.distance = p->distance;
    image.distance_row = p->width;
    image.color = planar(p->color, p->width, p->height);
    image.out = planar(p->out, p->width, p->height);
    return image;
}

static inline ty_screen_stats apply(ty_context* context, const ty_screen_def* def, const picture* p) {
    const ty_screen_image image = image_of(p);
    ty_screen_stats stats = ty_default_screen_stats();
    const ty_result result = ty_screen_apply(context, def, &image, NULL, 0, &stats);
    if (result != TY_OK) fail_msg("%s: %s", ty_result_name(result), ty_take_error(context));
    return stats;
}

static inline double sum_of(const float* values, int32_t count) {
    double sum = 0;
    for (int32_t i = 0; i < count; ++i) sum += (double)values[i];
    return sum;
}

static inline ty_screen_def gray_fog(double sigma_s, double sigma_a, double g, double focal) {
    ty_screen_def def = ty_default_screen_def();
    set3f(def.sigma_s, sigma_s, sigma_s, sigma_s);
    set3f(def.sigma_a, sigma_a, sigma_a, sigma_a);
    set3f(def.g, g, g, g);
    def.focal[0] = def.focal[1] = focal;
    return def;
}

/* Of Eq. 2, independently: the standard deviation, pixels, of light from `distance` m away. */
static inline double gaussian_spread(double sigma_s, double sigma_a, double g, double distance, double focal) {
    const double s = distance, reduced = sigma_s * (1 - g);
    return sqrt(0.5 / (2 * sigma_a / (3 * s) + 4 / (s * s * s * reduced))) / s * focal;
}

/* ---- variants ---- */

typedef enum variant {
    SMALL_ANGLE = 0,
    GAUSSIAN = 1,
    GATHER = 2,
    NAIVE = 3,
    PUBLISHED = 4,
    REFERENCE = 5,
    VARIANT_COUNT = 6
} variant;

static const char* const variant_names[VARIANT_COUNT] = {"small angle", "gaussian",  "gather",
                                                         "naive",       "published", "reference"};

static inline void set_variant(ty_screen_def* def, variant v) {
    if (v == GAUSSIAN) def->spread = TY_SCREEN_SPREAD_GAUSSIAN;
    if (v == GATHER) def->variant = TY_SCREEN_GATHER;
    if (v == NAIVE) ty_screen_naive_def(def);
    if (v == PUBLISHED) ty_screen_published_def(def);
    if (v == REFERENCE) def->variant = TY_SCREEN_REFERENCE;
}

#endif
