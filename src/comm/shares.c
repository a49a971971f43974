/* Rank 0's side of shares. */
#define _GNU_SOURCE
#include "comm/protocol.h"

#include "base/context.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Target duration of a share, and the longest wait for ranks at the end of the command, seconds. */
static const double share_seconds = 0.2, farewell_seconds = 5;
/* How long a rank may take for a share: at least so long, and so many times the longest share. */
static const double patience_shortest = 1, patience_factor = 4;

enum { ITEMS_MAX = 1 << 16 };

/* FREE: waits for a job. ASKS: waits for a share. BUSY: will ask. GONE: receives no messages. */
typedef enum rank_state { FREE, ASKS, BUSY, GONE } rank_state;

/* Another rank, as rank 0 knows it. */
typedef struct other_rank {
    rank_state state;
    int64_t items; /* of its next share */
} other_rank;

struct ty_shares {
    ty_comm* comm;
    other_rank* others; /* by rank; that of rank 0 is not used */
    ty_job job;
    uint64_t number; /* of the current job, or of the last one */
    ty_buffer head;  /* the message that describes the job */
    ty_buffer in, out;
    pthread_t thread;
    _Atomic bool begun; /* a job is under way; another thread of the command may begin one */
    _Atomic bool over;
    _Atomic double longest; /* seconds of the longest share */
};

/* ---- messages ---- */

void ty_buffer_add(ty_buffer* buffer, const void* bytes, size_t size) {
    if (buffer->capacity - buffer->size < size) {
        const size_t capacity = 2 * buffer->capacity + size;
        uint8_t* grown = realloc(buffer->bytes, capacity);
        if (grown == NULL) {
            fputs("tyndall: not enough memory for a message to another rank\n", stderr);
            abort();
        }
        buffer->bytes = grown;
        buffer->capacity = capacity;
    }
    if (size > 0) memcpy(buffer->bytes + buffer->size, bytes, size);
    buffer->size += size;
}

bool ty_message_take(ty_comm* comm, const ty_comm_message* message, ty_buffer* buffer, ty_message_head* head) {
    buffer->size = 0;
    if (buffer->capacity < message->size) {
        free(buffer->bytes);
        *buffer = (ty_buffer){.bytes = malloc(message->size)};
        if (buffer->bytes == NULL) ty_comm_abort(comm, 1);
        buffer->capacity = message->size;
    }
    if (!ty_comm_receive(comm, message, buffer->bytes) || message->size < sizeof *head) return false;
    buffer->size = message->size;
    memcpy(head, buffer->bytes, sizeof *head);
    return true;
}

bool ty_message_send(ty_comm* comm, int32_t to, int32_t tag, const ty_message_head* head, const void* bytes,
                     size_t size) {
    ty_buffer message = {.size = 0};
    ty_buffer_add(&message, head, sizeof *head);
    ty_buffer_add(&message, bytes, size);
    const bool sent = ty_comm_send(comm, to, tag, message.bytes, message.size);
    free(message.bytes);
    return sent;
}

/* ---- the ranks ---- */

ty_shares* ty_shares_create(ty_comm* comm) {
    ty_shares* shares = calloc(1, sizeof *shares);
    if (shares == NULL) return NULL;
    shares->comm = comm;
    shares->others = calloc((size_t)ty_comm_size(comm), sizeof *shares->others);
    for (int32_t i = 0; shares->others != NULL && i < ty_comm_size(comm); ++i)
        shares->others[i] = (other_rank){FREE, 1};
    if (shares->others != NULL) return shares;
    free(shares);
    return NULL;
}

int32_t ty_shares_ranks(const ty_shares* shares) {
    return ty_comm_size(shares->comm);
}

double ty_shares_patience(ty_shares* shares) {
    const double seconds = patience_factor * atomic_load(&shares->longest);
    return seconds > patience_shortest ? seconds : patience_shortest;
}

/* A greeting is a status and two texts: the name of the machine, and what it has read or why it cannot start. */
static bool check_greeting(const ty_buffer* in, const ty_message_head* head, int32_t from, const char* text,
                           char* message, size_t message_size) {
    const char* host = (const char*)in->bytes + sizeof *head;
    const char* said = host + strlen(host) + 1;
    if (head->status == 0 && strcmp(said, text) == 0) return true;
    if (head->status != 0)
        snprintf(message, message_size, "rank %d on %s: %s", (int)from, host, said);
    else
        snprintf(
            message, message_size,
            "rank %d on %s does not have what rank 0 has (%s, not %s): its files, the version or the processor differ",
            (int)from, host, said, text);
    return false;
}

bool ty_shares_greet(ty_shares* shares, const char* text, double seconds, char* message, size_t message_size) {
    const int32_t ranks = ty_comm_size(shares->comm);
    const double begun = ty_wall_seconds();
    int32_t missing = ranks - 1;
    while (missing > 0) {
        ty_comm_message found;
        ty_message_head head;
        const double left = seconds - (ty_wall_seconds() - begun);
        if (left <= 0 || !ty_comm_wait(shares->comm, left, &found)) {
            snprintf(message, message_size, "%d of %d ranks have not answered within %g s", (int)missing, (int)ranks,
                     seconds);
            return false;
        }
        if (!ty_message_take(shares->comm, &found, &shares->in, &head) || found.tag != TY_TAG_HELLO) continue;
        --missing;
        if (!check_greeting(&shares->in, &head, found.from, text, message, message_size)) return false;
    }
    return true;
}

