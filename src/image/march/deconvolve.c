/* Richardson's iteration: values grow by what their interpolant's means lack. */
#include "image/march/deconvolve.h"

#include "base/context.h"
#include "base/kernel.h"
#include "base/parallel.h"

#include <string.h>

/* Three come within a tenth of where more would end, and raise noise of single cells by four at most. */
enum { ITERATIONS = 3 };

/* Largest factor between the mean radiance that is interpolated and that of the cell. */
static const float farthest = 3;

typedef struct deconvolve_job {
    const int32_t* size;
    int32_t floats, term;
    bool positive;
    const ty_cuts* cuts;    /* NULL: none */
    const uint8_t* at_face; /* NULL: none */
    const float* cells;     /* the means to be had, with all other floats of cells */
    const float* from;      /* this term's values, and the next */
    float* to;
} deconvolve_job;

static int32_t neighbour(int32_t at, int32_t step, int32_t size) {
    const int32_t next = at + step;
    return next < 0 || next >= size ? at : next;
}

static const float weight[3] = {0.125f, 0.75f, 0.125f};

/* 1 6 1 / 8 along all axes at a cell by cuts: in place of those beyond there is itself. */
static float mean_on_side(const deconvolve_job* job, const int32_t at[3]) {
    const int32_t* size = job->size;
    const size_t own = ((size_t)at[2] * (size_t)size[1] + (size_t)at[1]) * (size_t)size[0] + (size_t)at[0];
    float sum = 0;
    for (int i = 0; i < 27; ++i) {
        const int off[3] = {i % 3, i / 3 % 3, i / 9};
        int32_t next[3];
        for (int a = 0; a < 3; ++a) next[a] = neighbour(at[a], off[a] - 1, size[a]);
        const size_t other = ((size_t)next[2] * (size_t)size[1] + (size_t)next[1]) * (size_t)size[0] + (size_t)next[0];
        const float factor = weight[off[0]] * weight[off[1]] * weight[off[2]];
        sum += factor * job->from[ty_cuts_join(job->cuts, at, next) ? other : own];
    }
    return sum;
}

/* 1 6 1 / 8 across rows. */
static void add_rows(const deconvolve_job* job, int32_t y, int32_t z, float* sum) {
    const int32_t* size = job->size;
    memset(sum, 0, sizeof *sum * (size_t)size[0]);
    for (int32_t k = -1; k <= 1; ++k)
        for (int32_t j = -1; j <= 1; ++j) {
            const size_t row = (size_t)neighbour(z, k, size[2]) * (size_t)size[1] + (size_t)neighbour(y, j, size[1]);
            const float* from = job->from + row * (size_t)size[0];
            const float factor = weight[k + 1] * weight[j + 1];
            for (int32_t x = 0; x < size[0]; ++x) sum[x] += factor * from[x];
        }
}

/* One row of the next values; `to` holds the sums across rows until they are no longer needed. */
static void deconvolve_row(const deconvolve_job* job, int32_t y, int32_t z) {
    const size_t count = (size_t)job->size[0], begin = ((size_t)z * (size_t)job->size[1] + (size_t)y) * count;
    float* to = job->to + begin;
    add_rows(job, y, z, to);
    float before = to[0];
    for (size_t x = 0; x < count; ++x) {
        const float here = to[x], after = x + 1 < count ? to[x + 1] : here;
        const int32_t at[3] = {(int32_t)x, y, z};
        const bool cut = job->cuts != NULL && ty_cuts_are_about(job->cuts, at);
        const float mean = cut ? mean_on_side(job, at) : 0.125f * (before + 6 * here + after);
        const float asked = job->cells[(begin + x) * (size_t)job->floats + (size_t)job->term];
        const float value = job->from[begin + x] + (asked - mean);
        if (job->at_face != NULL && job->at_face[begin + x] != 0)
            to[x] = asked;
        else
            to[x] = job->positive ? ty_clampf(value, asked / farthest, asked * farthest) : value;
        before = here;
    }
}

static void deconvolve_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const deconvolve_job* job = user;
    for (int32_t y = 0; y < job->size[1]; ++y) deconvolve_row(job, y, (int32_t)z);
}

ty_result ty_deconvolve_means(ty_context* context, const int32_t size[3], int32_t floats, int32_t terms, int32_t used,
                              const ty_cuts* cuts, const uint8_t* at_face, float* cells) {
    const size_t count = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    float* values[2] = {NULL, NULL};
    for (int i = 0; i < 2; ++i) values[i] = ty_alloc_array(context, count, sizeof(float), false);
    const bool whole = values[0] != NULL && values[1] != NULL;
    for (int32_t term = 0; term < used && whole; ++term) {
        deconvolve_job job = {.size = size,
                              .floats = floats,
                              .term = term,
                              .positive = term % terms == 0,
                              .cuts = cuts,
                              .at_face = at_face,
                              .cells = cells};
        for (size_t i = 0; i < count; ++i) values[0][i] = cells[i * (size_t)floats + (size_t)term];
        for (int n = 0; n < ITERATIONS; ++n) {
            job.from = values[n % 2];
            job.to = values[(n + 1) % 2];
            ty_parallel_flushed(context, size[2], deconvolve_plane, &job);
        }
        for (size_t i = 0; i < count; ++i) cells[i * (size_t)floats + (size_t)term] = job.to[i];
    }
    for (int i = 0; i < 2; ++i) ty_free_array(context, values[i], count, sizeof(float));
    return whole ? TY_OK : TY_ERROR_MEMORY;
}
