/* Means of planes on a box's cells over the cells of another box. */
#ifndef TY_DIRECT_MEDIA_COVERAGE_H
#define TY_DIRECT_MEDIA_COVERAGE_H

#include "direct/media/grid_medium.h"

/* A caller's box, m, cut into cells. One without extent along an axis is a plane, line or point. */
typedef struct ty_coverage_box {
    const double *lower, *upper;
    const int32_t* size;
} ty_coverage_box;

/* The cells of a box that a caller's cell covers along one axis, and how far it reaches. */
typedef struct ty_coverage {
    int32_t first, count;
    double lower, upper; /* in cells */
} ty_coverage;

/* Errors: TY_ERROR_ARGUMENT, where it is no such box. */
ty_result ty_coverage_check(ty_context* context, const ty_coverage_box* box);
/* A caller's cell in a box. */
void ty_coverage_of_cell(const ty_grid_box* box, const ty_coverage_box* callers, const int32_t cell[3],
                         ty_coverage axes[3]);
/* How much of what a cover spans one of its cells is. */
double ty_coverage_fraction(const ty_coverage* cover, int32_t cell);
/* Adds the mean over what three covers span, of planes of a box's cells, times scale, to out[]. */
void ty_coverage_add(const ty_grid_box* box, const ty_coverage axes[3], const float* const* planes, int32_t plane_count,
                     double scale, double* out);

#endif
