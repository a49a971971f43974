/* Expected errors and times of methods, by regression in logarithms on the features of a scene. `tyndall figure
 * auto-model` fits them to the matrix of methods (docs/method/auto.md). */
#ifndef TY_CHOOSE_PREDICT_H
#define TY_CHOOSE_PREDICT_H

#include <tyndall/choose.h>

/* Terms of the regression: functions of the features. */
typedef enum ty_term {
    TY_TERM_ONE,
    TY_TERM_NOISE,            /* log of `noise` */
    TY_TERM_VERTICES,         /* log of 1 + `vertices` */
    TY_TERM_SURFACE_NOISE,    /* log of `surface_noise` */
    TY_TERM_SURFACE_VERTICES, /* log of 1 + `surface_vertices` */
    TY_TERM_MULTIPLE,         /* log of `multiple` */
    TY_TERM_FORWARD,          /* -log of 1 - `g` */
    TY_TERM_CELL,             /* log of 1 + `cell` */
    TY_TERM_SCATTERINGS,      /* log of the number of scatterings before absorption or escape */
    TY_TERM_ENCLOSED,         /* `enclosed` */
    TY_TERM_SURFACES,         /* 1 with surfaces */
    TY_TERM_PLACED_LIGHT,     /* 1 with point, spot or area lights */
    TY_TERM_ENVIRONMENT,      /* 1 with environments */
    TY_TERM_HETEROGENEOUS,    /* 1 with heterogeneous media */
    TY_TERM_SPAN,             /* log of 1 + `span` */
    TY_TERM_LIGHTS,           /* log of 1 + `light_count` */
    TY_TERM_VOXELS,           /* log of `voxels` over 64^3 */
    TY_TERM_TRIAL,            /* log of the method's `trials` */
    TY_TERM_TRIAL_NOISE,      /* log of `trial_noise` */
    TY_TERMS
} ty_term;

/* Fitted quantities, in logarithms. Times are processor times of one thread. */
typedef enum ty_fit {
    TY_FIT_ERROR,   /* relative RMSE without noise; path: standard deviation of a pixel by one path */
    TY_FIT_SOLVE,   /* s, of what is done once; path: unused */
    TY_FIT_VIEW,    /* s per pixel; path: s per path */
    TY_FIT_SURFACE, /* s per path of surfaces, the same for all methods with takes_surfaces */
    TY_FIT_FINE,    /* error of structure below a twelfth of the picture; path: unused */
    TY_FIT_UNTRIED, /* TY_FIT_ERROR without trials; path: unused */
    TY_FITS
} ty_fit;

/* Coefficients of one method. */
typedef struct ty_method_model {
    const char* name;
    double terms[TY_FITS][TY_TERMS];
} ty_method_model;

/* All methods that auto chooses among; the first is path. */
typedef struct ty_choice_model {
    int32_t count;
    const ty_method_model* methods;
} ty_choice_model;

extern const ty_choice_model ty_fitted_model;

/* A picture that is asked for. */
typedef struct ty_picture_size {
    double pixels, samples;
} ty_picture_size;

typedef struct ty_expectation {
    double error;   /* relative RMSE of means over 4 x 4 pixels */
    double seconds; /* of one processor */
} ty_expectation;

/* Errors and times below which a picture is as good as another: 2 % is hardly seen, and 1 s hardly waited for. */
extern const double ty_error_unseen, ty_seconds_unfelt;

/* Terms of the method of a number. */
void ty_terms_of(const ty_scene_features* features, int32_t method, double out[TY_TERMS]);
ty_expectation ty_expect(const ty_choice_model* model, int32_t method, const ty_scene_features* features,
                         const ty_picture_size* size);
/* The part of an error that is TY_FIT_FINE. */
double ty_expect_fine(const ty_choice_model* model, int32_t method, const ty_scene_features* features);
/* Error times the root of time, with the values above added to each: what noise of path costs whatever its number of
 * samples, so that a method costs less than path where path would have more error in its time. */
double ty_cost_of(const ty_expectation* of);

#endif
