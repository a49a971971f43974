/* Summary of figures: their numbers, read back from their files, with expected values. */
#ifndef TY_FIGURES_SUMMARY_H
#define TY_FIGURES_SUMMARY_H

#include "figures/list.h"

typedef enum figure_state {
    FIGURE_ABSENT = 0, /* neither requested nor present */
    FIGURE_EARLIER,    /* not requested, present from an earlier call */
    FIGURE_MADE,
    FIGURE_KEPT,    /* requested, already present */
    FIGURE_SKIPPED, /* its input is missing */
    FIGURE_FAILED,
    FIGURE_LEFT /* not run after an interruption */
} figure_state;

typedef struct figure_outcome {
    const figure_entry* entry;
    figure_state state;
    int status;        /* of FIGURE_FAILED: its exit status */
    char message[512]; /* of FIGURE_SKIPPED and FIGURE_FAILED: why */
    /* Fields of figures that are present. */
    double seconds;
    bool quick;
    bool own_settings; /* neither --quick nor --size nor --spp */
    char version[32];
    char* caption;
    figure_quantity* quantities; /* unit in unit_texts */
    char (*unit_texts)[FIGURE_NAME_SIZE];
    size_t count;
    size_t checked, within; /* quantities with a tolerance, and those within it */
    size_t compared;        /* quantities with an expected value and no tolerance */
    size_t unknown;         /* quantities with a tolerance, whose value is below the noise */
} figure_outcome;

typedef struct figure_summary {
    const char* folder;
    figure_outcome* outcomes; /* one for each of figure_entries */
} figure_summary;

/* Quantities of one name, either all with a tolerance or all without. */
typedef struct figure_group {
    const figure_quantity* first;
    size_t count, within, unknown;
    bool checked; /* the quantities have a tolerance */
    bool same;    /* all have the same expected value and tolerance */
    /* Range of measured values if `same`; else of |measured - expected| / tolerance if `checked`; else of measured /
     * expected. Infinite if nothing is known. */
    double min, max;
    char out[200]; /* the items beyond the tolerance, truncated */
} figure_group;

bool figure_is_there(const figure_outcome* outcome);
/* True for a figure that is present or requested; true for a paper with such a figure. */
bool figure_is_listed(const figure_outcome* outcome);
bool figure_has_paper(const figure_summary* summary, int paper);
/* "made", "kept". */
const char* figure_state_name(figure_state state);

/* True if the files of a figure exist, made by this version with the same options. */
bool figure_can_keep(cli_session* session, const figure_options* options, const char* name);

/* Reads the files of made and kept figures, and finds those of earlier calls. Errors: TY_ERROR_MEMORY. */
ty_result figure_read_summary(cli_session* session, figure_summary* summary);
void figure_free_summary(figure_summary* summary);

/* The index-th group of a figure's quantities with an expected value: those with a tolerance first. false: past the
 * last. */
bool figure_get_group(const figure_outcome* outcome, size_t index, figure_group* out);
/* True if a quantity is within its tolerance; NaN means no number. */
bool figure_is_within(const figure_quantity* quantity);

/* Writes summary.csv, summary.md for docs/figures.md, and index.html. Errors: TY_ERROR_FILE,
 * TY_ERROR_MEMORY. */
ty_result figure_write_summary(cli_session* session, const figure_summary* summary);

#endif
