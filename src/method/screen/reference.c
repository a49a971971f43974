/* TY_SCREEN_REFERENCE: the light of every pixel, spread by its own Gaussian per channel over all others, by brute
 * force. It is the exact result of the model; remaining errors are those of the model. */
#include "method/screen/job.h"

#include "base/context.h"
#include "base/progress.h"

#include <math.h>
#include <string.h>

/* Pixels per task, and tile size of the sources, whose maximum spread is known. */
enum { SEGMENT = 64, SEGMENT_ROWS = 8, TILE = 32 };

typedef struct reference {
    ty_screen_job* job;
    ty_screen_sources sources;
    float* reach; /* of each tile, pixels */
    float* rows;  /* three for each worker */
    int32_t tiles[2], segments[2];
    int64_t first;            /* first of the current batch of tasks */
    ty_screen_counts* counts; /* of each row of tiles */
} reference;

static int32_t ceiling(int32_t a, int32_t b) {
    return (a + b - 1) / b;
}

static void lay_out(reference* r, const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height,
                    ty_arena* memory) {
    const size_t plane = sizeof(float) * (size_t)width * (size_t)height;
    r->tiles[0] = ceiling(width, TILE);
    r->tiles[1] = ceiling(height, TILE);
    r->segments[0] = ceiling(width, SEGMENT);
    r->segments[1] = ceiling(height, SEGMENT_ROWS);
    r->sources.width = width;
    r->sources.height = height;
    r->sources.before = def->window > 0 ? def->window / 2 : TY_SCREEN_SIDE_MAX;
    r->sources.after = def->window > 0 ? (def->window - 1) / 2 : TY_SCREEN_SIDE_MAX;
    for (int c = 0; c < 3; ++c) {
        r->sources.light[c] = ty_arena_take(memory, plane);
        r->sources.sharpness[c] = ty_arena_take(memory, plane);
    }
    r->reach = ty_arena_take(memory, sizeof(float) * (size_t)r->tiles[0] * (size_t)r->tiles[1]);
    r->counts = ty_arena_take(memory, sizeof *r->counts * (size_t)r->tiles[1]);
    r->rows = ty_arena_take(memory, 3 * sizeof(float) * (size_t)width * (size_t)ty_context_threads(context));
}

size_t ty_screen_reference_size(const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height) {
    reference r;
    ty_arena memory = {0};
    lay_out(&r, context, def, width, height, &memory);
    return memory.used;
}

/* Computes the sources of a row of tiles, and writes the attenuated light to the image. */
static void prepare(void* user, int64_t index, int32_t worker) {
    reference* r = user;
    const ty_screen_job* job = r->job;
    const int32_t width = job->image->width, begin = (int32_t)index * TILE;
    const int32_t end = begin + TILE < job->image->height ? begin + TILE : job->image->height;
    float* reach = r->reach + index * r->tiles[0];
    for (int32_t t = 0; t < r->tiles[0]; ++t) reach[t] = 0;
    ty_screen_counts counts = {0};
    for (int32_t y = begin; y < end; ++y) {
        ty_screen_split_out out = {0};
        for (int c = 0; c < 3; ++c) {
            out.attenuated[c] = r->rows + (ptrdiff_t)(3 * worker + c) * width;
            out.scattered[c] = r->sources.light[c] + (ptrdiff_t)y * width;
            out.measure[c] = r->sources.sharpness[c] + (ptrdiff_t)y * width;
        }
        const ty_screen_row row = ty_screen_image_row(job->image, y);
        job->kernels->split(&job->params, &row, ty_screen_no_limit, &out, &counts);
        for (int c = 0; c < 3; ++c)
            for (int32_t x = 0; x < width; ++x) {
                reach[x / TILE] = fmaxf(reach[x / TILE], TY_SCREEN_REACH * sqrtf(out.measure[c][x]) + 1);
                job->image->out.data[c][y * job->image->out.row + x * job->image->out.step] = out.attenuated[c][x];
            }
        job->kernels->reference_prepare(&r->sources, y);
    }
    r->counts[index] = counts;
}

