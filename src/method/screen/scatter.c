/* TY_SCREEN_SCATTER: light descends the pyramid as far as its width requires, and all of it is upsampled again.
 *
 * Level 0 is never stored: its rows are split on the fly; the light that stays goes to the image, the rest into
 * level 1. The image is read once and written twice, and the pyramid takes 8 bytes per pixel. */
#include "method/screen/job.h"

#include "base/context.h"
#include "method/screen/spread.h"

#include <math.h>

/* Rows of the next level per task. */
enum { BAND = 32, ROW_ALIGN = 16, TAPS_MAX = 6, PLANES = 6 };
/* Levels with fewer texels run in one thread: waking others takes longer. */
enum { TEXELS_FOR_THREADS = 1 << 15 };

typedef struct scatter {
    ty_screen_job* job;
    ty_screen_taps taps;
    ty_screen_level levels[TY_SCREEN_LEVELS_MAX + 1]; /* [0] has only a size */
    float variance[TY_SCREEN_LEVELS_MAX + 2];         /* represented by each level, pixels^2 */
    float limit[3];                                   /* largest measure of spread that the last level represents */
    int32_t level_limit;                              /* levels with allocated memory */
    int32_t level;                                    /* current level of the tasks */
    float* edges;                                     /* copies of the image rows around each band */
    float* rows;                                      /* worker_floats for each worker */
    ptrdiff_t row_stride, half_stride;
    ty_screen_counts* counts; /* one for each band */
    int32_t band_count;
    bool in_place;
} scatter;

/* Row stride of planes stored side by side: an odd multiple of ROW_ALIGN maps them to different cache sets. */
static ptrdiff_t aligned(ptrdiff_t floats) {
    return ((floats + ROW_ALIGN - 1) / ROW_ALIGN | 1) * ROW_ALIGN;
}

static int32_t halved(int32_t side) {
    return (side + 1) / 2;
}

static int32_t bands(int32_t rows) {
    return (rows + BAND - 1) / BAND;
}

/* ---- memory ---- */

static ptrdiff_t worker_floats(const scatter* s) {
    return PLANES * (TAPS_MAX * s->half_stride + s->row_stride);
}

static void allocate_areas(ty_screen_level* level, ty_arena* memory) {
    level->area[0] = ty_arena_take(memory, sizeof(float) * (size_t)level->width);
    level->area[1] = ty_arena_take(memory, sizeof(float) * (size_t)level->height);
}

static void lay_out(scatter* s, const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height,
                    ty_arena* memory) {
    s->level_limit = ty_screen_level_limit(def, width, height);
    s->taps = ty_screen_choose_taps(def->filter);
    s->levels[0] = (ty_screen_level){.width = width, .height = height};
    allocate_areas(&s->levels[0], memory);
    for (int32_t k = 1; k <= s->level_limit; ++k) {
        ty_screen_level* level = &s->levels[k];
        level->width = halved(s->levels[k - 1].width);
        level->height = halved(s->levels[k - 1].height);
        level->stride = aligned(level->width);
        allocate_areas(level, memory);
        for (int plane = 0; plane < PLANES; ++plane)
            level->plane[plane] = ty_arena_take(memory, sizeof(float) * (size_t)level->stride * (size_t)level->height);
    }
    s->row_stride = aligned(width);
    s->band_count = bands(s->levels[1].height);
    s->half_stride = aligned(halved(width));
    const size_t row = sizeof(float) * (size_t)s->row_stride;
    const int32_t margin = 2 * (s->taps.reach - 1);
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
    const int32_t margin = 2 * (s->taps.reach - 1);
    return s->edges + ((ptrdiff_t)(band * margin + index) * 3 + channel) * s->row_stride;
}

/* Image row of that copy; it may lie outside the image. */
static int32_t edge_y(const scatter* s, int32_t band, int32_t index) {
    const int32_t above = s->taps.reach - 1;
    return index < above ? 2 * BAND * band - above + index : 2 * BAND * (band + 1) + index - above;
}

