/* Dense cells at the border of media. */
#include "base/context.h"
#include "base/parallel.h"
#include "method/lpv/lattice/lattice.h"

/* Reduced optical depth of a cell whose center is a transport mean free path below its faces. */
static const float depth_at_border = 2.0f;

typedef struct exposed_job {
    ty_lattice* lattice;
    int32_t plane;
} exposed_job;

/* Reduced optical depth across a cell; 0 outside of the lattice. */
static float reduced_depth(const exposed_job* job, int32_t x, int32_t y, int32_t z) {
    const ty_lattice* lattice = job->lattice;
    const ty_grid_medium* medium = lattice->medium;
    const int32_t* size = lattice->box.size;
    if (x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2]) return 0.0f;
    const size_t cell = (size_t)(x + size[0] * (y + size[1] * z));
    return lattice->cell *
           (medium->extinction[job->plane][cell] - medium->g[job->plane][cell] * medium->scattering[job->plane][cell]);
}

static void fill_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const exposed_job* job = user;
    const int32_t *size = job->lattice->box.size, y = (int32_t)(row % size[1]), z = (int32_t)(row / size[1]);
    float* scale = job->lattice->border_scale[job->plane] + row * size[0];
    for (int32_t x = 0; x < size[0]; ++x) {
        const float depth = reduced_depth(job, x, y, z);
        float thinnest = depth;
        for (int32_t a = 0; a < 3; ++a)
            for (int32_t side = -1; side <= 1; side += 2)
                thinnest = ty_minf(thinnest, reduced_depth(job, x + (a == 0 ? side : 0), y + (a == 1 ? side : 0),
                                                           z + (a == 2 ? side : 0)));
        const float limit = depth_at_border + thinnest;
        scale[x] = depth > limit ? limit / depth : 1.0f;
    }
}

ty_result ty_lattice_find_border_scale(ty_lattice* lattice) {
    const ty_grid_medium* medium = lattice->medium;
    for (int32_t c = 0; medium != NULL && c < medium->planes; ++c) {
        exposed_job job = {.lattice = lattice, .plane = c};
        lattice->border_scale[c] = ty_alloc_array(lattice->context, lattice->cells, sizeof(float), false);
        if (lattice->border_scale[c] == NULL) return TY_ERROR_MEMORY;
        ty_parallel_flushed(lattice->context, (int64_t)lattice->box.size[1] * lattice->box.size[2], fill_row, &job);
    }
    return TY_OK;
}
