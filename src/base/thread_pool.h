/* A pool of threads for parallel loops. */
#ifndef TY_BASE_THREAD_POOL_H
#define TY_BASE_THREAD_POOL_H

#include "base/thread_errors.h"

#include <tyndall/base.h>

#include <pthread.h>
#include <stdatomic.h>

/* A loop whose indices are handed out one by one. */
typedef struct ty_loop {
    ty_parallel_fn body;
    void* user;
    int64_t count;
    _Atomic int64_t next;
    ty_thread_errors* errors; /* messages of the thread that waits for the loop */
} ty_loop;

struct ty_thread_pool;

typedef struct ty_pool_thread {
    struct ty_thread_pool* pool;
    int32_t index; /* of the worker, from 1 on; 0 is the calling thread */
    pthread_t thread;
} ty_pool_thread;

/* Threads that wait for loops. They start with the first loop that has work for them. */
typedef struct ty_thread_pool {
    pthread_mutex_t busy; /* held by the loop that has the pool */
    pthread_mutex_t lock; /* guards the fields below */
    pthread_cond_t wake, finished;
    ty_loop* loop;           /* the current one, as long as it has work to hand out; else NULL */
    _Atomic uint64_t epoch;  /* number of loops so far */
    int32_t members;         /* threads that the current loop has use for, beside the caller */
    _Atomic int32_t working; /* members that have begun and not finished */
    int32_t started;         /* threads there are */
    int32_t wanted;          /* threads there may be */
    bool spins;              /* threads spin for a while before they sleep */
    bool ends;
    ty_pool_thread* threads; /* wanted of them */
} ty_thread_pool;

/* threads: room for `wanted` of them. spins: there is a processor for each of them and the caller. */
void ty_thread_pool_create(ty_thread_pool* pool, ty_pool_thread* threads, int32_t wanted, bool spins);
/* Waits for the threads to end. */
void ty_thread_pool_destroy(ty_thread_pool* pool);
/* Runs a loop with the caller and up to count - 1 threads. */
void ty_thread_pool_run(ty_thread_pool* pool, int64_t count, ty_parallel_fn body, void* user);

#endif