/* When the image is overwritten in place, bands need the original rows of their neighbours. */
static void save_edges(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const scatter* s = user;
    const ty_screen_image* image = s->job->image;
    for (int32_t i = 0; i < 2 * (s->taps.reach - 1); ++i) {
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
    const int32_t first = 2 * BAND * band, above = s->taps.reach - 1;
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
    job->kernels->scatter(&job->params, &row, s->levels[0].down_fraction, s->limit, in_band ? target : NULL, out->step,
                          down, &s->counts[band]);
}

/* Computes rows of the next level from this one: Eq. 6 (Elek 2013), with fractions of each pixel's light for masks. */
static void descend(void* user, int64_t index, int32_t worker) {
    const scatter* s = user;
    const ty_screen_level *from = &s->levels[s->level], *to = &s->levels[s->level + 1];
    const int32_t band = (int32_t)index, begin = band * BAND, reach = s->taps.reach;
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
                s->job->kernels->downsample(&s->taps, down[plane], from->width, from->edges,
                                            worker_row(s, worker, done % TAPS_MAX, plane));
        }
        done = last;
        float weights[TAPS_MAX];
        ty_screen_down_weights(s->taps, from->area[1], from->height, y, weights);
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
    const ty_screen_level *level = &s->levels[s->level], *next = &s->levels[s->level + 1];
    const int32_t begin = (int32_t)index * BAND;
    const int32_t end = begin + BAND < level->height ? begin + BAND : level->height;
    for (int32_t y = begin; y < end; ++y)
        s->job->kernels->merge_up(&s->taps, level, next, y, worker_scratch(s, worker));
}

static void finish(void* user, int64_t index, int32_t worker) {
    const scatter* s = user;
    const ty_screen_image* image = s->job->image;
    const int32_t begin = (int32_t)index * 2 * BAND;
    const int32_t end = begin + 2 * BAND < image->height ? begin + 2 * BAND : image->height;
    for (int32_t y = begin; y < end; ++y)
        for (int c = 0; c < 3; ++c)
            s->job->kernels->add_upsampled(&s->taps, &s->levels[1], c, y, image->width,
                                           image->out.data[c] + y * image->out.row, image->out.step,
                                           worker_scratch(s, worker));
}

static void run(const scatter* s, int32_t level, int64_t count, ty_parallel_fn body) {
    const int64_t texels = (int64_t)s->levels[level].width * s->levels[level].height;
    if (texels >= TEXELS_FOR_THREADS)
        ty_screen_parallel(s->job, count, body, (void*)(uintptr_t)s);
    else
        ty_screen_serial(count, body, (void*)(uintptr_t)s);
}

/* ---- entry point ---- */

/* Small-angle spread: light is oversized if more than this fraction should pass beyond the last level, and there are
 * enough levels if less than the second fraction should. Tails are long, and coarse levels are nearly free. */
static const double oversized_fraction = 0.5, residual_fraction = 0.01;

/* The optical thickness at which light becomes oversized. */
static float thickness_limit(double width, double variance) {
    double low = 0, high = 1e6;
    for (int i = 0; i < 40; ++i) {
        const double center = i < 20 ? sqrt((low + 1e-6) * high) : 0.5 * (low + high);
        if (ty_screen_wider_fraction(width, center, variance) > oversized_fraction)
            high = center;
        else
            low = center;
    }
    return (float)low;
}

/* Half-light radius that a level represents, for the channel of least spread. */
static double max_radius(const scatter* s, int32_t level) {
    double min_radius = HUGE_VAL;
    for (int c = 0; c < 3; ++c) {
        const float variance = s->variance[level];
        const float measure = s->job->small_angle ? thickness_limit(s->job->width[c], (double)variance) : variance;
        min_radius = fmin(min_radius, ty_screen_radius(s->job, c, (double)measure));
    }
    return min_radius;
}

static void set_edges(ty_screen_taps taps, ty_screen_level* level) {
    const int32_t count = halved(level->width), begin = ty_screen_edge_begin(count);
    float* weights = level->edges;
    for (int32_t i = 0; i < count; i = i + 1 == begin ? ty_screen_edge_end(count) : i + 1) {
        ty_screen_down_weights(taps, level->area[0], level->width, i, weights);
        weights += TY_SCREEN_DOWN_WEIGHTS;
    }
}

