/* Passes under way over a run's items: what sample.c and device_pass.c share. */
#ifndef TY_PATH_SAMPLING_H
#define TY_PATH_SAMPLING_H

#include "comm/blocks.h"
#include "comm/queue.h"
#include "method/path/device.h"
#include "method/path/driver.h"

#include <pthread.h>
#include <stdatomic.h>

typedef struct ty_sampling {
    ty_path_run* run;
    ty_path_request odd;  /* runs with halves: the request of odd samples */
    uint32_t last;        /* samples of each item after this pass */
    uint32_t done_before; /* samples of each item before this pass */
    double begun;         /* start time as if the work had been done in one go */
    double cpu_begun;     /* the same in processor seconds */
    pthread_mutex_t lock; /* serialises reports and saved states, so that callbacks never overlap */
    double reported;
    pthread_rwlock_t items; /* read-locked while blocks are merged concurrently, write-locked while a state is copied */
    uint64_t vertices_before;    /* this run */
    uint32_t launch_paths;       /* paths of one launch, that take about TY_DEVICE_LAUNCH_SECONDS */
    uint8_t* state;              /* NULL: no state is saved */
    uint32_t* saved_counts;      /* samples of each block in the saved state */
    bool whole_due;              /* the next state is a whole one */
    size_t changes_size;         /* bytes of changes since the last whole state */
    double saved;                /* time of the last saved state: when copying it began */
    double state_period;         /* seconds until the next one */
    double shown;                /* time of the last partial image */
    double partial_period;       /* seconds until the next one */
    _Atomic int64_t blocks_done; /* blocks of this pass */
    _Atomic uint64_t vertices, paths;
    _Atomic uint32_t stride; /* paths that take about stride_seconds */
    _Atomic bool cancelled, out_of_time;
    ty_path_device* device; /* NULL: the processor traces */
    ty_work_queue* queue;   /* other ranks help; NULL: they do not, or there are none */
    ty_blocks blocks;       /* of a pass, with a queue */
    ty_result failed;       /* of the device */
} ty_sampling;

/* Range of a block in progress: samples of its items, not yet merged. */
typedef struct ty_block_work {
    int64_t begin, end;
    uint32_t first, count; /* samples */
    uint64_t vertices;
    ty_path_sums sums[TY_PATH_BLOCK];
    ty_path_aov_sums aov_sums[TY_PATH_BLOCK];
} ty_block_work;

/* A run's sampling, from its statistics on, with its locks; closing frees these. */
void ty_sampling_open(ty_sampling* pass, ty_path_run* run);
void ty_sampling_close(ty_sampling* pass);
int64_t ty_sampling_blocks(const ty_path_run* run);
/* Reports progress if due; sets cancelled if the caller asks for it. */
void ty_sampling_report(ty_sampling* pass, bool always);
/* Saves the state if due, and hands out the image so far if due. */
void ty_sampling_save(ty_sampling* pass, bool always);
void ty_sampling_show(ty_sampling* pass);
/* The time bound applies only once every item has a sample. */
bool ty_sampling_stops(ty_sampling* pass);
/* Adds the samples of a block to the run's items. */
void ty_sampling_merge(ty_sampling* pass, const ty_block_work* work);

/* Adds samples to a block until it has pass->last of them. */
void ty_sampling_block(ty_sampling* pass, int64_t block);

/* ---- shared.c ---- */

/* Offers the run to other ranks, if there are any and they can trace it. Errors: TY_ERROR_MEMORY. */
ty_result ty_sampling_distribute(ty_sampling* pass);
void ty_sampling_end_queue(ty_sampling* pass);
/* One pass of this rank and the others. */
void ty_sample_pass_shared(ty_sampling* pass);

/* One pass on the device. On its failure pass->failed is set. */
void ty_sample_pass_on_device(ty_sampling* pass);

#endif
