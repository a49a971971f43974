/* Entry points, and the work common to all variants. */
#include "method/screen/device/device.h"

#include "base/context.h"
#include "base/parallel.h"
#include "method/screen/spread.h"

#include <math.h>
#include <stdatomic.h>

static bool has_medium(const ty_screen_def* def) {
    for (int c = 0; c < 3; ++c)
        if (def->sigma_s[c] > 0 || def->sigma_a[c] > 0) return true;
    return false;
}

static float bounded(double value) {
    return (float)(value < 1e20 ? value : 1e20);
}

/* Eq. 2 (Elek 2013) squared, times (focal / D)^2: slope D / (1 + curvature D^2). */
static void set_spread(double sigma_s, double sigma_a, double g, double focal, float* slope, float* curvature) {
    const double reduced = sigma_s * (1 - g);
    *slope = bounded(focal * focal * reduced / 8);
    *curvature = bounded(sigma_a * reduced / 6);
}

static void make_params(ty_screen_job* job) {
    const ty_screen_def* def = job->def;
    const int32_t width = job->image->width, height = job->image->height;
    const bool centered = def->center[0] == -1 && def->center[1] == -1; /* crops of a frame may have it outside */
    ty_screen_params params = {.width = width,
                               .height = height,
                               .planar = def->distance_kind == TY_SCREEN_DISTANCE_AXIS,
                               .center_x = (float)(centered ? 0.5 * width : def->center[0]),
                               .center_y = (float)(centered ? 0.5 * height : def->center[1]),
                               .inverse_focal_x = (float)(1 / def->focal[0]),
                               .inverse_focal_y = (float)(1 / def->focal[1]),
                               .unknown = def->missing_depth};
    const double focal = sqrt(def->focal[0] * def->focal[1]);
    double mean_s = 0, mean_a = 0, mean_reduced = 0;
    for (int c = 0; c < 3; ++c) {
        const double sigma_s = (double)def->sigma_s[c], sigma_a = (double)def->sigma_a[c], g = (double)def->g[c];
        params.sigma_s[c] = def->sigma_s[c];
        params.sigma_a[c] = def->sigma_a[c];
        params.forward[c] = def->forward[c];
        const double sigma_t = sigma_s + sigma_a;
        params.airlight[c] = sigma_t > 0 ? (float)((double)def->environment[c] * sigma_s / sigma_t) : 0.0f;
        job->width[c] = focal * ty_screen_angle(g);
        params.angle[c] = (float)job->width[c];
        if (job->small_angle)
            params.slope[c] = def->sigma_s[c];
        else
            set_spread(sigma_s, sigma_a, g, focal, &params.slope[c], &params.curvature[c]);
        mean_s += sigma_s / 3;
        mean_a += sigma_a / 3;
        mean_reduced += sigma_s * (1 - g) / 3;
    }
    const double mean_g = mean_s > 0 ? 1 - mean_reduced / mean_s : 0;
    set_spread(mean_s, mean_a, mean_g, focal, &params.mean_slope, &params.mean_curvature);
    job->params = params;
}

ty_screen_row ty_screen_image_row(const ty_screen_image* image, int32_t y) {
    ty_screen_row row = {.color_step = image->color.step,
                         .distance = image->distance + y * image->distance_row,
                         .distance_step = image->distance_step,
                         .y = y};
    for (int c = 0; c < 3; ++c) row.color[c] = image->color.data[c] + y * image->color.row;
    return row;
}

const float ty_screen_no_limit[3] = {TY_FLOAT_MAX, TY_FLOAT_MAX, TY_FLOAT_MAX};

double ty_screen_radius(const ty_screen_job* job, int channel, double measure) {
    if (measure <= 0) return 0;
    return job->small_angle ? ty_screen_half_radius(job->width[channel], measure) : sqrt(2 * log(2.0) * measure);
}

void ty_screen_sum_counts(ty_screen_job* job, const ty_screen_counts* counts, int32_t band_count) {
    ty_screen_stats* stats = &job->stats;
    for (int32_t band = 0; band < band_count; ++band) {
        stats->nonfinite_fixed += counts[band].nonfinite_fixed;
        stats->missing_depth += counts[band].missing_depth;
        stats->oversized += counts[band].oversized;
        for (int c = 0; c < 3; ++c)
            stats->spread = fmax(stats->spread, ty_screen_radius(job, c, (double)counts[band].largest[c]));
    }
}

int32_t ty_screen_level_limit(const ty_screen_def* def, int32_t width, int32_t height) {
    const bool gaussian = def->variant != TY_SCREEN_SCATTER || def->spread == TY_SCREEN_SPREAD_GAUSSIAN;
    const int32_t max_levels = gaussian && def->levels == TY_AUTO ? TY_SCREEN_LEVELS_DEFAULT : TY_SCREEN_LEVELS_MAX;
    const int32_t limit = def->levels > 0 ? def->levels : max_levels;
    int32_t possible = 1;
    while (possible < limit && (width > 2 || height > 2)) {
        width = (width + 1) / 2;
        height = (height + 1) / 2;
        ++possible;
    }
    return possible;
}

