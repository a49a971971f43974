/* TY_SCREEN_GATHER: the method of Elek 2013. The levels of its pyramid are masked against light from near pixels; each
 * pixel does one lookup, at the level of its own distance. */
#include "method/screen/job.h"

#include "base/context.h"

#include <math.h>

/* Rows of the next level per task, and image rows per composition task. */
enum { BAND = 32, TAPS_MAX = 6, ROW_ALIGN = 16 };

typedef struct gather {
    ty_screen_job* job;
    ty_screen_gather_params params;
    ty_screen_taps taps[2]; /* G' and, of the same size, U */
    ty_screen_texels levels[TY_SCREEN_LEVELS_MAX + 1];
    float* spread[TY_SCREEN_LEVELS_MAX + 1]; /* W, pixels */
    int32_t level_limit, level;
    float* rows; /* worker_floats for each worker */
    ptrdiff_t row_stride, half_stride;
    ty_screen_counts* counts; /* one for each band */
    float limit;              /* variance of the last level */
} gather;

static int32_t bands(int32_t rows) {
    return (rows + BAND - 1) / BAND;
}

static ptrdiff_t aligned(ptrdiff_t floats) {
    return (floats + ROW_ALIGN - 1) / ROW_ALIGN * ROW_ALIGN;
}

static ptrdiff_t worker_floats(const gather* g) {
    return TY_GATHER_ROWS * ((TAPS_MAX + 1) * g->half_stride + g->row_stride);
}

static void lay_out(gather* g, const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height,
                    ty_arena* memory) {
    g->level_limit = ty_screen_level_limit(def, width, height);
    for (int32_t k = 0; k <= g->level_limit; ++k) {
        g->levels[k].width = k == 0 ? width : (g->levels[k - 1].width + 1) / 2;
        g->levels[k].height = k == 0 ? height : (g->levels[k - 1].height + 1) / 2;
        const size_t texels = (size_t)g->levels[k].width * (size_t)g->levels[k].height;
        g->levels[k].texels = ty_arena_take(memory, 4 * sizeof(float) * texels);
        g->spread[k] = ty_arena_take(memory, sizeof(float) * texels);
    }
    g->row_stride = aligned(width);
    g->half_stride = aligned((width + 1) / 2);
    g->rows = ty_arena_take(memory, sizeof(float) * (size_t)worker_floats(g) * (size_t)ty_context_threads(context));
    g->counts = ty_arena_take(memory, sizeof *g->counts * (size_t)bands(height));
}

size_t ty_screen_gather_size(const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height) {
    gather g;
    ty_arena memory = {0};
    lay_out(&g, context, def, width, height, &memory);
    return memory.used;
}

/* ---- Eq. 3-5 (Elek 2013) ---- */

static void split_rows(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const gather* g = user;
    const ty_screen_job* job = g->job;
    const int32_t width = job->image->width, begin = (int32_t)index * BAND;
    const int32_t end = begin + BAND < job->image->height ? begin + BAND : job->image->height;
    const float limit[3] = {g->limit, g->limit, g->limit};
    ty_screen_counts counts = {0};
    for (int32_t y = begin; y < end; ++y) {
        const ty_screen_row row = ty_screen_image_row(job->image, y);
        float* out[3];
        for (int c = 0; c < 3; ++c) out[c] = job->image->out.data[c] + y * job->image->out.row;
        job->kernels->gather_split(&job->params, &g->params, &row, limit, out, job->image->out.step,
                                   g->levels[0].texels + (ptrdiff_t)y * 4 * width, g->spread[0] + (ptrdiff_t)y * width,
                                   &counts);
    }
    g->counts[index] = counts;
}

/* ---- Eq. 6-9 (Elek 2013) ---- */

/* Rows of a worker: the last downsampled rows by kind, one row of the next level, and one of this level. */
static float* worker_row(const gather* g, int32_t worker, int32_t slot, int32_t kind) {
    return g->rows + (ptrdiff_t)worker * worker_floats(g) + (ptrdiff_t)(slot * TY_GATHER_ROWS + kind) * g->half_stride;
}

