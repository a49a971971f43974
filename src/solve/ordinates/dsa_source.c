/* Diffusion synthetic acceleration. The source of the low-order equation is the scattering of (iterate - mixed
 * iterate); its solution e corrects both fluence and flux of the iterate. P1, with T - x the change by a sweep:
 *
 *     div J + sigma_a e = s_0 (T - x)_0,   J = -D grad e + 3 D s_1 (T - x)_1.
 *
 * Cell values of diamond difference are means of corner values, so that a wave of phase k per cell has the slope
 * 2 tan(k / 2), but 2 sin(k / 2) in the diffusion solve: the ratio cos(k / 2)^2 is the mean of a cell and its
 * neighbours with weights 1/4, 1/2, 1/4. Without this mean, corrections of thick cells are too large by the square of
 * their optical thickness. For waves along several axes at once e becomes a little too small. */
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
    if (job->dsa != NULL) l.diffusivity = ty_dsa_diffusivity(job->dsa);
    return l;
}

/* Index of the P1 term along an axis. */
static size_t p1_term(int axis) {
    return axis == 0 ? 3 : (size_t)axis;
}

/* A row of cells; low-order arrays hold the row's cells term by term. */
typedef struct row {
    size_t cells, first;      /* number of cells in the row and before it */
    ptrdiff_t low_order, box; /* offset of the row in low-order arrays, and in DSA arrays */
} row;

static row row_of(const loop* l, int32_t y, int64_t z) {
    const ptrdiff_t dense = ty_box_dense(&l->box, y, (int32_t)z);
    return (row){.cells = (size_t)l->box.size[0],
                 .first = (size_t)dense,
                 .low_order = dense * l->job->low_order_terms,
                 .box = ty_box_at(&l->box, y, (int32_t)z)};
}

/* ---- low-order moments ---- */

/* Diffusive cells keep the moments of the mixed iterate, or of the initial guess. Returns the row's removal in the
 * sweep, which does not apply to them. */
static double restore_diffusive_row(const ty_ordinates_job* job, const row* r) {
    double sum = 0;
    for (size_t x = 0; job->diffusive.count > 0 && job->count > 0 && x < r->cells; ++x) {
        if (job->diffusive.slots[r->first + x] < 0) continue;
        float* low_order = job->low_order[job->latest] + r->low_order + x;
        sum += (double)job->extinction[r->first + x] * (double)*low_order;
        for (size_t t = 0; t < (size_t)job->low_order_terms; ++t)
            low_order[t * r->cells] = job->mixed[(size_t)r->low_order + x + t * r->cells];
    }
    return sum;
}

/* Sets the terms of a row's diffusive cells to 0. */
static void clear_diffusive_row(const ty_ordinates_job* job, const row* r, float* terms) {
    for (size_t x = 0; job->diffusive.count > 0 && x < r->cells; ++x)
        for (size_t t = 0; job->diffusive.slots[r->first + x] >= 0 && t < (size_t)job->low_order_terms; ++t)
            terms[(size_t)r->low_order + x + t * r->cells] = 0;
}

static void gather_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const size_t terms = (size_t)job->terms;
    double sum = 0;
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const row r = row_of(l, y, z);
        const float *moments = job->moments[job->latest] + r.first * terms, *extinction = job->extinction + r.first;
        float* low_order = job->low_order[job->latest] + r.low_order;
        for (size_t x = 0; x < r.cells; ++x) {
            for (size_t t = 0; t < (size_t)job->low_order_terms; ++t)
                low_order[t * r.cells + x] = moments[x * terms + t];
            sum += (double)extinction[x] * (double)low_order[x];
        }
        sum -= restore_diffusive_row(job, &r);
    }
    job->sums[z] = (ty_ordinates_sums){.removed = sum};
}

static void scatter_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const size_t terms = (size_t)job->terms;
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const row r = row_of(l, y, z);
        float* moments = job->moments[job->latest] + r.first * terms;
        const float* low_order = job->low_order[job->latest] + r.low_order;
        for (size_t x = 0; x < r.cells; ++x)
            for (size_t t = 0; t < (size_t)job->low_order_terms; ++t)
                moments[x * terms + t] = low_order[t * r.cells + x];
    }
}

