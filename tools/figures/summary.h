/* What came of figures: their numbers, read back from their files, beside what is expected. */
#ifndef TY_FIGURES_SUMMARY_H
#define TY_FIGURES_SUMMARY_H

#include "figures/list.h"

typedef enum figure_state {
    FIGURE_ABSENT = 0, /* neither asked for nor there */
    FIGURE_EARLIER,    /* not asked for, and there from an earlier call */
    FIGURE_MADE,
    FIGURE_KEPT,    /* asked for, and there already */
    FIGURE_SKIPPED, /* what it needs is not there */
    FIGURE_FAILED,
    FIGURE_LEFT /* not come to: interrupted */
} figure_state;

typedef struct figure_outcome {
    const figure_entry* entry;
    figure_state state;
    int status;        /* of FIGURE_FAILED: its exit status */
    char message[512]; /* of FIGURE_SKIPPED and FIGURE_FAILED: why */
    /* Of those that are there. */
    double seconds;
    bool quick;
    bool own_settings; /* neither --quick nor --size nor --spp */
    char version[32];
    char* caption;
    figure_quantity* quantities; /* unit in unit_texts */
    char (*unit_texts)[FIGURE_NAME_SIZE];
    size_t count;
    size_t checked, within; /* quantities that have a tolerance, and that keep it */
    size_t compared;        /* that have an expected value without one */
    size_t unknown;         /* that have a tolerance, and nothing that could be told from noise */
} figure_outcome;

typedef struct figure_summary {
    const char* folder;
    figure_outcome* outcomes; /* one for each of figure_entries */
} figure_summary;

/* Quantities of one name: those with a tolerance, or those that are compared without one. */
typedef struct figure_group {
    const figure_quantity* first;
    size_t count, within, unknown;
    bool checked; /* they have a tolerance */
    bool same;    /* one value is expected of all of them, and within one tolerance */
    /* Measured, where the same is expected; else, of those with a tolerance, distances over it; else, measured over
     * expected. Infinite where nothing is known. */
    double least, most;
    char out[200]; /* the items beyond the tolerance, as far as there is room */
} figure_group;

bool figure_is_there(const figure_outcome* outcome);
/* Whether it is there or was asked for; whether any of a paper's is. */
bool figure_is_listed(const figure_outcome* outcome);
bool figure_has_paper(const figure_summary* summary, int paper);
/* "made", "kept". */
const char* figure_state_name(figure_state state);

/* Whether the files of a figure are there, made by this version with the same options. */
bool figure_can_keep(cli_session* session, const figure_options* options, const char* name);

/* Reads what figures that are made or kept left, and looks for those of earlier calls. Errors: TY_ERROR_MEMORY. */
ty_result figure_read_summary(cli_session* session, figure_summary* summary);
void figure_free_summary(figure_summary* summary);

/* The index-th group of a figure's quantities that have an expected value: those with a tolerance first. false: there
 * are no more. */
bool figure_get_group(const figure_outcome* outcome, size_t index, figure_group* out);
/* Whether a quantity is as it should be; NaN: it has no number. */
bool figure_is_within(const figure_quantity* quantity);

/* summary.csv and summary.json, summary.md for docs/figures.md, index.md and index.html. Errors: TY_ERROR_FILE,
 * TY_ERROR_MEMORY. */
ty_result figure_write_summary(cli_session* session, const figure_summary* summary);

#endif
