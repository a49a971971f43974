/* Tasks of a command's work among its ranks. Rank 0 runs the command; for a loop that others can help with it sends
 * them a job, and each asks for tasks of it, one after another, until the job is over. A task carries what its
 * computation starts from, so that the others keep nothing, and one that dies costs its task. */
#ifndef TY_COMM_QUEUE_H
#define TY_COMM_QUEUE_H

#include "comm/comm.h"

/* Growing bytes of a message. */
typedef struct ty_buffer {
    uint8_t* bytes;
    size_t size, capacity;
} ty_buffer;

/* Appends bytes; without memory for them the program ends, since a message half sent helps nobody. */
void ty_buffer_add(ty_buffer* buffer, const void* bytes, size_t size);

typedef enum ty_job_kind { TY_JOB_PATH, TY_JOB_BAKE, TY_JOB_FRAMES, TY_JOB_JOINT, TY_JOB_KINDS } ty_job_kind;

/* ---- rank 0 ---- */

/* The part of rank 0 in a job. Its thread of messages makes the calls, one at a time. */
typedef struct ty_job {
    ty_job_kind kind;
    void* user;
    /* Lends up to `max_count` items [*first, *first + n); the result is n, 0 if there are none at the moment. */
    int64_t (*lend)(void* user, int64_t max_count, int64_t* first);
    /* Appends what another rank needs for these items. */
    void (*pack)(void* user, int64_t first, int64_t count, ty_buffer* out);
    /* Takes the results of items, as the kind's `work` appended them. */
    void (*accept)(void* user, int64_t first, int64_t count, const uint8_t* bytes, size_t size);
} ty_job;

typedef struct ty_work_queue ty_work_queue;

/* The tasks of a command, for rank 0; NULL without memory. They keep the comm. */
ty_work_queue* ty_queue_create(ty_comm* comm);
/* Waits for every rank's greeting, at most some seconds; the text of all must be that of rank 0. False: `message` tells
 * in one line which rank differs, is missing, or could not start. */
bool ty_queue_greet(ty_work_queue* queue, const char* text, double seconds, char* message, size_t message_size);
/* Lets the others go, with the status that their commands shall end with. True if all have answered. */
bool ty_queue_destroy(ty_work_queue* queue, int32_t status);

/* Sets a text that comes before each of the following jobs (ty_queue_listener); it is copied. */
void ty_queue_tell(ty_work_queue* queue, const char* text);
/* Offers a job, described by bytes, to the others; one job at a time. False: they
 * have one, and it shall not be ended. */
bool ty_queue_begin(ty_work_queue* queue, const ty_job* job, const void* bytes, size_t size);
/* The job that was begun is over; tasks that are still away come to nothing. */
void ty_queue_end(ty_work_queue* queue);
/* Seconds that a rank may take for a task before its items should be computed again. */
double ty_queue_patience(ty_work_queue* queue);
int32_t ty_queue_ranks(const ty_work_queue* queue);
ty_comm* ty_queue_comm(const ty_work_queue* queue);
/* False if a message could not be sent to some rank. */
bool ty_queue_is_whole(const ty_work_queue* queue);

/* ---- the other ranks ---- */

/* The part of another rank in a kind of job. */
typedef struct ty_job_worker {
    /* Prepares; false: it cannot, and rank 0 goes on without it. */
    bool (*begin)(void* user, const uint8_t* bytes, size_t size, void** job);
    /* Computes items from what rank 0 packed, and appends the results; false: it cannot. */
    bool (*work)(void* job, int64_t first, int64_t count, const uint8_t* bytes, size_t size, ty_buffer* out);
    void (*end)(void* job);
    void* user;
} ty_job_worker;

/* Takes in what rank 0 tells, before the first job after it and again before others; false: it cannot, and rank 0 goes
 * on without it. */
typedef struct ty_queue_listener {
    bool (*hear)(void* user, const char* text);
    void* user;
} ty_queue_listener;

/* Greets rank 0 with a text: of what it has read, or, with status != 0, why it cannot start. */
void ty_queue_hello(ty_comm* comm, int32_t status, const char* text);
/* Works until rank 0 lets it go, and returns the status that rank 0 gives. workers: TY_JOB_KINDS of them; one without
 * `begin` refuses its jobs. listener: NULL: jobs after a text are refused. *all: no rank is lost. */
int32_t ty_queue_serve(ty_comm* comm, const ty_job_worker* workers, const ty_queue_listener* listener, bool* all);

#endif
