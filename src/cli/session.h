/* What every command has while it runs: a context, progress, a clock, and --stats at the end. */
#ifndef TY_CLI_SESSION_H
#define TY_CLI_SESSION_H

#include "cli/json.h"
#include "cli/options.h"
#include "cli/progress.h"

#include <tyndall/tyndall.h>

typedef struct cli_session {
    const char* command;
    cli_common common;
    ty_context* context;
    cli_progress progress;
    double started;
    void (*stats)(json_writer* json, const void* user); /* what the command adds to --stats, or NULL */
    const void* stats_user;
} cli_session;

/* Gives CLI_GO, or an exit status after a message. */
int cli_session_open(cli_session* session, const char* command, const cli_common* common);
/* Writes --stats unless status tells of an error, frees the context, returns the exit status. */
int cli_session_close(cli_session* session, int status);

/* The end of a program: that stdout could not be written is its failure. Returns the exit status. */
int cli_finish(int status);

/* Prints "tyndall: " and the context's message, and returns the exit status for the result: wrong arguments and
 * input are the user's (2), and so is a file that could not be opened for reading. */
int cli_fail_reading(cli_session* session, ty_result result);
int cli_fail_running(cli_session* session, ty_result result);
/* The same for an error the command found itself. */
int cli_fail(int status, const char* format, ...) __attribute__((format(printf, 2, 3)));
/* What these printed last: for commands that go on with something else and tell at the end. */
const char* cli_last_message(void);

/* Checks before long work that a file can be made at path: CLI_GO, or CLI_USAGE after a message. */
int cli_check_output(const char* command, const char* path);
/* The same for a folder, which is made if it is missing. */
int cli_make_folder(const char* command, const char* path);
/* Whether path ends in extension (".exr"), in any case. */
bool cli_has_extension(const char* path, const char* extension);

/* "12.3 MiB" into out. */
void cli_format_bytes(double bytes, char out[24]);

double cli_wall_seconds(void);
/* Of all threads. */
double cli_cpu_seconds(void);

#endif
