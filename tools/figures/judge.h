/* Checks of figures' numbers against their tolerances. */
#ifndef TY_FIGURES_JUDGE_H
#define TY_FIGURES_JUDGE_H

#include "figures/summary.h"

/* A number known to be beyond its tolerance. */
typedef struct figure_known_miss {
    const char *figure, *item, *quantity;
    const char* reason; /* one sentence */
} figure_known_miss;

/* Prints the numbers of a figure beyond their tolerance, known misses with their reason, and known misses that are
 * obsolete. Returns the number of unknown misses. Figures made with --quick, --size or --spp are not checked, because
 * tolerances hold for the figures' own sizes and samples. */
size_t figure_judge(cli_session* session, const figure_outcome* outcome);

#endif
