#define _GNU_SOURCE
#include "comm/state.h"

#include "base/context.h"

#include <dlfcn.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* The shortest and the longest sleep between two looks for a message, seconds. */
static const double sleep_shortest = 2e-5, sleep_longest = 2e-3;
/* The longest wait for a transfer, in units of that for a rank to join. */
static const double patience_factor = 5;
/* The longest wait for the others at the end, seconds. */
static const double leave_seconds = 10;

/* Variables in which launchers tell the rank and the number of ranks: Open MPI's mpirun, and those that speak PMI. */
static const char* const rank_names[] = {"OMPI_COMM_WORLD_RANK", "PMI_RANK"};
static const char* const size_names[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"};

bool ty_comm_launched(int32_t* rank, int32_t* size) {
    for (int i = 0; i < 2; ++i) {
        const char *own = getenv(rank_names[i]), *all = getenv(size_names[i]);
        if (own == NULL || all == NULL) continue;
        *rank = (int32_t)strtol(own, NULL, 10);
        *size = (int32_t)strtol(all, NULL, 10);
        return *size > 1 && *rank >= 0 && *rank < *size;
    }
    *rank = 0;
    *size = 1;
    return false;
}

void ty_comm_sleep(double seconds) {
    struct timespec time = {.tv_nsec = (long)(1e9 * seconds)};
    nanosleep(&time, NULL);
}

/* ---- joining ---- */

/* A library that waits for a rank that never comes does so for ever. */
typedef struct watch {
    double seconds;
    const char* message; /* of the end, a format with the seconds; NULL: none */
    int status;
    pthread_t thread;
    bool started;
    _Atomic bool done;
} watch;

static void* run_watch(void* user) {
    watch* w = user;
    const double begun = ty_wall_seconds();
    while (!atomic_load(&w->done)) {
        ty_comm_sleep(0.01);
        if (ty_wall_seconds() - begun < w->seconds || atomic_load(&w->done)) continue;
        if (w->message != NULL) fprintf(stderr, "tyndall: %s within %g s\n", w->message, w->seconds);
        fflush(stdout);
        _exit(w->status);
    }
    return NULL;
}

static void begin_watch(watch* w) {
    w->started = pthread_create(&w->thread, NULL, run_watch, w) == 0;
}

static void end_watch(watch* w) {
    atomic_store(&w->done, true);
    if (w->started) pthread_join(w->thread, NULL);
}

static bool join(ty_comm* comm, double seconds, int32_t rank) {
    watch w = {.seconds = seconds, .status = 2};
    if (rank == 0) w.message = "a rank is missing: not all that were started together have joined";
    begin_watch(&w);
    const bool joined = comm->backend->open(&comm->rank, &comm->size);
    end_watch(&w);
    return joined;
}

static ty_comm* create(const ty_comm_backend* backend) {
    ty_comm* comm = calloc(1, sizeof *comm);
    if (comm == NULL) return NULL;
    comm->backend = backend;
    comm->size = 1;
    comm->lost = -1;
    pthread_mutex_init(&comm->lock, NULL);
    return comm;
}

ty_result ty_comm_join(const ty_comm_backend* backend, double seconds, int32_t rank, ty_comm** out) {
    ty_comm* comm = create(backend);
    if (comm == NULL) return TY_ERROR_MEMORY;
    comm->patience = patience_factor * seconds;
    if (join(comm, seconds, rank)) {
        *out = comm;
        return TY_OK;
    }
    pthread_mutex_destroy(&comm->lock);
    free(comm);
    *out = NULL;
    return ty_fail(NULL, TY_ERROR_UNSUPPORTED, "MPI does not start");
}

ty_result ty_comm_open(const char* module, double seconds, ty_comm** out) {
    int32_t rank, size;
    *out = NULL;
    if (!ty_comm_launched(&rank, &size)) return TY_OK;
    /* Open MPI's own plug-ins look for its symbols among the global ones. */
    void* handle = module != NULL ? dlopen(module, RTLD_NOW | RTLD_GLOBAL) : NULL;
    const ty_comm_backend* backend = handle != NULL ? dlsym(handle, TY_COMM_BACKEND_SYMBOL) : NULL;
    if (module == NULL)
        return ty_fail(NULL, TY_ERROR_UNSUPPORTED, "%d processes were started together, and this build has no MPI",
                       (int)size);
    if (backend == NULL || backend->version != TY_COMM_BACKEND_VERSION)
        return ty_fail(NULL, TY_ERROR_UNSUPPORTED, "%s cannot be loaded: %s", module,
                       handle == NULL ? dlerror() : "it is of another build");
    return ty_comm_join(backend, seconds, rank, out);
}

static void close_planned(void) {
}

ty_comm* ty_comm_plan(int32_t ranks) {
    static const ty_comm_backend planned = {.version = TY_COMM_BACKEND_VERSION, .close = close_planned};
    ty_comm* comm = ranks > 1 ? create(&planned) : NULL;
    if (comm != NULL) comm->size = ranks;
    return comm;
}

void ty_comm_close(ty_comm* comm, bool all, int status) {
    if (comm == NULL) return;
    watch w = {.seconds = leave_seconds, .status = status};
    begin_watch(&w);
    ty_comm_end_puts(comm, all);
    if (all) comm->backend->close();
    end_watch(&w);
    pthread_mutex_destroy(&comm->lock);
    free(comm);
}

int32_t ty_comm_rank(const ty_comm* comm) {
    return comm != NULL ? comm->rank : 0;
}

int32_t ty_comm_size(const ty_comm* comm) {
    return comm != NULL ? comm->size : 1;
}

/* ---- messages ---- */

void ty_comm_count_message(ty_comm* comm, size_t size) {
    comm->traffic.messages += 1;
    comm->traffic.bytes += size;
}

bool ty_comm_send(ty_comm* comm, int32_t to, int32_t tag, const void* bytes, size_t size) {
    pthread_mutex_lock(&comm->lock);
    const bool sent = comm->backend->send(to, tag, bytes, size);
    if (sent) ty_comm_count_message(comm, size);
    pthread_mutex_unlock(&comm->lock);
    return sent;
}

bool ty_comm_wait(ty_comm* comm, double seconds, ty_comm_message* out) {
    const double begun = ty_wall_seconds();
    double pause = sleep_shortest;
    for (;;) {
        pthread_mutex_lock(&comm->lock);
        const bool found = comm->backend->probe(out);
        pthread_mutex_unlock(&comm->lock);
        if (found) return true;
        const double left = seconds - (ty_wall_seconds() - begun);
        if (left <= 0) return false;
        ty_comm_sleep(pause < left ? pause : left);
        if (pause < sleep_longest) pause *= 2;
    }
}

bool ty_comm_receive(ty_comm* comm, const ty_comm_message* message, void* bytes) {
    pthread_mutex_lock(&comm->lock);
    const bool good = comm->backend->receive(message, bytes);
    if (good) ty_comm_count_message(comm, message->size);
    pthread_mutex_unlock(&comm->lock);
    return good;
}

void ty_comm_abort(ty_comm* comm, int status) {
    comm->backend->abort(status);
    _exit(status);
}

ty_comm_traffic ty_comm_get_traffic(const ty_comm* comm) {
    return comm != NULL ? comm->traffic : (ty_comm_traffic){0, 0};
}
