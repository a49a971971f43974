/* Diffusion synthetic acceleration. What an iterate scatters more than the mixture that it was made of, spread by
 * diffusion, is added to it: both its fluence and its flux (P1: with T - x for what a sweep changed,
 *
 *     div J + sigma_a e = s_0 (T - x)_0,   J = -D grad e + 3 D s_1 (T - x)_1).
 *
 * Cells' middles of diamond differences are means of corners, so that a wave with phase k per cell has the slope
 * 2 tan(k / 2), and 2 sin(k / 2) in the correction: the quotient, cos(k / 2) squared, is the mean of a cell and its
 * neighbours with weights 1/4, 1/2, 1/4. Without it corrections of thick cells are too large by the square of their
 * optical thickness. Where light moves along several axes at once e becomes a little less than it should. */
#include "solve/ordinates_job.h"

#include <math.h>
#include <string.h>

#define SQRT_3 1.7320508075688772f

typedef struct loop {
    ty_ordinates_job* job;
    const float* e;
    const float* diffusivity;
    ty_box box;
} loop;

static loop loop_over(ty_ordinates_job* job, const float* e) {
    loop l = {.job = job, .e = e, .box = ty_box_make(job->def->size[0], job->def->size[1], job->def->size[2])};
    if (job->correction != NULL) l.diffusivity = ty_correction_diffusivity(job->correction);
    return l;
}

/* The term of band 1 along an axis. */
static size_t along(int axis) {
    return axis == 0 ? 3 : (size_t)axis;
}

/* s_0 and s_1. */
static void scattering_of(const ty_ordinates_def* def, size_t i, float s[2]) {
    const float g = def->g[i];
    float forward = 1;
    for (int32_t l = 0; l < def->bands; ++l) forward *= g;
    s[0] = def->scattering[i] * (1 - forward);
    s[1] = def->scattering[i] * (g - forward);
}

/* ---- the source of the correction ---- */

static void take_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const size_t terms = (size_t)job->terms, lows = (size_t)job->lows,
                 begin = (size_t)ty_box_dense(&l->box, 0, (int32_t)z);
    const size_t end = begin + (size_t)l->box.size[0] * (size_t)l->box.size[1];
    const float* moments = job->moments[job->latest];
    float* low = job->low[job->latest];
    double sum = 0;
    for (size_t i = begin; i < end; ++i) {
        for (size_t t = 0; t < lows; ++t) low[i * lows + t] = moments[i * terms + t];
        sum += (double)job->extinction[i] * (double)low[i * lows];
    }
    job->sums[z] = (ty_ordinates_sums){.absorbed = sum};
}

static void give_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const size_t terms = (size_t)job->terms, lows = (size_t)job->lows,
                 begin = (size_t)ty_box_dense(&l->box, 0, (int32_t)z);
    const size_t end = begin + (size_t)l->box.size[0] * (size_t)l->box.size[1];
    float* moments = job->moments[job->latest];
    const float* low = job->low[job->latest];
    for (size_t i = begin; i < end; ++i)
        for (size_t t = 0; t < lows; ++t) moments[i * terms + t] = low[i * lows + t];
}

double ty_ordinates_take_low(ty_ordinates_job* job) {
    loop l = loop_over(job, NULL);
    ty_ordinates_planes(job, take_plane, &l);
    return ty_ordinates_total(job).absorbed;
}

void ty_ordinates_give_low(ty_ordinates_job* job) {
    loop l = loop_over(job, NULL);
    ty_ordinates_planes(job, give_plane, &l);
}

/* T - x, with what is missing of T; of the flux times sqrt(3) D s_1: that of e. */
static void excess_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const size_t lows = (size_t)job->lows;
    const float missing = (float)job->missing;
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const size_t begin = (size_t)ty_box_dense(&l->box, y, (int32_t)z);
        const float* d = l->diffusivity + ty_box_at(&l->box, y, (int32_t)z);
        const float *low = job->low[job->latest] + begin * lows, *before = job->before + begin * lows;
        float* change = job->changes[job->latest] + begin * lows;
        for (size_t x = 0; x < (size_t)l->box.size[0]; ++x) {
            float s[2];
            scattering_of(job->def, begin + x, s);
            change[x * lows] = s[0] * (low[x * lows] - before[x * lows] + missing * low[x * lows]);
            for (size_t t = x * lows + 1; t < (x + 1) * lows; ++t)
                change[t] = SQRT_3 * d[x] * s[1] * (low[t] - before[t]);
        }
    }
}

/* The same of the def's source. */
static void begin_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const size_t terms = (size_t)job->terms, lows = (size_t)job->lows;
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const size_t begin = (size_t)ty_box_dense(&l->box, y, (int32_t)z), count = (size_t)l->box.size[0];
        const float* d = l->diffusivity + ty_box_at(&l->box, y, (int32_t)z);
        float* change = job->changes[job->latest] + begin * lows;
        memset(job->moments[job->latest] + begin * terms, 0, sizeof(float) * terms * count);
        memset(job->low[job->latest] + begin * lows, 0, sizeof(float) * lows * count);
        for (size_t x = 0; x < count; ++x) {
            change[x * lows] = job->def->source[0][begin + x];
            for (size_t t = 1; t < lows; ++t)
                change[x * lows + t] = job->fixed != NULL ? SQRT_3 * d[x] * job->fixed[(begin + x) * terms + t] : 0;
        }
    }
}

