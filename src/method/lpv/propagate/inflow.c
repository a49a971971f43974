/* Inflow of light from the outer cascade. */
#include "method/lpv/lattice/lookup.k.h"
#include "method/lpv/propagate/propagation.h"

#include "base/context.h"
#include "base/parallel.h"

typedef struct inflow_job {
    ty_lpv_propagation* propagation;
    const ty_lattice* outer;
} inflow_job;

/* The scattering operator of the outer lattice's medium in cells of this lattice's size. */
static ty_lpv_medium_step outer_step(const inflow_job* job, int32_t channel, int32_t cell) {
    const ty_lpv_propagation* propagation = job->propagation;
    const ty_lpv_cell_medium medium = ty_lattice_medium_in(job->outer, channel, (size_t)cell);
    return ty_lpv_step_in(&propagation->transfer, propagation->mode, propagation->lattice->cell, &medium);
}

/* The light of the outer cascade, over all its iterations, in a cell around the lattice. */
static void fill_cell(const inflow_job* job, int32_t x, int32_t y, int32_t z) {
    const ty_lpv_propagation* propagation = job->propagation;
    const ty_lattice *lattice = propagation->lattice, *outer = job->outer;
    const double* lower = lattice->box.lower;
    const double cell = (double)lattice->cell;
    const ty_vec point = ty_vec_make((float)(lower[0] + (x + 0.5) * cell), (float)(lower[1] + (y + 0.5) * cell),
                                     (float)(lower[2] + (z + 0.5) * cell));
    ty_lattice_cells cells;
    if (!ty_lattice_find(outer, point, &cells)) return;
    float* to = propagation->from + (ptrdiff_t)ty_lpv_propagation_index(propagation, y, z) + x;
    for (int32_t c = 0; c < 3; ++c) {
        const ty_lpv_medium_step step = outer_step(job, c, cells.index[0]);
        const float volume = lattice->cell * lattice->cell * lattice->cell;
        for (int32_t t = 0; t < lattice->terms; ++t) {
            const int32_t band = ty_sh_band(t);
            const float light =
                ty_lattice_mean(&cells, outer->light[c][t]) + ty_lattice_mean(&cells, outer->propagated_sh[c][t]);
            to[(c * lattice->terms + t) * propagation->pitch.term] =
                step.scatter_factor[band] * light * volume / (step.length * step.flux_factor[band]);
        }
    }
}

static void fill_slab(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const inflow_job* job = user;
    const int32_t *size = job->propagation->lattice->box.size, z = (int32_t)index - 1;
    const bool end = z == -1 || z == size[2];
    for (int32_t y = -1; y <= size[1]; ++y) {
        const int32_t apart = end || y == -1 || y == size[1] ? 1 : size[0] + 1;
        for (int32_t x = -1; x <= size[0]; x += apart) fill_cell(job, x, y, z);
    }
}

ty_lpv_sums ty_lpv_propagation_inflow(ty_lpv_propagation* propagation, const ty_lattice* outer) {
    inflow_job job = {.propagation = propagation, .outer = outer};
    propagation->entered = true;
    memset(propagation->from, 0, propagation->floats * sizeof(float));
    ty_parallel_flushed(propagation->lattice->context, propagation->lattice->box.size[2] + 2, fill_slab, &job);
    const ty_lpv_sums sums = ty_lpv_propagation_step(propagation, false);
    memset(propagation->to, 0, propagation->floats * sizeof(float));
    return sums;
}
