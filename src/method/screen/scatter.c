/* TY_SCREEN_SCATTER: light descends the pyramid as far as its width requires, and all of it is upsampled again.
 *
 * Level 0 is never stored: its rows are split on the fly; the light that stays goes to the image, the rest into
 * level 1. The image is read once and written twice, and the pyramid takes 8 bytes per pixel. */
#include "method/screen/pyramid.h"

#include "base/context.h"

/* Rows of the next level per task. */
enum { BAND = 32, ROW_ALIGN = 16, TAPS_MAX = 6, PLANES = TY_SCREEN_PLANES };
/* Levels with fewer texels run in one thread: waking others takes longer. */
enum { TEXELS_FOR_THREADS = 1 << 15 };

typedef struct scatter {
    ty_screen_job* job;
    ty_screen_pyramid pyramid;
    int32_t level; /* current level of the tasks */
    float* edges;  /* copies of the image rows around each band */
    float* rows;   /* worker_floats for each worker */
    ptrdiff_t row_stride, half_stride;
    ty_screen_counts* counts; /* one for each band */
    int32_t band_count;
    bool in_place;
} scatter;

/* Row stride of planes stored side by side: an odd multiple of ROW_ALIGN maps them to different cache sets. */
static ptrdiff_t aligned(ptrdiff_t floats) {
    return ((floats + ROW_ALIGN - 1) / ROW_ALIGN | 1) * ROW_ALIGN;
}

static int32_t bands(int32_t rows) {
    return (rows + BAND - 1) / BAND;
}

/* ---- memory ---- */

static ptrdiff_t worker_floats(const scatter* s) {
    return PLANES * (TAPS_MAX * s->half_stride + s->row_stride);
}

static void lay_out(scatter* s, const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height,
                    ty_arena* memory) {
    ty_screen_pyramid_lay_out(&s->pyramid, def, width, height, memory);
    for (int32_t k = 1; k <= s->pyramid.level_limit; ++k) {
        ty_screen_level* level = &s->pyramid.levels[k];
        level->stride = aligned(level->width);
        for (int plane = 0; plane < PLANES; ++plane)
            level->plane[plane] = ty_arena_take(memory, sizeof(float) * (size_t)level->stride * (size_t)level->height);
    }
    s->row_stride = aligned(width);
    s->band_count = bands(s->pyramid.levels[1].height);
    s->half_stride = aligned((width + 1) / 2);
    const size_t row = sizeof(float) * (size_t)s->row_stride;
    const int32_t margin = 2 * (s->pyramid.taps.reach - 1);
    s->edges = ty_arena_take(memory, row * 3 * (size_t)margin * (size_t)s->band_count);
    s->rows = ty_arena_take(memory, sizeof(float) * (size_t)worker_floats(s) * (size_t)ty_context_threads(context));
    s->counts = ty_arena_take(memory, sizeof *s->counts * (size_t)s->band_count);
}

size_t ty_screen_scatter_size(const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height) {
    scatter s;
    ty_arena memory = {0};
    lay_out(&s, context, def, width, height, &memory);
    return memory.used;
}

/* ---- level 0 ---- */

/* Copy of row `index` around a band (above first, then below), channel by channel. */
static float* edge_row(const scatter* s, int32_t band, int32_t index, int channel) {
    const int32_t margin = 2 * (s->pyramid.taps.reach - 1);
    return s->edges + ((ptrdiff_t)(band * margin + index) * 3 + channel) * s->row_stride;
}

/* Image row of that copy; it may lie outside the image. */
static int32_t edge_y(const scatter* s, int32_t band, int32_t index) {
    const int32_t above = s->pyramid.taps.reach - 1;
    return index < above ? 2 * BAND * band - above + index : 2 * BAND * (band + 1) + index - above;
}

