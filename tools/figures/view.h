/* Scenes by a method, and how far its picture is from a path-traced one. */
#ifndef TY_FIGURES_VIEW_H
#define TY_FIGURES_VIEW_H

#include "figures/figure.h"
#include "cli/methods.h"

/* What errors are means over, against the truth's noise: blocks of so many pixels squared. */
enum { FIGURE_BLOCK = 4 };

typedef struct figure_picture {
    ty_image* image; /* path traced ones have variance */
    double seconds;
    int32_t samples; /* paths per pixel */
} figure_picture;

/* How a picture differs from the path-traced one. */
typedef struct figure_errors {
    double mean_ratio;
    double relative_rmse; /* without the truth's noise; NaN: that is all there is */
    double rel_mse;
} figure_errors;

/* The size of pictures: what the options say, or width x height, a quarter of it when quick. */
void figure_view_size(const figure_run* run, int32_t width, int32_t height, int32_t size[2]);

/* Renders a scene. Notes the time. report: what it did. */
ty_result figure_render(figure_run* run, const char* item, const ty_scene* scene, const cli_method* method,
                        const int32_t size[2], figure_picture* out, cli_report* report);
void figure_free_picture(figure_picture* picture);

/* Blocks that a picture of this size has. */
int32_t figure_block(const ty_image* image);
/* Compares with the path-traced picture, and notes what comes of it. */
ty_result figure_compare(figure_run* run, const char* item, const figure_picture* picture, const figure_picture* truth,
                         figure_errors* out);
/* Seconds that so many paths a pixel would take where a path-traced picture took what it did. */
double figure_paper_seconds(const figure_picture* truth);

/* Shows a picture in a cell, and below it its time and, with a truth, how far it is from that. errors may be NULL.
 * level: made as bright as the truth, which is said. */
ty_result figure_show(figure_run* run, const char* item, const ty_scene* scene, const figure_picture* picture,
                      const figure_picture* truth, bool level, plot_cell* cell, figure_errors* errors);

/* A way to render a scene. */
typedef struct figure_variant {
    const char* title;
    /* Renders, and notes the time and what else there is to note. */
    ty_result (*render)(figure_run* run, const char* item, ty_scene* scene, const int32_t size[2], const void* user,
                        figure_picture* out);
    const void* user;
} figure_variant;

/* A figure_variant's render by a method, which user is (a cli_method), as the scene has its settings. */
ty_result figure_render_by_method(figure_run* run, const char* item, ty_scene* scene, const int32_t size[2],
                                  const void* user, figure_picture* out);

/* A sheet of one scene: path tracing and variants beside one another, and below them their errors; put on the page with
 * the colour bar. errors: one for each variant. */
ty_result figure_show_variants(figure_run* run, const char* item, ty_scene* scene, const figure_variant* variants,
                               int count, const int32_t size[2], double picture_width, figure_errors* errors);

/* Ends a caption: what errors are means over, and whether the truth's noise is out of the relative RMSE. */
void figure_tell_errors(figure_run* run, bool without_noise);

/* "0.123", or "< noise" for NaN. */
void figure_format_error(double error, char out[16]);

#endif
