/* Baked irradiance at the surfaces visible to a camera, for figures: per pixel, or at the vertices around each pixel.
 */
#ifndef TY_FIGURES_BAKE_VIEW_H
#define TY_FIGURES_BAKE_VIEW_H

#include "figures/view.h"

#include <tyndall/bake.h>

/* A pixel: three receivers and their interpolation weights. */
typedef struct bake_pixel {
    int64_t at[3]; /* -1: no surface */
    float weight[3];
} bake_pixel;

typedef struct bake_view {
    int32_t size[2];
    bake_pixel* pixels;
    ty_bake_receiver* receivers;
    int64_t count;
} bake_view;

/* The light component. */
typedef enum bake_component {
    BAKE_ALL = 0,
    BAKE_SCATTERED = 1 /* single and multiple scattering only */
} bake_component;

/* by_vertex: receivers at the vertices of meshes, without shapes. The scene has no area lights. */
ty_result bake_view_create(const ty_scene* scene, const int32_t size[2], bool by_vertex, bake_view* out);
void bake_view_free(bake_view* view);

/* Bakes the receivers; the caller frees the result. Records the time. */
ty_result bake_view_light(figure_run* run, const char* item, const ty_scene* scene, const ty_bake_def* def,
                          const ty_bake_receiver* receivers, int64_t count, ty_bake_light** out, double* seconds);
/* An image of the irradiance. */
ty_result bake_view_image(figure_run* run, const bake_view* view, const ty_bake_light* light, bake_component component,
                          ty_image** out);

/* Errors of the receivers' irradiance against the reference. */
typedef struct bake_errors {
    double mean_ratio, relative_rmse; /* for BAKE_ALL corrected for the reference's noise; NaN: below the noise */
} bake_errors;

bake_errors bake_compare(const ty_bake_light* light, const ty_bake_light* truth, int64_t count,
                         bake_component component);
/* Records the errors; checked: with the baker's tolerances. */
void bake_note_errors(figure_run* run, const char* item, const bake_errors* errors, bool checked);
/* "WHAT 0.123, RMSE 4.5 %", or "< noise". */
void bake_write_errors(const char* what, const bake_errors* errors, char line[PLOT_LABEL_SIZE]);

/* The paths per receiver of methods and of the reference. */
int32_t bake_spp(const figure_run* run, bool truth);

#endif
