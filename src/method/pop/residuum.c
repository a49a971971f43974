/* Light that has lost its direction, passed on from cell to cell in one grid for all ordinates. */
#include "base/context.h"
#include "base/parallel.h"
#include "method/pop/merge.h"
#include "method/pop/merge_kernel.h"

/* One channel. Arrays have dark cells all around the box. */
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

/* What there is at first, and what absorbs it. */
static void begin_slab(void* user, int64_t z, int32_t worker) {
    const work* w = user;
    const int32_t* size = w->merged->box.size;
    const int plane = w->channel < w->medium->planes ? w->channel : 0;
    double sum = 0;
    (void)worker;
    for (int32_t y = 0; y < size[1]; ++y) {
        const size_t to = inner(w, y, (int32_t)z), from = outer(w, y, (int32_t)z);
        const float *extinction = w->medium->extinction[plane] + from,
                    *scattering = w->medium->scattering[plane] + from;
        const float* left = w->merged->left[w->channel] + from;
        for (int a = 0; a < 3; ++a) {
            const float length = 0.5f * (float)w->medium->cell[a];
            float* half = w->half[a] + to;
            for (int32_t x = 0; x < size[0]; ++x)
                half[x] = ty_expf(-length * ty_maxf(0.0f, extinction[x] - scattering[x]));
        }
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

static bool take(ty_context* context, work* w) {
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

int32_t ty_pop_residuum(ty_context* context, const ty_grid_medium* medium, double least, int32_t iterations,
                        ty_pop_merged* merged, double* left) {
    const int32_t* size = merged->box.size;
    work w = {.kernels = ty_pop_merge_kernels_best(), .medium = medium, .merged = merged};
    w.row = (size_t)size[0] + 2;
    w.slice = w.row * ((size_t)size[1] + 2);
    w.cells = w.slice * ((size_t)size[2] + 2);
    double first = 0, remains = 0;
    int32_t most = take(context, &w) ? 0 : -1;
    for (w.channel = 0; w.channel < 3 && most >= 0; ++w.channel) {
        const int32_t done = pass_channel(context, &w, least, iterations, &first, &remains);
        if (done > most) most = done;
    }
    give_back(context, &w);
    *left = first > 0 ? remains / first : 0;
    return most;
}
