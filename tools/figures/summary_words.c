/* Texts about figures' numbers. */
#include "figures/summary_words.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void figure_describe_expected(const figure_group* group, char out[FIGURE_WORDS_SIZE]) {
    const char* unit = strcmp(group->first->unit, "1") == 0 ? "" : group->first->unit;
    const char* gap = unit[0] != '\0' ? " " : "";
    if (!group->same)
        snprintf(out, FIGURE_WORDS_SIZE, "each its own%s", group->checked ? ", ± its tolerance" : "");
    else if (group->checked && group->first->expected == 0)
        snprintf(out, FIGURE_WORDS_SIZE, "at most %.4g%s%s", group->first->tolerance, gap, unit);
    else if (group->checked)
        snprintf(out, FIGURE_WORDS_SIZE, "%.4g ± %.4g%s%s", group->first->expected, group->first->tolerance, gap, unit);
    else
        snprintf(out, FIGURE_WORDS_SIZE, "%.4g%s%s", group->first->expected, gap, unit);
}

void figure_describe_measured(const figure_group* group, char out[FIGURE_WORDS_SIZE]) {
    const char* what = group->same ? "" : group->checked ? " of the tolerance off" : " of the expected value";
    if (!(group->min <= group->max))
        snprintf(out, FIGURE_WORDS_SIZE, "below the noise");
    else if (!group->same && group->checked)
        snprintf(out, FIGURE_WORDS_SIZE, "at most %.3g%s", group->max, what);
    else if (group->max - group->min <= 1e-4 * fabs(group->max))
        snprintf(out, FIGURE_WORDS_SIZE, "%.4g%s", group->min, what);
    else
        snprintf(out, FIGURE_WORDS_SIZE, "%.4g to %.4g%s", group->min, group->max, what);
}

void figure_describe_within(size_t within, size_t unknown, size_t count, char out[FIGURE_WORDS_SIZE]) {
    out[0] = '\0';
    if (count == 0) return;
    if (unknown == count) {
        snprintf(out, FIGURE_WORDS_SIZE, "below the noise");
        return;
    }
    if (within == count)
        snprintf(out, FIGURE_WORDS_SIZE, count == 1 ? "yes" : "all %zu", count);
    else
        snprintf(out, FIGURE_WORDS_SIZE, "%zu of %zu", within, count);
    const size_t used = strlen(out);
    if (unknown > 0) snprintf(out + used, FIGURE_WORDS_SIZE - used, ", %zu below the noise", unknown);
}

void figure_describe_outcome(const figure_outcome* outcome, char out[FIGURE_WORDS_SIZE]) {
    figure_describe_within(outcome->within, outcome->unknown, outcome->checked, out);
}
