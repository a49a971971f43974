/* Scenes by discrete ordinates with settings of their own, and their fluence. */
#ifndef TY_FIGURES_DOM_VIEW_H
#define TY_FIGURES_DOM_VIEW_H

#include "figures/pop_view.h"

/* The options of the scene, which its schema has checked, over the defaults. */
ty_dom_def dom_scene_def(const ty_scene* scene);

/* Renders with the scene's settings, or with those given (NULL: none). Records the time, the time before the march, and
 * sweeps. */
ty_result dom_render(figure_run* run, const char* item, ty_scene* scene, const ty_dom_def* settings,
                     const int32_t size[2], figure_picture* out);
/* A figure_variant's render; user is the settings. */
ty_result dom_render_variant(figure_run* run, const char* item, ty_scene* scene, const int32_t size[2],
                             const void* user, figure_picture* out);

/* Solves with a number of ordinates, a number for a final sweep (0: none), and cells along the longest side (0: the
 * method's choice). */
ty_result dom_solve(figure_run* run, const ty_scene* scene, int32_t directions, int32_t last, int32_t resolution,
                    ty_dom** out, ty_dom_stats* stats);
/* Scattered fluence: the total minus the reference's uncollided fluence, because the method counts strongly
 * forward-scattered light as uncollided. In isotropic media, without that component, truth can be NULL, and shadow
 * edges have no effect. */
ty_result dom_scattered_fluence(const ty_dom* light, const pop_box* box, const pop_truth* truth, double (*out)[3]);

#endif