void ty_screen_parallel(ty_screen_job* job, int64_t count, ty_parallel_fn body, void* user) {
    ty_parallel_flushed(job->context, count, body, user);
}

void ty_screen_serial(int64_t count, ty_parallel_fn body, void* user) {
    ty_parallel_flushed(NULL, count, body, user);
}

/* ---- row operations without a filter ---- */

enum { ROWS_PER_TASK = 32 };

static int64_t task_count(const ty_screen_image* image) {
    return (image->height + ROWS_PER_TASK - 1) / ROWS_PER_TASK;
}

typedef struct copy_work {
    const ty_screen_image* image;
    _Atomic int64_t nonfinite_fixed, missing_depth;
} copy_work;

/* Without a medium: copies the image, sanitised. */
static void copy_rows(void* user, int64_t index, int32_t worker) {
    (void)worker;
    copy_work* work = user;
    const ty_screen_image* image = work->image;
    int64_t nonfinite_fixed = 0, missing_depth = 0;
    for (int64_t y = index * ROWS_PER_TASK; y < (index + 1) * ROWS_PER_TASK && y < image->height; ++y) {
        for (int64_t x = 0; x < image->width; ++x) {
            int32_t changed = 0;
            float radiance[3]; /* read before any write: out may be the same planes in another order */
            for (int c = 0; c < 3; ++c)
                radiance[c] = ty_screen_sanitize(image->color.data[c][y * image->color.row + x * image->color.step],
                                                 TY_FLOAT_MAX, &changed);
            for (int c = 0; c < 3; ++c) image->out.data[c][y * image->out.row + x * image->out.step] = radiance[c];
            const float distance = image->distance[y * image->distance_row + x * image->distance_step];
            nonfinite_fixed += changed;
            missing_depth += distance > 0 && distance < TY_FLOAT_MAX ? 0 : 1;
        }
    }
    work->nonfinite_fixed += nonfinite_fixed;
    work->missing_depth += missing_depth;
}

static ty_result copy_image(ty_screen_job* job) {
    copy_work work = {.image = job->image};
    const double start = ty_wall_seconds();
    ty_parallel_for(job->context, task_count(job->image), copy_rows, &work);
    job->stats.step_seconds[0] = ty_wall_seconds() - start;
    job->stats.nonfinite_fixed = work.nonfinite_fixed;
    job->stats.missing_depth = work.missing_depth;
    job->stats.memory_bytes = (double)job->image->width * job->image->height * (4 + 3) * sizeof(float);
    return TY_OK;
}

enum { SPLIT_ROWS = 9 }; /* attenuated, scattered, measure of spread */

typedef struct split_work {
    const ty_screen_job* job;
    float* const* targets[3]; /* attenuated, scattered, spread */
    float* rows;              /* SPLIT_ROWS rows for each worker */
} split_work;

static void store_row(const ty_screen_image* image, int32_t y, const float* from, float* plane) {
    for (int64_t x = 0; plane != NULL && x < image->width; ++x)
        plane[y * image->out.row + x * image->out.step] = from[x];
}

static void split_rows(void* user, int64_t index, int32_t worker) {
    const split_work* work = user;
    const ty_screen_job* job = work->job;
    const int32_t width = job->image->width, begin = (int32_t)index * ROWS_PER_TASK;
    const int32_t end = begin + ROWS_PER_TASK < job->image->height ? begin + ROWS_PER_TASK : job->image->height;
    float* rows = work->rows + (ptrdiff_t)worker * SPLIT_ROWS * width;
    ty_screen_split_out out = {0};
    for (int c = 0; c < 3; ++c) {
        out.attenuated[c] = rows + (ptrdiff_t)c * width;
        out.scattered[c] = rows + (ptrdiff_t)(3 + c) * width;
        out.measure[c] = rows + (ptrdiff_t)(6 + c) * width;
    }
    for (int32_t y = begin; y < end; ++y) {
        const ty_screen_row row = ty_screen_image_row(job->image, y);
        ty_screen_counts counts = {0};
        job->kernels->split(&job->params, &row, ty_screen_no_limit, &out, &counts);
        for (int c = 0; c < 3; ++c)
            for (int32_t x = 0; x < width; ++x)
                out.measure[c][x] = (float)ty_screen_radius(job, c, (double)out.measure[c][x]);
        for (int kind = 0; kind < 3; ++kind)
            for (int c = 0; c < 3 && work->targets[kind] != NULL; ++c)
                store_row(job->image, y, rows + (ptrdiff_t)(3 * kind + c) * width, work->targets[kind][c]);
    }
}

/* ---- entry points ---- */

