/* State of one call of ty_screen_apply. */
#ifndef TY_METHOD_SCREEN_JOB_H
#define TY_METHOD_SCREEN_JOB_H

#include "base/arena.h"
#include "method/screen/kernel.h"

#include <tyndall/screen.h>

enum { TY_SCREEN_SIDE_MAX = 65536, TY_SCREEN_LEVELS_DEFAULT = 6 };

/* Copies a caller's def to own, in the library's own size, and checks it. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_screen_take_def(ty_context* context, const ty_screen_def* def, ty_screen_def* own);
/* True if a def's filter and levels are supported. */
bool ty_screen_has_filter(const ty_screen_def* def);
bool ty_screen_has_levels(const ty_screen_def* def);
/* Copies a caller's image to own, in the library's own size, and checks it. out: true if image->out is required.
 * Errors: TY_ERROR_ARGUMENT. */
ty_result ty_screen_take_image(ty_context* context, const ty_screen_image* image, ty_screen_image* own, bool out);

typedef struct ty_screen_job {
    ty_context* context;
    const ty_screen_def* def;
    const ty_screen_image* image;
    const ty_screen_kernels* kernels;
    ty_screen_params params; /* parameters of the kernels */
    bool small_angle;        /* measures of spread are scattering optical thicknesses, else variances in pixels^2 */
    double width[3];         /* ty_screen_angle times the focal length, pixels */
    char* memory;            /* the workspace, aligned to 64 bytes */
    ty_screen_stats stats;
} ty_screen_job;

/* Limits of spread that no pixel exceeds. */
extern const float ty_screen_no_limit[3];

/* Row y of the caller's image. */
ty_screen_row ty_screen_image_row(const ty_screen_image* image, int32_t y);

/* Number of levels that an image size and a def allow, at least 1. */
int32_t ty_screen_level_limit(const ty_screen_def* def, int32_t width, int32_t height);

/* ty_parallel_for with denormals flushed to 0. ty_screen_serial runs in the calling thread. */
void ty_screen_parallel(ty_screen_job* job, int64_t count, ty_parallel_fn body, void* user);
void ty_screen_serial(int64_t count, ty_parallel_fn body, void* user);

/* Sums the counts of the bands of an image into the statistics. */
void ty_screen_sum_counts(ty_screen_job* job, const ty_screen_counts* counts, int32_t band_count);
/* The half-light radius, pixels, of a measure of spread. */
double ty_screen_radius(const ty_screen_job* job, int channel, double measure);

/* Workspace size and implementation of each variant. */
size_t ty_screen_scatter_size(const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height);
ty_result ty_screen_scatter(ty_screen_job* job);
size_t ty_screen_gather_size(const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height);
ty_result ty_screen_gather(ty_screen_job* job);
size_t ty_screen_reference_size(const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height);
ty_result ty_screen_reference(ty_screen_job* job);

#endif
