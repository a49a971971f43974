/* Sampling of many items in passes over threads, with progress, saved states, bounds on time and error, and
 * cancelling. */
#define _POSIX_C_SOURCE 200809L
#include "base/context.h"
#include "base/progress.h"
#include "method/path/aov.h"
#include "method/path/outlines.h"
#include "method/path/sampling.h"
#include "method/path/state.h"

#include <math.h>
#include <string.h>

enum { PASS_MAX = 16, STRIDE_FIRST = 16, STRIDE_MAX = TY_PATH_BLOCK * PASS_MAX };
/* Samples of a pass with other ranks that only the number of samples ends, so that they are sent seldom. */
enum { PASS_MAX_SHARED = 256 };

/* Target duration of a thread's work between two checks for an early stop, seconds. */
static const double stride_seconds = 2e-3;

/* Saved states with TY_AUTO: the shortest time between two of them in seconds, the largest fraction of all threads'
 * time that they should take, and the target duration of samples that are in no state yet because their block is not
 * merged. */
static const double state_seconds_auto = 2, state_fraction = 0.02, merge_seconds = 0.5;

/* The shortest time between two partial images. */
static const double partial_seconds = 1;

/* Seed of the odd samples of a run with halves, over that of the even ones. */
static const uint64_t odd_seed = 0xb5ad4eceda1ce2a9u;

/* Root mean square standard error divided by the mean, over all items and channels, and the number of items that it
 * rests on: the effective sample size of the sum of their variances (Kish 1965). Where the samples' distribution has a
 * heavy tail, few items with the largest samples make the sum. */
static void estimate_error(ty_path_run* run) {
    double variance = 0, square = 0, mean = 0;
    for (int64_t i = 0; i < run->item_count; ++i) {
        double of_item = 0;
        for (int c = 0; c < 3; ++c) {
            of_item += ty_path_item_variance(&run->items[i], c);
            mean += ty_path_item_mean(&run->items[i], c);
        }
        variance += of_item;
        square += of_item * of_item;
    }
    const double n = 3.0 * (double)run->item_count;
    run->stats.error = mean > 0 ? sqrt(variance / n) / (mean / n) : 0;
    run->stats.error_pixels = square > 0 ? variance * variance / square : 0;
}

/* The error with two standard deviations of the sum of variances added to it: 1 / sqrt(error_pixels) of the sum each.
 */
static double error_bound(const ty_path_stats* stats) {
    return stats->error_pixels > 0 ? stats->error * sqrt(1 + 2 / sqrt(stats->error_pixels)) : stats->error;
}

int64_t ty_sampling_blocks(const ty_path_run* run) {
    return (run->item_count + TY_PATH_BLOCK - 1) / TY_PATH_BLOCK;
}

/* Fraction of the work done, by the bound that is nearest. */
static double fraction_done(const ty_sampling* pass, double seconds, double samples) {
    const ty_path_def* def = pass->run->def;
    double fraction = samples / def->spp;
    if (def->seconds > 0) fraction = fmax(fraction, seconds / def->seconds);
    if (def->error > 0 && pass->run->stats.error > 0 && pass->done_before > 0) {
        const double needed = pass->done_before * pow(error_bound(&pass->run->stats) / def->error, 2);
        fraction = fmax(fraction, samples / needed);
    }
    return fmin(fraction, 1);
}

/* Reports progress if due; sets cancelled if the caller asks for it. */
void ty_sampling_report(ty_sampling* pass, bool always) {
    const ty_path_def* def = pass->run->def;
    const double seconds = ty_wall_seconds() - pass->begun;
    if (def->seconds > 0 && seconds >= def->seconds) atomic_store(&pass->out_of_time, true);
    if (def->progress == NULL || (always ? pthread_mutex_lock : pthread_mutex_trylock)(&pass->lock) != 0) return;
    if (ty_report_due(&pass->reported) || always) {
        const double pass_fraction = (double)atomic_load(&pass->blocks_done) / (double)ty_sampling_blocks(pass->run);
        const double samples = pass->done_before + pass_fraction * (pass->last - pass->done_before);
        const double fraction = fraction_done(pass, seconds, samples);
        ty_progress progress = ty_progress_at(pass->run->stage, fraction, seconds);
        progress.done = pass->done_before;
        progress.total = def->spp < TY_PATH_SPP_MAX ? (uint64_t)def->spp : 0;
        if (!def->progress(def->progress_user, &progress)) atomic_store(&pass->cancelled, true);
    }
    pthread_mutex_unlock(&pass->lock);
}

