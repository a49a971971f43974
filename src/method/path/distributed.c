/* Passes over the blocks of an image by several ranks. A task has sums of samples and returns sums of more of them. */
#define _POSIX_C_SOURCE 200809L
#include "method/path/distributed.h"

#include "base/context.h"
#include "method/path/outlines.h"
#include "method/path/sampling.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

/* The render of a job. */
typedef struct path_job {
    uint64_t scene;
    ty_path_def def; /* without pointers; the guide is none or a known one */
} path_job;

/* Before the items of a task: samples of each item at its end, and, of results, the vertices of the paths. */
typedef struct path_task {
    uint64_t vertices;
    uint32_t last, reserved;
} path_task;

static int64_t items_end(const ty_path_run* run, int64_t block_end) {
    const int64_t end = block_end * TY_PATH_BLOCK;
    return end < run->item_count ? end : run->item_count;
}

/* Bytes of an item in a task. */
static size_t item_size(const ty_path_run* run) {
    return sizeof *run->items + (run->aov_sums != NULL ? sizeof *run->aov_sums : 0) +
           (run->halves != NULL ? sizeof *run->halves : 0);
}

static void pack_items(const ty_path_run* run, int64_t begin, int64_t end, ty_buffer* out) {
    const size_t count = (size_t)(end - begin);
    ty_buffer_add(out, run->items + begin, count * sizeof *run->items);
    if (run->aov_sums != NULL) ty_buffer_add(out, run->aov_sums + begin, count * sizeof *run->aov_sums);
    if (run->halves != NULL) ty_buffer_add(out, run->halves + begin, count * sizeof *run->halves);
}

/* Takes items [begin, end) out of the bytes of items from `first` on, `count` of them. */
static void unpack_items(ty_path_run* run, const uint8_t* bytes, int64_t first, int64_t count, int64_t begin,
                         int64_t end) {
    const size_t many = (size_t)count, skipped = (size_t)(begin - first), items = (size_t)(end - begin);
    memcpy(run->items + begin, bytes + skipped * sizeof *run->items, items * sizeof *run->items);
    bytes += many * sizeof *run->items;
    if (run->aov_sums != NULL)
        memcpy(run->aov_sums + begin, bytes + skipped * sizeof *run->aov_sums, items * sizeof *run->aov_sums);
    if (run->aov_sums != NULL) bytes += many * sizeof *run->aov_sums;
    if (run->halves != NULL)
        memcpy(run->halves + begin, bytes + skipped * sizeof *run->halves, items * sizeof *run->halves);
}

/* ---- rank 0 ---- */

static int64_t lend(void* user, int64_t max_count, int64_t* first) {
    ty_sampling* pass = user;
    if (ty_sampling_stops(pass)) return 0;
    return ty_blocks_lend(&pass->blocks, max_count, ty_queue_ranks(pass->queue), first);
}

static void pack(void* user, int64_t first, int64_t count, ty_buffer* out) {
    ty_sampling* pass = user;
    const path_task task = {.last = pass->last};
    ty_buffer_add(out, &task, sizeof task);
    pthread_rwlock_rdlock(&pass->items);
    pack_items(pass->run, first * TY_PATH_BLOCK, items_end(pass->run, first + count), out);
    pthread_rwlock_unlock(&pass->items);
}

/* Results of a pass that is over have fewer samples than those of this one, and nobody waits for them. */
static void accept(void* user, int64_t first, int64_t count, const uint8_t* bytes, size_t size) {
    ty_sampling* pass = user;
    ty_path_run* run = pass->run;
    path_task task;
    const int64_t begin = first * TY_PATH_BLOCK, end = items_end(run, first + count);
    if (first < 0 || first + count > ty_sampling_blocks(run) ||
        size != sizeof task + (size_t)(end - begin) * item_size(run))
        return;
    memcpy(&task, bytes, sizeof task);
    if (task.last != pass->last) return;
    atomic_fetch_add(&pass->vertices, task.vertices);
    for (int64_t b = first; b < first + count; ++b) {
        if (!ty_blocks_return(&pass->blocks, b)) continue;
        const int64_t at = b * TY_PATH_BLOCK, next = items_end(run, b + 1);
        pthread_rwlock_rdlock(&pass->items);
        const uint32_t before = run->items[at].count;
        unpack_items(run, bytes + sizeof task, begin, end - begin, at, next);
        atomic_fetch_add(&pass->paths, (uint64_t)(next - at) * (run->items[at].count - before));
        pthread_rwlock_unlock(&pass->items);
        atomic_fetch_add(&pass->blocks_done, 1);
        ty_blocks_settle(&pass->blocks);
    }
}