/* Pixels between the ranges [a, a + length_a) and [b, b + length_b), at least 0. */
static int32_t gap(int32_t a, int32_t length_a, int32_t b, int32_t length_b) {
    const int32_t after = b - (a + length_a - 1), before = a - (b + length_b - 1);
    const int32_t distance = after > before ? after : before;
    return distance > 0 ? distance : 0;
}

static void sum_segment(const reference* r, int32_t x, int32_t y, int32_t count, float* sums) {
    memset(sums, 0, 3 * sizeof(float) * (size_t)count);
    for (int32_t ty = 0; ty < r->tiles[1]; ++ty)
        for (int32_t tx = 0; tx < r->tiles[0]; ++tx) {
            int32_t from[2] = {tx * TILE, ty * TILE}, to[2] = {from[0] + TILE, from[1] + TILE};
            const float reach = r->reach[(ptrdiff_t)ty * r->tiles[0] + tx];
            if ((float)gap(x, count, from[0], TILE) > reach || (float)gap(y, 1, from[1], TILE) > reach) continue;
            if (to[0] > r->sources.width) to[0] = r->sources.width;
            if (to[1] > r->sources.height) to[1] = r->sources.height;
            if (from[1] < y - r->sources.after) from[1] = y - r->sources.after;
            if (to[1] > y + r->sources.before + 1) to[1] = y + r->sources.before + 1;
            r->job->kernels->reference_add(&r->sources, from, to, x, y, count, sums);
        }
}

/* Adds the scattered light to a few rows of pixels. */
static void compose(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const reference* r = user;
    const ty_screen_job* job = r->job;
    const ty_screen_image* image = job->image;
    const int64_t segment = r->first + index;
    const int32_t x0 = (int32_t)(segment % r->segments[0]) * SEGMENT;
    const int32_t y0 = (int32_t)(segment / r->segments[0]) * SEGMENT_ROWS;
    const int32_t count = x0 + SEGMENT < image->width ? SEGMENT : image->width - x0;
    float sums[3 * SEGMENT], coverage[SEGMENT];
    for (int32_t y = y0; y < y0 + SEGMENT_ROWS && y < image->height; ++y) {
        sum_segment(r, x0, y, count, sums);
        for (int c = 0; c < 3; ++c) {
            job->kernels->reference_coverage(&r->sources, c, x0, y, count, coverage);
            for (int32_t i = 0; i < count; ++i)
                image->out.data[c][y * image->out.row + (x0 + i) * image->out.step] +=
                    sums[c * count + i] / coverage[i];
        }
    }
}

/* Calls the progress function of the def; false: cancelled. */
static bool report(const reference* r, double start, int64_t done, int64_t total) {
    const ty_screen_def* def = r->job->def;
    if (def->progress == NULL) return true;
    const ty_progress progress = ty_progress_at("screen", (double)done / (double)total, ty_wall_seconds() - start);
    return def->progress(def->progress_user, &progress);
}

ty_result ty_screen_reference(ty_screen_job* job) {
    reference r = {.job = job};
    ty_arena memory = {.base = job->memory};
    lay_out(&r, job->context, job->def, job->image->width, job->image->height, &memory);
    const double start = ty_wall_seconds();
    ty_screen_parallel(job, r.tiles[1], prepare, &r);
    const double prepared = ty_wall_seconds();
    const int64_t total = (int64_t)r.segments[0] * r.segments[1], batch = 4 * (int64_t)ty_context_threads(job->context);
    for (r.first = 0; r.first < total; r.first += batch) {
        if (!report(&r, prepared, r.first, total)) return TY_CANCELLED;
        ty_screen_parallel(job, total - r.first < batch ? total - r.first : batch, compose, &r);
    }
    report(&r, prepared, total, total);
    job->stats.step_seconds[0] = prepared - start;
    job->stats.step_seconds[1] = ty_wall_seconds() - prepared;
    ty_screen_sum_counts(job, r.counts, r.tiles[1]);
    return TY_OK;
}
