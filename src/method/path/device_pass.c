/* Passes on a device: launches of a few hundredths of a second, whose samples are merged from time to time. */
#define _POSIX_C_SOURCE 200809L
#include "base/context.h"
#include "device/arrays.h"
#include "method/path/sampling.h"

#include <string.h>

/* Duration of samples at most that are in no state yet because they are not merged. */
static const double merge_seconds = 0.5;

/* Items with equal numbers of samples on a device, of which some are not merged yet. */
typedef struct device_range {
    ty_sampling* pass;
    int64_t begin, end;
    uint32_t first, count; /* samples of all these items that are not merged */
    int64_t ahead;         /* items before this one have `more` further ones */
    uint32_t more;
    const ty_path_sums* sums;
    const ty_path_aov_sums* aov_sums;
} device_range;

static void merge_from_device(void* user, int64_t block, int32_t worker) {
    (void)worker;
    const device_range* range = user;
    const ty_path_run* run = range->pass->run;
    ty_block_work work = {.begin = range->begin + block * TY_PATH_BLOCK, .first = range->first, .count = range->count};
    work.end = work.begin + TY_PATH_BLOCK < range->end ? work.begin + TY_PATH_BLOCK : range->end;
    if (work.begin < range->ahead) work.count += range->more;
    const size_t size = (size_t)(work.end - work.begin);
    if (work.count == 0) return;
    memcpy(work.sums, range->sums + work.begin, size * sizeof *work.sums);
    if (run->aov_sums != NULL) memcpy(work.aov_sums, range->aov_sums + work.begin, size * sizeof *work.aov_sums);
    ty_sampling_merge(range->pass, &work);
}

/* Merges what is not merged yet, so that states and images show it. */
static bool merge_range(device_range* range) {
    ty_sampling* pass = range->pass;
    uint64_t vertices;
    pass->failed = ty_path_device_read(pass->device, &range->sums, &range->aov_sums, &vertices);
    if (pass->failed != TY_OK) return false;
    ty_parallel_for(pass->run->context, (range->end - range->begin + TY_PATH_BLOCK - 1) / TY_PATH_BLOCK,
                    merge_from_device, range);
    atomic_store(&pass->vertices, pass->vertices_before + vertices);
    range->first += range->count;
    range->count = 0;
    return true;
}

/* Launches one slice of a range's items, whole blocks, for `samples` samples. */
static bool launch_slice(device_range* range, uint32_t samples) {
    ty_sampling* pass = range->pass;
    const bool odd = pass->run->halves != NULL && range->first % 2 == 1;
    const uint32_t first = pass->run->halves != NULL ? range->first / 2 : range->first + range->count;
    const int64_t many = (int64_t)pass->launch_paths / samples, whole = many - many % TY_PATH_BLOCK;
    const int64_t next = range->ahead + (whole > 0 ? whole : TY_PATH_BLOCK);
    const int64_t end = next < range->end ? next : range->end;
    const double begun = ty_wall_seconds();
    pass->failed = ty_path_device_trace(pass->device, odd, range->ahead, end, first, samples);
    const double seconds = ty_wall_seconds() - begun;
    pass->launch_paths = ty_device_next_launch(pass->launch_paths, seconds, TY_PATH_BLOCK);
    range->ahead = end;
    range->more = samples;
    const double part = (double)(end - range->begin) / (double)(range->end - range->begin);
    const double done = range->first + range->count - pass->done_before + part * samples;
    atomic_store(&pass->blocks_done,
                 (int64_t)(done / (pass->last - pass->done_before) * (double)(ty_sampling_blocks(pass->run) - 1)));
    ty_sampling_report(pass, false);
    return pass->failed == TY_OK && !ty_sampling_stops(pass);
}

/* Brings the items of a range, whose numbers of samples are equal, to those of the pass. */
static bool sample_range(device_range* range) {
    ty_sampling* pass = range->pass;
    double merged = ty_wall_seconds();
    while (range->first + range->count < pass->last) {
        const uint32_t left = pass->last - range->first - range->count;
        const int64_t many = (int64_t)pass->launch_paths / (range->end - range->begin);
        const uint32_t samples = many < 1 || pass->run->halves != NULL ? 1
                                 : many < (int64_t)left                ? (uint32_t)many
                                                                       : left;
        for (range->ahead = range->begin; range->ahead < range->end;)
            if (!launch_slice(range, samples)) {
                if (pass->failed == TY_OK) merge_range(range);
                return false;
            }
        range->count += samples;
        range->more = 0;
        const bool shown = pass->state != NULL || (pass->run->image != NULL && pass->run->def->partial != NULL);
        if (pass->run->halves == NULL && !(shown && ty_wall_seconds() - merged > merge_seconds)) continue;
        if (!merge_range(range)) return false;
        merged = ty_wall_seconds();
        ty_sampling_save(pass, false);
        ty_sampling_show(pass);
    }
    return range->count == 0 || merge_range(range);
}

/* One pass on the device, over ranges of blocks with equal numbers of samples: after an interrupted run there may be
 * several. */
void ty_sample_pass_on_device(ty_sampling* pass) {
    const ty_path_run* run = pass->run;
    for (int64_t begin = 0, end = 0; begin < run->item_count; begin = end) {
        device_range range = {.pass = pass, .begin = begin, .first = run->items[begin].count};
        while (end < run->item_count && run->items[end].count == range.first) end += TY_PATH_BLOCK;
        range.end = end = end < run->item_count ? end : run->item_count;
        if (range.first < pass->last && !sample_range(&range)) return;
    }
    atomic_store(&pass->blocks_done, ty_sampling_blocks(run));
    ty_sampling_save(pass, false);
    ty_sampling_show(pass);
}
