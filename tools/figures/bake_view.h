/* Light that is baked where a camera looks, for figures: at every pixel's surface, or at the vertices around it. */
#ifndef TY_FIGURES_BAKE_VIEW_H
#define TY_FIGURES_BAKE_VIEW_H

#include "figures/view.h"

#include <tyndall/bake.h>

/* A pixel: the receivers that it lies between, and their weights. */
typedef struct bake_pixel {
    int64_t at[3]; /* -1: it sees nothing */
    float weight[3];
} bake_pixel;

typedef struct bake_view {
    int32_t size[2];
    bake_pixel* pixels;
    ty_bake_receiver* receivers;
    int64_t count;
} bake_view;

/* What light is looked at. */
typedef enum bake_part { BAKE_ALL = 0, BAKE_SCATTERED = 1 /* single and multiple alone */ } bake_part;

/* by_vertex: the vertices of meshes; shapes are not seen then. The scene has no area lights. */
ty_result bake_view_create(const ty_scene* scene, const int32_t size[2], bool by_vertex, bake_view* out);
void bake_view_free(bake_view* view);

/* Light at receivers, to be freed; notes the time. */
ty_result bake_view_light(figure_run* run, const char* item, const ty_scene* scene, const ty_bake_def* def,
                          const ty_bake_receiver* receivers, int64_t count, ty_bake_light** out, double* seconds);
/* Irradiance as seen. */
ty_result bake_view_image(figure_run* run, const bake_view* view, const ty_bake_light* light, bake_part part,
                          ty_image** out);

/* How light at receivers differs from the truth. */
typedef struct bake_errors {
    double mean_ratio, relative_rmse; /* the truth's own noise is taken out of all light's; NaN: it is all there is */
} bake_errors;

bake_errors bake_compare(const ty_bake_light* light, const ty_bake_light* truth, int64_t count, bake_part part);
/* Notes them; judged: against the bounds that the baker is held to. */
ty_result bake_note_errors(figure_run* run, const char* item, const bake_errors* errors, bool judged);
/* "WHAT 0.123, RMSE 4.5 %", or "< noise". */
void bake_write_errors(const char* what, const bake_errors* errors, char line[PLOT_LABEL_SIZE]);

/* The paths per receiver of methods and of the truth. */
int32_t bake_spp(const figure_run* run, bool truth);

#endif
