/* Reliefs: what a view shows as surfaces that glow so and reflect nothing. */
#ifndef TY_FIGURES_SCREEN_RELIEF_H
#define TY_FIGURES_SCREEN_RELIEF_H

#include "figures/screen_view.h"

/* One facet a pixel, across the camera's axis at the pixel's distance, with the pixel's radiance: without a medium the
 * camera sees the view again, and nothing that the view does not show gives light. Water fills
 * everything; NULL: nothing does. The scene comes committed. Errors: TY_ERROR_MEMORY. */
ty_result screen_make_relief(figure_run* run, const screen_view* view, const screen_water* water, ty_scene** out);

#endif
