/* Scenes by light propagation volumes with given settings and by path tracing; errors in shadow. */
#ifndef TY_FIGURES_LPV_VIEW_H
#define TY_FIGURES_LPV_VIEW_H

#include "figures/view.h"
#include "scenes/scenes.h"
#include "method/lpv/job.h"

/* A rendering variant in words of ty_lpv_def; mode NULL: path tracing. */
typedef struct lpv_variant {
    const char *title, *mode, *parts;
    int32_t iterations;      /* 0: default of the mode */
    int32_t bands, cascades; /* 0: as in the scene */
} lpv_variant;

/* The options of the scene, which its schema has checked, over the defaults; and those of a variant over both. */
ty_lpv_def lpv_scene_def(const ty_scene* scene);
ty_lpv_def lpv_variant_def(const ty_scene* scene, const lpv_variant* variant);

/* Renders and records the time. stats may be NULL. */
ty_result lpv_render(figure_run* run, const char* item, ty_scene* scene, const lpv_variant* variant,
                     const int32_t size[2], figure_picture* out, ty_lpv_stats* stats);

/* The scene by shadow maps alone: black where surfaces are in shadow. *out is freed with ty_image_destroy. */
ty_result lpv_render_direct(const ty_scene* scene, const int32_t size[2], ty_image** out);

/* Records the errors against the path-traced image in blocks entirely in shadow, by the image of shadow maps alone.
 * Without shadow all errors are NaN. */
ty_result lpv_compare_shadow(figure_run* run, const char* item, const figure_picture* picture,
                             const figure_picture* truth, const ty_image* direct, figure_errors* out);

/* The mean of R, G and B over all pixels, W m^-2 sr^-1. */
double lpv_mean(const ty_image* image);

#endif