static ty_path_stats totals(ty_sampling* pass) {
    ty_path_stats stats = pass->run->stats;
    stats.seconds = ty_wall_seconds() - pass->begun;
    stats.cpu_seconds = ty_cpu_seconds() - pass->cpu_begun;
    stats.paths = atomic_load(&pass->paths);
    stats.vertices = atomic_load(&pass->vertices);
    stats.spp = (double)stats.paths / (double)pass->run->item_count;
    return stats;
}

/* Time between two states, or partial images, such that they take at most state_fraction of the threads' time: all of
 * them wait while one is copied, and a single one does the rest. */
static double period_of(const ty_sampling* pass, double copying, double rest) {
    return (copying + rest / ty_context_threads(pass->run->context)) / state_fraction;
}

/* Changes need time by their samples and not by their number, so that longer periods would save little. */
static double next_state_period(const ty_sampling* pass, double copying, double rest) {
    const ty_path_def* def = pass->run->def;
    if (def->state_seconds != TY_AUTO) return def->state_seconds;
    return def->state_change != NULL ? state_seconds_auto : fmax(state_seconds_auto, period_of(pass, copying, rest));
}

/* Hands out a whole state, or changes; returns false if it is a whole state and the caller cancels. */
static bool hand_out(ty_sampling* pass, bool whole, size_t size) {
    const ty_path_def* def = pass->run->def;
    if (whole) {
        pass->changes_size = 0;
        pass->whole_due = def->state_change == NULL;
        return def->state(def->state_user, pass->state, size);
    }
    pass->changes_size += size;
    const bool kept = def->state_change(def->state_user, pass->state, size);
    pass->whole_due = !kept || pass->changes_size >= 2 * ty_path_state_room(pass->run);
    return true;
}

/* Saves the state if due. Other threads wait only while it is copied. */
void ty_sampling_save(ty_sampling* pass, bool always) {
    if (pass->state == NULL || (always ? pthread_mutex_lock : pthread_mutex_trylock)(&pass->lock) != 0) return;
    const double begun = ty_wall_seconds();
    if (always || begun - pass->saved >= pass->state_period) {
        const bool whole = always || pass->whole_due;
        pthread_rwlock_wrlock(&pass->items);
        const ty_path_stats stats = totals(pass);
        if (whole) memset(pass->saved_counts, 0, ty_path_state_blocks(pass->run) * sizeof *pass->saved_counts);
        const size_t size = ty_path_state_copy(pass->run, &stats, pass->saved_counts, pass->state);
        pthread_rwlock_unlock(&pass->items);
        const double copied = ty_wall_seconds();
        ty_path_state_seal(pass->state, size);
        if (!hand_out(pass, whole, size)) atomic_store(&pass->cancelled, true);
        pass->saved = begun;
        pass->state_period = next_state_period(pass, copied - begun, ty_wall_seconds() - copied);
    }
    pthread_mutex_unlock(&pass->lock);
}

/* Hands out the image so far if due. Other threads wait only while it is made. */
void ty_sampling_show(ty_sampling* pass) {
    const ty_path_run* run = pass->run;
    if (run->image == NULL || run->def->partial == NULL || pthread_mutex_trylock(&pass->lock) != 0) return;
    const double begun = ty_wall_seconds();
    if (begun - pass->shown >= pass->partial_period) {
        pthread_rwlock_wrlock(&pass->items);
        ty_path_image_fill(run, run->image);
        pthread_rwlock_unlock(&pass->items);
        const double filled = ty_wall_seconds();
        if (!run->def->partial(run->def->partial_user, run->image)) atomic_store(&pass->cancelled, true);
        pass->shown = ty_wall_seconds();
        pass->partial_period = fmax(partial_seconds, period_of(pass, filled - begun, pass->shown - filled));
    }
    pthread_mutex_unlock(&pass->lock);
}

