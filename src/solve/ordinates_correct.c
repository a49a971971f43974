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

/* T - x, of the flux times sqrt(3) D s_1: that of e. */
static void excess_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const size_t terms = (size_t)job->terms, low = (size_t)job->low;
    const float* latest = job->iterates[job->latest];
    float* change = job->changes[job->latest];
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const float* d = l->diffusivity + ty_box_at(&l->box, y, (int32_t)z);
        const size_t begin = (size_t)ty_box_dense(&l->box, y, (int32_t)z);
        for (size_t x = 0; x < (size_t)l->box.size[0]; ++x) {
            const size_t i = begin + x;
            float s[2];
            scattering_of(job->def, i, s);
            change[i * low] = s[0] * (latest[i * terms] - job->before[i * low]);
            for (size_t t = 1; t < low; ++t)
                change[i * low + t] = SQRT_3 * d[x] * s[1] * (latest[i * terms + t] - job->before[i * low + t]);
        }
    }
}

/* The same of the def's source, for a first guess. */
static void begin_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const size_t terms = (size_t)job->terms, low = (size_t)job->low;
    float *latest = job->iterates[job->latest], *change = job->changes[job->latest];
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const float* d = l->diffusivity + ty_box_at(&l->box, y, (int32_t)z);
        const size_t begin = (size_t)ty_box_dense(&l->box, y, (int32_t)z);
        memset(latest + begin * terms, 0, sizeof(float) * terms * (size_t)l->box.size[0]);
        for (size_t x = 0; x < (size_t)l->box.size[0]; ++x) {
            const size_t i = begin + x;
            change[i * low] = job->def->source[0][i];
            for (size_t t = 1; t < low; ++t)
                change[i * low + t] = job->fixed != NULL ? SQRT_3 * d[x] * job->fixed[i * terms + t] : 0;
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
    const ptrdiff_t low = job->low, nx = l->box.size[0];
    const ptrdiff_t steps[3] = {low, low * nx, low * nx * l->box.size[1]};
    double sum = 0;
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const ptrdiff_t row = ty_box_at(&l->box, y, (int32_t)z);
        const float* change = job->changes[job->latest] + ty_box_dense(&l->box, y, (int32_t)z) * low;
        float* f = ty_correction_source(job->correction) + row;
        for (int32_t x = 0; x < nx; ++x) {
            const int32_t place[3] = {x, y, (int32_t)z};
            f[x] = change[x * low];
            for (int axis = 0; low > 1 && axis < 3; ++axis)
                f[x] -= outflow(l, change + x * low + (ptrdiff_t)along(axis), steps[axis], place[axis], axis,
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
    const size_t terms = (size_t)job->terms, low = (size_t)job->low, begin = (size_t)ty_box_dense(&l->box, y, z);
    const ptrdiff_t row = ty_box_at(&l->box, y, z), steps[3] = {1, l->box.row, l->box.plane};
    const float *e = l->e + row, *d = l->diffusivity + row;
    float* latest = job->iterates[job->latest] + begin * terms;
    const float* change = job->changes[job->latest] + begin * low;
    const float* smooth = ty_correction_smooth(job->correction) + row;
    for (size_t x = 0; x < (size_t)l->box.size[0]; ++x) latest[x * terms] += smooth[x];
    for (int axis = 0; low > 1 && axis < 3; ++axis) {
        const float inverse_edge = (float)(1 / job->def->cell[axis]);
        const size_t t = along(axis);
        for (size_t x = 0; x < (size_t)l->box.size[0]; ++x)
            latest[x * terms + t] += SQRT_3 * (flux(d + x, e + x, steps[axis], inverse_edge) + change[x * low + t]);
    }
}

/* What the latest iterate is more than its mixture, and its products with those of others. */
static void compare_row(const ty_ordinates_job* job, size_t begin, size_t count, ty_ordinates_sums* sums) {
    const size_t terms = (size_t)job->terms, low = (size_t)job->low;
    const float* latest = job->iterates[job->latest];
    float* change = job->changes[job->latest];
    double squares = 0, fluence = 0;
    for (size_t i = begin; i < begin + count; ++i) {
        for (size_t t = 0; t < low; ++t) change[i * low + t] = latest[i * terms + t] - job->before[i * low + t];
        squares += (double)change[i * low] * (double)change[i * low];
        fluence += (double)latest[i * terms] * (double)latest[i * terms];
    }
    sums->change += squares;
    sums->fluence += fluence;
    for (int32_t k = 0; k < job->count; ++k) {
        const float* other = job->changes[k];
        double product = 0;
#pragma omp simd reduction(+ : product)
        for (size_t i = begin * low; i < (begin + count) * low; ++i) product += (double)change[i] * (double)other[i];
        sums->products[k] += product;
    }
}

static void correct_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    ty_ordinates_sums sums = {0};
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        if (l->e != NULL) add_row(l, y, (int32_t)z);
        compare_row(l->job, (size_t)ty_box_dense(&l->box, y, (int32_t)z), (size_t)l->box.size[0], &sums);
    }
    l->job->sums[z] = sums;
}

ty_ordinates_sums ty_ordinates_correct(ty_ordinates_job* job, const float* e) {
    loop l = loop_over(job, e);
    ty_ordinates_planes(job, correct_plane, &l);
    return ty_ordinates_total(job);
}
