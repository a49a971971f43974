#define _POSIX_C_SOURCE 200809L
#include "bake/receivers/distributed.h"

#include "bake/impulse/impulse.h"

#include "base/context.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

/* The run of a job. For impulse responses all receivers follow, from which each rank finds the same virtual emitters.
 */
typedef struct bake_job {
    ty_bake_def def; /* without pointers */
    int64_t count;
    int32_t terms, cached;
} bake_job;

static size_t emitting_receivers(const ty_bake_def* def, int64_t count) {
    return def->method == TY_BAKE_IMPULSE ? (size_t)count : 0;
}

/* Before the receivers and the sums of a task. */
typedef struct bake_task {
    uint32_t first, count; /* samples */
} bake_task;

static int64_t receivers_end(const ty_bake_run* run, int64_t block_end) {
    const int64_t end = block_end * TY_BAKE_BLOCK;
    return end < run->count ? end : run->count;
}

static size_t light_size(const ty_bake_run* run) {
    return (size_t)(TY_BAKE_LAYERS * 3 * run->request.terms);
}

/* Bytes of the sums of a receiver. */
static size_t sums_size(const ty_bake_run* run) {
    return sizeof *run->sums + light_size(run) * sizeof *run->light;
}

static void pack_sums(const ty_bake_run* run, int64_t begin, int64_t end, ty_buffer* out) {
    const size_t count = (size_t)(end - begin), size = light_size(run);
    ty_buffer_add(out, run->sums + begin, count * sizeof *run->sums);
    ty_buffer_add(out, run->light + (size_t)begin * size, count * size * sizeof *run->light);
}

/* Takes receivers [begin, end) out of the bytes of sums from `first` on, `count` of them. */
static void unpack_sums(ty_bake_run* run, const uint8_t* bytes, int64_t first, int64_t count, int64_t begin,
                        int64_t end) {
    const size_t skipped = (size_t)(begin - first), many = (size_t)(end - begin), size = light_size(run);
    memcpy(run->sums + begin, bytes + skipped * sizeof *run->sums, many * sizeof *run->sums);
    bytes += (size_t)count * sizeof *run->sums;
    memcpy(run->light + (size_t)begin * size, bytes + skipped * size * sizeof *run->light,
           many * size * sizeof *run->light);
}

/* ---- rank 0 ---- */

static int64_t lend(void* user, int64_t max_count, int64_t* first) {
    ty_bake_shared* shared = user;
    return ty_blocks_lend(&shared->blocks, max_count, ty_queue_ranks(shared->queue), first);
}

static void pack(void* user, int64_t first, int64_t count, ty_buffer* out) {
    const ty_bake_shared* shared = user;
    const ty_bake_run* run = shared->run;
    const int64_t begin = first * TY_BAKE_BLOCK, end = receivers_end(run, first + count);
    const bake_task task = {shared->first, shared->count};
    ty_buffer_add(out, &task, sizeof task);
    ty_buffer_add(out, run->request.receivers + begin, (size_t)(end - begin) * sizeof *run->request.receivers);
    pack_sums(run, begin, end, out);
}

static void accept(void* user, int64_t first, int64_t count, const uint8_t* bytes, size_t size) {
    ty_bake_shared* shared = user;
    ty_bake_run* run = shared->run;
    bake_task task;
    const int64_t begin = first * TY_BAKE_BLOCK, end = receivers_end(run, first + count);
    if (first < 0 || first + count > shared->blocks.count ||
        size != sizeof task + (size_t)(end - begin) * sums_size(run))
        return;
    memcpy(&task, bytes, sizeof task);
    if (task.first != shared->first) return; /* of a pass before */
    for (int64_t b = first; b < first + count; ++b) {
        if (!ty_blocks_return(&shared->blocks, b)) continue;
        unpack_sums(run, bytes + sizeof task, begin, end - begin, b * TY_BAKE_BLOCK, receivers_end(run, b + 1));
        ty_blocks_settle(&shared->blocks);
    }
}

ty_result ty_bake_shared_open(ty_bake_shared* shared, ty_bake_run* run) {
    *shared = (ty_bake_shared){.run = run};
    ty_work_queue* queue = ty_context_queue(run->context);
    const int64_t blocks = (run->count + TY_BAKE_BLOCK - 1) / TY_BAKE_BLOCK;
    if (queue == NULL || blocks < 2) return TY_OK;
    bake_job job = {*run->def, run->count, run->request.terms, run->def->cache != NULL};
    job.def.tables = NULL;
    job.def.cache = NULL;
    job.def.progress = NULL;
    job.def.progress_user = NULL;
    const ty_job offered = {TY_JOB_BAKE, shared, lend, pack, accept};
    if (!ty_blocks_create(&shared->blocks, blocks)) return TY_ERROR_MEMORY;
    atomic_store(&shared->blocks.end, 0); /* until the first pass */
    shared->queue = queue;
    ty_buffer bytes = {.size = 0};
    ty_buffer_add(&bytes, &job, sizeof job);
    ty_buffer_add(&bytes, run->request.receivers,
                  emitting_receivers(run->def, run->count) * sizeof *run->request.receivers);
    if (!ty_queue_begin(queue, &offered, bytes.bytes, bytes.size)) shared->queue = NULL;
    free(bytes.bytes);
    return TY_OK;
}

