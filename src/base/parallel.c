#include "base/parallel.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "base/mapping.h"
#include "base/thread_pool.h"

typedef struct bounded {
    ty_context* context;
    ty_parallel_fn body;
    void* user;
} bounded;

/* Between two bodies, as the mappings of files have no other place where pages are taken out. */
static void run_bounded(void* user, int64_t index, int32_t worker) {
    const bounded* loop = user;
    loop->body(loop->user, index, worker);
    ty_mappings_trim(loop->context);
}

void ty_parallel_for(ty_context* context, int64_t count, ty_parallel_fn body, void* user) {
    bounded loop = {context, body, user};
    if (ty_mappings_are_bounded(context))
        ty_thread_pool_run(ty_context_pool(context), count, run_bounded, &loop);
    else
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
