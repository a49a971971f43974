#include "method/pop/published/residuum.h"

#include "base/context.h"
#include "base/parallel.h"
#include "direct/single/single.k.h"
#include "method/pop/grid/slab.h"
#include "method/pop/published/residuum_kernel.h"

#include <math.h>

/* ---- cells of the residuum ---- */

/* Squared cell edges projected on the world's axes; light advances one cell per step. */
static void add_squares(const ty_pop_grid* grid, double squares[3]) {
    if (grid->kind == TY_DISCRETE_POINT) {
        const double length = (double)ty_pop_cell_length(grid, grid->size[2] / 2);
        for (int a = 0; a < 3; ++a) squares[a] += length * length;
        return;
    }
    const double step[3] = {(double)grid->step.x, (double)grid->step.y, (double)grid->step.z};
    for (int i = 0; i < 3; ++i) {
        const double axis[3] = {(double)grid->axis[i].x, (double)grid->axis[i].y, (double)grid->axis[i].z};
        for (int a = 0; a < 3; ++a) squares[a] += pow(step[i] * axis[a], 2);
    }
}

ty_grid_box ty_pop_residuum_box(const ty_grid_box* medium, const ty_pop_light* lights, int32_t count) {
    static const double rounding = 1e-4; /* fraction of a cell */
    double squares[3] = {0, 0, 0};
    ty_grid_box box;
    for (int32_t i = 0; i < count; ++i) add_squares(&lights[i].grid, squares);
    for (int a = 0; a < 3; ++a) {
        const double step = sqrt(squares[a] / count), center = 0.5 * (medium->lower[a] + medium->upper[a]);
        const int32_t needed = (int32_t)ceil((medium->upper[a] - medium->lower[a]) / step - rounding);
        const int32_t cells = lights[0].grid.size[2];
        box.size[a] = needed > cells ? needed : cells;
        box.lower[a] = center - 0.5 * step * box.size[a];
        box.upper[a] = center + 0.5 * step * box.size[a];
    }
    return box;
}

/* ---- deposition ---- */

typedef struct deposit_job {
    const ty_pop_light* lights;
    int32_t count;
    ty_pop_merged* merged;
} deposit_job;

static void add_pair(float* at, size_t next, float fraction, float amount) {
    at[0] += (1 - fraction) * amount;
    at[next] += fraction * amount;
}

/* at: coordinates, cells. */
static void deposit_trilinear(const int32_t size[3], ty_vec at, float amount, float* left) {
    const ty_cell_point p = ty_cell_locate(size, at);
    for (int k = 0; k < 2; ++k) {
        float* layer = left + p.base + (k != 0 ? p.step[2] : 0);
        const float in_layer = amount * (k != 0 ? p.fraction[2] : 1 - p.fraction[2]);
        add_pair(layer, p.step[0], p.fraction[0], (1 - p.fraction[1]) * in_layer);
        add_pair(layer + p.step[1], p.step[0], p.fraction[0], p.fraction[1] * in_layer);
    }
}

/* Cross section of a column, m^2. Radial grids store values times r^2, so theirs is a solid angle, sr. */
static double column_section(const ty_pop_grid* grid) {
    if (grid->kind == TY_DISCRETE_DIRECTIONAL) return (double)grid->step.x * (double)grid->step.y;
    return 4 * (double)TY_PI / ((double)grid->size[0] * grid->size[1]);
}

static void deposit_light(const ty_pop_light* light, int channel, ty_pop_merged* merged) {
    const ty_pop_grid* grid = &light->grid;
    const ty_grid_box* box = &merged->box;
    const ty_vec lower = ty_vec_make((float)box->lower[0], (float)box->lower[1], (float)box->lower[2]);
    const ty_vec per_metre = ty_vec_make((float)(1 / ty_pop_cell_edge(box, 0)), (float)(1 / ty_pop_cell_edge(box, 1)),
                                         (float)(1 / ty_pop_cell_edge(box, 2)));
    const int32_t ghosts = ty_pop_ghost_width(grid), row = grid->size[0] + 2 * ghosts;
    const double cell = ty_pop_cell_edge(box, 0) * ty_pop_cell_edge(box, 1) * ty_pop_cell_edge(box, 2);
    for (int32_t k = 0; k < grid->size[2]; ++k) {
        const float fraction = (float)(column_section(grid) * (double)ty_pop_cell_length(grid, k) / cell);
        const float* slab = ty_pop_accumulated_slab(light, k) + TY_POP_CELL_FLOATS + channel;
        for (int32_t j = 0; j < grid->size[1]; ++j)
            for (int32_t i = 0; i < grid->size[0]; ++i) {
                const float amount = slab[light->floats * (row * (j + ghosts) + i + ghosts)];
                const ty_vec off = ty_sub(ty_pop_cell_center(grid, i, j, k), lower);
                const ty_vec at = ty_vec_make(off.x * per_metre.x, off.y * per_metre.y, off.z * per_metre.z);
                if (amount > 0) deposit_trilinear(box->size, at, fraction * amount, merged->unpropagated[channel]);
            }
    }
}