/* When the image is overwritten in place, bands need the original rows of their neighbours. */
static void save_edges(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const scatter* s = user;
    const ty_screen_image* image = s->job->image;
    for (int32_t i = 0; i < 2 * (s->pyramid.taps.reach - 1); ++i) {
        const int32_t y = edge_y(s, (int32_t)index, i);
        if (y < 0 || y >= image->height) continue;
        const ty_screen_row row = ty_screen_image_row(s->job->image, y);
        for (int c = 0; c < 3; ++c) {
            float* copy = edge_row(s, (int32_t)index, i, c);
            for (int32_t x = 0; x < image->width; ++x) copy[x] = row.color[c][x * row.color_step];
        }
    }
}

static ty_screen_row band_row(const scatter* s, int32_t band, int32_t y) {
    ty_screen_row row = ty_screen_image_row(s->job->image, y);
    const int32_t first = 2 * BAND * band, above = s->pyramid.taps.reach - 1;
    if (!s->in_place || (y >= first && y < first + 2 * BAND)) return row;
    const int32_t index = y < first ? y - first + above : y - first - 2 * BAND + above;
    for (int c = 0; c < 3; ++c) row.color[c] = edge_row(s, band, index, c);
    row.color_step = 1;
    return row;
}

/* ---- descending and ascending ---- */

/* Rows of a worker: the last downsampled rows, plane by plane, and one row of light passed on from the current level.
 */
static float* worker_row(const scatter* s, int32_t worker, int32_t slot, int plane) {
    return s->rows + (ptrdiff_t)worker * worker_floats(s) + (ptrdiff_t)(slot * PLANES + plane) * s->half_stride;
}

static float* worker_down(const scatter* s, int32_t worker, int plane) {
    return worker_row(s, worker, TAPS_MAX, 0) + plane * s->row_stride;
}

static float* worker_scratch(const scatter* s, int32_t worker) {
    return worker_down(s, worker, 0);
}

/* Computes the light passed on from row y of level 0; writes the light that stays if the band owns the row. */
static void scatter_row(const scatter* s, int32_t band, int32_t y, float* const down[6]) {
    const ty_screen_job* job = s->job;
    const ty_screen_planes* out = &job->image->out;
    const ty_screen_row row = band_row(s, band, y);
    float* target[3];
    for (int c = 0; c < 3; ++c) target[c] = out->data[c] + y * out->row;
    const bool in_band = y >= 2 * BAND * band && y < 2 * BAND * (band + 1);
    job->kernels->scatter(&job->params, &row, s->pyramid.levels[0].down_fraction, s->pyramid.limit,
                          in_band ? target : NULL, out->step, down, &s->counts[band]);
}

/* Computes rows of the next level from this one: Eq. 6 (Elek 2013), with fractions of each pixel's light for masks. */
static void descend(void* user, int64_t index, int32_t worker) {
    const scatter* s = user;
    const ty_screen_level *from = &s->pyramid.levels[s->level], *to = &s->pyramid.levels[s->level + 1];
    const int32_t band = (int32_t)index, begin = band * BAND, reach = s->pyramid.taps.reach;
    const int32_t end = begin + BAND < to->height ? begin + BAND : to->height;
    if (s->level == 0) s->counts[band] = (ty_screen_counts){0};
    float* down[PLANES];
    for (int plane = 0; plane < PLANES; ++plane) down[plane] = worker_down(s, worker, plane);
    int32_t done = 2 * begin - reach; /* last downsampled row */
    for (int32_t y = begin; y < end; ++y) {
        const int32_t last = 2 * y + reach;
        for (++done; done <= last; ++done) {
            if (done < 0 || done >= from->height) continue;
            if (s->level == 0)
                scatter_row(s, band, done, down);
            else
                s->job->kernels->split_level(from, done, down);
            for (int plane = 0; plane < PLANES; ++plane)
                s->job->kernels->downsample(&s->pyramid.taps, down[plane], from->width, from->edges,
                                            worker_row(s, worker, done % TAPS_MAX, plane));
        }
        done = last;
        float weights[TAPS_MAX];
        ty_screen_down_weights(s->pyramid.taps, from->area[1], from->height, y, weights);
        for (int plane = 0; plane < PLANES; ++plane) {
            const float* rows[TAPS_MAX];
            for (int32_t tap = 0; tap < TAPS_MAX; ++tap) {
                const int32_t row = weights[tap] > 0 ? 2 * y - 2 + tap : 2 * y;
                rows[tap] = worker_row(s, worker, row % TAPS_MAX, plane);
            }
            s->job->kernels->combine_rows(weights, rows, to->width, to->plane[plane] + y * to->stride);
        }
    }
}