/* The time bound applies only once every item has a sample. */
bool ty_sampling_stops(ty_sampling* pass) {
    return atomic_load_explicit(&pass->cancelled, memory_order_relaxed) ||
           (pass->done_before > 0 && atomic_load_explicit(&pass->out_of_time, memory_order_relaxed));
}

/* Adds `samples` samples of items to the work. With halves it is one, which has its index among those of its parity. */
static uint64_t trace(const ty_sampling* pass, ty_block_work* work, int64_t item, int64_t next, uint32_t sample,
                      uint32_t samples) {
    const ty_path_run* run = pass->run;
    const bool halves = run->halves != NULL;
    const ty_path_request* request = halves && work->first % 2 == 1 ? &pass->odd : &run->request;
    return run->kernel(request, item, next, halves ? work->first / 2 : work->first + sample, samples,
                       work->sums + (item - work->begin),
                       run->aov_sums != NULL ? work->aov_sums + (item - work->begin) : NULL);
}

/* Samples in strides of a few milliseconds; their lengths change no result. Returns false if the run stops. */
static bool sample_in_strides(ty_sampling* pass, ty_block_work* work) {
    int64_t item = work->begin;
    uint32_t sample = 0;
    while (item < work->end) {
        const uint32_t stride = atomic_load_explicit(&pass->stride, memory_order_relaxed);
        const uint32_t left = work->count - sample;
        const uint32_t samples = stride < left ? stride : left;
        const int64_t many = sample > 0 || samples < left ? 1 : stride / work->count;
        const int64_t next = item + many < work->end ? item + many : work->end;
        const double begun = ty_wall_seconds();
        work->vertices += trace(pass, work, item, next, sample, samples);
        const double seconds = ty_wall_seconds() - begun;
        uint32_t better = stride;
        if (seconds > 2 * stride_seconds && stride > 1) better = stride / 2;
        if (seconds < 0.5 * stride_seconds && stride < STRIDE_MAX) better = stride * 2;
        atomic_store_explicit(&pass->stride, better, memory_order_relaxed);
        sample = sample + samples < work->count ? sample + samples : 0;
        if (sample == 0) item = next;
        ty_sampling_report(pass, false);
        if (ty_sampling_stops(pass)) return false;
    }
    return true;
}

/* Samples per item of a block until they are merged: as many as take about merge_seconds, judged by the stride. A
 * stride of one path may take any time longer than a stride should, and then the fewest are merged. With halves each
 * sample is, because the next one belongs to the other half. */
static uint32_t samples_to_merge(const ty_sampling* pass, uint32_t left) {
    if (pass->run->halves != NULL) return 1;
    const uint32_t stride = atomic_load_explicit(&pass->stride, memory_order_relaxed);
    const double samples = stride * (merge_seconds / stride_seconds) / TY_PATH_BLOCK;
    const uint32_t count = stride <= 1 || samples < 1 ? 1 : (uint32_t)samples;
    return count < left ? count : left;
}

/* Adds an even sample of a block, by which its sums exceed those of the run's items, to the halves. */
static void add_to_halves(ty_path_run* run, const ty_block_work* work) {
    enum { AOV_SUMS = sizeof(ty_path_aov_sums) / sizeof(double) };
    for (int64_t i = work->begin; i < work->end; ++i) {
        const ty_path_sums* sums = &work->sums[i - work->begin];
        const double* after = (const double*)&work->aov_sums[i - work->begin];
        const double* before = (const double*)&run->aov_sums[i];
        double* half = (double*)&run->halves[i].aov_sums;
        for (int c = 0; c < 3; ++c) run->halves[i].mean[c] += sums->mean[c] - run->items[i].sums.mean[c];
        for (int k = 0; k < AOV_SUMS; ++k) half[k] += after[k] - before[k];
    }
}

