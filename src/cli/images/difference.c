/* Differences of images as JSON and as heat maps. */
#include "cli/images/difference.h"

#include <math.h>

const char* const cli_difference_names[4] = {"R", "G", "B", "all"};

void cli_difference_json(json_writer* json, const ty_difference* difference) {
    for (int i = 0; i < 4; ++i) {
        json_open_object(json, cli_difference_names[i]);
        json_number(json, "mean_ratio", difference->mean_ratio[i]);
        json_number(json, "rmse", difference->rmse[i]);
        json_number(json, "relative_rmse", difference->relative_rmse[i]);
        json_number(json, "rel_mse", difference->rel_mse[i]);
        json_close_object(json);
    }
    json_int(json, "differing", difference->differing);
    json_int(json, "not_finite", difference->not_finite);
}

static int32_t larger(int32_t a, int32_t b) {
    return a > b ? a : b;
}

static int32_t smaller(int32_t a, int32_t b) {
    return a < b ? a : b;
}

/* R + G + B of an image at a pixel of its frame. */
typedef struct brightness {
    const float* planes[3];
    int32_t x, y, width, height;
} brightness;

static bool find_brightness(const ty_image* image, brightness* out) {
    int32_t frame[4];
    ty_image_get_frame(image, frame);
    *out = (brightness){.x = frame[0], .y = frame[1], .width = ty_image_width(image), .height = ty_image_height(image)};
    return ty_image_rgb_planes(image, out->planes);
}

static double brightness_at(const brightness* b, int32_t x, int32_t y) {
    const int64_t i = (int64_t)(y - b->y) * b->width + (x - b->x);
    return (double)b->planes[0][i] + (double)b->planes[1][i] + (double)b->planes[2][i];
}

/* The mean of the finite values over the size of an image, from (x0, y0) on. */
static double mean_brightness(const brightness* b, int32_t x0, int32_t y0, const ty_image* size) {
    const double count = (double)ty_image_width(size) * (double)ty_image_height(size);
    double mean = 0;
    for (int32_t y = y0; y < y0 + ty_image_height(size); ++y)
        for (int32_t x = x0; x < x0 + ty_image_width(size); ++x) {
            const double value = brightness_at(b, x, y);
            if (isfinite(value)) mean += value / count;
        }
    return mean;
}

/* (x0, y0): the frame pixel of the map's first pixel. */
static void fill_heat_map(ty_image* map, const brightness* a, const brightness* b, int32_t x0, int32_t y0) {
    const int32_t width = ty_image_width(map), height = ty_image_height(map);
    const double mean = mean_brightness(b, x0, y0, map);
    float *red = ty_image_plane(map, 0), *green = ty_image_plane(map, 1), *blue = ty_image_plane(map, 2);
    for (int64_t i = 0; i < (int64_t)width * height; ++i) {
        const int32_t x = x0 + (int32_t)(i % width), y = y0 + (int32_t)(i / width);
        const double value = brightness_at(a, x, y), expected = brightness_at(b, x, y);
        const double relative = (value - expected) / fmax(fmax(expected, 0.1 * mean), 1e-30);
        if (!isfinite(relative)) {
            green[i] = 1;
            continue;
        }
        red[i] = (float)fmin(fmax(relative, 0), 1);
        blue[i] = (float)fmin(fmax(-relative, 0), 1);
    }
}

ty_result cli_write_heat_map(ty_context* context, const ty_image* a, const ty_image* b, const char* path) {
    brightness pa, pb;
    if (!find_brightness(a, &pa) || !find_brightness(b, &pb)) return TY_ERROR_ARGUMENT;
    const int32_t x0 = larger(pa.x, pb.x), x1 = smaller(pa.x + pa.width, pb.x + pb.width);
    const int32_t y0 = larger(pa.y, pb.y), y1 = smaller(pa.y + pa.height, pb.y + pb.height);
    ty_image* map = NULL;
    ty_result result = ty_image_create_rgb(context, x1 - x0, y1 - y0, &map);
    if (result == TY_OK) {
        fill_heat_map(map, &pa, &pb, x0, y0);
        result = ty_image_write_png(context, map, 0, TY_TONE_CLIP, path);
    }
    ty_image_destroy(map);
    return result;
}