/* ---- a job ---- */

static void offer(ty_shares* shares, int32_t rank) {
    const bool sent = ty_comm_send(shares->comm, rank, TY_TAG_JOB, shares->head.bytes, shares->head.size);
    shares->others[rank].state = sent ? BUSY : GONE;
}

/* The next share takes about share_seconds by the speed of the last one, and at most doubles. */
static void plan_share(ty_shares* shares, other_rank* other, const ty_message_head* head) {
    const double wanted = head->seconds > 0 ? (double)head->count * share_seconds / head->seconds : 2e9;
    const double most = wanted < 2 * (double)head->count ? wanted : 2 * (double)head->count;
    other->items = most < 1 ? 1 : most > ITEMS_MAX ? ITEMS_MAX : (int64_t)most;
    if (head->seconds > atomic_load(&shares->longest)) atomic_store(&shares->longest, head->seconds);
}

/* An answer of a rank. One to a job of before comes from a rank that was late, which gets the current job. */
static void take_answer(ty_shares* shares, const ty_comm_message* found) {
    ty_message_head head;
    if (!ty_message_take(shares->comm, found, &shares->in, &head) || found->tag != TY_TAG_ASK) return;
    other_rank* other = &shares->others[found->from];
    if (head.job != shares->number) {
        offer(shares, found->from);
        return;
    }
    other->state = head.status == 0 ? ASKS : FREE;
    if (head.count == 0) return;
    plan_share(shares, other, &head);
    shares->job.accept(shares->job.user, head.first, head.count, shares->in.bytes + sizeof head,
                       shares->in.size - sizeof head);
}

static void give_share(ty_shares* shares, int32_t rank) {
    ty_message_head head = {.job = shares->number};
    head.count = shares->job.lend(shares->job.user, shares->others[rank].items, &head.first);
    if (head.count == 0) return;
    shares->out.size = 0;
    ty_buffer_add(&shares->out, &head, sizeof head);
    shares->job.pack(shares->job.user, head.first, head.count, &shares->out);
    const bool sent = ty_comm_send(shares->comm, rank, TY_TAG_SHARE, shares->out.bytes, shares->out.size);
    shares->others[rank].state = sent ? BUSY : GONE;
}

static void* run_job(void* user) {
    ty_shares* shares = user;
    while (!atomic_load(&shares->over)) {
        ty_comm_message found;
        if (ty_comm_wait(shares->comm, 1e-3, &found)) take_answer(shares, &found);
        for (int32_t i = 1; i < ty_comm_size(shares->comm); ++i)
            if (shares->others[i].state == ASKS) give_share(shares, i);
    }
    return NULL;
}

bool ty_shares_begin(ty_shares* shares, const ty_job* job, const void* bytes, size_t size) {
    if (atomic_exchange(&shares->begun, true)) return false;
    shares->job = *job;
    ++shares->number;
    const ty_message_head head = {.job = shares->number, .kind = job->kind};
    shares->head.size = 0;
    ty_buffer_add(&shares->head, &head, sizeof head);
    ty_buffer_add(&shares->head, bytes, size);
    for (int32_t i = 1; i < ty_comm_size(shares->comm); ++i) {
        shares->others[i].items = 1;
        if (shares->others[i].state == FREE) offer(shares, i);
    }
    atomic_store(&shares->over, false);
    atomic_store(&shares->longest, 0);
    const bool started = pthread_create(&shares->thread, NULL, run_job, shares) == 0;
    if (!started) atomic_store(&shares->begun, false);
    return started;
}

void ty_shares_end(ty_shares* shares) {
    atomic_store(&shares->over, true);
    pthread_join(shares->thread, NULL);
    const ty_message_head head = {.job = shares->number};
    for (int32_t i = 1; i < ty_comm_size(shares->comm); ++i) {
        if (shares->others[i].state != ASKS) continue;
        const bool sent = ty_message_send(shares->comm, i, TY_TAG_OVER, &head, NULL, 0);
        shares->others[i].state = sent ? FREE : GONE;
    }
    atomic_store(&shares->begun, false);
}

bool ty_shares_destroy(ty_shares* shares, int32_t status) {
    const ty_message_head head = {.status = status};
    const double begun = ty_wall_seconds();
    int32_t left = ty_comm_size(shares->comm) - 1;
    for (int32_t i = 1; i < ty_comm_size(shares->comm); ++i) {
        const rank_state state = shares->others[i].state;
        if (state != BUSY && state != GONE && ty_message_send(shares->comm, i, TY_TAG_QUIT, &head, NULL, 0)) --left;
    }
    while (left > 0 && ty_wall_seconds() - begun < farewell_seconds) {
        ty_comm_message found;
        ty_message_head answer;
        if (!ty_comm_wait(shares->comm, 0.1, &found) || !ty_message_take(shares->comm, &found, &shares->in, &answer))
            continue;
        ty_message_send(shares->comm, found.from, TY_TAG_QUIT, &head, NULL, 0);
        --left;
    }
    free(shares->others);
    free(shares->head.bytes);
    free(shares->in.bytes);
    free(shares->out.bytes);
    free(shares);
    return left == 0;
}