double ty_ordinates_gather_low_order(ty_ordinates_job* job) {
    loop l = loop_over(job, NULL);
    ty_ordinates_planes(job, gather_plane, &l);
    return ty_ordinates_total(job).removed;
}

void ty_ordinates_scatter_low_order(ty_ordinates_job* job) {
    loop l = loop_over(job, NULL);
    ty_ordinates_planes(job, scatter_plane, &l);
}

/* ---- DSA source ---- */

/* Change T - x, with the energy deficit of T, times s_0; flux change times sqrt(3) D s_1, in units of e. */
static void residual_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const int32_t bands = job->def->bands;
    const float* fitted = bands > 1 ? job->def->scattered : NULL;
    const float energy_deficit = (float)job->energy_deficit;
    float s[2][TY_ORDINATES_SIDE_MAX];
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const row r = row_of(l, y, z);
        const float *scattering = job->def->scattering + r.first, *g = job->def->g + r.first;
        const float *d = l->diffusivity + r.box, *low_order = job->low_order[job->latest] + r.low_order,
                    *mixed = job->mixed + r.low_order;
        float* change = job->changes[job->latest] + r.low_order;
#pragma omp simd
        for (size_t x = 0; x < r.cells; ++x) {
            float forward = 1;
            for (int32_t b = 0; b < bands; ++b) forward *= g[x];
            s[0][x] = scattering[x] * (fitted != NULL ? fitted[0] : 1 - forward);
            s[1][x] = SQRT_3 * scattering[x] * d[x] * (fitted != NULL ? fitted[1] : g[x] - forward);
        }
#pragma omp simd
        for (size_t x = 0; x < r.cells; ++x)
            change[x] = s[0][x] * (low_order[x] - mixed[x] + energy_deficit * low_order[x]);
        for (size_t t = r.cells; t < r.cells * (size_t)job->low_order_terms; t += r.cells) {
#pragma omp simd
            for (size_t x = 0; x < r.cells; ++x) change[t + x] = s[1][x] * (low_order[t + x] - mixed[t + x]);
        }
        clear_diffusive_row(job, &r, job->changes[job->latest]);
    }
}

/* The same for the def's source. */
static void first_residual_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const size_t terms = (size_t)job->terms, low_order_terms = (size_t)job->low_order_terms;
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const row r = row_of(l, y, z);
        const float* d = l->diffusivity + r.box;
        float* change = job->changes[job->latest] + r.low_order;
        memset(job->moments[job->latest] + r.first * terms, 0, sizeof(float) * terms * r.cells);
        memset(job->low_order[job->latest] + r.low_order, 0, sizeof(float) * low_order_terms * r.cells);
        memcpy(change, job->def->source[0] + r.first, sizeof(float) * r.cells);
        for (size_t t = 1; t < low_order_terms; ++t)
            for (size_t x = 0; x < r.cells; ++x)
                change[t * r.cells + x] =
                    job->source_lm != NULL ? SQRT_3 * d[x] * job->source_lm[(r.first + x) * terms + t] : 0;
        clear_diffusive_row(job, &r, job->changes[job->latest]);
    }
}

/* The flux along an axis in a row's cells, and below and above them; NULL: the box ends there. */
typedef struct flux_rows {
    const float *below, *here, *above;
} flux_rows;

/* Subtracts the divergence of the flux from f. At the box's faces the outflow is that of the boundary in series with
 * the cell's half. */
static void subtract_outflow(flux_rows flux, double edge, const float* d, ptrdiff_t count, float* f) {
    const float inverse_edge = 1 / (float)edge;
    if (flux.below != NULL && flux.above != NULL) {
#pragma omp simd
        for (ptrdiff_t x = 0; x < count; ++x) f[x] -= 0.5f * inverse_edge * (flux.above[x] - flux.below[x]);
        return;
    }
    for (ptrdiff_t x = 0; x < count; ++x) {
        const float here = flux.here[x], outside = here / (1 + 4 * d[x] * inverse_edge);
        const float above = flux.above == NULL ? outside : 0.5f * (here + flux.above[x]);
        const float below = flux.below == NULL ? outside : 0.5f * (here + flux.below[x]);
        f[x] -= inverse_edge * (above - below);
    }
}