static float* wide_row(const gather* g, int32_t worker, int32_t kind) {
    return worker_row(g, worker, TAPS_MAX + 1, 0) + kind * g->row_stride;
}

static int32_t kind_count(const gather* g) {
    return g->params.mask.kind == TY_SCREEN_MASK_NONE ? TY_GATHER_MASK : TY_GATHER_ROWS;
}

static const ty_screen_taps* taps_of(const gather* g, int32_t kind) {
    return &g->taps[kind >= TY_GATHER_WEIGHT];
}

static void downsample_row(const gather* g, int32_t worker, int32_t y) {
    const ty_screen_texels* from = &g->levels[g->level];
    float* rows[TY_GATHER_ROWS];
    for (int32_t kind = 0; kind < TY_GATHER_ROWS; ++kind) rows[kind] = wide_row(g, worker, kind);
    const ptrdiff_t first = (ptrdiff_t)y * from->width;
    g->job->kernels->gather_rows(&g->params, from->texels + 4 * first, g->spread[g->level] + first, from->width, rows);
    for (int32_t kind = 0; kind < kind_count(g); ++kind)
        g->job->kernels->downsample(taps_of(g, kind), rows[kind], from->width, NULL,
                                    worker_row(g, worker, y % TAPS_MAX, kind));
}

static void join_rows(const gather* g, int32_t worker, int32_t y) {
    const ty_screen_texels *from = &g->levels[g->level], *to = &g->levels[g->level + 1];
    const float* joined[TY_GATHER_ROWS];
    for (int32_t kind = 0; kind < kind_count(g); ++kind) {
        const float* down = taps_of(g, kind)->down;
        const float weights[TAPS_MAX] = {down[2], down[1], down[0], down[0], down[1], down[2]};
        const float* rows[TAPS_MAX];
        for (int32_t tap = 0; tap < TAPS_MAX; ++tap) {
            const int32_t row = weights[tap] > 0 ? ty_screen_clamp_index(2 * y - 2 + tap, from->height) : 2 * y;
            rows[tap] = worker_row(g, worker, row % TAPS_MAX, kind);
        }
        float* out = worker_row(g, worker, TAPS_MAX, kind);
        g->job->kernels->combine_rows(weights, rows, to->width, out);
        joined[kind] = out;
    }
    const ptrdiff_t first = (ptrdiff_t)y * to->width;
    g->job->kernels->gather_store(&g->params, joined, to->width, to->texels + 4 * first,
                                  g->spread[g->level + 1] + first);
}

static void descend(void* user, int64_t index, int32_t worker) {
    const gather* g = user;
    const ty_screen_texels *from = &g->levels[g->level], *to = &g->levels[g->level + 1];
    const int32_t begin = (int32_t)index * BAND, reach = g->taps[0].reach;
    const int32_t end = begin + BAND < to->height ? begin + BAND : to->height;
    int32_t next = 2 * begin + 1 - reach;
    for (int32_t y = begin; y < end; ++y) {
        for (; next <= 2 * y + reach; ++next)
            if (next >= 0 && next < from->height) downsample_row(g, worker, next);
        join_rows(g, worker, y);
    }
}

/* ---- Eq. 10-12 (Elek 2013) ---- */

static void compose(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const gather* g = user;
    const ty_screen_planes* image = &g->job->image->out;
    const int32_t begin = (int32_t)index * BAND;
    const int32_t end = begin + BAND < g->levels[0].height ? begin + BAND : g->levels[0].height;
    for (int32_t y = begin; y < end; ++y) {
        float* out[3];
        for (int c = 0; c < 3; ++c) out[c] = image->data[c] + y * image->row;
        g->job->kernels->gather_add(&g->job->params, &g->params, g->levels, y, out, image->step);
    }
}

/* ---- entry point ---- */

/* W at a level, pixels: inverse of Eq. 10 (Elek 2013). */
static float spread_of(const gather* g, int32_t level) {
    return g->params.level_scale * exp2f((float)level);
}

