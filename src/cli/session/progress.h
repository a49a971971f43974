/* Progress on stderr: one updating line on a terminal, occasional lines elsewhere, or JSON lines. */
#ifndef TY_CLI_SESSION_PROGRESS_H
#define TY_CLI_SESSION_PROGRESS_H

#include "cli/options/options.h"

#include <stdbool.h>

#include <tyndall/base.h>

typedef struct cli_progress {
    cli_progress_mode mode;             /* never CLI_AUTO */
    bool updating;                      /* one updating line */
    bool line_open;                     /* the updating line is on screen */
    double last_seconds, last_fraction; /* time of the last line of CLI_PLAIN and CLI_JSON */
    char stage[32];
} cli_progress;

cli_progress cli_progress_begin(const cli_common* common);
/* A ty_progress_fn; user is the cli_progress. Returns false once the user has interrupted. */
bool cli_progress_report(void* user, const ty_progress* report);
/* Prints the start of one of several steps of unequal duration as a separate line, unless progress is off. */
void cli_progress_step(cli_progress* progress, const char* stage, int index, int count, double seconds);
/* Erases the updating line before other text. */
void cli_progress_clear(cli_progress* progress);
/* Prints a warning of the library as a separate line. */
void cli_progress_warn(cli_progress* progress, const char* text);

#endif
