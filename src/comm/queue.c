/* Rank 0's side of tasks. */
#define _GNU_SOURCE
#include "comm/protocol.h"

#include "base/context.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Target duration of a task, and the longest wait for ranks at the end of the command where a launcher ends all when
 * one dies, seconds. */
static const double task_seconds = 0.2, farewell_seconds = 5;
/* Time that a rank may take for a task: at least so many seconds, and so many times the longest task. */
static const double patience_shortest = 1, patience_factor = 4;

enum { ITEMS_MAX = 1 << 16 };

/* FREE: waits for a job. ASKS: waits for a task. BUSY: will ask. GONE: receives no messages. */
typedef enum rank_state { FREE, ASKS, BUSY, GONE } rank_state;

/* Another rank, as rank 0 knows it. */
typedef struct other_rank {
    rank_state state;
    int64_t items; /* of its next task */
    double since;  /* the time of the last message to it, that made it busy */
} other_rank;

struct ty_work_queue {
    ty_comm* comm;
    other_rank* others; /* by rank; that of rank 0 is not used */
    ty_job job;
    uint64_t number; /* of the current job, or of the last one */
    ty_buffer head;  /* the message that describes the job */
    char* told;      /* what comes before the job in it; NULL: nothing */
    pthread_mutex_t telling;
    ty_buffer in, out;
    pthread_t thread;
    _Atomic bool begun; /* a job is under way; another thread of the command may begin one */
    _Atomic bool over;
    _Atomic double longest; /* seconds of the longest task */
};

/* ---- messages ---- */

