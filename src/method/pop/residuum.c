/* Light that has lost its direction, passed on from cell to cell in one grid for all ordinates. */
#include "base/context.h"
#include "base/parallel.h"
#include "direct/single.k.h"
#include "method/pop/merge.h"
#include "method/pop/merge_kernel.h"
#include "method/pop/slab.h"

#include <math.h>

/* ---- its cells ---- */

/* Squares of the cells' edges along the axes of the world, where light goes one of them a step. */
static void add_squares(const ty_pop_frame* frame, double squares[3]) {
    if (frame->kind == TY_LIGHT_PART_RADIAL) {
        const double length = (double)ty_pop_length(frame, frame->size[2] / 2);
        for (int a = 0; a < 3; ++a) squares[a] += length * length;
        return;
    }
    const double step[3] = {(double)frame->step.x, (double)frame->step.y, (double)frame->step.z};
    for (int i = 0; i < 3; ++i) {
        const double axis[3] = {(double)frame->axis[i].x, (double)frame->axis[i].y, (double)frame->axis[i].z};
        for (int a = 0; a < 3; ++a) squares[a] += pow(step[i] * axis[a], 2);
    }
}

ty_grid_box ty_pop_residuum_box(const ty_grid_box* medium, const ty_pop_light* lights, int32_t count) {
    static const double rounding = 1e-4; /* of a cell */
    double squares[3] = {0, 0, 0};
    ty_grid_box box;
    for (int32_t i = 0; i < count; ++i) add_squares(&lights[i].frame, squares);
    for (int a = 0; a < 3; ++a) {
        const double step = sqrt(squares[a] / count), middle = 0.5 * (medium->lower[a] + medium->upper[a]);
        const int32_t needed = (int32_t)ceil((medium->upper[a] - medium->lower[a]) / step - rounding);
        const int32_t own = lights[0].frame.size[2];
        box.size[a] = needed > own ? needed : own;
        box.lower[a] = middle - 0.5 * step * box.size[a];
        box.upper[a] = middle + 0.5 * step * box.size[a];
    }
    return box;
}

static double edge_of(const ty_grid_box* box, int axis) {
    return (box->upper[axis] - box->lower[axis]) / box->size[axis];
}

/* ---- what comes in ---- */

typedef struct take_job {
    const ty_pop_light* lights;
    int32_t count;
    ty_pop_merged* merged;
} take_job;

static void add_pair(float* at, size_t next, float share, float amount) {
    at[0] += (1 - share) * amount;
    at[next] += share * amount;
}

/* at: in cells. */
static void share_out(const int32_t size[3], ty_vec at, float amount, float* left) {
    const ty_cell_point p = ty_cell_locate(size, at);
    for (int k = 0; k < 2; ++k) {
        float* layer = left + p.base + (k != 0 ? p.step[2] : 0);
        const float in_layer = amount * (k != 0 ? p.share[2] : 1 - p.share[2]);
        add_pair(layer, p.step[0], p.share[0], (1 - p.share[1]) * in_layer);
        add_pair(layer + p.step[1], p.step[0], p.share[0], p.share[1] * in_layer);
    }
}

/* What radial grids have is times the square of the distance, and so per solid angle. */
static double section_of(const ty_pop_frame* frame) {
    if (frame->kind == TY_LIGHT_PART_PARALLEL) return (double)frame->step.x * (double)frame->step.y;
    return 4 * (double)TY_PI / ((double)frame->size[0] * frame->size[1]);
}

static void take_light(const ty_pop_light* light, int channel, ty_pop_merged* merged) {
    const ty_pop_frame* frame = &light->frame;
    const ty_grid_box* box = &merged->box;
    const ty_vec lower = ty_vec_make((float)box->lower[0], (float)box->lower[1], (float)box->lower[2]);
    const ty_vec per_metre =
        ty_vec_make((float)(1 / edge_of(box, 0)), (float)(1 / edge_of(box, 1)), (float)(1 / edge_of(box, 2)));
    const int32_t ring = ty_pop_ring(frame), row = frame->size[0] + 2 * ring;
    const double cell = edge_of(box, 0) * edge_of(box, 1) * edge_of(box, 2);
    for (int32_t k = 0; k < frame->size[2]; ++k) {
        const float share = (float)(section_of(frame) * (double)ty_pop_length(frame, k) / cell);
        const float* slab = ty_pop_seen_slab(light, k) + TY_POP_SEEN + channel;
        for (int32_t j = 0; j < frame->size[1]; ++j)
            for (int32_t i = 0; i < frame->size[0]; ++i) {
                const float amount = slab[light->floats * (row * (j + ring) + i + ring)];
                const ty_vec off = ty_sub(ty_pop_middle(frame, i, j, k), lower);
                const ty_vec at = ty_vec_make(off.x * per_metre.x, off.y * per_metre.y, off.z * per_metre.z);
                if (amount > 0) share_out(box->size, at, share * amount, merged->left[channel]);
            }
    }
}

