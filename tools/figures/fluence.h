/* Scattered fluence in the cells of a box by path tracing and by methods. */
#ifndef TY_FIGURES_FLUENCE_H
#define TY_FIGURES_FLUENCE_H

#include "figures/view.h"

typedef struct fluence_box {
    double lower[3], upper[3];
    int32_t size[3];
} fluence_box;

enum { FLUENCE_CELLS_MAX = 16 * 16 * 16 };

/* Scattered and uncollided fluence by path tracing, W m^-2. */
typedef struct fluence_truth {
    double scattered[FLUENCE_CELLS_MAX][3], variance[FLUENCE_CELLS_MAX][3], uncollided[FLUENCE_CELLS_MAX][3];
} fluence_truth;

size_t fluence_cells(const fluence_box* box);
ty_result path_fluence(figure_run* run, const ty_scene* scene, const fluence_box* box, int32_t samples,
                       fluence_truth* out);
ty_result pop_fluence(const ty_pop* light, const fluence_box* box, double (*out)[3]);
/* The ratio of means, and the relative RMSE corrected for the reference's noise. */
figure_errors fluence_compare(const fluence_box* box, const double (*fluence)[3], const fluence_truth* truth);

/* Scattered fluence by discrete ordinates with a number of ordinates, a number for a final sweep (0: none), and cells
 * along the longest side or TY_AUTO: the total minus the reference's uncollided fluence, because the method counts
 * strongly forward-scattered light as uncollided. In isotropic media, without that component, truth can be NULL, and
 * shadow edges have no effect. */
ty_result dom_fluence(figure_run* run, const ty_scene* scene, int32_t directions, int32_t last, int32_t resolution,
                      const fluence_box* box, const fluence_truth* truth, double (*out)[3], ty_dom_stats* stats);

#endif
