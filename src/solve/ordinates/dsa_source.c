/* Diffusion synthetic acceleration. What an iterate scatters more than the mixture that it was made of, spread by
 * diffusion, is added to it: both its fluence and its flux (P1: with T - x for what a sweep changed,
 *
 *     div J + sigma_a e = s_0 (T - x)_0,   J = -D grad e + 3 D s_1 (T - x)_1).
 *
 * Cells' middles of diamond differences are means of corners, so that a wave with phase k per cell has the slope
 * 2 tan(k / 2), and 2 sin(k / 2) in the correction: the quotient, cos(k / 2) squared, is the mean of a cell and its
 * neighbours with weights 1/4, 1/2, 1/4. Without it corrections of thick cells are too large by the square of their
 * optical thickness. Where light moves along several axes at once e becomes a little less than it should. */
#include "base/kernel.h"
#include "solve/ordinates/job.h"

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
    if (job->correction != NULL) l.diffusivity = ty_dsa_diffusivity(job->correction);
    return l;
}

/* The term of band 1 along an axis. */
static size_t along(int axis) {
    return axis == 0 ? 3 : (size_t)axis;
}

/* A row of cells: of each low term, its cells after one another. */
typedef struct row {
    size_t cells, first; /* in it, and before it */
    ptrdiff_t low, box;  /* where it begins in arrays of low terms, and in the correction's */
} row;

static row row_of(const loop* l, int32_t y, int64_t z) {
    const ptrdiff_t dense = ty_box_dense(&l->box, y, (int32_t)z);
    return (row){.cells = (size_t)l->box.size[0],
                 .first = (size_t)dense,
                 .low = dense * l->job->lows,
                 .box = ty_box_at(&l->box, y, (int32_t)z)};
}

/* ---- low terms ---- */

/* Thick cells keep what the mixture has, or a start. Returns what the row's have taken in the sweep, which is not
 * theirs. */
static double hold_row(const ty_ordinates_job* job, const row* r) {
    double sum = 0;
    for (size_t x = 0; job->thick.count > 0 && job->count > 0 && x < r->cells; ++x) {
        if (job->thick.slots[r->first + x] < 0) continue;
        float* low = job->low[job->latest] + r->low + x;
        sum += (double)job->extinction[r->first + x] * (double)*low;
        for (size_t t = 0; t < (size_t)job->lows; ++t)
            low[t * r->cells] = job->before[(size_t)r->low + x + t * r->cells];
    }
    return sum;
}

/* Nothing of a row's thick cells. */
static void clear_row(const ty_ordinates_job* job, const row* r, float* terms) {
    for (size_t x = 0; job->thick.count > 0 && x < r->cells; ++x)
        for (size_t t = 0; job->thick.slots[r->first + x] >= 0 && t < (size_t)job->lows; ++t)
            terms[(size_t)r->low + x + t * r->cells] = 0;
}

static void take_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const size_t terms = (size_t)job->terms;
    double sum = 0;
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const row r = row_of(l, y, z);
        const float *moments = job->moments[job->latest] + r.first * terms, *extinction = job->extinction + r.first;
        float* low = job->low[job->latest] + r.low;
        for (size_t x = 0; x < r.cells; ++x) {
            for (size_t t = 0; t < (size_t)job->lows; ++t) low[t * r.cells + x] = moments[x * terms + t];
            sum += (double)extinction[x] * (double)low[x];
        }
        sum -= hold_row(job, &r);
    }
    job->sums[z] = (ty_ordinates_sums){.taken = sum};
}

static void give_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const size_t terms = (size_t)job->terms;
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const row r = row_of(l, y, z);
        float* moments = job->moments[job->latest] + r.first * terms;
        const float* low = job->low[job->latest] + r.low;
        for (size_t x = 0; x < r.cells; ++x)
            for (size_t t = 0; t < (size_t)job->lows; ++t) moments[x * terms + t] = low[t * r.cells + x];
    }
}

double ty_ordinates_gather_low_order(ty_ordinates_job* job) {
    loop l = loop_over(job, NULL);
    ty_ordinates_planes(job, take_plane, &l);
    return ty_ordinates_total(job).taken;
}

void ty_ordinates_scatter_low_order(ty_ordinates_job* job) {
    loop l = loop_over(job, NULL);
    ty_ordinates_planes(job, give_plane, &l);
}

/* ---- the source of the correction ---- */

/* T - x, with what is missing of T; of the flux times sqrt(3) D s_1: that of e. */
static void excess_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const int32_t bands = job->def->bands;
    const float* fitted = bands > 1 ? job->def->scattered : NULL;
    const float missing = (float)job->missing;
    float s[2][TY_ORDINATES_SIDE_MAX];
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const row r = row_of(l, y, z);
        const float *scattering = job->def->scattering + r.first, *g = job->def->g + r.first;
        const float *d = l->diffusivity + r.box, *low = job->low[job->latest] + r.low, *before = job->before + r.low;
        float* change = job->changes[job->latest] + r.low;
