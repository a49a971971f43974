/* The threads of a context. */
#ifndef TY_BASE_PARALLEL_H
#define TY_BASE_PARALLEL_H

#include "base/thread_errors.h"

#include <tyndall/base.h>

#include <pthread.h>
#include <stdatomic.h>

/* A loop in work. */
typedef struct ty_loop {
    ty_parallel_fn body;
    void* user;
    int64_t count;
    _Atomic int64_t next;
    ty_thread_errors* errors; /* messages of the thread that waits for the loop */
} ty_loop;

struct ty_team;

typedef struct ty_team_member {
    struct ty_team* team;
    int32_t index; /* as a worker, from 1 on; 0 is whoever calls */
    pthread_t thread;
} ty_team_member;

/* Threads that wait for loops. They start with the first loop that has work for them. */
typedef struct ty_team {
    pthread_mutex_t turn; /* held by the loop that has the team */
    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t called, finished;
    ty_loop* loop;           /* the current one, as long as it has work to hand out; else NULL */
    _Atomic uint64_t calls;  /* how many loops there were */
    int32_t members;         /* that the current loop has use for, beside the caller */
    _Atomic int32_t working; /* of them, those that have begun and not finished */
    int32_t started;         /* threads there are */
    int32_t wanted;          /* threads there may be */
    bool watches;            /* whether threads look out for a while before they sleep */
    bool ends;
    ty_team_member* threads; /* wanted of them */
} ty_team;

/* threads: room for `wanted` members. watches: there is a processor for each of them and the caller. */
void ty_team_create(ty_team* team, ty_team_member* threads, int32_t wanted, bool watches);
/* Waits for the threads to end. */
void ty_team_destroy(ty_team* team);
/* ty_parallel_for with denormals off (base/float_mode.h); without a context in the calling thread alone. */
void ty_parallel_flushed(ty_context* context, int64_t count, ty_parallel_fn body, void* user);

/* Runs the loop with the caller and up to count - 1 threads. */
void ty_team_run(ty_team* team, ty_loop* loop);

#endif
