/* The cube in a beam of Figs. 12 and 13. */
#ifndef TY_FIGURES_POP_CUBE_H
#define TY_FIGURES_POP_CUBE_H

#include "figures/pop_view.h"

/* The paper's 16^3 cells. */
extern const pop_box pop_cube_cells;

/* 1 m, sigma_s 4/m, nothing absorbed, lit from above (-z). */
ty_result pop_load_cube(figure_run* run, double g, ty_scene** out);
/* On as many cells, lobes kept. */
ty_pop_def pop_cube_def(figure_run* run, ty_pop_mode mode);

#endif