static void take_channel(void* user, int64_t channel, int32_t worker) {
    const take_job* job = user;
    (void)worker;
    for (int32_t i = 0; i < job->count; ++i) take_light(&job->lights[i], (int)channel, job->merged);
}

void ty_pop_residuum_take(ty_context* context, const ty_pop_light* lights, int32_t count, ty_pop_merged* merged) {
    take_job job = {lights, count, merged};
    ty_parallel_flushed(context, 3, take_channel, &job);
}

/* Where the middle of a cell is among another grid's. Returns whether it is in it. */
static bool locate(const ty_grid_box* box, const int32_t cell[3], const ty_grid_box* other, ty_cell_point* point) {
    float at[3];
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
        at[a] = (float)((box->lower[a] - other->lower[a] + (cell[a] + 0.5) * edge_of(box, a)) / edge_of(other, a));
        inside = inside && at[a] >= 0 && at[a] <= (float)other->size[a];
    }
    *point = ty_cell_locate(other->size, ty_vec_load(at));
    return inside;
}

/* ---- one channel ---- */

/* Arrays have dark cells all around the box. */
typedef struct work {
    const ty_pop_merge_kernels* kernels;
    const ty_grid_medium* medium;
    ty_pop_merged* merged;
    int channel;
    size_t row, slice, cells; /* floats of an array */
    float* half[3];           /* e^(-sigma_a dx / 2) along each axis */
    float *from, *to, *through;
    double* slabs; /* what came into each */
} work;

static size_t inner(const work* w, int32_t y, int32_t z) {
    return (size_t)(z + 1) * w->slice + (size_t)(y + 1) * w->row + 1;
}

static size_t outer(const work* w, int32_t y, int32_t z) {
    const int32_t* size = w->merged->box.size;
    return ((size_t)z * (size_t)size[1] + (size_t)y) * (size_t)size[0];
}

/* What absorbs light in a row of cells. */
static void absorb_row(const work* w, int32_t y, int32_t z) {
    const ty_grid_box* box = &w->merged->box;
    const int plane = w->channel < w->medium->planes ? w->channel : 0;
    const size_t to = inner(w, y, z);
    for (int32_t x = 0; x < box->size[0]; ++x) {
        const int32_t cell[3] = {x, y, z};
        ty_cell_point point;
        float absorption = 0;
        if (locate(box, cell, &w->medium->box, &point))
            absorption = ty_maxf(0, ty_cell_value(w->medium->extinction[plane], &point) -
                                        ty_cell_value(w->medium->scattering[plane], &point));
        for (int a = 0; a < 3; ++a) w->half[a][to + (size_t)x] = ty_expf(-0.5f * (float)edge_of(box, a) * absorption);
    }
}

/* What there is at first. */
static void begin_slab(void* user, int64_t z, int32_t worker) {
    const work* w = user;
    const int32_t* size = w->merged->box.size;
    double sum = 0;
    (void)worker;
    for (int32_t y = 0; y < size[1]; ++y) {
        const size_t to = inner(w, y, (int32_t)z);
        const float* left = w->merged->left[w->channel] + outer(w, y, (int32_t)z);
        if (w->channel < w->medium->planes) absorb_row(w, y, (int32_t)z);
        for (int32_t x = 0; x < size[0]; ++x) {
            w->from[to + (size_t)x] = left[x];
            w->through[to + (size_t)x] = 0.0f;
            sum += (double)left[x];
        }
    }
    w->slabs[z] = sum;
}

static void pass_slab(void* user, int64_t z, int32_t worker) {
    const work* w = user;
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
            .through = w->through + at,
        };
        sum += (double)w->kernels->pass(&row);
    }
    w->slabs[z] = sum;
}

