/* Scenes by discrete ordinates with settings of their own, and their fluence. */
#ifndef TY_FIGURES_DOM_VIEW_H
#define TY_FIGURES_DOM_VIEW_H

#include "figures/pop_view.h"

/* Renders, as the scene has its settings or with those given (NULL: none). Notes the time, that before the march and
 * sweeps. */
ty_result dom_render(figure_run* run, const char* item, ty_scene* scene, const ty_dom_settings* settings,
                     const int32_t size[2], figure_picture* out);
/* A figure_variant's render with settings, which user is. */
ty_result dom_render_variant(figure_run* run, const char* item, ty_scene* scene, const int32_t size[2],
                             const void* user, figure_picture* out);

/* Solves with so many directions, and in a last sweep (0: there is none), on so many cells along the longest side (0:
 * the method's own choice). */
ty_result dom_solve(figure_run* run, const ty_scene* scene, int32_t directions, int32_t last, int32_t resolution,
                    ty_dom** out, ty_dom_stats* stats);
/* Fluence of what has scattered: all but the truth's uncollided light, since the method counts light that is sent
 * nearly straight on as uncollided; in isotropic media, which have none of that, truth may be NULL, and edges of
 * shadows do not count. */
ty_result dom_scattered_fluence(const ty_dom* light, const pop_box* box, const pop_truth* truth, double (*out)[3]);

#endif
