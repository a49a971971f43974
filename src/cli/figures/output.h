/* What a figure leaves in its folder. */
#ifndef TY_CLI_FIGURES_OUTPUT_H
#define TY_CLI_FIGURES_OUTPUT_H

#include "cli/figures/figure.h"

/* NAME.csv, NAME.json and NAME.png, each whole or not at all. Returns CLI_DONE, or an exit status after a message. */
int figure_write(figure_run* run, const char* title, double seconds);

#endif