void ty_bake_shared_close(ty_bake_shared* shared) {
    if (shared->queue != NULL) ty_queue_end(shared->queue);
    ty_blocks_destroy(&shared->blocks);
}

void ty_bake_shared_begin_pass(ty_bake_shared* shared, uint32_t first, uint32_t count) {
    shared->first = first;
    shared->count = count;
    if (shared->queue != NULL) ty_blocks_reset(&shared->blocks);
}

bool ty_bake_shared_take(ty_bake_shared* shared, int64_t block) {
    return shared->queue == NULL || ty_blocks_take(&shared->blocks, block);
}

static void sample_again(void* user, int64_t block, int32_t worker) {
    (void)worker;
    ty_bake_shared* shared = user;
    ty_bake_run* run = shared->run;
    if (ty_blocks_take_back(&shared->blocks, block))
        run->kernel(&run->request, block * TY_BAKE_BLOCK, receivers_end(run, block + 1), shared->first, shared->count,
                    run->sums, run->light);
}

void ty_bake_shared_end_pass(ty_bake_shared* shared) {
    if (shared->queue == NULL) return;
    const double begun = ty_wall_seconds();
    while (atomic_load(&shared->blocks.away) > 0) {
        const struct timespec pause = {.tv_nsec = 500000};
        nanosleep(&pause, NULL);
        if (ty_wall_seconds() - begun > ty_queue_patience(shared->queue))
            ty_parallel_for(shared->run->context, shared->blocks.count, sample_again, shared);
    }
}

/* ---- the other ranks ---- */

typedef struct bake_service {
    ty_bake_run run;
    ty_bake_receiver* receivers;
    int64_t count; /* of them */
} bake_service;

static void end_job(void* user) {
    bake_service* service = user;
    ty_context* context = service->run.context;
    ty_bake_run_end(&service->run);
    ty_free_array(context, service->receivers, (size_t)service->count, sizeof *service->receivers);
    free(service);
}

/* A run as that of rank 0, with the same virtual emitters. */
static ty_result begin_run(bake_service* service, const ty_bake_helper* helper, const bake_job* job) {
    ty_bake_run* run = &service->run;
    const ty_result result =
        ty_bake_run_begin(run, helper->scene, &job->def, service->receivers, job->count, job->terms);
    return result == TY_OK && ty_bake_impulse_emits(run) ? ty_bake_impulse_begin(run) : result;
}

/* A job with a cache is for ranks that have it. */
static bool begin_job(void* user, const uint8_t* bytes, size_t size, void** out) {
    const ty_bake_helper* helper = user;
    bake_job job;
    if (size < sizeof job) return false;
    memcpy(&job, bytes, sizeof job);
    const size_t emitting = emitting_receivers(&job.def, job.count) * sizeof(ty_bake_receiver);
    if (job.count < 0 || size != sizeof job + emitting || (job.cached != 0 && helper->cache == NULL)) return false;
    job.def.tables = helper->tables;
    bake_service* service = calloc(1, sizeof *service);
    if (service == NULL) return false;
    ty_context* context = ty_scene_context(helper->scene);
    if (job.cached != 0) job.def.cache = helper->cache;
    service->count = job.count;
    service->receivers = ty_alloc_array(context, (size_t)job.count, sizeof *service->receivers, true);
    if (service->receivers != NULL && emitting > 0) memcpy(service->receivers, bytes + sizeof job, emitting);
    if (service->receivers == NULL || begin_run(service, helper, &job) != TY_OK) {
        end_job(service);
        return false;
    }
    *out = service;
    return true;
}

/* Blocks of a task, from its first one on. */
typedef struct task_blocks {
    ty_bake_run* run;
    int64_t first;
    bake_task task;
} task_blocks;

static void sample_task(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const task_blocks* blocks = user;
    ty_bake_run* run = blocks->run;
    const int64_t block = blocks->first + index;
    run->kernel(&run->request, block * TY_BAKE_BLOCK, receivers_end(run, block + 1), blocks->task.first,
                blocks->task.count, run->sums, run->light);
}

static bool do_task(void* user, int64_t first, int64_t count, const uint8_t* bytes, size_t size, ty_buffer* out) {
    bake_service* service = user;
    ty_bake_run* run = &service->run;
    task_blocks blocks = {.run = run, .first = first};
    const int64_t begin = first * TY_BAKE_BLOCK, end = receivers_end(run, first + count);
    const size_t receivers = (size_t)(end - begin) * sizeof *service->receivers;
    if (first < 0 || begin >= end || size != sizeof blocks.task + receivers + (size_t)(end - begin) * sums_size(run))
        return false;
    memcpy(&blocks.task, bytes, sizeof blocks.task);
    memcpy(service->receivers + begin, bytes + sizeof blocks.task, receivers);
    unpack_sums(run, bytes + sizeof blocks.task + receivers, begin, end - begin, begin, end);
    ty_parallel_for(run->context, count, sample_task, &blocks);
    ty_buffer_add(out, &blocks.task, sizeof blocks.task);
    pack_sums(run, begin, end, out);
    return true;
}

ty_job_worker ty_bake_job_worker(ty_bake_helper* helper) {
    return (ty_job_worker){begin_job, do_task, end_job, helper};
}
