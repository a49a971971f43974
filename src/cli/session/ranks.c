#define _GNU_SOURCE
#include "cli/session/ranks.h"

#include "base/context.h"
#include "base/isa.h"
#include "cli/text/text.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { PATH_SIZE = 4096, TEXT_SIZE = 160, MESSAGE_SIZE = 1024 };

/* Seconds that ranks wait for one another when the command starts. */
static const double wait_default = 120;

/* The messages of a rank other than 0, for rank 0. */
static char kept_message[MESSAGE_SIZE];
static bool joined; /* the ranks have found one another */
static bool lost;   /* some have died since, so that the others do not wait for all */

bool cli_ranks_start(void) {
    int32_t rank, size;
    if (!ty_comm_launched(&rank, &size) || rank == 0) return false;
    cli_keep_messages(kept_message, sizeof kept_message);
    cli_silence_interrupts();
    if (freopen("/dev/null", "w", stdout) == NULL) fclose(stdout);
    return true;
}

int cli_ranks_end(int status) {
    int32_t rank, size;
    if (status == CLI_DONE || joined || !ty_comm_launched(&rank, &size)) return status;
    sleep(10); /* the launcher ends all ranks when the first one fails, which wakes this one */
    if (cli_interrupted()) return status;
    cli_keep_messages(NULL, 0);
    return cli_fail(status, "rank %d: %s", (int)rank, kept_message);
}

static double wait_seconds(void) {
    const char* text = getenv("TYNDALL_RANKS_WAIT");
    const double seconds = text != NULL ? strtod(text, NULL) : 0;
    return seconds > 0 && seconds < 1e6 ? seconds : wait_default;
}

int cli_ranks_open(cli_session* session) {
    char path[PATH_SIZE];
    const ty_result result = ty_comm_open(cli_find_beside("tyndall-mpi.so", R_OK, path, sizeof path) ? path : NULL,
                                          wait_seconds(), &session->comm);
    if (result != TY_OK) return cli_session_close(session, cli_fail(CLI_USAGE, "%s", ty_take_error(NULL)));
    if (session->comm == NULL) return CLI_GO;
    joined = true;
    if (ty_comm_rank(session->comm) > 0) {
        session->common.quiet = true;
        session->common.stats = NULL;
        session->progress.mode = CLI_NONE;
        return CLI_GO;
    }
    session->queue = ty_queue_create(session->comm);
    if (session->queue == NULL) ty_comm_abort(session->comm, cli_fail(CLI_FAILED, "not enough memory"));
    return CLI_GO;
}

bool cli_ranks_helps(const cli_session* session) {
    return ty_comm_rank(session->comm) > 0;
}

/* A text of the things that all ranks must have in common. */
static void describe(const ty_scene* scene, char out[TEXT_SIZE]) {
    snprintf(out, TEXT_SIZE, "scene %016" PRIx64 ", version %s, instruction set %s",
             scene != NULL ? ty_scene_hash(scene) : 0, ty_version(), ty_isa_name(ty_best_isa()));
}

int cli_ranks_greet(cli_session* session, const ty_scene* scene) {
    char text[TEXT_SIZE], message[MESSAGE_SIZE];
    if (session->queue == NULL) return CLI_GO;
    describe(scene, text);
    if (!ty_queue_greet(session->queue, text, wait_seconds(), message, sizeof message))
        return cli_fail(CLI_USAGE, "%s", message);
    ty_context_set_queue(session->context, session->queue);
    return CLI_GO;
}

void cli_ranks_hello(cli_session* session, int status, const ty_scene* scene) {
    char text[TEXT_SIZE];
    describe(scene, text);
    ty_queue_hello(session->comm, status == CLI_GO ? 0 : status, status == CLI_GO ? text : kept_message);
    cli_end_on_interrupt(true);
}

int cli_ranks_serve(cli_session* session, const ty_job_worker* workers, const ty_queue_listener* listener) {
    bool all = true;
    const int status = ty_queue_serve(session->comm, workers, listener, &all);
    lost = !all;
    return status;
}

void cli_ranks_tell_alone(cli_session* session, const char* method) {
    if (session->queue == NULL || session->common.quiet) return;
    cli_progress_clear(&session->progress);
    fprintf(stderr, "%s is solved by rank 0 alone; the other %d help where it traces paths\n", method,
            (int)ty_comm_size(session->comm) - 1);
}

void cli_ranks_close(cli_session* session, int status) {
    if (session->queue != NULL) {
        ty_context_set_queue(session->context, NULL);
        lost = !ty_queue_destroy(session->queue, status);
    }
    ty_comm_close(session->comm, !lost, status);
    session->queue = NULL;
    session->comm = NULL;
}