#pragma omp simd
        for (size_t x = 0; x < r.cells; ++x) {
            float forward = 1;
            for (int32_t b = 0; b < bands; ++b) forward *= g[x];
            s[0][x] = scattering[x] * (fitted != NULL ? fitted[0] : 1 - forward);
            s[1][x] = SQRT_3 * scattering[x] * d[x] * (fitted != NULL ? fitted[1] : g[x] - forward);
        }
#pragma omp simd
        for (size_t x = 0; x < r.cells; ++x) change[x] = s[0][x] * (low[x] - before[x] + missing * low[x]);
        for (size_t t = r.cells; t < r.cells * (size_t)job->lows; t += r.cells) {
#pragma omp simd
            for (size_t x = 0; x < r.cells; ++x) change[t + x] = s[1][x] * (low[t + x] - before[t + x]);
        }
        clear_row(job, &r, job->changes[job->latest]);
    }
}

/* The same of the def's source. */
static void begin_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const size_t terms = (size_t)job->terms, lows = (size_t)job->lows;
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const row r = row_of(l, y, z);
        const float* d = l->diffusivity + r.box;
        float* change = job->changes[job->latest] + r.low;
        memset(job->moments[job->latest] + r.first * terms, 0, sizeof(float) * terms * r.cells);
        memset(job->low[job->latest] + r.low, 0, sizeof(float) * lows * r.cells);
        memcpy(change, job->def->source[0] + r.first, sizeof(float) * r.cells);
        for (size_t t = 1; t < lows; ++t)
            for (size_t x = 0; x < r.cells; ++x)
                change[t * r.cells + x] =
                    job->fixed != NULL ? SQRT_3 * d[x] * job->fixed[(r.first + x) * terms + t] : 0;
        clear_row(job, &r, job->changes[job->latest]);
    }
}

/* Faces of a row's cells across an axis: whether they are the box's. */
typedef struct faces {
    bool below, above;
    float edge;
} faces;

/* Takes what flux lets out of cells from f. Through the box's faces it is what the boundary, in series with the cell's
 * half, lets out. */
static void subtract_outflow(faces at, const float* flux, const float* d, ptrdiff_t step, ptrdiff_t begin,
                             ptrdiff_t end, float* f) {
    const float inverse_edge = 1 / at.edge;
    if (!at.below && !at.above) {
#pragma omp simd
        for (ptrdiff_t x = begin; x < end; ++x) f[x] -= 0.5f * inverse_edge * (flux[x + step] - flux[x - step]);
        return;
    }
    for (ptrdiff_t x = begin; x < end; ++x) {
        const float here = flux[x], outside = here / (1 + 4 * d[x] * inverse_edge);
        const float above = at.above ? outside : 0.5f * (here + flux[x + step]);
        const float below = at.below ? outside : 0.5f * (here + flux[x - step]);
        f[x] -= inverse_edge * (above - below);
    }
}

static void source_row(const loop* l, const row* r, int32_t y, int32_t z, float* f) {
    const ty_ordinates_job* job = l->job;
    const ptrdiff_t nx = l->box.size[0], low_row = nx * job->lows;
    const float *change = job->changes[job->latest] + r->low, *d = l->diffusivity + r->box;
    const double* cell = job->def->cell;
    memcpy(f, change, sizeof(float) * r->cells);
    if (job->lows == 1) return;
    const float* along_x = change + (ptrdiff_t)along(0) * nx;
    subtract_outflow((faces){true, nx == 1, (float)cell[0]}, along_x, d, 1, 0, 1, f);
    subtract_outflow((faces){false, false, (float)cell[0]}, along_x, d, 1, 1, nx - 1, f);
    if (nx > 1) subtract_outflow((faces){false, true, (float)cell[0]}, along_x, d, 1, nx - 1, nx, f);
    subtract_outflow((faces){y == 0, y == l->box.size[1] - 1, (float)cell[1]}, change + (ptrdiff_t)along(1) * nx, d,
                     low_row, 0, nx, f);
    subtract_outflow((faces){z == 0, z == l->box.size[2] - 1, (float)cell[2]}, change + (ptrdiff_t)along(2) * nx, d,
                     low_row * l->box.size[1], 0, nx, f);
}

static double product_of(const float* a, const float* b, size_t count) {
    float sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t i = 0; i < count; ++i) sum += a[i] * b[i];
    return (double)sum;
}

