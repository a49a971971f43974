/* Shared by tests of the path tracer against closed forms: scenes in few words, rays on faces, means with errors. */
#ifndef TY_TESTS_TRUTH_H
#define TY_TESTS_TRUTH_H

#include "base/quadrature.h"
#include "effort.h"
#include "files.h"

#include <tyndall/tyndall.h>

#include <math.h>

static const double pi = 3.14159265358979323846;

/* ---- contexts and scenes ---- */

static inline ty_context* truth_context(int32_t threads) {
    ty_context_def def = ty_default_context_def();
    def.threads = threads;
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&def, &context), TY_OK);
    return context;
}

static inline int truth_start(void** state) {
    *state = truth_context(TY_AUTO);
    return 0;
}

static inline int truth_stop(void** state) {
    ty_context_destroy(*state);
    return 0;
}

static inline void must(ty_context* context, ty_result result) {
    if (result != TY_OK) fail_msg("%s: %s", ty_result_name(result), ty_take_error(context));
}

static inline void set3(double out[3], double x, double y, double z) {
    out[0] = x;
    out[1] = y;
    out[2] = z;
}

static inline void rgb(float out[3], double r, double g, double b) {
    out[0] = (float)r;
    out[1] = (float)g;
    out[2] = (float)b;
}

static inline void gray(float out[3], double value) {
    rgb(out, value, value, value);
}

static inline ty_medium_def medium_of(double sigma_s, double sigma_a, double g) {
    ty_medium_def def = ty_default_medium_def();
    gray(def.sigma_s, sigma_s);
    gray(def.sigma_a, sigma_a);
    gray(def.g, g);
    return def;
}

/* A cube about the origin. */
static inline ty_medium_def medium_cube(double half, double sigma_s, double sigma_a, double g) {
    ty_medium_def def = medium_of(sigma_s, sigma_a, g);
    def.bounds = TY_BOUNDS_BOX;
    set3(def.box_min, -half, -half, -half);
    set3(def.box_max, half, half, half);
    return def;
}

static inline ty_medium_def medium_sphere(double radius, double sigma_s, double sigma_a, double g) {
    ty_medium_def def = medium_of(sigma_s, sigma_a, g);
    def.bounds = TY_BOUNDS_SPHERE;
    def.sphere_radius = radius;
    return def;
}

static inline ty_light_def light_of(ty_light_kind kind, double color) {
    ty_light_def def = ty_default_light_def();
    def.kind = kind;
    gray(def.color, color);
    return def;
}

static inline ty_shape_def sphere_shape(double x, double y, double z, double radius, double albedo, double emission) {
    ty_shape_def def = ty_default_shape_def();
    def.kind = TY_SHAPE_SPHERE;
    set3(def.origin, x, y, z);
    def.radius = radius;
    gray(def.albedo, albedo);
    gray(def.emission, emission);
    return def;
}

/* A square of half side `half` about `center` with unit edges along u and v; its front is the side u x v points to. */
static inline ty_shape_def square_shape(const double center[3], const double u[3], const double v[3], double half,
                                        double albedo) {
    ty_shape_def def = ty_default_shape_def();
    for (int a = 0; a < 3; ++a) {
        def.origin[a] = center[a] - half * (u[a] + v[a]);
        def.u[a] = 2 * half * u[a];
        def.v[a] = 2 * half * v[a];
    }
    gray(def.albedo, albedo);
    return def;
}

static inline ty_scene* new_scene(ty_context* context) {
    ty_scene* scene = NULL;
    must(context, ty_scene_create(context, TY_AXIS_Y, &scene));
    return scene;
}

static inline void add_medium(ty_scene* scene, const ty_medium_def* def) {
    must(ty_scene_context(scene), ty_scene_add_medium(scene, def));
}

static inline void add_light(ty_scene* scene, const ty_light_def* def) {
    must(ty_scene_context(scene), ty_scene_add_light(scene, def));
}

static inline void add_shape(ty_scene* scene, const ty_shape_def* def) {
    must(ty_scene_context(scene), ty_scene_add_shape(scene, def));
}

static inline void set_camera(ty_scene* scene, double x, double y, double z, double fov_y) {
    ty_camera_def def = ty_default_camera_def();
    set3(def.position, x, y, z);
    def.fov_y = fov_y;
    must(ty_scene_context(scene), ty_scene_set_camera(scene, &def));
}

static inline void commit(ty_scene* scene) {
    must(ty_scene_context(scene), ty_scene_commit(scene));
}

