/* Figures: each has a name and a function that fills a page and records measurements. */
#ifndef TY_FIGURES_FIGURE_H
#define TY_FIGURES_FIGURE_H

#include "bench/noise.h"
#include "cli/session/session.h"
#include "plot/page.h"
#include "scenes/scenes.h"

enum { FIGURE_NAME_SIZE = 64, FIGURE_CAPTION_SIZE = 1024, FIGURE_PATH_SIZE = 4096 };

typedef struct figure_options {
    const char* folder; /* output folder */
    const char* data;   /* folder of third-party images and volumes, or NULL */
    int32_t size[2];    /* pixels of the pictures; 0: the figure's own choice */
    int32_t samples;    /* per pixel, of path-traced pictures; 0: the figure's own choice */
    bool quick;         /* fewer samples and smaller pictures */
    double latency;     /* of a message between ranks in the model of scaling, s */
    double bandwidth;   /* and bytes/s */
    bool keep;          /* reuse existing figures of this version and these options */
} figure_options;

/* One number of a figure. NaN: none. */
typedef struct figure_quantity {
    char item[FIGURE_NAME_SIZE], name[FIGURE_NAME_SIZE]; /* "scatter, thickness 4", "relative RMSE" */
    const char* unit;                                    /* "1" for ratios */
    double measured, expected, tolerance;                /* tolerance: maximum |measured - expected| */
} figure_quantity;

/* The state of a figure during its generation. */
typedef struct figure_run {
    cli_session* session;
    const figure_options* options;
    const char* name;
    plot_page page;
    char caption[FIGURE_CAPTION_SIZE];
    figure_quantity* quantities;
    size_t count, capacity;
    bool incomplete; /* a number is missing, because memory ran out */
    bool skipped;    /* set by figure_find_data: nothing is written */
} figure_run;

/* Sets the text below the page (printf-like). */
void figure_caption(figure_run* run, const char* format, ...) __attribute__((format(printf, 2, 3)));

/* Records a number; unit must outlive the run. When memory runs out, the run fails at its end. */
void figure_note(figure_run* run, const char* item, const char* name, const char* unit, double measured);
/* Records several numbers of an item: figure_notes(run, item, {"time", "s", seconds}, {"iterations", "1", count}). */
typedef struct figure_number {
    const char *name, *unit;
    double measured;
} figure_number;

void figure_note_numbers(figure_run* run, const char* item, const figure_number* numbers, size_t count);
#define figure_notes(run, item, ...)                                                                                   \
    figure_note_numbers(run, item, (const figure_number[]){__VA_ARGS__},                                               \
                        sizeof((const figure_number[]){__VA_ARGS__}) / sizeof(figure_number))

/* Records a number with its expected value; tolerance NaN: none. */
void figure_expect(figure_run* run, const char* item, const char* name, const char* unit, double measured,
                   double expected, double tolerance);
/* The path of a file of third-party data. If it is missing, prints a line on stderr, marks the run as skipped, and
 * returns false. */
bool figure_find_data(figure_run* run, const char* name, char path[FIGURE_PATH_SIZE]);
/* True if a file of third-party data exists, for figures where it is optional. */
bool figure_has_data(const figure_run* run, const char* name);

/* Loads a scene by tools_load_scene. Errors: those of ty_scene_load. */
ty_result figure_load_scene(figure_run* run, const char* name, const char* const* overrides, int32_t override_count,
                            ty_scene** out);

/* TY_CANCELLED after an interruption by the user: for work without a progress callback. */
ty_result figure_check_interrupt(void);

/* Samples per pixel: from the options, or the figure's own choice. */
int32_t figure_samples(const figure_run* run, int32_t choice);

/* Records the differences of a from b by ty_image_compare as quantities of an item. The expected energy of a method is
 * that of its reference within 1 %. */
ty_result figure_note_difference(figure_run* run, const char* item, const ty_image* a, const ty_image* b,
                                 ty_difference* out);
/* An error map: red where a is brighter than b, blue where it is darker, both of the same size, in percent of max(b,
 * mean(b) / 10); of means over block x block pixels, block from 1 to the image size. */
ty_result figure_error_map(figure_run* run, const ty_image* a, const ty_image* b, int32_t block, plot_picture* out);
extern const plot_scale figure_error_scale;

/* Adds a sheet to the page if the result is TY_OK, with a color bar below it unless that is NULL; frees the sheet. */
void figure_place_sheet(figure_run* run, ty_result result, plot_sheet* sheet, const plot_scale* bar);

/* The figures, in the order of papers: method and subject, which form the name, the paper, the number in the paper ("":
 * none) and the title. */