/* The distance beyond which only the last level is read, or of maximum spread: larger distances, above all of skies,
 * must not dominate blurred distances. */
static float max_distance(const gather* g) {
    const double slope = (double)g->job->params.mean_slope, curvature = (double)g->job->params.mean_curvature;
    const double variance = (double)g->limit, discriminant = slope * slope - 4 * variance * variance * curvature;
    if (slope <= 0) return TY_SCREEN_DISTANCE_MAX;
    if (discriminant < 0) return (float)(1 / sqrt(curvature));
    return (float)(2 * variance / (slope + sqrt(discriminant)));
}

static void prepare(gather* g, ty_screen_job* job) {
    const ty_screen_def* def = job->def;
    g->job = job;
    g->taps[0] = ty_screen_choose_taps(def->filter);
    g->taps[1] = g->taps[0];
    for (int32_t i = 0; i < g->taps[1].reach; ++i) g->taps[1].down[i] = 0.5f / (float)g->taps[1].reach;
    g->params = (ty_screen_gather_params){.mask = {.kind = (int32_t)def->mask, .width = def->mask_width},
                                          .luminance_weights = def->luminance_weights,
                                          .normalise = def->normalise,
                                          .blurred_distance = def->blurred_distance,
                                          .level_scale = def->level_scale};
    g->limit = spread_of(g, g->level_limit) * spread_of(g, g->level_limit);
    g->params.max_distance = max_distance(g);
}

/* Memory traffic in bytes, counting each plane once per pass: image and level 0, the pyramid, and the lookups. */
static double count_bytes(const gather* g, int32_t levels) {
    const double pixels = (double)g->levels[0].width * g->levels[0].height;
    double floats = pixels * (4 + 3 + 5) + pixels * (3 + 3 + 4);
    for (int32_t k = 1; k <= levels; ++k) {
        const double texels = (double)g->levels[k].width * g->levels[k].height;
        floats += 4 * 5 * texels + 5 * texels + 4 * texels; /* read from the finer level, written, looked up */
    }
    return floats * sizeof(float);
}

static int32_t choose_levels(const gather* g) {
    const bool all = g->job->def->levels > 0;
    float widest = 0; /* standard deviation, pixels */
    for (int32_t band = 0; band < bands(g->levels[0].height); ++band)
        for (int c = 0; c < 3; ++c) widest = fmaxf(widest, sqrtf(g->counts[band].largest[c]));
    int32_t levels = 1;
    while (levels < g->level_limit && (all || spread_of(g, levels) < widest)) ++levels;
    return levels;
}

ty_result ty_screen_gather(ty_screen_job* job) {
    gather g;
    ty_arena memory = {.base = job->memory};
    lay_out(&g, job->context, job->def, job->image->width, job->image->height, &memory);
    prepare(&g, job);

    const double start = ty_wall_seconds();
    ty_screen_parallel(job, bands(job->image->height), split_rows, &g);
    ty_screen_sum_counts(job, g.counts, bands(job->image->height));
    const int32_t levels = choose_levels(&g);
    const double attenuated = ty_wall_seconds();
    for (g.level = 0; g.level < levels; ++g.level) {
        g.params.mask.threshold = spread_of(&g, g.level);
        ty_screen_parallel(job, bands(g.levels[g.level + 1].height), descend, &g);
    }
    g.params.level_count = levels + 1;
    const double filtered = ty_wall_seconds();
    ty_screen_parallel(job, bands(job->image->height), compose, &g);

    job->stats.step_seconds[0] = attenuated - start;
    job->stats.step_seconds[1] = filtered - attenuated;
    job->stats.step_seconds[2] = ty_wall_seconds() - filtered;
    job->stats.levels = levels;
    job->stats.max_spread = ty_screen_radius(job, 0, (double)(spread_of(&g, levels) * spread_of(&g, levels)));
    job->stats.memory_bytes = count_bytes(&g, levels);
    return TY_OK;
}
