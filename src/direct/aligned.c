/* Separable means of voxels. */
#include "direct/aligned.h"

#include "base/context.h"

static bool is_aligned(const ty_medium_view* medium) {
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            if (row != column && medium->to_index[4 * row + column] != 0) return false;
    return true;
}

/* Negative densities count as 0 at every point, which means do not know of. */
static bool has_negative(const ty_medium_view* medium) {
    const int32_t* bricks = medium->grid.bricks;
    const size_t count = (size_t)bricks[0] * (size_t)bricks[1] * (size_t)bricks[2];
    for (size_t i = 0; i < count; ++i)
        if (medium->extremes[2 * i] < 0) return true;
    return false;
}

/* Cell `index` along axis a. */
static bool weigh(const ty_grid_medium* out, const ty_medium_view* medium, int32_t samples, int a, int32_t index,
                  ty_aligned_cell* cell) {
    const float *map = medium->to_index, last = (float)medium->grid.size[a];
    float at[2];
    for (int end = 0; end < 2; ++end) {
        const double share = end == 0 ? 0.5 / samples : 1 - 0.5 / samples;
        at[end] = map[5 * a] * (float)(out->box.lower[a] + out->cell[a] * (index + share)) + map[4 * a + 3];
    }
    *cell = (ty_aligned_cell){0};
    cell->first = (int32_t)floorf(ty_clampf(ty_minf(at[0], at[1]), -1, last));
    for (int32_t s = 0; s < samples; ++s) {
        const float x = samples > 1 ? ty_lerpf(at[0], at[1], (float)s / (float)(samples - 1)) : at[0];
        if (x < -1 || x > last) continue;
        const int32_t base = (int32_t)floorf(x), slot = base - cell->first;
        const float share = x - (float)base;
        if (slot < 0 || slot + 1 >= TY_ALIGNED_VOXELS) return false;
        cell->weight[slot] += (1 - share) / (float)samples;
        cell->weight[slot + 1] += share / (float)samples;
        if (slot + 2 > cell->count) cell->count = slot + 2;
    }
    return true;
}

static bool weigh_axis(const ty_grid_medium* out, const ty_medium_view* medium, int32_t samples, int a,
                       ty_aligned_cell* cells) {
    for (int32_t i = 0; i < out->box.size[a]; ++i)
        if (!weigh(out, medium, samples, a, i, &cells[i])) return false;
    return true;
}

ty_result ty_aligned_create(const ty_grid_medium* out, const ty_medium_view* medium, const int32_t samples[3],
                            ty_aligned* aligned) {
    *aligned = (ty_aligned){{NULL}};
    if (medium->has_grid == 0 || medium->transfer != NULL || !is_aligned(medium) || has_negative(medium)) return TY_OK;
    bool fits = true;
    for (int a = 0; a < 3 && fits; ++a) {
        aligned->cells[a] = ty_alloc_array(out->context, (size_t)out->box.size[a], sizeof *aligned->cells[a], false);
        if (aligned->cells[a] == NULL) {
            ty_aligned_destroy(out, aligned);
            return TY_ERROR_MEMORY;
        }
        fits = weigh_axis(out, medium, samples[a], a, aligned->cells[a]);
    }
    if (!fits) ty_aligned_destroy(out, aligned);
    return TY_OK;
}

void ty_aligned_destroy(const ty_grid_medium* out, ty_aligned* aligned) {
    for (int a = 0; a < 3; ++a) {
        ty_free_array(out->context, aligned->cells[a], (size_t)out->box.size[a], sizeof *aligned->cells[a]);
        aligned->cells[a] = NULL;
    }
}

double ty_aligned_density(const ty_aligned* aligned, const ty_medium_view* medium, const int32_t cell[3]) {
    const ty_aligned_cell* x = &aligned->cells[0][cell[0]];
    const ty_aligned_cell* y = &aligned->cells[1][cell[1]];
    const ty_aligned_cell* z = &aligned->cells[2][cell[2]];
    double sum = 0;
    for (int32_t k = 0; k < z->count; ++k)
        for (int32_t j = 0; j < y->count; ++j) {
            float row = 0;
            for (int32_t i = 0; i < x->count; ++i)
                row += x->weight[i] * ty_grid_fetch(&medium->grid, x->first + i, y->first + j, z->first + k);
            sum += (double)(z->weight[k] * y->weight[j] * row);
        }
    return sum;
}