static size_t workspace(const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height) {
    if (!has_medium(def)) return 64;
    switch (def->variant) {
    case TY_SCREEN_SCATTER: return ty_screen_scatter_size(context, def, width, height);
    case TY_SCREEN_GATHER: return ty_screen_gather_size(context, def, width, height);
    case TY_SCREEN_REFERENCE: return ty_screen_reference_size(context, def, width, height);
    }
    return 0;
}

size_t ty_screen_workspace(const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height) {
    const bool size = width >= 1 && height >= 1 && width <= TY_SCREEN_SIDE_MAX && height <= TY_SCREEN_SIDE_MAX;
    ty_screen_def known = ty_default_screen_def();
    const bool usable = context != NULL && size &&
                        ty_take_def(NULL, def, "ty_default_screen_def", &known, sizeof known) == TY_OK &&
                        ty_screen_has_filter(&known) && ty_screen_has_levels(&known);
    return usable ? workspace(context, &known, width, height) : 0;
}

static ty_result scatter(ty_screen_job* job) {
    ty_device* device = NULL;
    const ty_result result = ty_context_device(job->context, &device);
    if (result != TY_OK) return result;
    return device != NULL ? ty_screen_scatter_on_device(job, device) : ty_screen_scatter(job);
}

static ty_result run(ty_screen_job* job) {
    if (!has_medium(job->def)) return copy_image(job);
    switch (job->def->variant) {
    case TY_SCREEN_SCATTER: return scatter(job);
    case TY_SCREEN_GATHER: return ty_screen_gather(job);
    case TY_SCREEN_REFERENCE: return ty_screen_reference(job);
    }
    return TY_ERROR_ARGUMENT;
}

/* A caller's structures, in the library's own size. */
typedef struct known_input {
    ty_screen_def def;
    ty_screen_image image;
} known_input;

static ty_result start(ty_screen_job* job, const ty_screen_def* def, const ty_screen_image* image, bool out,
                       known_input* known) {
    ty_result result = ty_screen_take_def(job->context, def, &known->def);
    if (result == TY_OK) result = ty_screen_take_image(job->context, image, &known->image, out);
    if (result != TY_OK) return result;
    job->def = &known->def;
    job->image = &known->image;
    job->kernels = TY_BEST_KERNELS(ty_screen_kernels);
    job->stats.isa = ty_isa_name(ty_best_isa());
    job->small_angle = job->def->variant == TY_SCREEN_SCATTER && job->def->spread == TY_SCREEN_SPREAD_SMALL_ANGLE;
    make_params(job);
    return TY_OK;
}

ty_result ty_screen_apply(ty_context* context, const ty_screen_def* def, const ty_screen_image* image, void* memory,
                          size_t memory_size, ty_screen_stats* stats) {
    if (context == NULL) return TY_ERROR_ARGUMENT;
    const double began = ty_wall_seconds();
    known_input known;
    ty_screen_job job = {.context = context, .memory = memory};
    ty_result result = ty_take_stats(context, stats, "ty_default_screen_stats", &job.stats, sizeof job.stats);
    if (result == TY_OK) result = start(&job, def, image, true, &known);
    if (result != TY_OK) return result;
    const size_t needed = workspace(context, job.def, job.image->width, job.image->height);
    if (memory != NULL && (memory_size < needed || (uintptr_t)memory % 64 != 0))
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "screen: the workspace has %zu bytes, %zu are needed, aligned to 64 bytes", memory_size, needed);
    if (memory == NULL) job.memory = ty_alloc_array(context, needed, 1, false);
    if (job.memory == NULL) return TY_ERROR_MEMORY;
    result = run(&job);
    if (memory == NULL) ty_free_array(context, job.memory, needed, 1);
    job.stats.seconds = ty_wall_seconds() - began;
    ty_give_stats(&job.stats, sizeof job.stats, stats);
    return result;
}

ty_result ty_screen_split(ty_context* context, const ty_screen_def* def, const ty_screen_image* image,
                          float* const attenuated[3], float* const scattered[3], float* const spread[3]) {
    if (context == NULL) return TY_ERROR_ARGUMENT;
    known_input known;
    ty_screen_job job = {.context = context};
    const ty_result result = start(&job, def, image, false, &known);
    if (result != TY_OK) return result;
    if (job.image->out.step == 0) return ty_fail(context, TY_ERROR_ARGUMENT, "screen image: out.step is 0");
    const size_t floats = (size_t)ty_context_threads(context) * SPLIT_ROWS * (size_t)job.image->width;
    split_work work = {.job = &job, .targets = {attenuated, scattered, spread}};
    work.rows = ty_alloc_array(context, floats, sizeof(float), false);
    if (work.rows == NULL) return TY_ERROR_MEMORY;
    ty_screen_parallel(&job, task_count(job.image), split_rows, &work);
    ty_free_array(context, work.rows, floats, sizeof(float));
    return TY_OK;
}