#define FIGURES(X)                                                                                                     \
    X(screen, spread, SCREEN, "Fig. 4", "the spread of light over distance")                                           \
    X(screen, stages, SCREEN, "Figs. 1, 5", "inputs, steps and result")                                                \
    X(screen, leaking, SCREEN, "Fig. 6", "prevention of leaking")                                                      \
    X(screen, thickness, SCREEN, "Fig. 7", "optical thickness 2 to 8")                                                 \
    X(screen, truth, SCREEN, "Fig. 8", "against path tracing")                                                         \
    X(screen, photo, SCREEN, "Fig. 9", "a photograph in three media")                                                  \
    X(screen, table, SCREEN, "Table 1", "milliseconds")                                                                \
    X(fld, limiters, FLD, "Table 2", "flux limiters")                                                                  \
    X(fld, point, FLD, "Figs. 3, 5", "a point source, theory and solvers")                                             \
    X(fld, convergence, FLD, "Fig. 4", "convergence of the solvers")                                                   \
    X(fld, nebulae, FLD, "Fig. 1", "a nebula in vacuum")                                                               \
    X(fld, resolution, FLD, "Fig. 6", "full against quarter resolution")                                               \
    X(fld, albedo, FLD, "Fig. 7", "albedo 0.1 to 1")                                                                   \
    X(fld, ct, FLD, "Fig. 8", "a CT scan with a transfer function")                                                    \
    X(fld, fire, FLD, "Fig. 9", "a plume that glows")                                                                  \
    X(pop, prefilter, POP, "Fig. 6", "thin slabs, prefiltered")                                                        \
    X(pop, importance, POP, "Fig. 7", "few ordinates, where they count")                                               \
    X(pop, residuum, POP, "Fig. 8", "isotropic light in one grid")                                                     \
    X(pop, sphere, POP, "Fig. 10", "a point light in a sphere")                                                        \
    X(pop, smoke, POP, "Fig. 11", "smoke in an environment")                                                           \
    X(pop, lobes, POP, "Fig. 12", "where light goes in a cube")                                                        \
    X(pop, iterations, POP, "Fig. 13", "convergence of the propagation")                                               \
    X(pop, ordinates, POP, "Fig. 14", "numbers of ordinates and importance")                                           \
    X(pop, clouds, POP, "Fig. 15", "clouds, anisotropic and not")                                                      \
    X(pop, animation, POP, "Fig. 16", "a plume, frame by frame")                                                       \
    X(pop, surfaces, POP, "Fig. 17", "a solid in a medium")                                                            \
    X(pop, table, POP, "Fig. 14", "milliseconds of the typical setting")                                               \
    X(lpv, parts, LPV, "Fig. 5", "contribution of each part")                                                          \
    X(lpv, leaking, LPV, "Fig. 6", "thin walls, small lights, few iterations")                                         \
    X(lpv, truth, LPV, "Figs. 7, 8", "against path tracing")                                                           \
    X(lpv, shafts, LPV, "", "single scattering against path tracing")                                                  \
    X(lpv, animation, LPV, "", "sun and camera in small steps")                                                        \
    X(lpv, energy, LPV, "", "where the energy goes")                                                                   \
    X(lpv, dense, LPV, "", "thin to dense fog around a lamp")                                                          \
    X(lpv, table, LPV, "Table 1", "milliseconds of injection and propagation")                                         \
    X(impulse, tables, IMPULSE, "Fig. 10", "zonal harmonics over distance")                                            \
    X(bake, staircase, IMPULSE, "Fig. 8", "by vertex, media that vary")                                                \
    X(bake, cornell, IMPULSE, "Fig. 9", "lightmaps in fog, back-scattering")                                           \
    X(bake, lights, IMPULSE, "Fig. 12", "a lamp and the sun in fog")                                                   \
    X(bake, table, IMPULSE, "Section 5", "overhead of media over surfaces")                                            \
    X(dom, cube, DOM, "", "fluence of a cube in a beam")                                                               \
    X(dom, convergence, DOM, "", "sweeps against thickness, with diffusion's help and without")                        \
    X(dom, rays, DOM, "", "ray effects and false scattering")                                                          \
    X(dom, images, DOM, "", "images beside those of other methods")                                                    \
    X(dom, milk, DOM, "", "milk in a glass and in a ball")                                                             \
    X(auto, choice, AUTO, "", "loss of its choices against the best in their time")                                    \
    X(auto, model, AUTO, "", "the model that it chooses by, and its loss on scenes left out")                          \
    X(path, seeds, PATH, "", "means of images over seeds, lamps in media")                                             \
    X(path, guide, PATH, "", "led by a coarse solve of dom, in equal time")                                            \
    X(i3rc, step, I3RC, "Case 1", "the step cloud by columns")                                                         \
    X(scaling, ranks, SCALING, "", "one command by 1 to 4 ranks, and a model to 4096")                                 \
    X(matrix, scenes, MATRIX, "", "scenes of every kind, by path")                                                     \
    X(matrix, methods, MATRIX, "", "every method on scenes of every kind")                                             \
    X(matrix, fine, MATRIX, "", "errors of structure in larger pictures")                                              \
    X(matrix, check, MATRIX, "", "methods that are worse than the stored table has them")

#define FIGURE_DECLARE(method, subject, ...) ty_result figure_##method##_##subject(figure_run* run);
FIGURES(FIGURE_DECLARE)
#undef FIGURE_DECLARE

#endif
