/* Texts about figures' numbers. */
#ifndef TY_FIGURES_SUMMARY_WORDS_H
#define TY_FIGURES_SUMMARY_WORDS_H

#include "figures/summary.h"

enum { FIGURE_WORDS_SIZE = 96 };

/* "1 ± 0.2". */
void figure_describe_expected(const figure_group* group, char out[FIGURE_WORDS_SIZE]);
/* "0.95 to 1.03". */
void figure_describe_measured(const figure_group* group, char out[FIGURE_WORDS_SIZE]);
/* "all 12", "10 of 12, 1 below the noise". */
void figure_describe_within(size_t within, size_t unknown, size_t count, char out[FIGURE_WORDS_SIZE]);
void figure_describe_outcome(const figure_outcome* outcome, char out[FIGURE_WORDS_SIZE]);

#endif
