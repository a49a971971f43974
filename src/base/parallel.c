/* Parallel loops: indices are handed out one by one; results may depend on the index only, never on the worker. */
#include "base/context.h"

#include <pthread.h>
#include <stdatomic.h>

typedef struct loop {
    ty_parallel_fn body;
    void* user;
    int64_t count;
    _Atomic int64_t next;
} loop;

typedef struct worker {
    loop* loop;
    int32_t index;
    pthread_t thread;
} worker;

static void* work(void* argument) {
    const worker* self = argument;
    loop* shared = self->loop;
    for (;;) {
        const int64_t index = atomic_fetch_add_explicit(&shared->next, 1, memory_order_relaxed);
        if (index >= shared->count) return NULL;
        shared->body(shared->user, index, self->index);
    }
}

void ty_parallel_for(ty_context* context, int64_t count, ty_parallel_fn body, void* user) {
    loop shared = {.body = body, .user = user, .count = count};
    atomic_init(&shared.next, 0);
    int32_t threads = ty_context_threads(context);
    if (threads > count) threads = count < 1 ? 1 : (int32_t)count;
    worker first = {.loop = &shared, .index = 0};
    worker others[TY_THREADS_MAX - 1];
    int32_t started = 0;
    for (int32_t i = 0; i < threads - 1; ++i) {
        others[i] = (worker){.loop = &shared, .index = i + 1};
        if (pthread_create(&others[i].thread, NULL, work, &others[i]) != 0) break;
        ++started;
    }
    work(&first);
    for (int32_t i = 0; i < started; ++i) pthread_join(others[i].thread, NULL);
}
