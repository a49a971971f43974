/* Every method on every scene of the matrix: rendering by processes of their own, stored references, tables. */
#ifndef TY_FIGURES_MATRIX_H
#define TY_FIGURES_MATRIX_H

#include "figures/process.h"
#include "scenes/matrix.h"

enum {
    MATRIX_BLOCK = 12, /* pixels */
    MATRIX_BLOCKS = MATRIX_WIDTH / MATRIX_BLOCK * (MATRIX_HEIGHT / MATRIX_BLOCK),
    MATRIX_METHODS_MAX = 12,
    MATRIX_BAKES = 2,
    MATRIX_PATH_SIZE = FIGURE_PATH_SIZE + 128
};

/* Means of R, G and B over blocks of a scene's image by path, W m^-2 sr^-1. */
typedef struct matrix_reference {
    char name[MATRIX_NAME_SIZE];                      /* "": there is none */
    int32_t samples;                                  /* per pixel */
    double mean[MATRIX_BLOCKS], error[MATRIX_BLOCKS]; /* error: standard error of the mean */
} matrix_reference;

typedef enum matrix_state {
    MATRIX_RENDERED,
    MATRIX_REFUSED,  /* exit status 2: the method does not take the scene */
    MATRIX_FAILED,   /* another exit status, or pixels that are not finite */
    MATRIX_CRASHED,  /* ended by a signal */
    MATRIX_TOO_LONG, /* ended after matrix_seconds_max of processor time */
    MATRIX_LEFT_OUT  /* it was not tried, for the reason that the words tell */
} matrix_state;

/* Outcome of a method on a scene. */
typedef struct matrix_cell {
    matrix_state state;
    char words[FIGURE_WORDS_SIZE]; /* the program's message, if it rendered nothing */
    double ratio;                  /* mean over that of the reference */
    double rmse;                   /* relative, of means of blocks; corrected for the reference's noise */
    double seconds;                /* processor time without loading the scene */
    double view, surface;          /* parts of it: of the view, and of paths of surfaces or of all light */
    double deviation;              /* standard deviation of a pixel by one of these paths, over their mean */
    double means[MATRIX_BLOCKS];   /* of the picture's blocks */
    plot_picture picture;          /* owned */
} matrix_cell;

typedef struct matrix_row {
    matrix_scene scene;
    char name[MATRIX_NAME_SIZE];
    matrix_reference reference;
    double noise;       /* of the reference, relative to its mean */
    const char* choice; /* of method auto */
    ty_scene_features features;
    matrix_cell cells[MATRIX_METHODS_MAX];
    matrix_cell bakes[MATRIX_BAKES]; /* against path's irradiance; MATRIX_LEFT_OUT without surfaces */
    double bake_noise;               /* of the latter, relative to its mean */
    matrix_cell view;                /* of the viewer, against the picture of matrix_view_method by `tyndall render` */
    const char* view_method;
} matrix_row;

/* All scenes of a run, and the names of the methods in columns. */
typedef struct matrix_table {
    matrix_row* rows;
    int32_t row_count, method_count;
    int32_t samples; /* per pixel, of path and of surfaces */
    const char* methods[MATRIX_METHODS_MAX];
} matrix_table;

extern const int32_t matrix_seconds_max; /* of processor time a method has for a scene */

/* Runs `tyndall` with arguments, ended by NULL. Errors: TY_ERROR_MEMORY where no process can be started, TY_CANCELLED.
 */
ty_result matrix_run_tyndall(const char* const* arguments, figure_process* out);
/* Runs `tyndall render SCENE -o IMAGE --threads 1` with further arguments. */
ty_result matrix_render(const char* folder, const char* scene, const char* const* arguments, figure_process* out);
/* The image and the measurements (--stats) that matrix_render writes. */
void matrix_image_path(const char* folder, char out[MATRIX_PATH_SIZE]);
void matrix_stats_path(const char* folder, char out[MATRIX_PATH_SIZE]);
/* Sets a cell's state and words after a process without a result. */
void matrix_take_failure(const figure_process* process, matrix_cell* out);

/* Means of blocks of R, G and B; variances may be NULL. False if a pixel is not finite. */
bool matrix_block_means(const ty_image* image, double means[MATRIX_BLOCKS], double variances[MATRIX_BLOCKS]);

double matrix_mean(const double means[MATRIX_BLOCKS]);
/* Stops that bring the reference's mean to a middle gray. */
double matrix_exposure(const matrix_row* row);

/* Writes the scenes into a folder of the run's, whose name goes to folder, and makes the rows. The caller closes the
 * table in any case. Errors: TY_ERROR_FILE, TY_ERROR_MEMORY. */
ty_result matrix_open(figure_run* run, char folder[FIGURE_PATH_SIZE], matrix_table* table);
void matrix_close(matrix_table* table);
/* Renders, bakes and views all rows by all methods of the registry. Errors: those of the functions below. */
ty_result matrix_fill(figure_run* run, const char* folder, matrix_table* table);
/* The file of a row's scene. */
void matrix_scene_path(const char* folder, const matrix_row* row, char out[MATRIX_PATH_SIZE]);

/* The reference of a scene: stored, or of the file matrix_reference.txt in the run's folder, to which it is added if it
 * is missing there, where samples are given. Errors: TY_ERROR_INPUT (there is none), TY_ERROR_FILE, TY_CANCELLED. */
ty_result matrix_find_reference(figure_run* run, const char* folder, matrix_row* row);

/* Sets the choice of method auto for the scene of a path. Errors: those of ty_scene_load and ty_choose_method. */
ty_result matrix_choose(figure_run* run, const char* path, matrix_row* row);

/* The methods of `tyndall bake` in columns. */
extern const char* const matrix_bakes[MATRIX_BAKES];
/* Writes the meshes whose vertices are receivers into the folder. Errors: TY_ERROR_FILE. */
ty_result matrix_write_floors(figure_run* run, const char* folder);
/* Bakes the floor of a row's scene. Errors: TY_ERROR_MEMORY, TY_ERROR_FILE, TY_CANCELLED. */
ty_result matrix_bake(figure_run* run, const char* folder, matrix_row* row);
/* Compares the viewer's final picture with that of `tyndall render`, whose cell is filled in. Errors: as matrix_bake.
 */
ty_result matrix_view(figure_run* run, const char* folder, const matrix_table* table, matrix_row* row);

enum { MATRIX_USE_SIZE = 16 };
/* Methods, bakes and the view as one list of columns: their number, and the cell and the name of one. */
int32_t matrix_use_count(const matrix_table* table);
matrix_cell* matrix_use(const matrix_table* table, int32_t row, int32_t use, char name[MATRIX_USE_SIZE]);
/* Writes all cells as the table that is stored in tools/scenes/matrix_measured.txt. Errors: TY_ERROR_FILE,
 * TY_ERROR_MEMORY. */
ty_result matrix_write_measured(ty_context* context, const matrix_table* table, const char* path);
/* The stored cell of a scene; false if there is none. */
bool matrix_find_measured(const char* scene, const char* use, matrix_cell* out);

/* Writes the tables as Markdown. Errors: TY_ERROR_FILE, TY_ERROR_MEMORY. */
ty_result matrix_write_tables(ty_context* context, const matrix_table* table, const char* path);
/* True where a mean ratio is beyond 2/3 to 3/2, or nothing was rendered without a refusal. */
bool matrix_is_outlier(const matrix_cell* cell);

#endif