static void ascend(void* user, int64_t index, int32_t worker) {
    const scatter* s = user;
    const ty_screen_level *level = &s->pyramid.levels[s->level], *next = &s->pyramid.levels[s->level + 1];
    const int32_t begin = (int32_t)index * BAND;
    const int32_t end = begin + BAND < level->height ? begin + BAND : level->height;
    for (int32_t y = begin; y < end; ++y)
        s->job->kernels->merge_up(&s->pyramid.taps, level, next, y, worker_scratch(s, worker));
}

static void finish(void* user, int64_t index, int32_t worker) {
    const scatter* s = user;
    const ty_screen_image* image = s->job->image;
    const int32_t begin = (int32_t)index * 2 * BAND;
    const int32_t end = begin + 2 * BAND < image->height ? begin + 2 * BAND : image->height;
    for (int32_t y = begin; y < end; ++y)
        for (int c = 0; c < 3; ++c)
            s->job->kernels->add_upsampled(&s->pyramid.taps, &s->pyramid.levels[1], c, y, image->width,
                                           image->out.data[c] + y * image->out.row, image->out.step,
                                           worker_scratch(s, worker));
}

static void run(const scatter* s, int32_t level, int64_t count, ty_parallel_fn body) {
    const int64_t texels = (int64_t)s->pyramid.levels[level].width * s->pyramid.levels[level].height;
    if (texels >= TEXELS_FOR_THREADS)
        ty_screen_parallel(s->job, count, body, (void*)(uintptr_t)s);
    else
        ty_screen_serial(count, body, (void*)(uintptr_t)s);
}

/* ---- entry point ---- */

static bool overlap(const ty_screen_image* image) {
    for (int c = 0; c < 3; ++c)
        for (int d = 0; d < 3; ++d)
            if (image->out.data[c] == image->color.data[d]) return true;
    return false;
}

ty_result ty_screen_scatter(ty_screen_job* job) {
    scatter s;
    ty_arena memory = {.base = job->memory};
    lay_out(&s, job->context, job->def, job->image->width, job->image->height, &memory);
    s.job = job;
    s.in_place = overlap(job->image);
    ty_screen_pyramid_set(&s.pyramid, job);

    const double start = ty_wall_seconds();
    s.level = 0;
    if (s.in_place) run(&s, 0, s.band_count, save_edges);
    run(&s, 0, s.band_count, descend);
    ty_screen_sum_counts(job, s.counts, s.band_count);
    const double split = ty_wall_seconds();
    const int32_t levels = ty_screen_pyramid_levels(&s.pyramid, job, s.counts, s.band_count);
    for (s.level = 1; s.level < levels; ++s.level)
        run(&s, s.level, bands(s.pyramid.levels[s.level + 1].height), descend);
    for (s.level = levels - 1; s.level >= 1; --s.level)
        run(&s, s.level, bands(s.pyramid.levels[s.level].height), ascend);
    const double filtered = ty_wall_seconds();
    s.level = 0;
    run(&s, 0, bands(s.pyramid.levels[1].height), finish);

    job->stats.step_seconds[0] = split - start;
    job->stats.step_seconds[1] = filtered - split;
    job->stats.step_seconds[2] = ty_wall_seconds() - filtered;
    job->stats.levels = levels;
    job->stats.max_spread = ty_screen_pyramid_radius(&s.pyramid, job, levels);
    job->stats.memory_bytes = ty_screen_pyramid_bytes(&s.pyramid, levels);
    return TY_OK;
}