/* What leaves a cell of the flux `at` along an axis, per volume. Through the box's face it is what the boundary, in
 * series with the cell's half, lets out. */
static float outflow(const loop* l, const float* at, ptrdiff_t step, int32_t place, int axis, float diffusivity) {
    const float edge = (float)l->job->def->cell[axis], here = at[0];
    const float share = 1 / (1 + 4 * diffusivity / edge);
    const float above = place + 1 < l->box.size[axis] ? 0.5f * (here + at[step]) : share * here;
    const float below = place > 0 ? 0.5f * (here + at[-step]) : share * here;
    return (above - below) / edge;
}

static void source_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const ptrdiff_t lows = job->lows, nx = l->box.size[0];
    const ptrdiff_t steps[3] = {lows, lows * nx, lows * nx * l->box.size[1]};
    double sum = 0;
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const ptrdiff_t row = ty_box_at(&l->box, y, (int32_t)z);
        const float* change = job->changes[job->latest] + ty_box_dense(&l->box, y, (int32_t)z) * lows;
        float* f = ty_correction_source(job->correction) + row;
        for (int32_t x = 0; x < nx; ++x) {
            const int32_t place[3] = {x, y, (int32_t)z};
            f[x] = change[x * lows];
            for (int axis = 0; lows > 1 && axis < 3; ++axis)
                f[x] -= outflow(l, change + x * lows + (ptrdiff_t)along(axis), steps[axis], place[axis], axis,
                                l->diffusivity[row + x]);
            sum += (double)f[x] * (double)f[x];
        }
    }
    job->sums[z] = (ty_ordinates_sums){.change = sum};
}

double ty_ordinates_excess(ty_ordinates_job* job, bool first) {
    loop l = loop_over(job, NULL);
    ty_ordinates_planes(job, first ? begin_plane : excess_plane, &l);
    ty_ordinates_planes(job, source_plane, &l);
    return ty_ordinates_total(job).change;
}

/* ---- the correction ---- */

/* -D grad e along an axis, the mean of what the cell's faces have. */
static float flux(const float* d, const float* e, ptrdiff_t step, float inverse_edge) {
    const float here = fabsf(d[0]), below = fabsf(d[-step]), above = fabsf(d[step]);
    return here * inverse_edge *
           (below / (here + below) * (e[-step] - e[0]) + above / (here + above) * (e[0] - e[step]));
}

/* Adds e to fluence and flux of a row; `change` holds the flux that a sweep adds to that of e. */
static void add_row(const loop* l, int32_t y, int32_t z) {
    const ty_ordinates_job* job = l->job;
    const size_t lows = (size_t)job->lows, count = (size_t)l->box.size[0];
    const ptrdiff_t dense = ty_box_dense(&l->box, y, z) * job->lows, row = ty_box_at(&l->box, y, z);
    const ptrdiff_t steps[3] = {1, l->box.row, l->box.plane};
    const float *e = l->e + row, *d = l->diffusivity + row, *smooth = ty_correction_smooth(job->correction) + row;
    const float* change = job->changes[job->latest] + dense;
    float* low = job->low[job->latest] + dense;
    for (size_t x = 0; x < count; ++x) low[x * lows] += smooth[x];
    for (int axis = 0; lows > 1 && axis < 3; ++axis) {
        const float inverse_edge = (float)(1 / job->def->cell[axis]);
        const size_t t = along(axis);
        for (size_t x = 0; x < count; ++x)
            low[x * lows + t] += SQRT_3 * (flux(d + x, e + x, steps[axis], inverse_edge) + change[x * lows + t]);
    }
}

static double product_of(const float* a, const float* b, size_t count) {
    float sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t i = 0; i < count; ++i) sum += a[i] * b[i];
    return (double)sum;
}

/* What the latest iterate is more than its mixture, and its products with those of others. */
static void compare_row(const ty_ordinates_job* job, ptrdiff_t dense, size_t cells, ty_ordinates_sums* sums) {
    const size_t lows = (size_t)job->lows, count = cells * lows;
    const float *low = job->low[job->latest] + dense * job->lows, *before = job->before + dense * job->lows;
    float* change = job->changes[job->latest] + dense * job->lows;
    double squares = 0, fluence = 0;
#pragma omp simd
    for (size_t i = 0; i < count; ++i) change[i] = low[i] - before[i];
    for (size_t i = 0; i < count; i += lows) {
        squares += (double)change[i] * (double)change[i];
        fluence += (double)low[i] * (double)low[i];
    }
    sums->change += squares;
    sums->fluence += fluence;
    for (int32_t k = 0; k < job->count; ++k)
        sums->products[k] += product_of(change, job->changes[k] + dense * job->lows, count);
}

static void correct_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    ty_ordinates_sums sums = {0};
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        if (l->e != NULL) add_row(l, y, (int32_t)z);
        compare_row(l->job, ty_box_dense(&l->box, y, (int32_t)z), (size_t)l->box.size[0], &sums);
    }
    l->job->sums[z] = sums;
}

ty_ordinates_sums ty_ordinates_correct(ty_ordinates_job* job, const float* e) {
    loop l = loop_over(job, e);
    ty_ordinates_planes(job, correct_plane, &l);
    return ty_ordinates_total(job);
}
