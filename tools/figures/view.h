/* Scenes rendered by a method, and errors against path tracing. */
#ifndef TY_FIGURES_VIEW_H
#define TY_FIGURES_VIEW_H

#include "figures/figure.h"
#include "cli/methods.h"

/* Block size of averaged errors, pixels, which reduces the reference's noise. */
enum { FIGURE_BLOCK = 4 };

typedef struct figure_picture {
    ty_image* image; /* path-traced images have variance */
    double seconds;
    int32_t samples; /* paths per pixel */
} figure_picture;

/* Errors of an image against the path-traced one. */
typedef struct figure_errors {
    double mean_ratio;
    double relative_rmse; /* corrected for the reference's noise; NaN: below the noise */
    double rel_mse;
} figure_errors;

/* The size of images: from the options, or width x height, a quarter of each with --quick. */
void figure_view_size(const figure_run* run, int32_t width, int32_t height, int32_t size[2]);

/* Renders a scene and records the time. report: its measurements. */
ty_result figure_render(figure_run* run, const char* item, const ty_scene* scene, const ty_method* method,
                        const int32_t size[2], figure_picture* out, cli_report* report);
void figure_free_picture(figure_picture* picture);

/* The number of blocks in an image of this size. */
int32_t figure_block(const ty_image* image);
/* Compares with the path-traced image, and records the errors. */
ty_result figure_compare(figure_run* run, const char* item, const figure_picture* picture, const figure_picture* truth,
                         figure_errors* out);
/* Seconds for a number of paths per pixel, extrapolated from a path-traced image. */
double figure_paper_seconds(const figure_picture* truth);

/* Shows an image in a cell, with its time and, given a reference, its errors below. errors may be NULL. level: scaled
 * to the reference's brightness, which the text states. */
ty_result figure_show(figure_run* run, const char* item, const ty_scene* scene, const figure_picture* picture,
                      const figure_picture* truth, bool level, plot_cell* cell, figure_errors* errors);

/* A rendering variant of a scene. */
typedef struct figure_variant {
    const char* title;
    /* Renders, and records the time and other measurements. */
    ty_result (*render)(figure_run* run, const char* item, ty_scene* scene, const int32_t size[2], const void* user,
                        figure_picture* out);
    const void* user;
} figure_variant;

/* A figure_variant's render by a method with the scene's settings; user is the ty_method. */
ty_result figure_render_by_method(figure_run* run, const char* item, ty_scene* scene, const int32_t size[2],
                                  const void* user, figure_picture* out);

/* A sheet of one scene: path tracing and variants in columns, with their errors below; added to the page with the color
 * bar. errors: one per variant. */
ty_result figure_show_variants(figure_run* run, const char* item, ty_scene* scene, const figure_variant* variants,
                               int count, const int32_t size[2], double picture_width, figure_errors* errors);

/* Ends a caption: the block size of errors, and the correction of the relative RMSE for the reference's noise. */
void figure_describe_errors(figure_run* run, bool without_noise);

/* "0.123", or "< noise" for NaN. */
void figure_format_error(double error, char out[16]);

#endif