/* A row of the neighbours' flux, from `index` on. */
static const float* beyond(const ty_ordinates_job* job, int side, ptrdiff_t index) {
    return job->flux_beyond[side] != NULL ? job->flux_beyond[side] + index : NULL;
}

static void source_row(const loop* l, const row* r, int32_t y, int32_t z, float* f) {
    const ty_ordinates_job* job = l->job;
    const int32_t ny = l->box.size[1];
    const ptrdiff_t nx = l->box.size[0], low_row = nx * job->low_order_terms, low_plane = low_row * ny;
    const float *change = job->changes[job->latest] + r->low_order, *d = l->diffusivity + r->box;
    const double* cell = job->def->cell;
    memcpy(f, change, sizeof(float) * r->cells);
    if (job->low_order_terms == 1) return;
    const float* along[3];
    for (int axis = 0; axis < 3; ++axis) along[axis] = change + (ptrdiff_t)p1_term(axis) * nx;
    const float *x = along[0], *last = x + nx - 1;
    const bool repeats[3] = {(job->def->periodic & 1) != 0, (job->def->periodic & 2) != 0,
                             (job->def->periodic & 4) != 0};
    const float* lower_x = repeats[0] ? last : beyond(job, 0, (ptrdiff_t)z * ny + y);
    const float* upper_x = repeats[0] ? x : beyond(job, 1, (ptrdiff_t)z * ny + y);
    const float* lower_y = repeats[1] ? along[1] + low_row * (ny - 1 - y) : beyond(job, 2, z * nx);
    const float* upper_y = repeats[1] ? along[1] - low_row * y : beyond(job, 3, z * nx);
    const float* lower_z = repeats[2] ? along[2] + low_plane * (l->box.size[2] - 1 - z) : NULL;
    const float* upper_z = repeats[2] ? along[2] - low_plane * z : NULL;
    subtract_outflow((flux_rows){lower_x, x, nx > 1 ? x + 1 : upper_x}, cell[0], d, 1, f);
    if (nx > 2) subtract_outflow((flux_rows){x, x + 1, x + 2}, cell[0], d + 1, nx - 2, f + 1);
    if (nx > 1) subtract_outflow((flux_rows){last - 1, last, upper_x}, cell[0], d + nx - 1, 1, f + nx - 1);
    subtract_outflow(
        (flux_rows){y > 0 ? along[1] - low_row : lower_y, along[1], y + 1 < ny ? along[1] + low_row : upper_y}, cell[1],
        d, nx, f);
    subtract_outflow((flux_rows){z > 0 ? along[2] - low_plane : lower_z, along[2],
                                 z + 1 < l->box.size[2] ? along[2] + low_plane : upper_z},
                     cell[2], d, nx, f);
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
        float* f = ty_dsa_source(l->job->dsa) + r.box;
        source_row(l, &r, y, (int32_t)z, f);
        sum += product_of(f, f, r.cells);
    }
    l->job->sums[z] = (ty_ordinates_sums){.change = sum};
}

double ty_ordinates_residual(ty_ordinates_job* job, bool first) {
    loop l = loop_over(job, NULL);
    ty_ordinates_planes(job, first ? first_residual_plane : residual_plane, &l);
    ty_ordinates_exchange_flux(job);
    ty_ordinates_planes(job, source_plane, &l);
    double squares = ty_ordinates_total(job).change;
    squares += ty_ordinates_faces_residual(job, first) + ty_ordinates_diffusive_residual(job, first) +
               ty_ordinates_images_residual(job, first);
    ty_ordinates_sum_ranks(job, &squares, 1);
    return squares;
}

/* ---- correction ---- */

/* Adds -D grad e along an axis, the mean over both faces of a cell, plus the flux source of the sweep, to a row's flux.
 */
