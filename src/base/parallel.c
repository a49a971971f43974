#include "base/parallel.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "base/thread_pool.h"

void ty_parallel_for(ty_context* context, int64_t count, ty_parallel_fn body, void* user) {
    ty_thread_pool_run(ty_context_pool(context), count, body, user);
}

typedef struct flushed {
    ty_parallel_fn body;
    void* user;
} flushed;

static void run_flushed(void* user, int64_t index, int32_t worker) {
    const flushed* loop = user;
    const unsigned state = ty_flush_denormals();
    loop->body(loop->user, index, worker);
    ty_restore_denormals(state);
}

void ty_parallel_flushed(ty_context* context, int64_t count, ty_parallel_fn body, void* user) {
    flushed loop = {body, user};
    if (context != NULL) {
        ty_parallel_for(context, count, run_flushed, &loop);
        return;
    }
    const unsigned state = ty_flush_denormals();
    for (int64_t i = 0; i < count; ++i) body(user, i, 0);
    ty_restore_denormals(state);
}
