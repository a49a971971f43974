/* One command by several ranks under mpirun: the processor time of each, and what rank 0 counted. */
#ifndef TY_FIGURES_SCALING_MEASURE_H
#define TY_FIGURES_SCALING_MEASURE_H

#include "figures/process.h"

#include <jansson.h>

enum { SCALING_ARGUMENTS_MAX = 16, SCALING_RANKS_MAX = 4 };

/* A command whose work grows with a number. */
typedef struct scaling_command {
    /* Of tyndall. One that ends with '=' gets the number, and '@' at the beginning of one is the figure's folder. */
    const char* arguments[SCALING_ARGUMENTS_MAX];
} scaling_command;

typedef struct scaling_run {
    int32_t ranks;
    double sum, max;        /* processor s of all ranks, and of the one with the most */
    double messages, bytes; /* of rank 0 */
    json_t* stats;          /* of --stats; the caller frees it */
} scaling_run;

/* The folder of commands' output; made. Errors: TY_ERROR_FILE. */
ty_result scaling_open_folder(figure_run* run, char folder[FIGURE_PATH_SIZE]);
/* True if several ranks can be started; otherwise it says why not, and the figure is skipped. */
bool scaling_can_start(figure_run* run, const char* folder);
/* Runs a command by so many ranks of one thread. Errors: TY_ERROR_FILE, with the command's message; TY_ERROR_MEMORY,
 * TY_CANCELLED. */
ty_result scaling_measure(figure_run* run, const char* folder, const scaling_command* command, int32_t number,
                          int32_t ranks, scaling_run* out);

#endif