static void add_flux(const float* d, const float* e, ptrdiff_t step, float factor, const float* change, size_t cells,
                     float* low_order) {
#pragma omp simd
    for (ptrdiff_t x = 0; x < (ptrdiff_t)cells; ++x) {
        const float here = fabsf(d[x]), below = fabsf(d[x - step]), above = fabsf(d[x + step]);
        const float down = below / (here + below) * (e[x - step] - e[x]);
        const float up = above / (here + above) * (e[x] - e[x + step]);
        low_order[x] += factor * here * (down + up) + SQRT_3 * change[x];
    }
}

static void correct_row(const loop* l, const row* r) {
    const ty_ordinates_job* job = l->job;
    const ptrdiff_t steps[3] = {1, l->box.row, l->box.plane};
    const float *e = l->e + r->box, *d = l->diffusivity + r->box;
    const float* smooth = ty_dsa_smoothed_fluence(job->dsa) + r->box;
    const float* change = job->changes[job->latest] + r->low_order;
    float* low_order = job->low_order[job->latest] + r->low_order;
#pragma omp simd
    for (size_t x = 0; x < r->cells; ++x) low_order[x] += smooth[x];
    for (int axis = 0; job->low_order_terms > 1 && axis < 3; ++axis) {
        const size_t t = p1_term(axis) * r->cells;
        add_flux(d, e, steps[axis], SQRT_3 / (float)job->def->cell[axis], change + t, r->cells, low_order + t);
    }
}

/* Diffusive cells are not diamond differenced, and their flux is not used further. */
static void correct_diffusive_row(const loop* l, const row* r) {
    const ty_ordinates_job* job = l->job;
    const float *e = l->e + r->box, *smooth = ty_dsa_smoothed_fluence(job->dsa) + r->box;
    for (size_t x = 0; job->diffusive.count > 0 && x < r->cells; ++x) {
        if (job->diffusive.slots[r->first + x] < 0) continue;
        float* low_order = job->low_order[job->latest] + r->low_order + x;
        low_order[0] += e[x] - smooth[x];
        for (size_t t = 1; t < (size_t)job->low_order_terms; ++t) low_order[t * r->cells] = 0;
    }
}

/* Change of the latest iterate against its mixed iterate, and its products with the changes of the others. */
static void compare_row(const ty_ordinates_job* job, const row* r, ty_ordinates_sums* sums) {
    const size_t count = r->cells * (size_t)job->low_order_terms;
    const float *low_order = job->low_order[job->latest] + r->low_order, *mixed = job->mixed + r->low_order;
    float* change = job->changes[job->latest] + r->low_order;
#pragma omp simd
    for (size_t i = 0; i < count; ++i) change[i] = low_order[i] - mixed[i];
    sums->change += product_of(change, change, r->cells);
    sums->fluence += product_of(low_order, low_order, r->cells);
    const float *extinction = job->def->extinction + r->first, *scattering = job->def->scattering + r->first;
    for (size_t x = 0; job->diffusive.count > 0 && x < r->cells; ++x)
        sums->absorbed += (double)(extinction[x] - scattering[x]) * (double)low_order[x];
    for (int32_t k = 0; k < job->count; ++k)
        sums->products[k] += product_of(change, job->changes[k] + r->low_order, count);
}

static void correct_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    ty_ordinates_sums sums = {0};
    for (int32_t y = 0; y < l->box.size[1]; ++y) {
        const row r = row_of(l, y, z);
        if (l->e != NULL) correct_row(l, &r);
        if (l->e != NULL) correct_diffusive_row(l, &r);
        compare_row(l->job, &r, &sums);
    }
    l->job->sums[z] = sums;
}

ty_ordinates_sums ty_ordinates_correct(ty_ordinates_job* job, const float* e) {
    loop l = loop_over(job, e);
    if (e != NULL) ty_ordinates_faces_correct(job, e);
    ty_ordinates_planes(job, correct_plane, &l);
    if (e != NULL) ty_ordinates_images_correct(job, e);
    if (e != NULL) ty_ordinates_diffusive_correct(job, e);
    ty_ordinates_sums sums = ty_ordinates_total(job);
    ty_ordinates_faces_compare(job, &sums);
    ty_ordinates_diffusive_compare(job, &sums);
    ty_ordinates_sum_ranks(job, (double*)&sums, sizeof sums / sizeof(double));
    return sums;
}
