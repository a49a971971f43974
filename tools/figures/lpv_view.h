/* Scenes by light propagation volumes with settings of their own, beside path tracing; errors where no light shines. */
#ifndef TY_FIGURES_LPV_VIEW_H
#define TY_FIGURES_LPV_VIEW_H

#include "figures/view.h"
#include "scenes/scenes.h"
#include "method/lpv/job.h"

/* A way to render: words of ty_lpv_settings; mode NULL: path tracing. */
typedef struct lpv_variant {
    const char *title, *mode, *parts;
    int32_t iterations;      /* 0: the mode's own */
    int32_t bands, cascades; /* 0: the scene's */
} lpv_variant;

/* The scene's settings with those of a variant. */
ty_lpv_settings lpv_variant_settings(const ty_scene* scene, const lpv_variant* variant);

/* Notes the time. stats may be NULL. */
ty_result lpv_render(figure_run* run, const char* item, ty_scene* scene, const lpv_variant* variant,
                     const int32_t size[2], figure_picture* out, ty_lpv_stats* stats);

/* The scene by shadow maps alone: black where surfaces are in shadow. *out is freed with ty_image_destroy. */
ty_result lpv_render_direct(const ty_scene* scene, const int32_t size[2], ty_image** out);

/* How a picture differs from the path-traced one in blocks that are wholly in shadow, by the picture of shadow maps
 * alone; noted. Where nothing is in shadow everything is NaN. */
ty_result lpv_compare_shadow(figure_run* run, const char* item, const figure_picture* picture,
                             const figure_picture* truth, const ty_image* direct, figure_errors* out);

/* The mean of R, G and B over all pixels, W m^-2 sr^-1. */
double lpv_mean(const ty_image* image);

#endif
