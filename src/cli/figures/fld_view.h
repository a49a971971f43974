/* Scenes by path tracing, flux-limited and classical diffusion, beside one another. */
#ifndef TY_CLI_FIGURES_FLD_VIEW_H
#define TY_CLI_FIGURES_FLD_VIEW_H

#include "cli/figures/figure.h"

typedef enum fld_method { FLD_PATH = 0, FLD_LIMITED = 1, FLD_CLASSICAL = 2, FLD_METHODS = 3 } fld_method;

/* What errors are means over, against the truth's noise: blocks of so many pixels squared. */
enum { FLD_BLOCK = 4 };

extern const char* const fld_method_titles[FLD_METHODS];

typedef struct fld_picture {
    ty_image* image; /* path traced ones have variance */
    double seconds;
    int32_t samples; /* paths per pixel */
} fld_picture;

/* How a picture differs from the path-traced one. */
typedef struct fld_errors {
    double mean_ratio;
    double relative_rmse; /* without the truth's noise; NaN: that is all there is */
    double rel_mse;
} fld_errors;

/* The size of pictures: what the options say, or width x height, a quarter of it when quick. */
void fld_view_size(const figure_run* run, int32_t width, int32_t height, int32_t size[2]);

/* Renders a scene. Notes the time. */
ty_result fld_render(figure_run* run, const char* item, const ty_scene* scene, fld_method method, const int32_t size[2],
                     fld_picture* out);
void fld_free_picture(fld_picture* picture);

/* Compares with the path-traced picture, and notes what comes of it. */
ty_result fld_compare(figure_run* run, const char* item, const fld_picture* picture, const fld_picture* truth,
                      fld_errors* out);
/* Notes that FLD should be nearer to the truth than CDA. */
ty_result fld_expect_better(figure_run* run, const char* item, const fld_errors* limited, const fld_errors* classical);

/* A page of one scene by all methods, with maps of their errors. */
ty_result fld_show_scene(figure_run* run, const ty_scene* scene, const char* item, int32_t width, int32_t height);

#endif