static void deposit_channel(void* user, int64_t channel, int32_t worker) {
    const deposit_job* job = user;
    (void)worker;
    for (int32_t i = 0; i < job->count; ++i) deposit_light(&job->lights[i], (int)channel, job->merged);
}

void ty_pop_residuum_deposit(ty_context* context, const ty_pop_light* lights, int32_t count, ty_pop_merged* merged) {
    deposit_job job = {lights, count, merged};
    ty_parallel_flushed(context, 3, deposit_channel, &job);
}

/* ---- one channel ---- */

/* Arrays have dark ghost cells on all sides of the box. */
typedef struct residuum_job {
    const ty_pop_residuum_kernels* kernels;
    const ty_grid_medium* medium;
    ty_pop_merged* merged;
    int channel;
    size_t row, slice, cells; /* size of an array, floats */
    float* half[3];           /* e^(-sigma_a dx / 2) along each axis */
    float *from, *to, *accumulated;
    double* slab_sums; /* light that entered each slab */
} residuum_job;

static size_t inner(const residuum_job* w, int32_t y, int32_t z) {
    return (size_t)(z + 1) * w->slice + (size_t)(y + 1) * w->row + 1;
}

static size_t outer(const residuum_job* w, int32_t y, int32_t z) {
    const int32_t* size = w->merged->box.size;
    return ((size_t)z * (size_t)size[1] + (size_t)y) * (size_t)size[0];
}

/* Transmittances of half a cell for one row. */
static void absorb_row(const residuum_job* w, int32_t y, int32_t z) {
    const ty_grid_box* box = &w->merged->box;
    const int plane = w->channel < w->medium->planes ? w->channel : 0;
    const size_t to = inner(w, y, z);
    for (int32_t x = 0; x < box->size[0]; ++x) {
        const int32_t cell[3] = {x, y, z};
        ty_cell_point point;
        float absorption = 0;
        if (ty_pop_locate_center(box, cell, &w->medium->box, &point))
            absorption = ty_maxf(0, ty_cell_value(w->medium->extinction[plane], &point) -
                                        ty_cell_value(w->medium->scattering[plane], &point));
        for (int a = 0; a < 3; ++a)
            w->half[a][to + (size_t)x] = ty_expf(-0.5f * (float)ty_pop_cell_edge(box, a) * absorption);
    }
}

/* Initial light of a slab. */
static void begin_slab(void* user, int64_t z, int32_t worker) {
    const residuum_job* w = user;
    const int32_t* size = w->merged->box.size;
    double sum = 0;
    (void)worker;
    for (int32_t y = 0; y < size[1]; ++y) {
        const size_t to = inner(w, y, (int32_t)z);
        const float* left = w->merged->unpropagated[w->channel] + outer(w, y, (int32_t)z);
        if (w->channel < w->medium->planes) absorb_row(w, y, (int32_t)z);
        for (int32_t x = 0; x < size[0]; ++x) {
            w->from[to + (size_t)x] = left[x];
            w->accumulated[to + (size_t)x] = 0.0f;
            sum += (double)left[x];
        }
    }
    w->slab_sums[z] = sum;
}

