/* Ranks that are threads of this program, with mailboxes in place of MPI. */
#ifndef TY_TESTS_RANKS_H
#define TY_TESTS_RANKS_H

#include "comm/comm.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RANKS_MAX = 8, BOX = 4096 };

typedef struct letter {
    ty_comm_message message;
    uint8_t* bytes;
} letter;

/* Letters to a receiver, in order: messages, and transfers. */
typedef struct mailbox {
    letter letters[BOX];
    int count;
} mailbox;

static pthread_mutex_t box_lock = PTHREAD_MUTEX_INITIALIZER;
static mailbox box_messages[RANKS_MAX], box_transfers[RANKS_MAX];
static int32_t box_ranks = 1;          /* that are started together */
static _Thread_local int32_t own_rank; /* 0 also in the thread of messages */

static bool box_open(int32_t* rank, int32_t* size) {
    *rank = own_rank;
    *size = box_ranks;
    return true;
}

static bool box_drop(mailbox* box, int32_t tag, const void* bytes, size_t size) {
    pthread_mutex_lock(&box_lock);
    const bool room = box->count < BOX;
    if (room) {
        letter* at = &box->letters[box->count++];
        *at = (letter){{own_rank, tag, size}, malloc(size + 1)};
        if (size > 0) memcpy(at->bytes, bytes, size);
    }
    pthread_mutex_unlock(&box_lock);
    return room;
}

/* Under the lock. */
static void box_take(mailbox* box, int i, void* bytes) {
    letter* at = &box->letters[i];
    if (at->message.size > 0) memcpy(bytes, at->bytes, at->message.size);
    free(at->bytes);
    memmove(at, at + 1, (size_t)(--box->count - i) * sizeof *at);
}

static bool box_send(int32_t to, int32_t tag, const void* bytes, size_t size) {
    return box_drop(&box_messages[to], tag, bytes, size);
}

static bool box_probe(ty_comm_message* out) {
    pthread_mutex_lock(&box_lock);
    const bool there = box_messages[own_rank].count > 0;
    if (there) *out = box_messages[own_rank].letters[0].message;
    pthread_mutex_unlock(&box_lock);
    return there;
}

static bool box_receive(const ty_comm_message* message, void* bytes) {
    (void)message; /* the one that box_probe saw */
    pthread_mutex_lock(&box_lock);
    box_take(&box_messages[own_rank], 0, bytes);
    pthread_mutex_unlock(&box_lock);
    return true;
}

/* Receives of a thread's rank under way, in the order in which they were posted, in which they are matched. */
static _Thread_local ty_comm_transfer* box_wanted[BOX];
static _Thread_local int box_wanted_count;

static bool box_post(ty_comm_transfer* t) {
    if (!t->receives) {
        t->done = box_drop(&box_transfers[t->rank], t->tag, t->bytes, t->size);
        return t->done;
    }
    if (box_wanted_count == BOX) return false;
    box_wanted[box_wanted_count++] = t;
    return true;
}

static bool box_test(ty_comm_transfer* t) {
    mailbox* box = &box_transfers[own_rank];
    bool good = true;
    int at = 0;
    while (box_wanted[at]->rank != t->rank || box_wanted[at]->tag != t->tag) ++at;
    if (box_wanted[at] != t) return true; /* another one comes first */
    pthread_mutex_lock(&box_lock);
    for (int i = 0; i < box->count && !t->done; ++i) {
        const ty_comm_message* m = &box->letters[i].message;
        if (m->from != t->rank || m->tag != t->tag) continue;
        t->done = true;
        good = m->size == t->size;
        if (good) box_take(box, i, t->bytes);
    }
    pthread_mutex_unlock(&box_lock);
    if (t->done) memmove(&box_wanted[at], &box_wanted[at + 1], (size_t)(--box_wanted_count - at) * sizeof *box_wanted);
    return good;
}

static void box_close(void) {
}

static const ty_comm_backend box_backend = {
    TY_COMM_BACKEND_VERSION, box_open, box_send, box_probe, box_receive, box_post, box_test, box_close, exit};

/* ---- a function on all ranks ---- */

typedef struct rank_thread {
    pthread_t thread;
    int32_t rank;
    double seconds; /* patience */
    void (*body)(ty_comm* comm, void* user);
    void* user;
} rank_thread;

static void* run_rank(void* user) {
    const rank_thread* r = user;
    ty_comm* comm = NULL;
    own_rank = r->rank;
    if (box_ranks > 1 && ty_comm_join(&box_backend, r->seconds, r->rank, &comm) != TY_OK) abort();
    r->body(comm, r->user);
    ty_comm_close(comm, ty_comm_lost(comm) < 0, 0);
    return NULL;
}

/* Runs a body as so many ranks at once; of one rank the comm is NULL. */
static inline void run_ranks_for(int32_t count, double seconds, void (*body)(ty_comm* comm, void* user), void* user) {
    rank_thread ranks[RANKS_MAX];
    box_ranks = count;
    for (int32_t i = 0; i < count; ++i) {
        ranks[i] = (rank_thread){.rank = i, .seconds = seconds, .body = body, .user = user};
        if (pthread_create(&ranks[i].thread, NULL, run_rank, &ranks[i]) != 0) abort();
    }
    for (int32_t i = 0; i < count; ++i) pthread_join(ranks[i].thread, NULL);
}

static inline void run_ranks(int32_t count, void (*body)(ty_comm* comm, void* user), void* user) {
    run_ranks_for(count, 60, body, user);
}

/* In a body, where cmocka's assertions would leave the thread. */
#define require(condition)                                                                                             \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            fprintf(stderr, "%s:%d: rank %d: %s is false\n", __FILE__, __LINE__, (int)own_rank, #condition);           \
            abort();                                                                                                   \
        }                                                                                                              \
    } while (0)

#endif
