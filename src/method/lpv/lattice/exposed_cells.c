/* Dense cells at the border of media. */
#include "base/context.h"
#include "base/parallel.h"
#include "method/lpv/lattice/lattice.h"

/* Reduced optical depth of a dense cell at a border. In media that absorb nothing its center is as far inside as the
 * light's extrapolated zero is outside, 0.7104 transport mean free paths (Milne's problem), and the next center, where
 * the lattice's light ends, is at that zero. In media that absorb most it is where light scatters first, at one mean
 * free path. Between them the square of the reduced albedo decides, which fits the scenes of docs/matrix.md. */
static const float conservative_depth = 2 * 0.7104f, absorbing_depth = 2.0f;

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

/* The least depth of the six cells beside one. */
static float min_beside(const exposed_job* job, int32_t x, int32_t y, int32_t z) {
    float min = TY_FLOAT_MAX;
    for (int32_t i = 0; i < 6; ++i) {
        int32_t at[3] = {x, y, z};
        at[i / 2] += i % 2 == 0 ? -1 : 1;
        min = ty_minf(min, reduced_depth(job, at[0], at[1], at[2]));
    }
    return min;
}

static float scale_in(const exposed_job* job, int32_t x, int32_t y, int32_t z) {
    const ty_lattice* lattice = job->lattice;
    const ty_grid_medium* medium = lattice->medium;
    const size_t cell = (size_t)(x + lattice->box.size[0] * (y + lattice->box.size[1] * z));
    const float depth = reduced_depth(job, x, y, z);
    if (!(depth > conservative_depth)) return 1.0f;
    const float albedo =
        lattice->cell * medium->scattering[job->plane][cell] * (1.0f - medium->g[job->plane][cell]) / depth;
    const float limit = ty_lerpf(absorbing_depth, conservative_depth, albedo * albedo) + min_beside(job, x, y, z);
    return depth > limit ? limit / depth : 1.0f;
}

static void fill_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const exposed_job* job = user;
    const int32_t* size = job->lattice->box.size;
    float* scale = job->lattice->border_scale[job->plane] + row * size[0];
    for (int32_t x = 0; x < size[0]; ++x)
        scale[x] = scale_in(job, x, (int32_t)(row % size[1]), (int32_t)(row / size[1]));
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
