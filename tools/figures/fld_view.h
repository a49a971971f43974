/* Scenes by path tracing, flux-limited and classical diffusion, beside one another. */
#ifndef TY_FIGURES_FLD_VIEW_H
#define TY_FIGURES_FLD_VIEW_H

#include "figures/view.h"

typedef enum fld_method { FLD_PATH = 0, FLD_LIMITED = 1, FLD_CLASSICAL = 2, FLD_METHODS = 3 } fld_method;

extern const char* const fld_method_titles[FLD_METHODS];

/* Renders a scene and records the time. */
ty_result fld_render(figure_run* run, const char* item, const ty_scene* scene, fld_method method, const int32_t size[2],
                     figure_picture* out);

/* Records the expectation that the error of FLD is below that of CDA. */
ty_result fld_expect_better(figure_run* run, const char* item, const figure_errors* limited,
                            const figure_errors* classical);

/* A page of one scene by all methods, with maps of their errors. */
ty_result fld_show_scene(figure_run* run, const ty_scene* scene, const char* item, int32_t width, int32_t height);

#endif