/* Texels of the last row or column of a level may lie only partly in the image. */
static void set_areas(scatter* s) {
    for (int axis = 0; axis < 2; ++axis) {
        const int32_t pixels = axis == 0 ? s->levels[0].width : s->levels[0].height;
        for (int32_t i = 0; i < pixels; ++i) s->levels[0].area[axis][i] = 1;
        for (int32_t k = 1; k <= s->level_limit; ++k) {
            const int32_t fine = axis == 0 ? s->levels[k - 1].width : s->levels[k - 1].height;
            float weights[TAPS_MAX];
            for (int32_t i = 0; i < halved(fine); ++i)
                s->levels[k].area[axis][i] =
                    ty_screen_down_weights(s->taps, s->levels[k - 1].area[axis], fine, i, weights);
        }
    }
    for (int32_t k = 0; k < s->level_limit; ++k) set_edges(s->taps, &s->levels[k]);
}

static void set_levels(scatter* s) {
    const ty_screen_job* job = s->job;
    const float step = ty_screen_taps_variance(s->taps);
    s->variance[0] = 0;
    for (int32_t k = 0; k <= s->level_limit; ++k) s->variance[k + 1] = s->variance[k] + step * exp2f(2.0f * (float)k);
    for (int c = 0; c < 3; ++c) {
        ty_screen_down_fraction fractions[TY_SCREEN_LEVELS_MAX + 1];
        const bool same_as_previous = c > 0 && job->width[c] == job->width[c - 1];
        if (same_as_previous) {
            s->limit[c] = s->limit[c - 1];
        } else if (job->small_angle) {
            ty_screen_small_angle_fractions(job->width[c], s->variance, s->level_limit, fractions);
            s->limit[c] = thickness_limit(job->width[c], (double)s->variance[s->level_limit]);
        } else {
            ty_screen_gaussian_fractions(s->variance, s->level_limit, fractions);
            s->limit[c] = s->variance[s->level_limit];
        }
        for (int32_t k = 0; k < s->level_limit; ++k)
            s->levels[k].down_fraction[c] = same_as_previous ? s->levels[k].down_fraction[c - 1] : fractions[k];
    }
}

/* Number of levels required by the largest spread, or by the options. */
static int32_t choose_levels(const scatter* s) {
    if (s->job->def->levels > 0 || s->job->stats.oversized > 0) return s->level_limit;
    int32_t levels = 1;
    for (int32_t band = 0; band < s->band_count; ++band)
        for (int c = 0; c < 3; ++c) {
            const double measure = (double)s->counts[band].largest[c];
            while (levels < s->level_limit &&
                   (s->job->small_angle ? ty_screen_wider_fraction(s->job->width[c], measure,
                                                                   (double)s->variance[levels]) > residual_fraction
                                        : (double)s->variance[levels] < measure))
                ++levels;
        }
    return levels;
}

/* Memory traffic in bytes, counting each plane once per pass: image in and out, pyramid down and up. */
static double count_bytes(const scatter* s, int32_t levels) {
    const double pixels = (double)s->levels[0].width * s->levels[0].height;
    double floats = pixels * (4 + 3) + pixels * (3 + 3);
    for (int32_t k = 1; k <= levels; ++k) {
        const double texels = (double)s->levels[k].width * s->levels[k].height;
        floats += texels * PLANES; /* written while descending */
        if (k < levels)
            floats += texels * (PLANES + PLANES + 3); /* read while descending, read and written while ascending */
        floats += texels * 3;                         /* read by the level above */
    }
    return floats * sizeof(float);
}

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
    set_areas(&s);
    set_levels(&s);

    const double start = ty_wall_seconds();
    s.level = 0;
    if (s.in_place) run(&s, 0, s.band_count, save_edges);
    run(&s, 0, s.band_count, descend);
    ty_screen_sum_counts(job, s.counts, s.band_count);
    const double split = ty_wall_seconds();
    const int32_t levels = choose_levels(&s);
    for (s.level = 1; s.level < levels; ++s.level) run(&s, s.level, bands(s.levels[s.level + 1].height), descend);
    for (s.level = levels - 1; s.level >= 1; --s.level) run(&s, s.level, bands(s.levels[s.level].height), ascend);
    const double filtered = ty_wall_seconds();
    s.level = 0;
    run(&s, 0, bands(s.levels[1].height), finish);

    job->stats.step_seconds[0] = split - start;
    job->stats.step_seconds[1] = filtered - split;
    job->stats.step_seconds[2] = ty_wall_seconds() - filtered;
    job->stats.levels = levels;
    job->stats.max_spread = max_radius(&s, levels);
    job->stats.memory_bytes = count_bytes(&s, levels);
    return TY_OK;
}