void ty_buffer_add(ty_buffer* buffer, const void* bytes, size_t size) {
    if (buffer->capacity - buffer->size < size) {
        const size_t capacity = 2 * buffer->capacity + size;
        uint8_t* grown = realloc(buffer->bytes, capacity);
        if (grown == NULL) {
            fputs("tyndall: not enough memory for a message to another rank\n", stderr);
            _exit(1); /* as where a rank dies: the rest of the job goes on, or resumes */
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

ty_work_queue* ty_queue_create(ty_comm* comm) {
    ty_work_queue* queue = calloc(1, sizeof *queue);
    if (queue == NULL) return NULL;
    queue->comm = comm;
    pthread_mutex_init(&queue->telling, NULL);
    queue->others = calloc((size_t)ty_comm_size(comm), sizeof *queue->others);
    for (int32_t i = 0; queue->others != NULL && i < ty_comm_size(comm); ++i)
        queue->others[i] = (other_rank){FREE, 1, 0};
    if (queue->others != NULL) return queue;
    pthread_mutex_destroy(&queue->telling);
    free(queue);
    return NULL;
}

int32_t ty_queue_ranks(const ty_work_queue* queue) {
    return ty_comm_size(queue->comm);
}

ty_comm* ty_queue_comm(const ty_work_queue* queue) {
    return queue->comm;
}

bool ty_queue_is_whole(const ty_work_queue* queue) {
    for (int32_t i = 1; i < ty_comm_size(queue->comm); ++i)
        if (queue->others[i].state == GONE) return false;
    return true;
}

double ty_queue_patience(ty_work_queue* queue) {
    const double seconds = patience_factor * atomic_load(&queue->longest);
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

bool ty_queue_greet(ty_work_queue* queue, const char* text, double seconds, char* message, size_t message_size) {
    const int32_t ranks = ty_comm_size(queue->comm);
    const double begun = ty_wall_seconds();
    int32_t missing = ranks - 1;
    while (missing > 0) {
        ty_comm_message found;
        ty_message_head head;
        const double left = seconds - (ty_wall_seconds() - begun);
        if (left <= 0 || !ty_comm_wait(queue->comm, left, &found)) {
            snprintf(message, message_size, "%d of %d ranks have not answered within %g s", (int)missing, (int)ranks,
                     seconds);
            return false;
        }
        if (!ty_message_take(queue->comm, &found, &queue->in, &head) || found.tag != TY_TAG_HELLO) continue;
        --missing;
        if (!check_greeting(&queue->in, &head, found.from, text, message, message_size)) return false;
    }
    return true;
}

/* ---- a job ---- */

static void offer(ty_work_queue* queue, int32_t rank) {
    const bool sent = ty_comm_send(queue->comm, rank, TY_TAG_JOB, queue->head.bytes, queue->head.size);
    queue->others[rank].state = sent ? BUSY : GONE;
    queue->others[rank].since = ty_wall_seconds();
}

/* The next task takes about task_seconds by the speed of the last one, and at most doubles. */
static void plan_task(ty_work_queue* queue, other_rank* other, const ty_message_head* head) {
    const double wanted = head->seconds > 0 ? (double)head->count * task_seconds / head->seconds : 2e9;
    const double max_items = wanted < 2 * (double)head->count ? wanted : 2 * (double)head->count;
    other->items = max_items < 1 ? 1 : max_items > ITEMS_MAX ? ITEMS_MAX : (int64_t)max_items;
    if (head->seconds > atomic_load(&queue->longest)) atomic_store(&queue->longest, head->seconds);
}

/* An answer of a rank. One to a job of before comes from a rank that was late, which gets the current job. */
static void take_answer(ty_work_queue* queue, const ty_comm_message* found) {
    ty_message_head head;
    if (!ty_message_take(queue->comm, found, &queue->in, &head) || found->tag != TY_TAG_ASK) return;
    other_rank* other = &queue->others[found->from];
    if (head.job != queue->number) {
        offer(queue, found->from);
        return;
    }
    other->state = head.status == 0 ? ASKS : FREE;
    if (head.count == 0) return;
    plan_task(queue, other, &head);
    queue->job.accept(queue->job.user, head.first, head.count, queue->in.bytes + sizeof head,
                      queue->in.size - sizeof head);
}

static void give_task(ty_work_queue* queue, int32_t rank) {
    ty_message_head head = {.job = queue->number};
    head.count = queue->job.lend(queue->job.user, queue->others[rank].items, &head.first);
    if (head.count == 0) return;
    queue->out.size = 0;
    ty_buffer_add(&queue->out, &head, sizeof head);
    queue->job.pack(queue->job.user, head.first, head.count, &queue->out);
    const bool sent = ty_comm_send(queue->comm, rank, TY_TAG_TASK, queue->out.bytes, queue->out.size);
    queue->others[rank].state = sent ? BUSY : GONE;
    queue->others[rank].since = ty_wall_seconds();
}

static void* run_job(void* user) {
    ty_work_queue* queue = user;
    while (!atomic_load(&queue->over)) {
        ty_comm_message found;
        if (ty_comm_wait(queue->comm, 1e-3, &found)) take_answer(queue, &found);
        for (int32_t i = 1; i < ty_comm_size(queue->comm); ++i)
            if (queue->others[i].state == ASKS) give_task(queue, i);
    }
    return NULL;
}

void ty_queue_tell(ty_work_queue* queue, const char* text) {
    char* copy = strdup(text);
    if (copy == NULL) ty_comm_abort(queue->comm, 1);
    pthread_mutex_lock(&queue->telling);
    free(queue->told);
    queue->told = copy;
    pthread_mutex_unlock(&queue->telling);
}

/* The message of a job: its head, what was told, and the description. */
static void write_head(ty_work_queue* queue, const ty_job* job, const void* bytes, size_t size) {
    pthread_mutex_lock(&queue->telling);
    const size_t told = queue->told != NULL ? strlen(queue->told) + 1 : 0;
    const ty_message_head head = {.job = queue->number, .kind = job->kind, .first = (int64_t)told};
    queue->head.size = 0;
    ty_buffer_add(&queue->head, &head, sizeof head);
    ty_buffer_add(&queue->head, queue->told, told);
    pthread_mutex_unlock(&queue->telling);
    ty_buffer_add(&queue->head, bytes, size);
}

bool ty_queue_begin(ty_work_queue* queue, const ty_job* job, const void* bytes, size_t size) {
    if (atomic_exchange(&queue->begun, true)) return false;
    queue->job = *job;
    ++queue->number;
    write_head(queue, job, bytes, size);
    for (int32_t i = 1; i < ty_comm_size(queue->comm); ++i) {
        queue->others[i].items = 1;
        if (queue->others[i].state == FREE) offer(queue, i);
    }
    atomic_store(&queue->over, false);
    atomic_store(&queue->longest, 0);
    const bool started = pthread_create(&queue->thread, NULL, run_job, queue) == 0;
    if (!started) atomic_store(&queue->begun, false);
    return started;
}

void ty_queue_end(ty_work_queue* queue) {
    atomic_store(&queue->over, true);
    pthread_join(queue->thread, NULL);
    const ty_message_head head = {.job = queue->number};
    for (int32_t i = 1; i < ty_comm_size(queue->comm); ++i) {
        if (queue->others[i].state != ASKS) continue;
        const bool sent = ty_message_send(queue->comm, i, TY_TAG_OVER, &head, NULL, 0);
        queue->others[i].state = sent ? FREE : GONE;
    }
    atomic_store(&queue->begun, false);
}

/* True where the launcher lets the others go on when a rank dies (mpirun --enable-recovery). */
static bool outlives_ranks(void) {
    const char* text = getenv("OMPI_MCA_orte_enable_recovery");
    return text != NULL && strcmp(text, "0") != 0;
}

/* Ranks that are gone, or busy for longer than a task may take. */
static int32_t count_silent(ty_work_queue* queue, double seconds, int32_t* busy) {
    const double now = ty_wall_seconds();
    int32_t silent = 0;
    *busy = 0;
    for (int32_t i = 1; i < ty_comm_size(queue->comm); ++i) {
        const other_rank* other = &queue->others[i];
        if (other->state == GONE || (other->state == BUSY && now - other->since > seconds))
            ++silent;
        else if (other->state == BUSY)
            ++*busy;
    }
    return silent;
}

/* Waits for the ranks that are busy, as long as they may answer; the result is the number of those that do not. Where a
 * launcher would have ended this rank had they died, they are slow, and have some time more. */
static int32_t wait_for_busy(ty_work_queue* queue) {
    const double begun = ty_wall_seconds(), patience = ty_queue_patience(queue);
    const double grace = outlives_ranks() ? 0 : farewell_seconds;
    for (;;) {
        int32_t busy;
        const double waited = ty_wall_seconds() - begun;
        const int32_t silent = count_silent(queue, waited < grace ? HUGE_VAL : patience, &busy);
        if (busy == 0 || waited > farewell_seconds) return silent + busy;
        ty_comm_message found;
        ty_message_head answer;
        if (ty_comm_wait(queue->comm, 0.1, &found) && ty_message_take(queue->comm, &found, &queue->in, &answer) &&
            queue->others[found.from].state == BUSY)
            queue->others[found.from].state = FREE;
    }
}

bool ty_queue_destroy(ty_work_queue* queue, int32_t status) {
    const int32_t lost = wait_for_busy(queue);
    const ty_message_head head = {.status = status, .count = lost};
    for (int32_t i = 1; i < ty_comm_size(queue->comm); ++i)
        if (queue->others[i].state == FREE || queue->others[i].state == ASKS)
            ty_message_send(queue->comm, i, TY_TAG_QUIT, &head, NULL, 0);
    free(queue->others);
    free(queue->head.bytes);
    free(queue->told);
    pthread_mutex_destroy(&queue->telling);
    free(queue->in.bytes);
    free(queue->out.bytes);
    free(queue);
    return lost == 0;
}
