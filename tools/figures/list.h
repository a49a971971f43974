/* The list of figures, and their papers. */
#ifndef TY_FIGURES_LIST_H
#define TY_FIGURES_LIST_H

#include "figures/figure.h"

enum { FIGURE_TITLE_SIZE = 192 };

typedef enum figure_paper_index {
    FIGURE_SCREEN,
    FIGURE_FLD,
    FIGURE_POP,
    FIGURE_LPV,
    FIGURE_IMPULSE,
    FIGURE_DOM,
    FIGURE_AUTO,
    FIGURE_PATH,
    FIGURE_I3RC,
    FIGURE_SCALING,
    FIGURE_MATRIX,
    FIGURE_PAPERS
} figure_paper_index;

typedef struct figure_paper {
    const char* method;
    const char* citation; /* "": from no paper */
} figure_paper;

typedef struct figure_entry {
    const char* name; /* method, dash, subject */
    figure_paper_index paper;
    const char* number; /* number in the paper: "Figs. 3, 5"; "": none */
    const char* title;
    ty_result (*make)(figure_run* run);
} figure_entry;

extern const figure_paper figure_papers[FIGURE_PAPERS];
/* In the order of papers. */
extern const figure_entry figure_entries[];
extern const int figure_entry_count;

/* "Flux-limited diffusion: flux limiters (Table 2)". */
void figure_full_title(const figure_entry* entry, char out[FIGURE_TITLE_SIZE]);

#endif