static void propagate_slab(void* user, int64_t z, int32_t worker) {
    const residuum_job* w = user;
    double sum = 0;
    (void)worker;
    for (int32_t y = 0; y < w->merged->box.size[1]; ++y) {
        const size_t at = inner(w, y, (int32_t)z);
        const ty_pop_residuum_row row = {
            .count = w->merged->box.size[0],
            .stride = {1, (ptrdiff_t)w->row, (ptrdiff_t)w->slice},
            .half = {w->half[0] + at, w->half[1] + at, w->half[2] + at},
            .from = w->from + at,
            .to = w->to + at,
            .accumulated = w->accumulated + at,
        };
        sum += (double)w->kernels->propagate(&row);
    }
    w->slab_sums[z] = sum;
}

static void end_slab(void* user, int64_t z, int32_t worker) {
    const residuum_job* w = user;
    const int c = w->channel;
    (void)worker;
    for (int32_t y = 0; y < w->merged->box.size[1]; ++y) {
        const size_t from = inner(w, y, (int32_t)z), to = outer(w, y, (int32_t)z);
        for (int32_t x = 0; x < w->merged->box.size[0]; ++x) {
            const float accumulated = w->accumulated[from + (size_t)x];
            w->merged->fluence[c][to + (size_t)x] += accumulated;
            w->merged->accumulated_radiance[c][to + (size_t)x] += accumulated * (0.25f / TY_PI);
            w->merged->unpropagated[c][to + (size_t)x] = w->from[from + (size_t)x];
        }
    }
}

/* Runs a body over all slabs and returns the sum of their light. */
static double for_slabs(ty_context* context, residuum_job* w, ty_parallel_fn body) {
    const int32_t count = w->merged->box.size[2];
    double sum = 0;
    ty_parallel_flushed(context, count, body, w);
    for (int32_t z = 0; z < count; ++z) sum += w->slab_sums[z];
    return sum;
}

/* Returns the iterations; adds the initial light to `first` and the remaining light to `left`. */
static int32_t propagate_channel(ty_context* context, residuum_job* w, double tolerance, int32_t iterations,
                                 double* first, double* left) {
    const double all = for_slabs(context, w, begin_slab);
    double now = all;
    int32_t done = 0;
    for (; done < iterations && now > tolerance * all; ++done) {
        now = for_slabs(context, w, propagate_slab);
        float* swap = w->from;
        w->from = w->to;
        w->to = swap;
    }
    *first += all;
    *left += now;
    if (done > 0) ty_parallel_flushed(context, w->merged->box.size[2], end_slab, w);
    return done;
}

static bool allocate(ty_context* context, residuum_job* w) {
    float** arrays[] = {&w->half[0], &w->half[1], &w->half[2], &w->from, &w->to, &w->accumulated};
    bool ok = true;
    for (int i = 0; i < 6; ++i) {
        *arrays[i] = ty_alloc_array(context, w->cells, sizeof(float), true);
        ok = ok && *arrays[i] != NULL;
    }
    w->slab_sums = ty_alloc_array(context, (size_t)w->merged->box.size[2], sizeof *w->slab_sums, true);
    return ok && w->slab_sums != NULL;
}

static void release(ty_context* context, residuum_job* w) {
    float* const arrays[] = {w->half[0], w->half[1], w->half[2], w->from, w->to, w->accumulated};
    for (int i = 0; i < 6; ++i) ty_free_array(context, arrays[i], w->cells, sizeof(float));
    ty_free_array(context, w->slab_sums, (size_t)w->merged->box.size[2], sizeof *w->slab_sums);
}

/* Sec. 5.4 (Elek 2014). */
int32_t ty_pop_residuum(ty_context* context, const ty_grid_medium* medium, double tolerance, int32_t iterations,
                        ty_pop_merged* merged, double* left) {
    const int32_t* size = merged->box.size;
    residuum_job w = {.kernels = TY_BEST_KERNELS(ty_pop_residuum_kernels), .medium = medium, .merged = merged};
    w.row = (size_t)size[0] + 2;
    w.slice = w.row * ((size_t)size[1] + 2);
    w.cells = w.slice * ((size_t)size[2] + 2);
    double first = 0, remaining = 0;
    int32_t max_done = allocate(context, &w) ? 0 : -1;
    for (w.channel = 0; w.channel < 3 && max_done >= 0; ++w.channel) {
        const int32_t done = propagate_channel(context, &w, tolerance, iterations, &first, &remaining);
        if (done > max_done) max_done = done;
    }
    release(context, &w);
    *left = first > 0 ? remaining / first : 0;
    return max_done;
}
