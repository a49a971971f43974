/* Commands that several processes run together, under mpirun: rank 0 runs the command, and the others do tasks of its
 * work (comm/queue.h). */
#ifndef TY_CLI_SESSION_RANKS_H
#define TY_CLI_SESSION_RANKS_H

#include "cli/session/session.h"
#include "comm/queue.h"

/* For a program that a launcher may have started several times, first of all: true on ranks other than 0, which then
 * print nothing, and keep their first message for rank 0. */
bool cli_ranks_start(void);
/* The exit status of a rank other than 0 whose command has ended with a status: one that ends with an error before it
 * joined the others first gives rank 0 ten seconds to say the same, and then says it itself. */
int cli_ranks_end(int status);

/* Joins the others: CLI_GO, or an exit status after a message. Without a launcher it does nothing. */
int cli_ranks_open(cli_session* session);
/* True on ranks other than 0. */
bool cli_ranks_helps(const cli_session* session);
/* On rank 0, after the scene was read: checks that all ranks have the same scene, version and instruction set: CLI_GO,
 * or an exit status after a message. */
int cli_ranks_greet(cli_session* session, const ty_scene* scene);
/* On the others: tells rank 0 of the scene, or with status other than CLI_GO why there is none. */
void cli_ranks_hello(cli_session* session, int status, const ty_scene* scene);
/* On the others, after that: works for rank 0, and returns the exit status. workers: TY_JOB_KINDS of them; listener: of
 * what rank 0 tells, NULL: none. */
int cli_ranks_serve(cli_session* session, const ty_job_worker* workers, const ty_queue_listener* listener);
/* Says on stderr that a method is solved by rank 0 alone. */
void cli_ranks_tell_alone(cli_session* session, const char* method);
/* On rank 0: lets the others end with a status. The session's end calls it. */
void cli_ranks_close(cli_session* session, int status);

#endif
