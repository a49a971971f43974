#include "io/interchange/environment_map.h"

#include "base/constants.h"
#include "base/context.h"
#include "io/interchange/solids.h"

#include <math.h>
#include <string.h>

/* The place in the unit square of a unit direction (Clarberg 2008, with the arc tangent itself). */
static void square_from_sphere(const double d[3], double uv[2]) {
    const double x = fabs(d[0]), y = fabs(d[1]), r = sqrt(fmax(0, 1 - fabs(d[2])));
    const double phi = x == 0 && y == 0 ? 0 : atan2(y, x) * 2 / TY_PI_F64;
    double v = phi * r, u = r - v;
    if (d[2] < 0) {
        const double swapped = u;
        u = 1 - v;
        v = 1 - swapped;
    }
    uv[0] = 0.5 * (copysign(u, d[0]) + 1);
    uv[1] = 0.5 * (copysign(v, d[1]) + 1);
}

/* The place in the unit square of an equirectangular map whose left edge is along -z, with +x at a quarter. */
static void square_from_angles(const double d[3], double uv[2]) {
    const double turn = atan2(d[0], -d[2]) / (2 * TY_PI_F64);
    uv[0] = turn < 0 ? turn + 1 : turn;
    uv[1] = acos(fmin(fmax(d[1], -1), 1)) / TY_PI_F64;
}

typedef struct map_task {
    ty_map_kind kind;
    const float* from[3];
    float* to[3];
    int32_t size[2], width, height, samples; /* size: of the image that is read */
    ty_affine light_from_world;
} map_task;

/* One row: each pixel is the mean over samples x samples of its directions, whose texels are the nearest. */
static void convert_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const map_task* task = user;
    const int32_t n = task->samples;
    for (int32_t column = 0; column < task->width; ++column) {
        double sum[3] = {0, 0, 0};
        for (int32_t s = 0; s < n * n; ++s) {
            const double u = (column + (s % n + 0.5) / n) / task->width;
            const double v = ((double)row + (s / n + 0.5) / n) / task->height;
            const double phi = 2 * TY_PI_F64 * (u - 0.5), sine = sin(TY_PI_F64 * v);
            const double world[3] = {sine * cos(phi), cos(TY_PI_F64 * v), sine * sin(phi)};
            double d[3], uv[2], length = 0;
            ty_affine_direction(&task->light_from_world, world, d);
            for (int a = 0; a < 3; ++a) length += d[a] * d[a];
            for (int a = 0; a < 3; ++a) d[a] /= sqrt(length);
            if (task->kind == TY_MAP_OCTAHEDRAL)
                square_from_sphere(d, uv);
            else
                square_from_angles(d, uv);
            const int32_t x = (int32_t)fmin(fmax(uv[0] * task->size[0], 0), task->size[0] - 1);
            const int32_t y = (int32_t)fmin(fmax(uv[1] * task->size[1], 0), task->size[1] - 1);
            for (int c = 0; c < 3; ++c) sum[c] += (double)task->from[c][(size_t)y * (size_t)task->size[0] + (size_t)x];
        }
        for (int c = 0; c < 3; ++c)
            task->to[c][(size_t)row * (size_t)task->width + (size_t)column] = (float)fmax(0, sum[c] / (n * n));
    }
}

/* The illuminance by the upper hemisphere of light space that pbrt divides by: the sum over texels times 2 pi / their
 * number, which is half of the integral over that hemisphere, as a texel has 4 pi / their number. */
static double measure_illuminance(const float* const planes[3], int32_t side) {
    double sum = 0;
    for (int32_t y = 0; y < side; ++y)
        for (int32_t x = 0; x < side; ++x) {
            const double u = fabs(2 * (x + 0.5) / side - 1), v = fabs(2 * (y + 0.5) / side - 1), r = u + v;
            if (r >= 1) continue;
            const size_t at = (size_t)y * (size_t)side + (size_t)x;
            sum += (1 - r * r) *
                   (0.2126 * (double)planes[0][at] + 0.7152 * (double)planes[1][at] + 0.0722 * (double)planes[2][at]);
        }
    return sum * 2 * TY_PI_F64 / ((double)side * side);
}

ty_result ty_convert_map(ty_context* context, const ty_image* image, ty_map_kind kind, const ty_affine* light,
                         double* illuminance, ty_image** out) {
    enum { WIDTH_MIN = 16, WIDTH_MAX = 8192 };
    map_task task = {.kind = kind, .size = {ty_image_width(image), ty_image_height(image)}};
    if (!ty_image_rgb_planes(image, task.from) || (kind == TY_MAP_OCTAHEDRAL && task.size[0] != task.size[1]))
        return ty_fail(context, TY_ERROR_INPUT,
                       "the map of a light at infinity is not a colour image of the right shape");
    if (!ty_affine_invert(light, &task.light_from_world))
        return ty_fail(context, TY_ERROR_INPUT, "the transform of a light at infinity cannot be inverted");
    const int32_t wanted = kind == TY_MAP_OCTAHEDRAL ? 2 * task.size[0] : task.size[0] + task.size[0] % 2;
    task.width = wanted < WIDTH_MIN ? WIDTH_MIN : wanted > WIDTH_MAX ? WIDTH_MAX : wanted;
    task.height = task.width / 2;
    task.samples = 2 * ((wanted + task.width - 1) / task.width);
    const ty_result result = ty_image_create_rgb(context, task.width, task.height, out);
    if (result != TY_OK) return result;
    for (int32_t c = 0; c < 3; ++c) task.to[c] = ty_image_plane(*out, c);
    if (illuminance != NULL) *illuminance = measure_illuminance(task.from, task.size[0]);
    ty_parallel_for(context, task.height, convert_row, &task);
    return TY_OK;
}
