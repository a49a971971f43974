#include "direct/media/coverage.h"

#include "base/context.h"
#include "base/check.h"

#include <math.h>

/* Coverage along an axis by cell `index` of `count` from lower to upper. A cell without extent is a point; the upper
 * face belongs to the box. */
static ty_coverage cover_along(const ty_grid_box* box, int axis, double lower, double upper, int32_t index,
                               int32_t count) {
    const double per_metre = box->size[axis] / (box->upper[axis] - box->lower[axis]);
    const double width = (upper - lower) / count;
    ty_coverage c = {.lower = (lower + width * index - box->lower[axis]) * per_metre,
                     .upper = (lower + width * (index + 1) - box->lower[axis]) * per_metre};
    if (upper == lower && upper == box->upper[axis]) c.lower = c.upper = box->size[axis] - 1;
    const double first = fmin(fmax(floor(c.lower), 0), box->size[axis]);
    const double end = fmin(fmax(fmax(ceil(c.upper), floor(c.lower) + 1), 0), box->size[axis]);
    c.first = (int32_t)first;
    c.count = (int32_t)(end - first);
    return c;
}

double ty_coverage_fraction(const ty_coverage* c, int32_t cell) {
    if (!(c->upper > c->lower)) return 1;
    return fmax(0, fmin(c->upper, cell + 1) - fmax(c->lower, cell)) / (c->upper - c->lower);
}

void ty_coverage_add(const ty_grid_box* box, const ty_coverage axes[3], const float* const* planes, int32_t plane_count,
                     double scale, double* out) {
    for (int32_t k = axes[2].first; k < axes[2].first + axes[2].count; ++k)
        for (int32_t j = axes[1].first; j < axes[1].first + axes[1].count; ++j) {
            const double row = scale * ty_coverage_fraction(&axes[2], k) * ty_coverage_fraction(&axes[1], j);
            const size_t base = (size_t)box->size[0] * ((size_t)j + (size_t)box->size[1] * (size_t)k);
            for (int32_t i = axes[0].first; i < axes[0].first + axes[0].count; ++i) {
                const double fraction = row * ty_coverage_fraction(&axes[0], i);
                for (int32_t p = 0; p < plane_count; ++p) out[p] += fraction * (double)planes[p][base + (size_t)i];
            }
        }
}

void ty_coverage_spread(const ty_grid_box* box, const ty_coverage axes[3], double value, float* plane) {
    for (int32_t k = axes[2].first; k < axes[2].first + axes[2].count; ++k)
        for (int32_t j = axes[1].first; j < axes[1].first + axes[1].count; ++j) {
            const double row = value * ty_coverage_fraction(&axes[2], k) * ty_coverage_fraction(&axes[1], j);
            float* to = plane + (size_t)box->size[0] * ((size_t)j + (size_t)box->size[1] * (size_t)k);
            for (int32_t i = axes[0].first; i < axes[0].first + axes[0].count; ++i)
                to[i] += (float)(row * ty_coverage_fraction(&axes[0], i));
        }
}

void ty_coverage_of_cell(const ty_grid_box* box, const ty_coverage_box* callers, const int32_t cell[3],
                         ty_coverage axes[3]) {
    for (int a = 0; a < 3; ++a)
        axes[a] = cover_along(box, a, callers->lower[a], callers->upper[a], cell[a], callers->size[a]);
}

ty_result ty_coverage_check(ty_context* context, const ty_coverage_box* box) {
    ty_result result = ty_check_point(context, "fluence: lower", box->lower);
    if (result == TY_OK) result = ty_check_point(context, "fluence: upper", box->upper);
    for (int a = 0; a < 3 && result == TY_OK; ++a)
        if (box->lower[a] > box->upper[a] || box->size[a] < 1 || box->size[a] > 65536)
            result = ty_fail(context, TY_ERROR_ARGUMENT,
                             "fluence: %d cells from %g to %g m are no cut of a box along axis %d", box->size[a],
                             box->lower[a], box->upper[a], a);
    return result;
}
