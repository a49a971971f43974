/* The cube in a beam of Figs. 12 and 13. */
#ifndef TY_FIGURES_POP_CUBE_H
#define TY_FIGURES_POP_CUBE_H

#include "figures/fluence.h"

/* The paper's 16^3 cells. */
extern const fluence_box pop_cube_cells;

/* A cube of 1 m, sigma_s = 4/m, albedo 1, lit from above (-z). */
ty_result pop_load_cube(figure_run* run, double g, ty_scene** out);
/* Settings with the paper's number of cells, lobes stored. */
ty_pop_def pop_cube_def(figure_run* run, ty_pop_mode mode);

#endif
