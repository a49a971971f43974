#include "comm/joint.h"

#include <stdlib.h>
#include <string.h>

/* Tags of a rank's answer, 0 if it takes part, and of the word of rank 0 whether the solve begins. */
enum { TAG_OF_ANSWER = 8, TAG_OF_WORD = 9 };

/* ---- rank 0 ---- */

/* A job without items: ranks are in it until their part of the solve is made. */
static int64_t lend_nothing(void* user, int64_t max_count, int64_t* first) {
    (void)user;
    (void)max_count;
    *first = 0;
    return 0;
}

static void pack_nothing(void* user, int64_t first, int64_t count, ty_buffer* out) {
    (void)user, (void)first, (void)count, (void)out;
}

static void accept_nothing(void* user, int64_t first, int64_t count, const uint8_t* bytes, size_t size) {
    (void)user, (void)first, (void)count, (void)bytes, (void)size;
}

/* True if all other ranks take part; each is told. */
static bool gather_answers(ty_comm* comm) {
    int32_t refusals = 0;
    for (int32_t r = 1; r < ty_comm_size(comm); ++r) {
        int32_t answer = 1;
        if (!ty_comm_get(comm, r, TAG_OF_ANSWER, &answer, sizeof answer)) return false;
        refusals += answer != 0;
    }
    for (int32_t r = 1; r < ty_comm_size(comm); ++r)
        if (!ty_comm_put(comm, r, TAG_OF_WORD, &refusals, sizeof refusals)) return false;
    return refusals == 0;
}

ty_comm* ty_joint_begin(ty_work_queue* queue, ty_joint_kind kind, const void* bytes, size_t size) {
    ty_comm* comm = queue != NULL ? ty_queue_comm(queue) : NULL;
    if (comm == NULL || ty_comm_lost(comm) >= 0 || !ty_queue_is_whole(queue)) return NULL;
    const ty_job job = {TY_JOB_JOINT, NULL, lend_nothing, pack_nothing, accept_nothing};
    const int32_t head = kind;
    ty_buffer message = {.size = 0};
    ty_buffer_add(&message, &head, sizeof head);
    ty_buffer_add(&message, bytes, size);
    const bool begun = ty_queue_begin(queue, &job, message.bytes, message.size);
    const bool together = begun && gather_answers(comm);
    if (begun) ty_queue_end(queue);
    free(message.bytes);
    return together ? comm : NULL;
}

/* ---- the other ranks ---- */

/* Takes part in the solve, and asks for no tasks. */
static bool begin_joint(void* user, const uint8_t* bytes, size_t size, void** job) {
    const ty_joint_rank* rank = user;
    int32_t kind = TY_JOINT_KINDS, refusals = 1;
    *job = NULL;
    if (size >= sizeof kind) memcpy(&kind, bytes, sizeof kind);
    const bool able = kind >= 0 && kind < TY_JOINT_KINDS && rank->solvers[kind] != NULL;
    const int32_t answer = able ? 0 : 1;
    if (ty_comm_put(rank->comm, 0, TAG_OF_ANSWER, &answer, sizeof answer) &&
        ty_comm_get(rank->comm, 0, TAG_OF_WORD, &refusals, sizeof refusals) && refusals == 0)
        rank->solvers[kind](rank->comm, rank->user, bytes + sizeof kind, size - sizeof kind);
    return false;
}

static bool work_on_nothing(void* job, int64_t first, int64_t count, const uint8_t* bytes, size_t size,
                            ty_buffer* out) {
    (void)job, (void)first, (void)count, (void)bytes, (void)size, (void)out;
    return false;
}

static void end_nothing(void* job) {
    (void)job;
}

ty_job_worker ty_joint_job_worker(ty_joint_rank* rank) {
    return (ty_job_worker){begin_joint, work_on_nothing, end_nothing, rank};
}
