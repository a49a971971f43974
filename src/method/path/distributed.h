/* The path tracer's tasks on ranks other than rank 0. */
#ifndef TY_PATH_DISTRIBUTED_H
#define TY_PATH_DISTRIBUTED_H

#include "comm/queue.h"

#include <tyndall/path.h>

/* The worker of TY_JOB_PATH for a scene, which is that of rank 0; tasks stop once progress returns false. The scene
 * stays the caller's. */
typedef struct ty_path_helper {
    const ty_scene* scene;
    ty_progress_fn progress;
    void* progress_user;
} ty_path_helper;
ty_job_worker ty_path_job_worker(ty_path_helper* helper);

#endif
