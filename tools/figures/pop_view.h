/* Scenes by principal-ordinates propagation with given settings, and by path tracing. */
#ifndef TY_FIGURES_POP_VIEW_H
#define TY_FIGURES_POP_VIEW_H

#include "figures/view.h"

/* The options of the scene, which its schema has checked, over the defaults. */
ty_pop_def pop_scene_def(const ty_scene* scene);

/* Renders by pop, or with settings NULL by path tracing. Records the time, for pop also the time before the march.
 * stats may be NULL. */
ty_result pop_render(figure_run* run, const char* item, ty_scene* scene, const ty_pop_def* settings,
                     const int32_t size[2], figure_picture* out, ty_pop_stats* stats);

/* A figure_variant's render; user is the settings. */
ty_result pop_render_variant(figure_run* run, const char* item, ty_scene* scene, const int32_t size[2],
                             const void* user, figure_picture* out);

/* A scene from text with a synthetic environment: a dim room with windows and a light. */
ty_result pop_make_scene(figure_run* run, const char* name, const char* const* overrides, int32_t override_count,
                         ty_scene** out);

/* Noise smoke, 2 m across, in this environment, with the paper's coefficients of Fig. 11. */
ty_result pop_make_smoke(figure_run* run, const char* const* overrides, int32_t override_count, ty_scene** out);

/* ---- fluence ---- */

typedef struct pop_box {
    double lower[3], upper[3];
    int32_t size[3];
} pop_box;

enum { POP_CELLS_MAX = 16 * 16 * 16 };

/* Scattered and uncollided fluence by path tracing, W m^-2. */
typedef struct pop_truth {
    double scattered[POP_CELLS_MAX][3], variance[POP_CELLS_MAX][3], uncollided[POP_CELLS_MAX][3];
} pop_truth;

size_t pop_box_cells(const pop_box* box);
ty_result pop_path_fluence(figure_run* run, const ty_scene* scene, const pop_box* box, int32_t samples, pop_truth* out);
ty_result pop_scattered_fluence(const ty_pop* light, const pop_box* box, double (*out)[3]);
/* The ratio of means, and the relative RMSE corrected for the reference's noise. */
figure_errors pop_compare_fluence(const pop_box* box, const double (*fluence)[3], const pop_truth* truth);

#endif
