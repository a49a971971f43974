/* Figures: each has a name and a function that fills a page and notes what it measured. */
#ifndef TY_FIGURES_FIGURE_H
#define TY_FIGURES_FIGURE_H

#include "bench/noise.h"
#include "cli/session.h"
#include "plot/page.h"
#include "scenes/scenes.h"

enum { FIGURE_NAME_SIZE = 64, FIGURE_CAPTION_SIZE = 1024, FIGURE_PATH_SIZE = 4096 };

typedef struct figure_options {
    const char* folder; /* to write to */
    const char* data;   /* folder of third-party images and volumes, or NULL */
    int32_t size[2];    /* pixels of the pictures; 0: the figure's own choice */
    int32_t samples;    /* per pixel, of path-traced pictures; 0: the figure's own choice */
    bool quick;         /* fewer samples and smaller pictures */
    bool keep;          /* what is there already, made by this version with these options */
} figure_options;

/* One number of a figure. NaN: there is none. */
typedef struct figure_quantity {
    char item[FIGURE_NAME_SIZE], name[FIGURE_NAME_SIZE]; /* "scatter, thickness 4", "relative RMSE" */
    const char* unit;                                    /* "1" for ratios */
    double measured, expected, tolerance;                /* tolerance: how far measured may be from expected */
} figure_quantity;

/* A figure in the making. */
typedef struct figure_run {
    cli_session* session;
    const figure_options* options;
    const char* name;
    plot_page page;
    char caption[FIGURE_CAPTION_SIZE];
    figure_quantity* quantities;
    size_t count, capacity;
    bool skipped; /* by figure_find_data: nothing is written */
} figure_run;

/* Notes a number; unit must outlive the run. Errors: TY_ERROR_MEMORY. */
ty_result figure_note(figure_run* run, const char* item, const char* name, const char* unit, double measured);
/* The same with what it should be; tolerance NaN: how near is not said. */
ty_result figure_expect(figure_run* run, const char* item, const char* name, const char* unit, double measured,
                        double expected, double tolerance);
/* The path of a file of third-party data. Where there is none, a line on stderr says so, the run is marked as skipped,
 * and false comes back. */
bool figure_find_data(figure_run* run, const char* name, char path[FIGURE_PATH_SIZE]);
/* Whether it is there, for figures that can do without. */
bool figure_has_data(const figure_run* run, const char* name);

/* A scene as tools_load_scene has it. Errors: as of ty_scene_load. */
ty_result figure_load_scene(figure_run* run, const char* name, const char* const* overrides, int32_t override_count,
                            ty_scene** out);

/* TY_CANCELLED once the user has interrupted: for work that takes no progress callback. */
ty_result figure_check_interrupt(void);

/* Samples per pixel: what the options say, or the figure's own choice. */
int32_t figure_samples(const figure_run* run, int32_t choice);

/* How a differs from b, as ty_image_compare has it, as quantities of an item. A method should keep the energy of its
 * reference within a hundredth. */
ty_result figure_note_difference(figure_run* run, const char* item, const ty_image* a, const ty_image* b,
                                 ty_difference* out);
/* Where a is brighter (red) or darker (blue) than b, of the same size, in percent of b or of a tenth of b's mean,
 * whichever is more; of means over block x block pixels, 1 or more and not more than there are. */
ty_result figure_error_map(figure_run* run, const ty_image* a, const ty_image* b, int32_t block, plot_picture* out);
extern const plot_scale figure_error_scale;

/* The figures. */
ty_result figure_auto_choice(figure_run* run);
ty_result figure_bake_cornell(figure_run* run);
ty_result figure_bake_lights(figure_run* run);
ty_result figure_bake_staircase(figure_run* run);
ty_result figure_fld_limiters(figure_run* run);
ty_result figure_fld_point(figure_run* run);
ty_result figure_fld_convergence(figure_run* run);
ty_result figure_fld_nebulae(figure_run* run);
ty_result figure_fld_resolution(figure_run* run);
ty_result figure_fld_albedo(figure_run* run);
ty_result figure_fld_ct(figure_run* run);
ty_result figure_fld_fire(figure_run* run);
ty_result figure_pop_prefilter(figure_run* run);
ty_result figure_pop_importance(figure_run* run);
ty_result figure_pop_residuum(figure_run* run);
ty_result figure_pop_sphere(figure_run* run);
ty_result figure_pop_smoke(figure_run* run);
ty_result figure_pop_lobes(figure_run* run);
ty_result figure_pop_iterations(figure_run* run);
ty_result figure_pop_ordinates(figure_run* run);
ty_result figure_pop_clouds(figure_run* run);
ty_result figure_pop_animation(figure_run* run);
ty_result figure_pop_surfaces(figure_run* run);
ty_result figure_lpv_parts(figure_run* run);
ty_result figure_lpv_leaking(figure_run* run);
ty_result figure_lpv_truth(figure_run* run);
ty_result figure_lpv_shafts(figure_run* run);
ty_result figure_lpv_animation(figure_run* run);
ty_result figure_lpv_energy(figure_run* run);
ty_result figure_lpv_dense(figure_run* run);
ty_result figure_dom_cube(figure_run* run);
ty_result figure_dom_convergence(figure_run* run);
ty_result figure_dom_rays(figure_run* run);
ty_result figure_dom_images(figure_run* run);
ty_result figure_screen_leaking(figure_run* run);
ty_result figure_screen_thickness(figure_run* run);
ty_result figure_screen_truth(figure_run* run);
ty_result figure_screen_photo(figure_run* run);
ty_result figure_screen_table(figure_run* run);
ty_result figure_impulse_tables(figure_run* run);
ty_result figure_screen_spread(figure_run* run);
ty_result figure_screen_stages(figure_run* run);
ty_result figure_lpv_table(figure_run* run);
ty_result figure_pop_table(figure_run* run);
ty_result figure_bake_table(figure_run* run);

#endif