/* A square of side `side` m that shines at the origin from 1 m away, in a cube of fog of half side `half`. */
static inline ty_scene* emitter_in_fog(ty_context* context, double side, double half, double thickness, double g) {
    static const double center[3] = {0, 0, -1}, x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
    ty_scene* scene = new_scene(context);
    const ty_medium_def fog = medium_cube(half, thickness, 0, g);
    ty_shape_def emitter = square_shape(center, x, y, side / 2, 0);
    gray(emitter.emission, 1);
    add_medium(scene, &fog);
    add_shape(scene, &emitter);
    commit(scene);
    return scene;
}

static inline ty_image* render(const ty_scene* scene, int32_t side, int32_t spp, uint64_t seed) {
    ty_path_def def = ty_default_path_def();
    def.spp = spp;
    def.seed = seed;
    def.width = def.height = side;
    ty_image* image = NULL;
    must(ty_scene_context(scene), ty_path_render(scene, &def, &image, NULL));
    return image;
}

static inline double* new_numbers(int64_t count) {
    double* numbers = calloc((size_t)count, sizeof *numbers);
    assert_non_null(numbers);
    return numbers;
}

/* Radiance seen along rays of an origin and a direction of view, and its variance where wanted. */
static inline void radiance_along(const ty_scene* scene, int64_t count, const double* views, int32_t spp,
                                  int32_t max_depth, double* radiance, double* variance) {
    ty_path_def def = ty_default_path_def();
    def.spp = spp;
    def.max_depth = max_depth;
    double* rays = new_numbers(6 * count);
    for (int64_t i = 0; i < 6 * count; ++i) rays[i] = i % 6 < 3 ? views[i] : 0 - views[i];
    must(ty_scene_context(scene), ty_path_radiance(scene, &def, rays, count, radiance, variance));
    free(rays);
}

/* ---- rays ---- */

