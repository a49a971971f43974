/* Means of planes on a box's cells over the cells of another box. */
#ifndef TY_DIRECT_MEDIA_COVERAGE_H
#define TY_DIRECT_MEDIA_COVERAGE_H

#include "direct/media/grid_medium.h"

/* A caller's box, m, cut into cells. One without extent along an axis is a plane, line or point. */
typedef struct ty_cover_box {
    const double *lower, *upper;
    const int32_t* size;
} ty_cover_box;

/* The cells of a box that a caller's cell covers along one axis, and how far it reaches. */
typedef struct ty_cover {
    int32_t first, count;
    double lower, upper; /* in cells */
} ty_cover;

/* Errors: TY_ERROR_ARGUMENT, where it is no such box. */
ty_result ty_cover_check(ty_context* context, const ty_cover_box* box);
/* A caller's cell in a box. */
void ty_cover_cell(const ty_grid_box* box, const ty_cover_box* callers, const int32_t cell[3], ty_cover axes[3]);
/* How much of what a cover spans one of its cells is. */
double ty_cover_share(const ty_cover* cover, int32_t cell);
/* Adds the mean over what three covers span, of planes of a box's cells, times scale, to out[]. */
void ty_cover_add(const ty_grid_box* box, const ty_cover axes[3], const float* const* planes, int32_t plane_count,
                  double scale, double* out);

#endif
