/* Inpainting of texels without light of their own: inside walls, or not sampled yet. */
#include "base/context.h"
#include "bake/atlas/atlas.h"

#include <math.h>

typedef struct inpaint_job {
    const ty_atlas* atlas;
    const bool* valid;
    bool* queued;              /* per receiver */
    int32_t *wave, *next_wave; /* current wave of receivers with valid neighbours, and the next wave */
    int32_t* waves;            /* memory of both waves */
} inpaint_job;

/* The receiver at a neighbouring texel of the same chart; -1: none. */
static int32_t neighbour_of(const ty_atlas* atlas, int32_t receiver, int32_t dx, int32_t dy) {
    const int32_t texel = atlas->texels[receiver];
    const int32_t x = texel % atlas->width + dx, y = texel / atlas->width + dy;
    if (x < 0 || x >= atlas->width || y < 0 || y >= atlas->height) return -1;
    const int32_t other = atlas->receiver[(size_t)y * (size_t)atlas->width + (size_t)x];
    return other >= 0 && atlas->charts[other] == atlas->charts[receiver] ? other : -1;
}

static const int32_t offsets[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};

/* The mean of the valid neighbours, diagonal ones weighted by 1 / sqrt(2). */
static void inpaint_receiver(const inpaint_job* work, int32_t receiver, float* const planes[TY_ATLAS_PLANES]) {
    double sum[TY_ATLAS_PLANES] = {0}, weights = 0;
    for (int direction = 0; direction < 8; ++direction) {
        const int32_t other = neighbour_of(work->atlas, receiver, offsets[direction][0], offsets[direction][1]);
        if (other < 0 || !work->valid[other]) continue;
        const double weight = direction < 4 ? 1 : sqrt(0.5);
        weights += weight;
        for (int plane = 0; plane < TY_ATLAS_PLANES; ++plane)
            sum[plane] += weight * (double)planes[plane][work->atlas->texels[other]];
    }
    for (int plane = 0; plane < TY_ATLAS_PLANES; ++plane)
        planes[plane][work->atlas->texels[receiver]] = (float)(sum[plane] / weights);
}

static void queue(inpaint_job* work, int32_t receiver, int64_t* count) {
    if (receiver < 0 || work->valid[receiver] || work->queued[receiver]) return;
    work->queued[receiver] = true;
    work->next_wave[(*count)++] = receiver;
}

/* The first wave: invalid receivers beside valid ones. */
static int64_t first_wave(inpaint_job* work) {
    int64_t count = 0;
    for (int64_t i = 0; i < work->atlas->count; ++i)
        for (int direction = 0; direction < 8 && !work->valid[i]; ++direction) {
            const int32_t other = neighbour_of(work->atlas, (int32_t)i, offsets[direction][0], offsets[direction][1]);
            if (other >= 0 && work->valid[other]) queue(work, (int32_t)i, &count);
        }
    return count;
}

ty_result ty_atlas_inpaint(const ty_atlas* atlas, bool* valid, float* const planes[TY_ATLAS_PLANES]) {
    size_t invalid = 0;
    for (int64_t i = 0; i < atlas->count; ++i) invalid += !valid[i];
    if (invalid == 0) return TY_OK;
    inpaint_job work = {.atlas = atlas, .valid = valid};
    work.queued = ty_alloc_array(atlas->context, (size_t)atlas->count, sizeof *work.queued, true);
    work.waves = ty_alloc_array(atlas->context, 2 * invalid, sizeof *work.waves, false);
    const bool ready = work.queued != NULL && work.waves != NULL;
    work.next_wave = work.waves;
    for (int64_t count = ready ? first_wave(&work) : 0; count > 0;) {
        work.wave = work.next_wave;
        work.next_wave = work.wave == work.waves ? work.waves + invalid : work.waves;
        for (int64_t i = 0; i < count; ++i) inpaint_receiver(&work, work.wave[i], planes);
        for (int64_t i = 0; i < count; ++i) valid[work.wave[i]] = true;
        int64_t next = 0;
        for (int64_t i = 0; i < count; ++i)
            for (int direction = 0; direction < 8; ++direction)
                queue(&work, neighbour_of(atlas, work.wave[i], offsets[direction][0], offsets[direction][1]), &next);
        count = next;
    }
    ty_free_array(atlas->context, work.queued, (size_t)atlas->count, sizeof *work.queued);
    ty_free_array(atlas->context, work.waves, 2 * invalid, sizeof *work.waves);
    return ready ? TY_OK : TY_ERROR_MEMORY;
}
