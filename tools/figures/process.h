/* Programs as processes of their own. */
#ifndef TY_FIGURES_PROCESS_H
#define TY_FIGURES_PROCESS_H

#include "figures/figure.h"

enum { FIGURE_WORDS_SIZE = 256 };

typedef struct figure_process {
    int status; /* exit status; -1: ended by a signal */
    int signal;
    double seconds;                /* processor time, with that of processes that it waited for */
    char words[FIGURE_WORDS_SIZE]; /* first line of its messages, without the program's name */
} figure_process;

/* Runs a program, found as by a shell, with its arguments behind it and NULL at the end; a process of it may take so
 * many seconds of processor time. Errors: TY_ERROR_MEMORY where none can be started, TY_CANCELLED. */
ty_result figure_run_process(const char* const* list, int32_t seconds_max, figure_process* out);

#endif
