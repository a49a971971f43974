/* Scenes rendered by a method, and errors against path tracing. */
#ifndef TY_FIGURES_VIEW_H
#define TY_FIGURES_VIEW_H

#include "figures/figure.h"
#include "cli/methods/methods.h"

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

/* The mean of R, G and B over all pixels, W m^-2 sr^-1. */
double figure_mean(const ty_image* image);

/* ---- tables of scenes and variants ---- */

enum { FIGURE_OVERRIDES_MAX = 6, FIGURE_VARIANTS_MAX = 8, FIGURE_SCENES_MAX = 6 };

/* A scene in a setting. */
typedef struct figure_scene {
    const char* title;
    const char* scene;                           /* argument of figure_load_scene */
    const char* overrides[FIGURE_OVERRIDES_MAX]; /* "media[0].g=0.7"; ended by NULL */
    int32_t width, height;                       /* pixels of its images */
    const char* item;                            /* its name in files; NULL: the title */
    const char* quick;                           /* a further override with --quick, or NULL */
    const char* file;                            /* optional third-party data that it needs, or NULL */
    bool windows;                                /* with a synthetic environment: a dim room with windows and a light */
} figure_scene;

/* A method in a setting. */
typedef struct figure_variant {
    const char* title;
    const ty_method* method;
    const char* options; /* over those of the scene: "ordinates=64 prefilter=4"; NULL: none */
    bool level;          /* shown as bright as the reference */
    /* A renderer other than a method: it renders and records the time. NULL: by method. */
    ty_result (*render)(figure_run* run, const char* item, ty_scene* scene, const int32_t size[2], const void* user,
                        figure_picture* out);
    const void* user;
} figure_variant;

/* Path tracing, the reference. */
extern const figure_variant figure_path;

/* Loads a scene of a table. Errors: those of ty_scene_load. */
ty_result figure_load(figure_run* run, const figure_scene* from, ty_scene** out);

/* Fills in a method's def with the defaults, the scene's options, and options as in figure_variant. Errors:
 * TY_ERROR_ARGUMENT. */
ty_result figure_method_def(const ty_scene* scene, const ty_method* method, const char* options, void* def);

/* Renders, and records the time and what the method tells of its solve. report may be NULL. */
ty_result figure_render_variant(figure_run* run, const char* item, ty_scene* scene, const figure_variant* variant,
                                const int32_t size[2], figure_picture* out, cli_report* report);

/* A sheet of one scene: path tracing and variants in columns, with their errors below; added to the page with the color
 * bar. errors: one per variant. */
ty_result figure_show_variants(figure_run* run, const char* item, ty_scene* scene, const figure_variant* variants,
                               int count, const int32_t size[2], double picture_width, figure_errors* errors);
/* The same for a scene of a table, which is loaded. */
ty_result figure_show_scene(figure_run* run, const figure_scene* from, const figure_variant* variants, int count,
                            double picture_width, figure_errors* errors);

/* Scenes in columns and variants in rows, the first of which is the reference; items are "SCENE, VARIANT". */
typedef struct figure_matrix {
    const figure_scene* scenes;
    const figure_variant* variants;
    int scene_count, variant_count;
    figure_picture pictures[FIGURE_SCENES_MAX][FIGURE_VARIANTS_MAX];
    figure_errors errors[FIGURE_SCENES_MAX][FIGURE_VARIANTS_MAX];
} figure_matrix;

/* Renders all, and adds a sheet to the page. The caller frees the pictures in any case. */
ty_result figure_show_matrix(figure_run* run, figure_matrix* matrix, double picture_width);
void figure_free_matrix(figure_matrix* matrix);

/* Ends a caption: the block size of errors, and the correction of the relative RMSE for the reference's noise. */
void figure_describe_errors(figure_run* run, bool without_noise);

/* "0.123", or "< noise" for NaN. */
void figure_format_error(double error, char out[16]);

#endif
