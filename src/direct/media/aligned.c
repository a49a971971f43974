/* Separable cell means of grids whose axes are those of the cells. */
#include "direct/media/aligned.h"

#include "base/context.h"

static bool is_aligned(const ty_medium_view* medium) {
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            if (row != column && medium->to_index[4 * row + column] != 0) return false;
    return true;
}

/* True if a voxel is negative: lookups clamp each sample at 0, which separable means cannot. */
static bool has_negative(const ty_medium_view* medium) {
    const int32_t* bricks = medium->grid.bricks;
    const size_t count = (size_t)bricks[0] * (size_t)bricks[1] * (size_t)bricks[2];
    for (size_t i = 0; i < count; ++i)
        if (medium->extremes[2 * i] < 0) return true;
    return false;
}

/* Weights of the voxels along axis a for cell `index`; false if they do not fit. */
static bool find_weights(const ty_grid_medium* out, const ty_medium_view* medium, int32_t samples, int a, int32_t index,
                         ty_aligned_cell* cell) {
    const float *map = medium->to_index, last = (float)medium->grid.size[a];
    float at[2];
    for (int end = 0; end < 2; ++end) {
        const double t = end == 0 ? 0.5 / samples : 1 - 0.5 / samples;
        at[end] = map[5 * a] * (float)(out->box.lower[a] + out->cell[a] * (index + t)) + map[4 * a + 3];
    }
    *cell = (ty_aligned_cell){0};
    cell->first = (int32_t)floorf(ty_clampf(ty_minf(at[0], at[1]), -1, last));
    for (int32_t s = 0; s < samples; ++s) {
        const float x = samples > 1 ? ty_lerpf(at[0], at[1], (float)s / (float)(samples - 1)) : at[0];
        if (x < -1 || x > last) continue;
        const int32_t base = (int32_t)floorf(x), slot = base - cell->first;
        const float t = x - (float)base;
        if (slot < 0 || slot + 1 >= TY_ALIGNED_VOXELS) return false;
        cell->weight[slot] += (1 - t) / (float)samples;
        cell->weight[slot + 1] += t / (float)samples;
        if (slot + 2 > cell->count) cell->count = slot + 2;
    }
    return true;
}

static bool find_axis_weights(const ty_grid_medium* out, const ty_medium_view* medium, int32_t samples, int a,
                              ty_aligned_cell* cells) {
    for (int32_t i = 0; i < out->box.size[a]; ++i)
        if (!find_weights(out, medium, samples, a, i, &cells[i])) return false;
    return true;
}

ty_result ty_aligned_create(const ty_grid_medium* out, const ty_medium_view* medium, const int32_t samples[3],
                            ty_aligned* aligned) {
    *aligned = (ty_aligned){.scratch_size = (size_t)medium->grid.size[0] + 3 + (size_t)out->box.size[0]};
    if (medium->has_grid == 0 || medium->transfer != NULL || !is_aligned(medium) || has_negative(medium)) return TY_OK;
    bool fits = true, whole = true;
    for (int a = 0; a < 3 && fits && whole; ++a) {
        aligned->cells[a] = ty_alloc_array(out->context, (size_t)out->box.size[a], sizeof *aligned->cells[a], false);
        whole = aligned->cells[a] != NULL;
        fits = whole && find_axis_weights(out, medium, samples[a], a, aligned->cells[a]);
    }
    if (fits) {
        const size_t count = aligned->scratch_size * (size_t)ty_context_threads(out->context);
        aligned->scratch = ty_alloc_array(out->context, count, sizeof *aligned->scratch, false);
        whole = aligned->scratch != NULL;
    }
    if (!fits || !whole) ty_aligned_destroy(out, aligned);
    return whole ? TY_OK : TY_ERROR_MEMORY;
}

void ty_aligned_destroy(const ty_grid_medium* out, ty_aligned* aligned) {
    for (int a = 0; a < 3; ++a) {
        ty_free_array(out->context, aligned->cells[a], (size_t)out->box.size[a], sizeof *aligned->cells[a]);
        aligned->cells[a] = NULL;
    }
    ty_free_array(out->context, aligned->scratch, aligned->scratch_size * (size_t)ty_context_threads(out->context),
                  sizeof *aligned->scratch);
    aligned->scratch = NULL;
}

