/* Results may depend on a loop's index only, never on the worker.
 *
 * The threads of a pool wait between loops, since starting them takes longer than a short loop. A loop that begins
 * while another has the pool (from a body, or from another thread of the caller's) runs in its own thread alone: the
 * processors are at work already. */
#include "base/thread_pool.h"

/* Iterations before a thread sleeps, some tens of microseconds: it takes about as long to wake one up, and longer than
 * many loops do, which often follow each other at once. */
enum { SPIN_COUNT = 2000 };

static void pause_shortly(void) {
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
}

/* Until a loop begins after this epoch, or for a while. */
static void spin_for_loop(ty_thread_pool* pool, uint64_t epoch) {
    for (int i = 0; i < SPIN_COUNT && atomic_load_explicit(&pool->epoch, memory_order_relaxed) == epoch; ++i)
        pause_shortly();
}

/* Until all members have finished, or for a while. */
static void spin_for_end(ty_thread_pool* pool) {
    for (int i = 0; i < SPIN_COUNT && atomic_load_explicit(&pool->working, memory_order_relaxed) > 0; ++i)
        pause_shortly();
}

static void work(ty_loop* loop, int32_t worker) {
    for (;;) {
        const int64_t index = atomic_fetch_add_explicit(&loop->next, 1, memory_order_relaxed);
        if (index >= loop->count) return;
        loop->body(loop->user, index, worker);
    }
}

static void* wait_for_loops(void* argument) {
    const ty_pool_thread* self = argument;
    ty_thread_pool* pool = self->pool;
    uint64_t epoch = 0;
    for (;;) {
        if (pool->spins) spin_for_loop(pool, epoch);
        pthread_mutex_lock(&pool->lock);
        while (!pool->ends && (pool->loop == NULL || pool->epoch == epoch || self->index > pool->members))
            pthread_cond_wait(&pool->wake, &pool->lock);
        if (pool->ends) break;
        epoch = pool->epoch;
        ty_loop* loop = pool->loop;
        ++pool->working;
        pthread_mutex_unlock(&pool->lock);
        ty_errors_work_for(loop->errors);
        work(loop, self->index);
        pthread_mutex_lock(&pool->lock);
        if (--pool->working == 0) pthread_cond_signal(&pool->finished);
        pthread_mutex_unlock(&pool->lock);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

void ty_thread_pool_create(ty_thread_pool* pool, ty_pool_thread* threads, int32_t wanted, bool spins) {
    *pool = (ty_thread_pool){.threads = threads, .wanted = wanted, .spins = spins};
    pthread_mutex_init(&pool->busy, NULL);
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->wake, NULL);
    pthread_cond_init(&pool->finished, NULL);
}

void ty_thread_pool_destroy(ty_thread_pool* pool) {
    pthread_mutex_lock(&pool->lock);
    pool->ends = true;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->lock);
    for (int32_t i = 0; i < pool->started; ++i) pthread_join(pool->threads[i].thread, NULL);
    pthread_cond_destroy(&pool->wake);
    pthread_cond_destroy(&pool->finished);
    pthread_mutex_destroy(&pool->lock);
    pthread_mutex_destroy(&pool->busy);
}

/* As many threads as the loop has use for, if the system gives them. */
static int32_t start_threads(ty_thread_pool* pool, int64_t useful) {
    const int32_t members = useful < pool->wanted ? (int32_t)useful : pool->wanted;
    while (pool->started < members) {
        ty_pool_thread* thread = &pool->threads[pool->started];
        *thread = (ty_pool_thread){.pool = pool, .index = pool->started + 1};
        if (pthread_create(&thread->thread, NULL, wait_for_loops, thread) != 0) return pool->started;
        ++pool->started;
    }
    return members;
}

void ty_thread_pool_run(ty_thread_pool* pool, int64_t count, ty_parallel_fn body, void* user) {
    ty_loop loop = {.body = body, .user = user, .count = count, .errors = ty_errors_current()};
    atomic_init(&loop.next, 0);
    const bool serial = count < 2 || pool->wanted < 1 || pthread_mutex_trylock(&pool->busy) != 0;
    if (serial) {
        work(&loop, 0);
        return;
    }
    pthread_mutex_lock(&pool->lock);
    pool->members = start_threads(pool, count - 1);
    pool->loop = &loop;
    ++pool->epoch;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->lock);
    work(&loop, 0);
    pthread_mutex_lock(&pool->lock);
    pool->loop = NULL; /* a thread that has not woken up by now finds nothing to do, and is not waited for */
    pthread_mutex_unlock(&pool->lock);
    if (pool->spins) spin_for_end(pool);
    pthread_mutex_lock(&pool->lock);
    while (pool->working > 0) pthread_cond_wait(&pool->finished, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
    pthread_mutex_unlock(&pool->busy);
}
