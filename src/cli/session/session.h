/* The session of a running command: a context, progress, a clock, and --stats at the end. */
#ifndef TY_CLI_SESSION_SESSION_H
#define TY_CLI_SESSION_SESSION_H

#include "cli/text/json.h"
#include "cli/options/options.h"
#include "cli/session/progress.h"
#include "cli/session/signals.h"

#include <tyndall/tyndall.h>

typedef struct cli_session {
    const char* command;
    cli_common common;
    ty_context* context;
    cli_progress progress;
    double started;
    void (*stats)(json_writer* json, const void* user); /* the command's members of --stats, or NULL */
    const void* stats_user;
    struct ty_comm* comm;        /* the ranks under mpirun; NULL: this process is alone */
    struct ty_work_queue* queue; /* what rank 0 gives them to do; NULL: nothing, or another rank */
} cli_session;

/* Opens a session: CLI_GO, or an exit status after a message. */
int cli_session_open(cli_session* session, const char* command, const cli_common* common);
/* Writes --stats unless status is an error, frees the context, returns the exit status. */
int cli_session_close(cli_session* session, int status);
/* Writes the stats of a command that goes on; returns status, or that of a failure. */
int cli_session_write_stats(cli_session* session, const char* path, int status);

/* Ends a program: a write error of stdout becomes a failure, but for a reader that is gone, which gives the status 141
 * that a shell shows for SIGPIPE. Interruptions become the status of their signal. Returns the exit status. */
int cli_finish(int status);

/* Prints "tyndall: " and the context's message, and returns the exit status of the result: 2 (usage) for wrong
 * arguments, wrong input and files that could not be opened for reading. */
int cli_fail_reading(cli_session* session, ty_result result);
int cli_fail_running(cli_session* session, ty_result result);
/* Like cli_fail_running, for an error that the command detected itself. */
int cli_fail(int status, const char* format, ...) __attribute__((format(printf, 2, 3)));
/* The path of a program or module that comes with this one: in the same folder, as in a build, or in that of an
 * installation. mode: as of access(). False: there is none. */
bool cli_find_beside(const char* name, int mode, char* out, size_t size);
/* The last printed error, for commands that continue and report it at the end. */
const char* cli_last_message(void);

/* Checks before long work that a file can be created at path: CLI_GO, or CLI_USAGE after a message. */
int cli_check_output(const char* command, const char* path);
/* Checks a folder likewise, and creates it if missing. */
int cli_make_folder(const char* command, const char* path);
/* Creates a folder of its own for temporary files, tyndall-USE-XXXXXX in TMPDIR or /tmp. False, with errno set: it
 * cannot be made, or its path is longer than `size`. */
bool cli_make_temporary_folder(const char* use, char* out, size_t size);
/* True if path ends in an extension (".exr"), ignoring case. */
bool cli_has_extension(const char* path, const char* extension);

/* Prints "12.3 MiB" into out. */
void cli_format_bytes(double bytes, char out[24]);

double cli_wall_seconds(void);
/* CPU seconds of all threads. */
double cli_cpu_seconds(void);

#endif
