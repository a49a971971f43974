/* --resume: the state of a render in a file beside its image. */
#define _GNU_SOURCE
#include "cli/checkpoint.h"

#include <errno.h>
#include <stdlib.h>
#include <unistd.h>

int cli_checkpoint_open(cli_checkpoint* checkpoint, cli_session* session, const char* output) {
    *checkpoint = (cli_checkpoint){.session = session};
    if (asprintf(&checkpoint->path, "%s.state", output) < 0) {
        checkpoint->path = NULL;
        return cli_fail(CLI_FAILED, "not enough memory");
    }
    const int status = cli_check_output(session->command, checkpoint->path);
    if (status != CLI_GO) return status;
    if (access(checkpoint->path, F_OK) != 0 && errno == ENOENT) return CLI_GO;
    const ty_result result =
        ty_bytes_read(session->context, checkpoint->path, PTRDIFF_MAX, &checkpoint->bytes, &checkpoint->size);
    return result == TY_OK ? CLI_GO : cli_fail_reading(session, result);
}

void cli_checkpoint_close(cli_checkpoint* checkpoint) {
    ty_bytes_destroy(checkpoint->session->context, checkpoint->bytes, checkpoint->size);
    free(checkpoint->path);
}

bool cli_checkpoint_write(void* user, const void* state, size_t size) {
    cli_checkpoint* checkpoint = user;
    cli_session* session = checkpoint->session;
    if (ty_bytes_write(session->context, checkpoint->path, state, size) == TY_OK) return true;
    const char* message = ty_take_error(session->context);
    if (!checkpoint->warned && !session->common.quiet) cli_progress_warn(&session->progress, message);
    checkpoint->warned = true;
    return true;
}