/* Adds a row of voxels times weight to sum, which starts one voxel before the first and ends two past the last. */
static void add_voxels(const ty_grid_view* grid, int32_t j, int32_t k, float weight, float* sum) {
    const int32_t nx = grid->size[0], ny = grid->size[1], nz = grid->size[2];
    const bool outside = j < 0 || k < 0 || j >= ny || k >= nz;
    for (int32_t i = -1; i < nx + 2; i += i < 0 ? nx + 1 : 1) sum[i + 1] += weight * ty_grid_fetch(grid, i, j, k);
    if (outside && grid->clamp == 0) {
        for (int32_t i = 0; i < nx; ++i) sum[i + 1] += weight * grid->background;
        return;
    }
    j = j < 0 ? 0 : j >= ny ? ny - 1 : j;
    k = k < 0 ? 0 : k >= nz ? nz - 1 : k;
    int32_t count;
    for (int32_t first = 0; first < nx; first += count) {
        size_t at;
        count = ty_grid_run(grid, first, j, k, &at);
        float* to = sum + first + 1;
        if (grid->floats == NULL) {
            for (int32_t i = 0; i < count; ++i) to[i] += weight * ty_half_to_float(grid->halves[at + (size_t)i]);
            continue;
        }
        const float* run = grid->floats + at;
#pragma omp simd
        for (int32_t i = 0; i < count; ++i) to[i] += weight * run[i];
    }
}

const float* ty_aligned_row(const ty_aligned* aligned, const ty_grid_medium* out, const ty_medium_view* medium,
                            int32_t y, int32_t z, int32_t worker) {
    const ty_aligned_cell *row = &aligned->cells[1][y], *layer = &aligned->cells[2][z];
    float* sum = aligned->scratch + aligned->scratch_size * (size_t)worker;
    float* means = sum + medium->grid.size[0] + 3;
    memset(sum, 0, ((size_t)medium->grid.size[0] + 3) * sizeof *sum);
    for (int32_t k = 0; k < layer->count; ++k)
        for (int32_t j = 0; j < row->count; ++j)
            add_voxels(&medium->grid, row->first + j, layer->first + k, layer->weight[k] * row->weight[j], sum);
    for (int32_t x = 0; x < out->box.size[0]; ++x) {
        const ty_aligned_cell* cell = &aligned->cells[0][x];
        const float* voxels = sum + cell->first + 1;
        float mean = 0;
        for (int32_t i = 0; i < cell->count; ++i) mean += cell->weight[i] * voxels[i];
        means[x] = mean;
    }
    return means;
}

/* The voxel that a lookup at an index reads; -1: the background. */
static int32_t voxel_read(const ty_grid_view* grid, int axis, int32_t index) {
    const int32_t last = grid->size[axis] - 1;
    if (index >= 0 && index <= last) return index;
    return grid->clamp == 0 ? -1 : index < 0 ? 0 : last;
}

void ty_aligned_spread_row(const ty_aligned* aligned, const ty_grid_medium* out, const ty_medium_view* medium,
                           int32_t y, int32_t z, const double* by_density, double* voxels) {
    const ty_grid_view* grid = &medium->grid;
    const ty_aligned_cell *row = &aligned->cells[1][y], *layer = &aligned->cells[2][z];
    for (int32_t k = 0; k < layer->count; ++k)
        for (int32_t j = 0; j < row->count; ++j) {
            const int32_t at_z = voxel_read(grid, 2, layer->first + k), at_y = voxel_read(grid, 1, row->first + j);
            if (at_z < 0 || at_y < 0) continue;
            const double weight = (double)layer->weight[k] * (double)row->weight[j];
            double* to = voxels + (size_t)grid->size[0] * ((size_t)at_y + (size_t)grid->size[1] * (size_t)at_z);
            for (int32_t x = 0; x < out->box.size[0]; ++x) {
                const ty_aligned_cell* cell = &aligned->cells[0][x];
                for (int32_t i = 0; i < cell->count; ++i) {
                    const int32_t at_x = voxel_read(grid, 0, cell->first + i);
                    if (at_x >= 0) to[at_x] += weight * (double)cell->weight[i] * by_density[x];
                }
            }
        }
}
