/* Numbers of figures held to their tolerances. */
#ifndef TY_FIGURES_JUDGE_H
#define TY_FIGURES_JUDGE_H

#include "figures/summary.h"

/* A number that is known to be beyond its tolerance. */
typedef struct figure_known_miss {
    const char *figure, *item, *quantity;
    const char* reason; /* one sentence */
} figure_known_miss;

/* Tells of the numbers of a figure that are beyond their tolerance, of known misses among them with their reason, and
 * of known misses that are none any more. Returns the count of misses that are not known. Figures that were made with
 * --quick, --size or --spp are not judged: tolerances are those of the figures' own sizes and samples. */
size_t figure_judge(cli_session* session, const figure_outcome* outcome);

#endif