static void source_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    double sum = 0;
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const row r = row_of(l, y, z);
        float* f = ty_dsa_source(l->job->correction) + r.box;
        source_row(l, &r, y, (int32_t)z, f);
        sum += product_of(f, f, r.cells);
    }
    l->job->sums[z] = (ty_ordinates_sums){.change = sum};
}

double ty_ordinates_residual(ty_ordinates_job* job, bool first) {
    loop l = loop_over(job, NULL);
    ty_ordinates_planes(job, first ? begin_plane : excess_plane, &l);
    ty_ordinates_planes(job, source_plane, &l);
    const double squares = ty_ordinates_total(job).change;
    return squares + ty_ordinates_faces_residual(job, first) + ty_ordinates_diffusive_residual(job, first);
}

/* ---- the correction ---- */

/* Adds -D grad e along an axis, the mean of what cells' faces have, and the flux that a sweep adds to it, to a row's.
 */
static void add_flux(const float* d, const float* e, ptrdiff_t step, float factor, const float* change, size_t cells,
                     float* low) {
#pragma omp simd
    for (ptrdiff_t x = 0; x < (ptrdiff_t)cells; ++x) {
        const float here = fabsf(d[x]), below = fabsf(d[x - step]), above = fabsf(d[x + step]);
        const float down = below / (here + below) * (e[x - step] - e[x]);
        const float up = above / (here + above) * (e[x] - e[x + step]);
        low[x] += factor * here * (down + up) + SQRT_3 * change[x];
    }
}

static void add_row(const loop* l, const row* r) {
    const ty_ordinates_job* job = l->job;
    const ptrdiff_t steps[3] = {1, l->box.row, l->box.plane};
    const float *e = l->e + r->box, *d = l->diffusivity + r->box;
    const float* smooth = ty_dsa_smoothed_fluence(job->correction) + r->box;
    const float* change = job->changes[job->latest] + r->low;
    float* low = job->low[job->latest] + r->low;
#pragma omp simd
    for (size_t x = 0; x < r->cells; ++x) low[x] += smooth[x];
    for (int axis = 0; job->lows > 1 && axis < 3; ++axis) {
        const size_t t = along(axis) * r->cells;
        add_flux(d, e, steps[axis], SQRT_3 / (float)job->def->cell[axis], change + t, r->cells, low + t);
    }
}

/* In thick cells differences are not those of diamonds, and the flux is not gone on with. */
static void add_thick(const loop* l, const row* r) {
    const ty_ordinates_job* job = l->job;
    const float *e = l->e + r->box, *smooth = ty_dsa_smoothed_fluence(job->correction) + r->box;
    for (size_t x = 0; job->thick.count > 0 && x < r->cells; ++x) {
        if (job->thick.slots[r->first + x] < 0) continue;
        float* low = job->low[job->latest] + r->low + x;
        low[0] += e[x] - smooth[x];
        for (size_t t = 1; t < (size_t)job->lows; ++t) low[t * r->cells] = 0;
    }
}

/* What the latest iterate is more than its mixture, and its products with those of others. */
static void compare_row(const ty_ordinates_job* job, const row* r, ty_ordinates_sums* sums) {
    const size_t count = r->cells * (size_t)job->lows;
    const float *low = job->low[job->latest] + r->low, *before = job->before + r->low;
    float* change = job->changes[job->latest] + r->low;
#pragma omp simd
    for (size_t i = 0; i < count; ++i) change[i] = low[i] - before[i];
    sums->change += product_of(change, change, r->cells);
    sums->fluence += product_of(low, low, r->cells);
    const float *extinction = job->def->extinction + r->first, *scattering = job->def->scattering + r->first;
    for (size_t x = 0; job->thick.count > 0 && x < r->cells; ++x)
        sums->absorbed += (double)(extinction[x] - scattering[x]) * (double)low[x];
    for (int32_t k = 0; k < job->count; ++k) sums->products[k] += product_of(change, job->changes[k] + r->low, count);
}

static void correct_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    ty_ordinates_sums sums = {0};
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const row r = row_of(l, y, z);
        if (l->e != NULL) add_row(l, &r);
        if (l->e != NULL) add_thick(l, &r);
        compare_row(l->job, &r, &sums);
    }
    l->job->sums[z] = sums;
}

ty_ordinates_sums ty_ordinates_correct(ty_ordinates_job* job, const float* e) {
    loop l = loop_over(job, e);
    if (e != NULL) ty_ordinates_faces_correct(job, e);
    ty_ordinates_planes(job, correct_plane, &l);
    if (e != NULL) ty_ordinates_diffusive_correct(job, e);
    ty_ordinates_sums sums = ty_ordinates_total(job);
    ty_ordinates_faces_compare(job, &sums);
    ty_ordinates_diffusive_compare(job, &sums);
    return sums;
}
