/* The other ranks' side of tasks. */
#define _GNU_SOURCE
#include "comm/protocol.h"

#include "base/context.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* A rank that waits looks for messages again after so many seconds. */
static const double look_seconds = 3600;

void ty_queue_hello(ty_comm* comm, int32_t status, const char* text) {
    char host[256] = "";
    ty_buffer texts = {.size = 0};
    gethostname(host, sizeof host - 1);
    ty_buffer_add(&texts, host, strlen(host) + 1);
    ty_buffer_add(&texts, text, strlen(text) + 1);
    const ty_message_head head = {.status = status};
    ty_message_send(comm, 0, TY_TAG_HELLO, &head, texts.bytes, texts.size);
    free(texts.bytes);
}

/* The job that a rank takes part in. */
typedef struct service {
    ty_comm* comm;
    const ty_job_worker *workers, *worker; /* of the job; NULL: none */
    const ty_queue_listener* listener;
    void* job;
    ty_buffer in, out;
} service;

static void end_job(service* s) {
    if (s->worker != NULL) s->worker->end(s->job);
    s->worker = NULL;
}

/* True if nothing was told before the job, or it was taken in. A joint solve needs nothing but what it comes with. */
static bool hear(const service* s, int32_t kind, const char* told, size_t size) {
    if (size == 0 || kind == TY_JOB_JOINT) return true;
    return told[size - 1] == '\0' && s->listener != NULL && s->listener->hear(s->listener->user, told);
}

/* Asks for the first task, or refuses the job. */
static void begin_job(service* s, const ty_message_head* head) {
    end_job(s);
    const ty_job_worker* worker = head->kind >= 0 && head->kind < TY_JOB_KINDS ? &s->workers[head->kind] : NULL;
    const uint8_t* bytes = s->in.bytes + sizeof *head;
    const size_t size = s->in.size - sizeof *head, told = (size_t)head->first <= size ? (size_t)head->first : 0;
    const bool able = worker != NULL && worker->begin != NULL && hear(s, head->kind, (const char*)bytes, told) &&
                      worker->begin(worker->user, bytes + told, size - told, &s->job);
    if (able) s->worker = worker;
    const ty_message_head answer = {.job = head->job, .status = able ? 0 : 1};
    ty_message_send(s->comm, 0, TY_TAG_ASK, &answer, NULL, 0);
}

static void do_task(service* s, const ty_message_head* head) {
    ty_message_head answer = *head;
    const double begun = ty_wall_seconds();
    s->out.size = 0;
    ty_buffer_add(&s->out, &answer, sizeof answer);
    if (s->worker == NULL || !s->worker->work(s->job, head->first, head->count, s->in.bytes + sizeof *head,
                                              s->in.size - sizeof *head, &s->out)) {
        end_job(s);
        answer = (ty_message_head){.job = head->job, .status = 1};
        s->out.size = sizeof answer;
    }
    answer.seconds = ty_wall_seconds() - begun;
    memcpy(s->out.bytes, &answer, sizeof answer);
    ty_comm_send(s->comm, 0, TY_TAG_ASK, s->out.bytes, s->out.size);
}

int32_t ty_queue_serve(ty_comm* comm, const ty_job_worker* workers, const ty_queue_listener* listener, bool* all) {
    service s = {.comm = comm, .workers = workers, .listener = listener};
    ty_message_head head = {.status = 0};
    for (bool going = true; going;) {
        ty_comm_message found;
        if (!ty_comm_wait(comm, look_seconds, &found) || !ty_message_take(comm, &found, &s.in, &head)) continue;
        switch (found.tag) {
        case TY_TAG_JOB: begin_job(&s, &head); break;
        case TY_TAG_TASK: do_task(&s, &head); break;
        case TY_TAG_OVER: end_job(&s); break;
        default: going = found.tag != TY_TAG_QUIT; break;
        }
    }
    end_job(&s);
    free(s.in.bytes);
    free(s.out.bytes);
    *all = head.count == 0;
    return head.status;
}