/* A device traces faster than the others could, and light in dielectrics is on this rank alone. */
ty_result ty_sampling_distribute(ty_sampling* pass) {
    ty_path_run* run = pass->run;
    ty_work_queue* queue = ty_context_queue(run->context);
    if (queue == NULL || run->request.kind != TY_PATH_PIXELS || run->def->enclosed != NULL || pass->device != NULL ||
        ty_sampling_blocks(run) < 2)
        return TY_OK;
    path_job job = {.scene = run->scene_hash, .def = *run->def};
    job.def.state = job.def.state_change = NULL;
    job.def.partial = NULL;
    job.def.progress = NULL;
    job.def.state_user = job.def.partial_user = job.def.progress_user = NULL;
    job.def.resume = NULL;
    job.def.resume_size = 0;
    const ty_job offered = {TY_JOB_PATH, pass, lend, pack, accept};
    if (!ty_blocks_create(&pass->blocks, ty_sampling_blocks(run))) return TY_ERROR_MEMORY;
    atomic_store(&pass->blocks.end, 0); /* until the first pass */
    pass->queue = queue;                /* before other ranks ask */
    if (!ty_queue_begin(queue, &offered, &job, sizeof job)) pass->queue = NULL;
    return TY_OK;
}

void ty_sampling_end_queue(ty_sampling* pass) {
    if (pass->queue != NULL) ty_queue_end(pass->queue);
    pass->queue = NULL;
    ty_blocks_destroy(&pass->blocks);
}

static void sample_own(void* user, int64_t block, int32_t worker) {
    (void)worker;
    ty_sampling* pass = user;
    if (ty_blocks_take(&pass->blocks, block)) ty_sampling_block(pass, block);
}

static void sample_again(void* user, int64_t block, int32_t worker) {
    (void)worker;
    ty_sampling* pass = user;
    if (ty_blocks_take_back(&pass->blocks, block)) ty_sampling_block(pass, block);
}

void ty_sample_pass_shared(ty_sampling* pass) {
    const int64_t count = ty_sampling_blocks(pass->run);
    ty_blocks_reset(&pass->blocks);
    ty_parallel_for(pass->run->context, count, sample_own, pass);
    const double begun = ty_wall_seconds();
    while (atomic_load(&pass->blocks.away) > 0 && !ty_sampling_stops(pass)) {
        const struct timespec pause = {.tv_nsec = 500000};
        nanosleep(&pause, NULL);
        ty_sampling_report(pass, false);
        ty_sampling_save(pass, false);
        if (ty_wall_seconds() - begun > ty_queue_patience(pass->queue))
            ty_parallel_for(pass->run->context, count, sample_again, pass);
    }
}

/* ---- the other ranks ---- */

typedef struct path_service {
    ty_path_run run;
    ty_sampling pass;
} path_service;

static bool begin_job(void* user, const uint8_t* bytes, size_t size, void** out) {
    const ty_path_helper* helper = user;
    path_job job;
    if (size != sizeof job) return false;
    memcpy(&job, bytes, sizeof job);
    path_service* service = job.scene == ty_scene_hash(helper->scene) ? calloc(1, sizeof *service) : NULL;
    if (service == NULL) return false;
    job.def.progress = helper->progress;
    job.def.progress_user = helper->progress_user;
    if (ty_path_begin_pixels(helper->scene, &job.def, &service->run) != TY_OK) {
        free(service);
        return false;
    }
    ty_sampling_open(&service->pass, &service->run);
    *out = service;
    return true;
}

/* Blocks of a task, from its first one on. */
typedef struct task_blocks {
    ty_sampling* pass;
    int64_t first;
} task_blocks;

static void sample_task(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const task_blocks* blocks = user;
    ty_sampling_block(blocks->pass, blocks->first + index);
}

static bool do_task(void* user, int64_t first, int64_t count, const uint8_t* bytes, size_t size, ty_buffer* out) {
    path_service* service = user;
    ty_path_run* run = &service->run;
    path_task task;
    const int64_t begin = first * TY_PATH_BLOCK, end = items_end(run, first + count);
    if (first < 0 || begin >= end || size != sizeof task + (size_t)(end - begin) * item_size(run)) return false;
    memcpy(&task, bytes, sizeof task);
    unpack_items(run, bytes + sizeof task, begin, end - begin, begin, end);
    service->pass.last = task.last;
    atomic_store(&service->pass.vertices, 0);
    if (task.last > TY_OUTLINE_FIRST) ty_path_find_outlines(run);
    task_blocks blocks = {&service->pass, first};
    ty_parallel_for(run->context, count, sample_task, &blocks);
    task.vertices = atomic_load(&service->pass.vertices);
    ty_buffer_add(out, &task, sizeof task);
    pack_items(run, begin, end, out);
    return !ty_sampling_stops(&service->pass);
}

static void end_job(void* user) {
    path_service* service = user;
    ty_sampling_close(&service->pass);
    ty_path_run_end(&service->run);
    free(service);
}

ty_job_worker ty_path_job_worker(ty_path_helper* helper) {
    return (ty_job_worker){begin_job, do_task, end_job, helper};
}