static void end_slab(void* user, int64_t z, int32_t worker) {
    const work* w = user;
    const int c = w->channel;
    (void)worker;
    for (int32_t y = 0; y < w->merged->box.size[1]; ++y) {
        const size_t from = inner(w, y, (int32_t)z), to = outer(w, y, (int32_t)z);
        for (int32_t x = 0; x < w->merged->box.size[0]; ++x) {
            const float through = w->through[from + (size_t)x];
            w->merged->fluence[c][to + (size_t)x] += through;
            w->merged->seen[c][to + (size_t)x] += through * (0.25f / TY_PI);
            w->merged->left[c][to + (size_t)x] = w->from[from + (size_t)x];
        }
    }
}

/* Runs over all slabs, and gives the sum of what is in them. */
static double for_slabs(ty_context* context, work* w, ty_parallel_fn body) {
    const int32_t count = w->merged->box.size[2];
    double sum = 0;
    ty_parallel_flushed(context, count, body, w);
    for (int32_t z = 0; z < count; ++z) sum += w->slabs[z];
    return sum;
}

/* Returns the iterations; adds to `first` and `left` what there was and is. */
static int32_t pass_channel(ty_context* context, work* w, double least, int32_t iterations, double* first,
                            double* left) {
    const double all = for_slabs(context, w, begin_slab);
    double now = all;
    int32_t done = 0;
    for (; done < iterations && now > least * all; ++done) {
        now = for_slabs(context, w, pass_slab);
        float* swap = w->from;
        w->from = w->to;
        w->to = swap;
    }
    *first += all;
    *left += now;
    if (done > 0) ty_parallel_flushed(context, w->merged->box.size[2], end_slab, w);
    return done;
}

static bool take_memory(ty_context* context, work* w) {
    float** arrays[] = {&w->half[0], &w->half[1], &w->half[2], &w->from, &w->to, &w->through};
    bool ok = true;
    for (int i = 0; i < 6; ++i) {
        *arrays[i] = ty_alloc_array(context, w->cells, sizeof(float), true);
        ok = ok && *arrays[i] != NULL;
    }
    w->slabs = ty_alloc_array(context, (size_t)w->merged->box.size[2], sizeof *w->slabs, true);
    return ok && w->slabs != NULL;
}

static void give_back(ty_context* context, work* w) {
    float* const arrays[] = {w->half[0], w->half[1], w->half[2], w->from, w->to, w->through};
    for (int i = 0; i < 6; ++i) ty_free_array(context, arrays[i], w->cells, sizeof(float));
    ty_free_array(context, w->slabs, (size_t)w->merged->box.size[2], sizeof *w->slabs);
}

/* Sec. 5.4 (Elek 2014). */
int32_t ty_pop_residuum(ty_context* context, const ty_grid_medium* medium, double least, int32_t iterations,
                        ty_pop_merged* merged, double* left) {
    const int32_t* size = merged->box.size;
    work w = {.kernels = ty_pop_merge_kernels_best(), .medium = medium, .merged = merged};
    w.row = (size_t)size[0] + 2;
    w.slice = w.row * ((size_t)size[1] + 2);
    w.cells = w.slice * ((size_t)size[2] + 2);
    double first = 0, remains = 0;
    int32_t most = take_memory(context, &w) ? 0 : -1;
    for (w.channel = 0; w.channel < 3 && most >= 0; ++w.channel) {
        const int32_t done = pass_channel(context, &w, least, iterations, &first, &remains);
        if (done > most) most = done;
    }
    give_back(context, &w);
    *left = first > 0 ? remains / first : 0;
    return most;
}

/* ---- on other cells ---- */

typedef struct add_job {
    const ty_pop_merged* from;
    ty_pop_merged* to;
} add_job;

static void add_slab(void* user, int64_t z, int32_t worker) {
    const add_job* job = user;
    const int32_t* size = job->to->box.size;
    size_t at = (size_t)z * (size_t)size[1] * (size_t)size[0];
    (void)worker;
    for (int32_t y = 0; y < size[1]; ++y)
        for (int32_t x = 0; x < size[0]; ++x, ++at) {
            const int32_t cell[3] = {x, y, (int32_t)z};
            ty_cell_point point;
            locate(&job->to->box, cell, &job->from->box, &point);
            for (int c = 0; c < 3; ++c) {
                job->to->seen[c][at] += ty_cell_value(job->from->seen[c], &point);
                job->to->fluence[c][at] += ty_cell_value(job->from->fluence[c], &point);
            }
        }
}

void ty_pop_merged_add(ty_context* context, const ty_pop_merged* from, ty_pop_merged* to) {
    add_job job = {from, to};
    ty_parallel_flushed(context, to->box.size[2], add_slab, &job);
}
