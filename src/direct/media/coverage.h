/* Means of a box's cells over a caller's cells in another box. */
#ifndef TY_DIRECT_MEDIA_COVERAGE_H
#define TY_DIRECT_MEDIA_COVERAGE_H

#include "direct/media/grid_medium.h"

/* A caller's box, m, divided into cells. Along an axis without extent its cells are planes, lines or points. */
typedef struct ty_coverage_box {
    const double *lower, *upper;
    const int32_t* size;
} ty_coverage_box;

/* The range of a box's cells that a caller's cell covers along one axis, and its bounds. */
typedef struct ty_coverage {
    int32_t first, count;
    double lower, upper; /* in cells */
} ty_coverage;

/* Errors: TY_ERROR_ARGUMENT for a box without cells or with its bounds swapped. */
ty_result ty_coverage_check(ty_context* context, const ty_coverage_box* box);
/* Coverage of a caller's cell along the three axes of a box. */
void ty_coverage_of_cell(const ty_grid_box* box, const ty_coverage_box* callers, const int32_t cell[3],
                         ty_coverage axes[3]);
/* The fraction of the caller's cell that one of the box's cells covers. */
double ty_coverage_fraction(const ty_coverage* c, int32_t cell);
/* Adds the means of planes over the caller's cell, times scale, to out[]. */
void ty_coverage_add(const ty_grid_box* box, const ty_coverage axes[3], const float* const* planes, int32_t plane_count,
                     double scale, double* out);
/* The transpose of ty_coverage_add for one plane: adds value times the fraction that each cell of the box has of the
 * caller's. */
void ty_coverage_spread(const ty_grid_box* box, const ty_coverage axes[3], double value, float* plane);

#endif
