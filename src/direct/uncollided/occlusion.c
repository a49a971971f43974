/* Occlusion distances of rays that miss the box. */
#include "direct/uncollided/occlusion.h"

#include <string.h>

/* In units of a cell's sides. */
static const double shrink = 1e-3;

ty_occlusion_box ty_occlusion_box_of(const ty_grid_medium* medium) {
    ty_occlusion_box box;
    for (int a = 0; a < 3; ++a) {
        box.lower[a] = medium->box.lower[a] + shrink * medium->cell[a];
        box.upper[a] = medium->box.upper[a] - shrink * medium->cell[a];
    }
    return box;
}

static bool is_none(float distance) {
    return distance < 0;
}

static void fill_row(float* row, size_t count) {
    for (size_t i = 1; i < count; ++i)
        if (is_none(row[i])) row[i] = row[i - 1];
    for (size_t i = count - 1; i-- > 0;)
        if (is_none(row[i])) row[i] = row[i + 1];
}

/* Fills a row without defined distances from another. */
static void fill_from(float* row, const float* other, size_t count) {
    if (is_none(row[0])) memcpy(row, other, count * sizeof *row);
}

void ty_occlusion_fill(float* distances, int32_t columns, int32_t rows) {
    const size_t across = (size_t)columns, down = (size_t)rows;
    for (size_t row = 0; row < down; ++row) fill_row(distances + row * across, across);
    for (size_t row = 1; row < down; ++row) fill_from(distances + row * across, distances + (row - 1) * across, across);
    for (size_t row = down - 1; row-- > 0;) fill_from(distances + row * across, distances + (row + 1) * across, across);
}