/* Adds the samples of a block to the run's items. */
void ty_sampling_merge(ty_sampling* pass, const ty_block_work* work) {
    ty_path_run* run = pass->run;
    const size_t size = (size_t)(work->end - work->begin);
    pthread_rwlock_rdlock(&pass->items);
    if (run->halves != NULL && work->first % 2 == 0) add_to_halves(run, work);
    for (size_t i = 0; i < size; ++i) {
        run->items[(size_t)work->begin + i].sums = work->sums[i];
        run->items[(size_t)work->begin + i].count = work->first + work->count;
    }
    if (run->aov_sums != NULL) memcpy(run->aov_sums + work->begin, work->aov_sums, size * sizeof *run->aov_sums);
    atomic_fetch_add(&pass->vertices, work->vertices);
    atomic_fetch_add(&pass->paths, (uint64_t)size * work->count);
    pthread_rwlock_unlock(&pass->items);
}

void ty_sampling_block(ty_sampling* pass, int64_t block) {
    ty_path_run* run = pass->run;
    if (ty_sampling_stops(pass)) return;
    ty_block_work work = {.begin = block * TY_PATH_BLOCK};
    work.end = work.begin + TY_PATH_BLOCK < run->item_count ? work.begin + TY_PATH_BLOCK : run->item_count;
    work.first = run->items[work.begin].count;
    const size_t size = (size_t)(work.end - work.begin);
    for (size_t i = 0; i < size; ++i) work.sums[i] = run->items[(size_t)work.begin + i].sums;
    if (run->aov_sums != NULL) memcpy(work.aov_sums, run->aov_sums + work.begin, size * sizeof *run->aov_sums);
    for (; work.first < pass->last; work.first += work.count) {
        work.count = samples_to_merge(pass, pass->last - work.first);
        work.vertices = 0;
        if (!sample_in_strides(pass, &work)) return;
        ty_sampling_merge(pass, &work);
        if (work.first + work.count < pass->last) ty_sampling_save(pass, false);
        ty_sampling_show(pass);
    }
    atomic_fetch_add(&pass->blocks_done, 1);
    ty_sampling_save(pass, false);
}

static void sample_block(void* user, int64_t block, int32_t worker) {
    (void)worker;
    ty_sampling_block(user, block);
}

/* Samples per item in the next pass: few at first, so that bounds on time and error are checked early, then more. */
static uint32_t next_pass(const ty_sampling* pass, uint32_t done) {
    const ty_path_run* run = pass->run;
    const bool bounded = run->def->seconds > 0 || run->def->error > 0 || run->def->partial != NULL;
    uint32_t count = done < 1 ? 1 : done < PASS_MAX ? done : PASS_MAX;
    if (pass->queue != NULL && !bounded) count = PASS_MAX_SHARED;
    if (done + count > (uint32_t)run->def->spp) count = (uint32_t)run->def->spp - done;
    return count;
}

/* Minimum of samples over items; *uniform is true if all items have the same number. */
static uint32_t min_samples(const ty_path_run* run, bool* uniform) {
    uint32_t min_count = UINT32_MAX, max_count = 0;
    for (int64_t i = 0; i < run->item_count; i += TY_PATH_BLOCK) {
        if (run->items[i].count < min_count) min_count = run->items[i].count;
        if (run->items[i].count > max_count) max_count = run->items[i].count;
    }
    *uniform = min_count == max_count;
    return min_count;
}

/* True if a bound other than that on samples is met, between passes. */
static bool bounds_met(ty_sampling* pass) {
    ty_path_run* run = pass->run;
    if (run->def->error > 0 && pass->done_before > 0) {
        estimate_error(run);
        if (pass->done_before >= 4 && error_bound(&run->stats) <= run->def->error) return true;
    }
    return run->def->seconds > 0 && pass->done_before > 0 && ty_wall_seconds() - pass->begun >= run->def->seconds;
}

