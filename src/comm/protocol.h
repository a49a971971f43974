/* Messages of tasks: docs/farm.md, "Messages". */
#ifndef TY_COMM_PROTOCOL_H
#define TY_COMM_PROTOCOL_H

#include "comm/queue.h"

enum { TY_TAG_HELLO = 1, TY_TAG_JOB, TY_TAG_ASK, TY_TAG_TASK, TY_TAG_OVER, TY_TAG_QUIT };

/* First bytes of every message. */
typedef struct ty_message_head {
    uint64_t job;         /* number of the job, from 1 on */
    int32_t kind, status; /* of the job; of a greeting, a refusal or an end */
    int64_t first, count; /* items */
    double seconds;       /* that they took */
} ty_message_head;

/* Receives a message into a buffer of its size: false if it failed or has no head. */
bool ty_message_take(ty_comm* comm, const ty_comm_message* message, ty_buffer* buffer, ty_message_head* head);
/* Sends a head, and bytes behind it; false: the receiver is gone. */
bool ty_message_send(ty_comm* comm, int32_t to, int32_t tag, const ty_message_head* head, const void* bytes,
                     size_t size);

#endif
