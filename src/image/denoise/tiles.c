/* Tiles of the image on all threads. */
#include "base/parallel.h"
#include "image/denoise/job.h"

#include <string.h>

typedef struct tile_loop {
    ty_denoise_job* job;
    ty_denoise_tile_fn body;
    int32_t columns;        /* tiles of a pass along x */
    int32_t step, first[2]; /* tiles from one of a pass to the next, and its first along x and y */
} tile_loop;

static int32_t smaller(int32_t a, int32_t b) {
    return a < b ? a : b;
}

static void run_tile(void* user, int64_t index, int32_t worker) {
    const tile_loop* loop = user;
    ty_denoise_job* job = loop->job;
    ty_denoise_tile* tile = &job->tiles[worker];
    const int32_t column = loop->first[0] + (int32_t)(index % loop->columns) * loop->step,
                  row = loop->first[1] + (int32_t)(index / loop->columns) * loop->step;
    const int32_t x = column * TY_DENOISE_TILE, y = row * TY_DENOISE_TILE;
    tile->width = smaller(job->width - x, TY_DENOISE_TILE);
    tile->height = smaller(job->height - y, TY_DENOISE_TILE);
    tile->softening = job->light.softening;
    loop->body(job, tile, x, y);
}

void ty_denoise_tiles(ty_denoise_job* job, bool in_passes, ty_denoise_tile_fn body) {
    const int32_t columns = (job->width + TY_DENOISE_TILE - 1) / TY_DENOISE_TILE,
                  rows = (job->height + TY_DENOISE_TILE - 1) / TY_DENOISE_TILE;
    const int32_t step = in_passes ? 2 : 1;
    for (int32_t pass = 0; pass < step * step; ++pass) {
        tile_loop loop = {.job = job, .body = body, .step = step, .first = {pass % step, pass / step}};
        loop.columns = (columns - loop.first[0] + step - 1) / step;
        const int32_t count = (rows - loop.first[1] + step - 1) / step;
        ty_parallel_flushed(job->context, (int64_t)loop.columns * count, run_tile, &loop);
    }
}

void ty_denoise_load(const ty_denoise_job* job, const float* plane, int32_t x, int32_t y, float* out) {
    for (int32_t row = 0; row < TY_DENOISE_ROWS; ++row) {
        const int32_t from = y + row - TY_DENOISE_MARGIN;
        const float* in = plane + (size_t)(from < 0 ? 0 : smaller(from, job->height - 1)) * (size_t)job->width;
        for (int32_t i = 0; i < TY_DENOISE_PITCH; ++i) {
            const int32_t at = x + i - TY_DENOISE_MARGIN;
            out[row * TY_DENOISE_PITCH + i] = in[at < 0 ? 0 : smaller(at, job->width - 1)];
        }
    }
}

void ty_denoise_load_charts(const ty_denoise_job* job, int32_t x, int32_t y, ty_denoise_tile* tile) {
    for (int32_t row = 0; row < TY_DENOISE_ROWS; ++row)
        for (int32_t i = 0; i < TY_DENOISE_PITCH; ++i) {
            const int32_t px = x + i - TY_DENOISE_MARGIN, py = y + row - TY_DENOISE_MARGIN;
            const bool inside = px >= 0 && px < job->width && py >= 0 && py < job->height;
            float chart = inside ? 0.0f : -1.0f;
            if (inside && job->def.charts != NULL)
                chart = (float)job->def.charts[(size_t)py * (size_t)job->width + (size_t)px];
            tile->chart[row * TY_DENOISE_PITCH + i] = chart;
        }
}

/* Noise whose variance is below that of softening, times this, may stay. */
static const float negligible = 1e-2f;

bool ty_denoise_is_noisy(const ty_denoise_tile* tile) {
    bool noisy = false;
    for (int32_t i = 0; i < TY_DENOISE_PLANE && !noisy; ++i) noisy = tile->variance[i] > negligible * tile->softening;
    return noisy;
}

/* ---- predictions ---- */

/* Adds a tile's sums to those of the image. */
static void add_sums(ty_denoise_job* job, const ty_denoise_tile* tile, int32_t x, int32_t y) {
    const int32_t x0 = x - TY_DENOISE_BEFORE, y0 = y - TY_DENOISE_BEFORE;
    const int32_t first = x0 < 0 ? -x0 : 0, last = smaller(TY_DENOISE_REACH, job->width - x0);
    for (int h = 0; h < 2; ++h)
        for (int k = 0; k < TY_DENOISE_CANDIDATES; ++k)
            for (int c = 0; c < 4; ++c)
                for (int32_t row = y0 < 0 ? -y0 : 0; row < smaller(TY_DENOISE_REACH, job->height - y0); ++row) {
                    const float* from = tile->sums[h][k][c] + row * TY_DENOISE_REACH;
                    float* to = job->light.sums[h][k][c] + (size_t)(y0 + row) * (size_t)job->width;
                    for (int32_t i = first; i < last; ++i) to[x0 + i] += from[i];
                }
}

static void predict_tile(ty_denoise_job* job, ty_denoise_tile* tile, int32_t x, int32_t y) {
    const ty_denoise_light* light = &job->light;
    ty_denoise_load(job, light->variance, x, y, tile->variance);
    if (!ty_denoise_is_noisy(tile)) return;
    for (int c = 0; c < 3; ++c)
        for (int h = 0; h < 2; ++h) ty_denoise_load(job, light->color[h][c], x, y, tile->color[h][c]);
    for (int32_t f = 0; f < job->feature_count; ++f) ty_denoise_load(job, job->features[f], x, y, tile->feature[f]);
    ty_denoise_load_charts(job, x, y, tile);
    memset(tile->sums, 0, sizeof tile->sums);
    for (int32_t h = 0; h < 2; ++h) {
        job->kernels->distances(tile, 1 - h);
        job->kernels->regress(tile, h, job->feature_count, job->ridge);
    }
    add_sums(job, tile, x, y);
}

void ty_denoise_predict(ty_denoise_job* job) {
    for (int h = 0; h < 2; ++h)
        for (int k = 0; k < TY_DENOISE_CANDIDATES; ++k)
            for (int c = 0; c < 4; ++c) memset(job->light.sums[h][k][c], 0, job->pixels * sizeof(float));
    ty_denoise_tiles(job, true, predict_tile);
}
