/* Receivers as tasks of several ranks (comm/queue.h). */
#ifndef TY_BAKE_RECEIVERS_DISTRIBUTED_H
#define TY_BAKE_RECEIVERS_DISTRIBUTED_H

#include "bake/gather/run.h"
#include "comm/blocks.h"
#include "comm/queue.h"

/* Receivers that are sampled together. */
enum { TY_BAKE_BLOCK = 8 };

/* A run of rank 0 that others help with; queue NULL: it is alone, and every block is its own. */
typedef struct ty_bake_shared {
    ty_bake_run* run;
    ty_work_queue* queue;
    ty_blocks blocks;
    uint32_t first, count; /* samples of the pass */
} ty_bake_shared;

/* Offers the run to other ranks, if there are any. Errors: TY_ERROR_MEMORY. */
ty_result ty_bake_shared_open(ty_bake_shared* shared, ty_bake_run* run);
void ty_bake_shared_close(ty_bake_shared* shared);
/* A pass of samples [first, first + count), and its end, which waits for the other ranks. */
void ty_bake_shared_begin_pass(ty_bake_shared* shared, uint32_t first, uint32_t count);
void ty_bake_shared_end_pass(ty_bake_shared* shared);
/* True if the block is this rank's. */
bool ty_bake_shared_take(ty_bake_shared* shared, int64_t block);

/* The worker of TY_JOB_BAKE on other ranks. Scene, cache and tables are those of rank 0, and stay the caller's. */
typedef struct ty_bake_helper {
    const ty_scene* scene;
    const ty_bake_cache* cache; /* NULL: none */
    const ty_impulse* tables;   /* NULL: none */
} ty_bake_helper;
ty_job_worker ty_bake_job_worker(ty_bake_helper* helper);

#endif
