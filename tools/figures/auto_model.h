/* The model of method auto: measurements that it is fitted to, the fit, and the cost of its choices. */
#ifndef TY_FIGURES_AUTO_MODEL_H
#define TY_FIGURES_AUTO_MODEL_H

#include "choose/predict.h"
#include "figures/matrix.h"

enum {
    AUTO_LARGE_PIXELS = 160 * 120,
    AUTO_METHODS = 6,
    AUTO_CANDIDATES = 5,
    AUTO_SURFACES = 1,
    AUTO_ROWS_MAX = MATRIX_SCENES
};

/* Methods that are measured: those that auto chooses among, path first and then one that traces surfaces, and behind
 * them what it leaves out. */
extern const char* const auto_methods[AUTO_METHODS];

/* Measurements of a method on a scene. */
typedef struct auto_measured {
    bool rendered;
    double error;         /* as TY_FIT_ERROR */
    double noise;         /* standard deviation of a pixel by one path of surfaces, over the mean of the picture */
    double solve;         /* s */
    double view;          /* s per pixel; path: s per path */
    double surface;       /* s per path of surfaces */
    double fine;          /* error of structure at 160 x 120 pixels; 0: not measured */
    double fine_fitted;   /* or as fitted */
    ty_expectation large; /* as measured at that size, with 32 samples per pixel; 0: not measured */
} auto_measured;

typedef struct auto_row {
    char name[MATRIX_NAME_SIZE];
    ty_scene_features features, untried; /* untried: without trials */
    double terms[AUTO_METHODS][TY_TERMS];
    auto_measured methods[AUTO_METHODS];
} auto_row;

/* A choice beside what was measured. */
typedef struct auto_judged {
    int32_t chosen, best; /* of auto_methods */
    ty_expectation expected, measured, best_measured;
    double loss; /* ratio of costs */
} auto_judged;

/* The stored error and time at 160 x 120 pixels; false if there is none. */
bool matrix_find_fine(const char* scene, const char* method, ty_expectation* out);
/* Fits all rows but `left_out` (-1: all). */
void auto_model_fit(const auto_row* rows, int32_t count, int32_t left_out, ty_method_model out[AUTO_METHODS]);
ty_expectation auto_measured_at(const auto_row* row, int32_t method, const ty_picture_size* size);
/* features: those of the row, or without trials. */
auto_judged auto_model_judge(const auto_row* row, const ty_scene_features* features, const ty_choice_model* model,
                             const ty_picture_size* size);

#endif
