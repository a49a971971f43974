/* Light of texels that got none of their own: within walls, or not sampled yet. */
#include "base/context.h"
#include "bake/atlas.h"

#include <math.h>

typedef struct mender {
    const ty_atlas* atlas;
    const bool* valid;
    bool* queued;          /* per receiver */
    int32_t *wave, *after; /* receivers that have good neighbours, and those that will have */
    int32_t* all;          /* room for both */
} mender;

/* The receiver at a neighbouring texel, if it is on the same chart; -1: none is. */
static int32_t neighbour_of(const ty_atlas* atlas, int32_t receiver, int32_t dx, int32_t dy) {
    const int32_t texel = atlas->texels[receiver];
    const int32_t x = texel % atlas->width + dx, y = texel / atlas->width + dy;
    if (x < 0 || x >= atlas->width || y < 0 || y >= atlas->height) return -1;
    const int32_t other = atlas->receiver[(size_t)y * (size_t)atlas->width + (size_t)x];
    return other >= 0 && atlas->charts[other] == atlas->charts[receiver] ? other : -1;
}

static const int32_t ways[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};

/* The mean of good neighbours, those across a corner counting less. */
static void take_mean(const mender* work, int32_t receiver, float* const planes[TY_ATLAS_PLANES]) {
    double sum[TY_ATLAS_PLANES] = {0}, weights = 0;
    for (int way = 0; way < 8; ++way) {
        const int32_t other = neighbour_of(work->atlas, receiver, ways[way][0], ways[way][1]);
        if (other < 0 || !work->valid[other]) continue;
        const double weight = way < 4 ? 1 : sqrt(0.5);
        weights += weight;
        for (int plane = 0; plane < TY_ATLAS_PLANES; ++plane)
            sum[plane] += weight * (double)planes[plane][work->atlas->texels[other]];
    }
    for (int plane = 0; plane < TY_ATLAS_PLANES; ++plane)
        planes[plane][work->atlas->texels[receiver]] = (float)(sum[plane] / weights);
}

static void queue(mender* work, int32_t receiver, int64_t* count) {
    if (receiver < 0 || work->valid[receiver] || work->queued[receiver]) return;
    work->queued[receiver] = true;
    work->after[(*count)++] = receiver;
}

/* All that is not good beside what is. */
static int64_t first_wave(mender* work) {
    int64_t count = 0;
    for (int64_t i = 0; i < work->atlas->count; ++i)
        for (int way = 0; way < 8 && !work->valid[i]; ++way) {
            const int32_t other = neighbour_of(work->atlas, (int32_t)i, ways[way][0], ways[way][1]);
            if (other >= 0 && work->valid[other]) queue(work, (int32_t)i, &count);
        }
    return count;
}

ty_result ty_atlas_mend(const ty_atlas* atlas, bool* valid, float* const planes[TY_ATLAS_PLANES]) {
    size_t bad = 0;
    for (int64_t i = 0; i < atlas->count; ++i) bad += !valid[i];
    if (bad == 0) return TY_OK;
    mender work = {.atlas = atlas, .valid = valid};
    work.queued = ty_alloc_array(atlas->context, (size_t)atlas->count, sizeof *work.queued, true);
    work.all = ty_alloc_array(atlas->context, 2 * bad, sizeof *work.all, false);
    const bool ready = work.queued != NULL && work.all != NULL;
    work.after = work.all;
    for (int64_t count = ready ? first_wave(&work) : 0; count > 0;) {
        work.wave = work.after;
        work.after = work.wave == work.all ? work.all + bad : work.all;
        for (int64_t i = 0; i < count; ++i) take_mean(&work, work.wave[i], planes);
        for (int64_t i = 0; i < count; ++i) valid[work.wave[i]] = true;
        int64_t next = 0;
        for (int64_t i = 0; i < count; ++i)
            for (int way = 0; way < 8; ++way)
                queue(&work, neighbour_of(atlas, work.wave[i], ways[way][0], ways[way][1]), &next);
        count = next;
    }
    ty_free_array(atlas->context, work.queued, (size_t)atlas->count, sizeof *work.queued);
    ty_free_array(atlas->context, work.all, 2 * bad, sizeof *work.all);
    return ready ? TY_OK : TY_ERROR_MEMORY;
}
