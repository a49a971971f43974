/* Parallel loops: indices are handed out one by one; results may depend on the index only, never on the worker.
 *
 * The threads of a context wait between loops, since starting them takes longer than a short loop. A loop that begins
 * while another has them (from a body, or from another thread of the caller's) runs in its own thread alone: the
 * context's processors are at work already. */
#include "base/parallel.h"

#include "base/float_mode.h"

/* Looks before a thread sleeps, some tens of microseconds: it takes about as long to wake one up, and longer than many
 * loops do, which often follow each other at once. */
enum { LOOKS = 2000 };

/* Between two looks. */
static void pause_shortly(void) {
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
}

/* Until there is a loop after so many, or for a while. */
static void look_for_loop(ty_team* team, uint64_t seen) {
    for (int i = 0; i < LOOKS && atomic_load_explicit(&team->calls, memory_order_relaxed) == seen; ++i) pause_shortly();
}

/* Until all members have finished, or for a while. */
static void look_for_end(ty_team* team) {
    for (int i = 0; i < LOOKS && atomic_load_explicit(&team->working, memory_order_relaxed) > 0; ++i) pause_shortly();
}

static void work(ty_loop* loop, int32_t worker) {
    for (;;) {
        const int64_t index = atomic_fetch_add_explicit(&loop->next, 1, memory_order_relaxed);
        if (index >= loop->count) return;
        loop->body(loop->user, index, worker);
    }
}

static void* wait_for_loops(void* argument) {
    const ty_team_member* self = argument;
    ty_team* team = self->team;
    uint64_t seen = 0;
    for (;;) {
        if (team->watches) look_for_loop(team, seen);
        pthread_mutex_lock(&team->lock);
        while (!team->ends && (team->loop == NULL || team->calls == seen || self->index > team->members))
            pthread_cond_wait(&team->called, &team->lock);
        if (team->ends) break;
        seen = team->calls;
        ty_loop* loop = team->loop;
        ++team->working;
        pthread_mutex_unlock(&team->lock);
        ty_errors_work_for(loop->errors);
        work(loop, self->index);
        pthread_mutex_lock(&team->lock);
        if (--team->working == 0) pthread_cond_signal(&team->finished);
        pthread_mutex_unlock(&team->lock);
    }
    pthread_mutex_unlock(&team->lock);
    return NULL;
}

void ty_team_create(ty_team* team, ty_team_member* threads, int32_t wanted, bool watches) {
    *team = (ty_team){.threads = threads, .wanted = wanted, .watches = watches};
    pthread_mutex_init(&team->turn, NULL);
    pthread_mutex_init(&team->lock, NULL);
    pthread_cond_init(&team->called, NULL);
    pthread_cond_init(&team->finished, NULL);
}

void ty_team_destroy(ty_team* team) {
    pthread_mutex_lock(&team->lock);
    team->ends = true;
    pthread_cond_broadcast(&team->called);
    pthread_mutex_unlock(&team->lock);
    for (int32_t i = 0; i < team->started; ++i) pthread_join(team->threads[i].thread, NULL);
    pthread_cond_destroy(&team->called);
    pthread_cond_destroy(&team->finished);
    pthread_mutex_destroy(&team->lock);
    pthread_mutex_destroy(&team->turn);
}

/* As many threads as the loop has use for, if the system gives them. */
static int32_t start_threads(ty_team* team, int64_t useful) {
    const int32_t members = useful < team->wanted ? (int32_t)useful : team->wanted;
    while (team->started < members) {
        ty_team_member* member = &team->threads[team->started];
        *member = (ty_team_member){.team = team, .index = team->started + 1};
        if (pthread_create(&member->thread, NULL, wait_for_loops, member) != 0) return team->started;
        ++team->started;
    }
    return members;
}

void ty_team_run(ty_team* team, ty_loop* loop) {
    const bool alone = loop->count < 2 || team->wanted < 1 || pthread_mutex_trylock(&team->turn) != 0;
    if (alone) {
        work(loop, 0);
        return;
    }
    pthread_mutex_lock(&team->lock);
    team->members = start_threads(team, loop->count - 1);
    team->loop = loop;
    ++team->calls;
    pthread_cond_broadcast(&team->called);
    pthread_mutex_unlock(&team->lock);
    work(loop, 0);
    pthread_mutex_lock(&team->lock);
    team->loop = NULL; /* whoever has not woken up by now finds nothing to do, and is not waited for */
    pthread_mutex_unlock(&team->lock);
    if (team->watches) look_for_end(team);
    pthread_mutex_lock(&team->lock);
    while (team->working > 0) pthread_cond_wait(&team->finished, &team->lock);
    pthread_mutex_unlock(&team->lock);
    pthread_mutex_unlock(&team->turn);
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