static void sample_passes(ty_sampling* pass) {
    const uint32_t spp = (uint32_t)pass->run->def->spp;
    bool uniform;
    pass->done_before = pass->last = min_samples(pass->run, &uniform);
    /* An interrupted pass is completed before bounds are checked, so that the error refers to equal samples of all
     * items. */
    for (; pass->done_before < spp && !(uniform && bounds_met(pass)); uniform = true) {
        pass->last = pass->done_before + next_pass(pass, pass->done_before);
        atomic_store(&pass->blocks_done, 0);
        if (pass->last > TY_OUTLINE_FIRST) ty_path_find_outlines(pass->run);
        if (pass->device != NULL)
            ty_sample_pass_on_device(pass);
        else if (pass->queue != NULL)
            ty_sample_pass_shared(pass);
        else
            ty_parallel_for(pass->run->context, ty_sampling_blocks(pass->run), sample_block, pass);
        if (atomic_load(&pass->blocks_done) < ty_sampling_blocks(pass->run)) return;
        pass->done_before = pass->last;
    }
}

void ty_sampling_open(ty_sampling* pass, ty_path_run* run) {
    *pass = (ty_sampling){.run = run, .odd = run->request, .reported = ty_wall_seconds(), .launch_paths = 1 << 12};
    pass->odd.seed ^= odd_seed;
    pass->begun = pass->reported - run->stats.seconds - run->guide_seconds;
    pass->cpu_begun = ty_cpu_seconds() - run->stats.cpu_seconds - run->guide_cpu_seconds;
    pass->saved = pass->shown = ty_wall_seconds();
    pass->partial_period = partial_seconds;
    pass->state_period = run->def->state_seconds == TY_AUTO ? 0.5 * state_seconds_auto : run->def->state_seconds;
    atomic_init(&pass->paths, run->stats.paths);
    atomic_init(&pass->vertices, run->stats.vertices);
    atomic_init(&pass->stride, STRIDE_FIRST);
    pthread_mutex_init(&pass->lock, NULL);
    pthread_rwlock_init(&pass->items, NULL);
}

void ty_sampling_close(ty_sampling* pass) {
    pthread_mutex_destroy(&pass->lock);
    pthread_rwlock_destroy(&pass->items);
}

static ty_result allocate_states(ty_sampling* pass, size_t room, size_t blocks) {
    if (room == 0) return TY_OK;
    ty_context* context = pass->run->context;
    pass->state = ty_alloc_array(context, room, 1, false);
    pass->saved_counts = ty_alloc_array(context, blocks, sizeof *pass->saved_counts, true);
    pass->whole_due = true;
    return pass->state != NULL && pass->saved_counts != NULL ? TY_OK : TY_ERROR_MEMORY;
}

/* Samples, and leaves the statistics and the last state; true if the caller cancelled. */
static bool run_passes(ty_sampling* pass) {
    ty_path_run* run = pass->run;
    if (pass->device != NULL) run->stats.isa = ty_path_device_kind(pass->device);
    pass->vertices_before = run->stats.vertices;
    sample_passes(pass);
    ty_sampling_end_queue(pass);
    const bool cancelled = atomic_load(&pass->cancelled) && pass->done_before < (uint32_t)run->def->spp;
    ty_sampling_report(pass, true);
    run->stats = totals(pass);
    estimate_error(run);
    ty_sampling_save(pass, true);
    return cancelled;
}

ty_result ty_path_sample(ty_path_run* run) {
    ty_sampling pass;
    ty_sampling_open(&pass, run);
    const bool saves = run->def->state != NULL && run->request.kind == TY_PATH_PIXELS;
    const size_t room = saves ? ty_path_state_room(run) : 0, blocks = saves ? ty_path_state_blocks(run) : 0;
    ty_result result = allocate_states(&pass, room, blocks);
    if (result == TY_OK) result = ty_path_device_create(run, &pass.odd, &pass.device);
    if (result == TY_OK) result = ty_sampling_distribute(&pass);
    const bool cancelled = result == TY_OK && run_passes(&pass);
    ty_path_device_destroy(pass.device);
    ty_sampling_close(&pass);
    ty_free_array(run->context, pass.state, room, 1);
    ty_free_array(run->context, pass.saved_counts, blocks, sizeof *pass.saved_counts);
    if (result != TY_OK) return result;
    return pass.failed != TY_OK ? pass.failed : cancelled ? TY_CANCELLED : TY_OK;
}
