/* Reliefs: the visible surfaces of a view as emissive, non-reflecting facets. */
#ifndef TY_FIGURES_SCREEN_RELIEF_H
#define TY_FIGURES_SCREEN_RELIEF_H

#include "figures/screen_view.h"

/* One facet per pixel, perpendicular to the camera's axis at the pixel's distance, with the pixel's radiance: without a
 * medium the camera image equals the view, and there are no sources outside the view. Water fills all space; NULL: no
 * medium. The scene is committed. Errors: TY_ERROR_MEMORY. */
ty_result screen_make_relief(figure_run* run, const screen_view* view, const screen_water* water, ty_scene** out);

#endif