static inline void cross3(const double a[3], const double b[3], double out[3]) {
    set3(out, a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

static inline double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void normalize3(double v[3]) {
    const double length = sqrt(dot3(v, v));
    for (int a = 0; a < 3; ++a) v[a] /= length;
}

/* The n-th point of a sequence that fills the unit cube evenly in four dimensions (Roberts 2018). */
static inline void even_point(int64_t n, double out[4]) {
    static const double root = 1.1673039782614186842; /* of x^5 = x + 1 */
    double step = 1;
    for (int d = 0; d < 4; ++d) {
        step /= root;
        const double x = 0.5 + (double)(n + 1) * step;
        out[d] = x - floor(x);
    }
}

/* The n-th of rays that leave a face for the inside of a body: from all over the parallelogram (corner, u, v), moved
 * outwards by `lift`, directions cosine-distributed about u x v. The face's exitance is pi times their mean radiance.
 */
static inline void face_ray(int64_t n, const double corner[3], const double u[3], const double v[3], double lift,
                            double ray[6]) {
    double x[4], normal[3], s[3], t[3];
    even_point(n, x);
    cross3(u, v, normal);
    normalize3(normal);
    for (int a = 0; a < 3; ++a) s[a] = u[a];
    normalize3(s);
    cross3(normal, s, t);
    const double radius = sqrt(x[2]), turn = 2 * pi * x[3], height = sqrt(1 - x[2]);
    for (int a = 0; a < 3; ++a) {
        ray[3 + a] = radius * cos(turn) * s[a] + radius * sin(turn) * t[a] + height * normal[a];
        ray[a] = corner[a] + x[0] * u[a] + x[1] * v[a] - lift * ray[3 + a];
    }
}

/* ---- means and what they must be ---- */

typedef struct estimate {
    double mean, error; /* error: standard error of the mean */
} estimate;

/* Of values[0], values[stride], ... of evenly chosen items; the error comes from the spread of 64 runs of neighbours,
 * each of which is as evenly chosen. count is a multiple of 64. */
static inline estimate estimate_of(const double* values, int64_t count, int stride) {
    enum { RUNS = 64 };
    double runs[RUNS] = {0}, mean = 0, square = 0;
    assert_int_equal(count % RUNS, 0);
    for (int64_t i = 0; i < count; ++i) runs[i / (count / RUNS)] += values[stride * i] * RUNS / (double)count;
    for (int i = 0; i < RUNS; ++i) mean += runs[i] / RUNS;
    for (int i = 0; i < RUNS; ++i) square += (runs[i] - mean) * (runs[i] - mean);
    return (estimate){mean, sqrt(square / (RUNS * (RUNS - 1)))};
}

/* Prints the figure, and fails unless it is within tolerance (relative) of what is expected and its own error is well
 * below that. */
static inline void assert_close(const char* name, estimate measured, double expected, double tolerance) {
    const double off = measured.mean / expected - 1;
    printf("%-44s %11.6g +- %.1e, expected %11.6g: %+.3f%% of %.2f%%\n", name, measured.mean, measured.error, expected,
           100 * off, 100 * tolerance);
    if (!(fabs(off) <= tolerance)) fail_msg("%s: %.8g, not %.8g", name, measured.mean, expected);
    if (!(measured.error <= 0.4 * tolerance * expected)) fail_msg("%s: too noisy to tell", name);
}

/* ---- images ---- */

/* The mean of a channel over the image, and its standard error by the image's own variance. */
static inline estimate image_mean(const ty_image* image, int channel) {
    const int64_t count = (int64_t)ty_image_width(image) * ty_image_height(image);
    const float* values = ty_image_plane_const(image, channel);
    const float* variance = ty_image_plane_const(image, channel + 3);
    double sum = 0, square = 0;
    for (int64_t i = 0; i < count; ++i) {
        sum += (double)values[i];
        square += (double)variance[i];
    }
    return (estimate){sum / (double)count, sqrt(square) / (double)count};
}

static inline void assert_finite(const ty_image* image) {
    const int64_t count = (int64_t)ty_image_width(image) * ty_image_height(image);
    for (int channel = 0; channel < ty_image_channel_count(image); ++channel)
        for (int64_t i = 0; i < count; ++i) {
            const float value = ty_image_plane_const(image, channel)[i];
            if (!isfinite(value) || value < 0) fail_msg("channel %d, pixel %d: %g", channel, (int)i, (double)value);
        }
}

enum { BLOCK_SIDE = 8 };

/* The mean of a channel over a block, and its standard error. */
static inline estimate block_mean(const ty_image* image, int channel, int32_t left, int32_t top) {
    const int32_t width = ty_image_width(image);
    double sum = 0, variance = 0;
    for (int32_t y = top; y < top + BLOCK_SIDE; ++y)
        for (int32_t x = left; x < left + BLOCK_SIDE; ++x) {
            sum += (double)ty_image_plane_const(image, channel)[y * width + x];
            variance += (double)ty_image_plane_const(image, channel + 3)[y * width + x];
        }
    const double pixels = BLOCK_SIDE * BLOCK_SIDE;
    return (estimate){sum / pixels, sqrt(variance) / pixels};
}

/* Two channels show the same picture: their means agree to tolerance, and blocks of pixels differ as their variances
 * say they should. */
static inline void assert_same_channel(const char* name, const ty_image* a, int channel_a, const ty_image* b,
                                       int channel_b, double tolerance) {
    const estimate mean_a = image_mean(a, channel_a), mean_b = image_mean(b, channel_b);
    double worst = 0, square = 0, blocks = 0;
    for (int32_t y = 0; y + BLOCK_SIDE <= ty_image_height(a); y += BLOCK_SIDE)
        for (int32_t x = 0; x + BLOCK_SIDE <= ty_image_width(a); x += BLOCK_SIDE) {
            const estimate block_a = block_mean(a, channel_a, x, y), block_b = block_mean(b, channel_b, x, y);
            const double z = (block_a.mean - block_b.mean) /
                             (hypot(block_a.error, block_b.error) + 1e-5 * (block_a.mean + mean_a.mean));
            worst = fmax(worst, fabs(z));
            square += z * z;
            blocks += 1;
        }
    const double ratio = mean_a.mean / mean_b.mean;
    const double error = hypot(mean_a.error / mean_a.mean, mean_b.error / mean_b.mean);
    printf("%-36s %c: mean ratio %.5f +- %.5f of %.3f; blocks: mean z^2 %.2f, worst |z| %.2f\n", name, "RGB"[channel_a],
           ratio, error, tolerance, square / blocks, worst);
    if (!(fabs(ratio - 1) <= tolerance)) fail_msg("%s: the means' ratio is %g", name, ratio);
    if (!(error <= tolerance / 2)) fail_msg("%s: too noisy to tell", name);
    if (!(square <= blocks * (1 + 4 * sqrt(2 / blocks)) && worst < 5))
        fail_msg("%s: blocks differ by more than their noise", name);
}

static inline double henyey_greenstein(double mu, double g) {
    return (1 - g * g) / (4 * pi * pow(1 + g * g - 2 * g * mu, 1.5));
}

#endif
