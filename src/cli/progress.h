/* Progress on stderr: one line that updates on a terminal, now and then a line elsewhere, or JSON lines. */
#ifndef TY_CLI_PROGRESS_H
#define TY_CLI_PROGRESS_H

#include "cli/options.h"

#include <stdbool.h>

#include <tyndall/base.h>

typedef struct cli_progress {
    cli_progress_mode mode;             /* never CLI_AUTO */
    bool updating;                      /* one line, overwritten */
    bool line_open;                     /* that line is on screen */
    double last_seconds, last_fraction; /* of the last line of CLI_PLAIN and CLI_JSON */
    char stage[32];
} cli_progress;

cli_progress cli_progress_begin(const cli_common* common);
/* A ty_progress_fn; user is the cli_progress. Returns false once the user has interrupted. */
bool cli_progress_report(void* user, const ty_progress* report);
/* The beginning of one of several steps that take unequal times: a line on its own, unless progress is off. */
void cli_progress_step(cli_progress* progress, const char* stage, int index, int count, double seconds);
/* Takes the updating line off the screen, so that other text can follow. */
void cli_progress_clear(cli_progress* progress);
/* A warning of the library, as a line of its own. */
void cli_progress_warn(cli_progress* progress, const char* text);

/* SIGINT and SIGTERM ask the running work to stop; a second one ends the program at once with 130. */
void cli_catch_interrupts(void);
bool cli_interrupted(void);

#endif
