/* Loops over all cells before and after a sweep. Sums are formed per plane and added in plane order. */
#include "base/constants.h"
#include "base/kernel.h"
#include "base/parallel.h"
#include "solve/ordinates/job.h"
#include "solve/ordinates/anderson_kernel.h"

#include <math.h>
#include <string.h>

/* Smaller boxes run on one thread: waking the others takes longer. */
enum { CELLS_FOR_THREADS = 1 << 12 };

typedef struct loop {
    ty_ordinates_job* job;
    const float* const* planes;
    float* const* outputs;
    const float* from;
    float *to, *reduced, *absorption;
    int32_t count, terms;
} loop;

void ty_ordinates_planes(const ty_ordinates_job* job, ty_parallel_fn body, void* user) {
    ty_parallel_flushed(job->cells >= CELLS_FOR_THREADS ? job->context : NULL, job->def->size[2], body, user);
}

ty_ordinates_sums ty_ordinates_total(const ty_ordinates_job* job) {
    ty_ordinates_sums total = {0};
    for (int32_t z = 0; z < job->def->size[2]; ++z) {
        const ty_ordinates_sums* s = &job->sums[z];
        total.change += s->change;
        total.fluence += s->fluence;
        total.emitted += s->emitted;
        total.absorbed += s->absorbed;
        total.removed += s->removed;
        for (int i = 0; i < TY_ANDERSON_DEPTH; ++i) total.products[i] += s->products[i];
    }
    return total;
}

/* Cells per plane. */
static size_t plane_cells(const ty_ordinates_job* job) {
    return (size_t)job->def->size[0] * (size_t)job->def->size[1];
}

/* ---- coefficients ---- */

static double power(double base, int32_t exponent) {
    double product = 1;
    for (int32_t i = 0; i < exponent; ++i) product *= base;
    return product;
}

static bool is_in_range(const ty_ordinates_def* def, size_t i) {
    const float sigma = def->extinction[i], scattering = def->scattering[i], g = def->g[i];
    return sigma >= 0 && sigma <= TY_FLOAT_MAX && scattering >= 0 && scattering <= sigma && g > -1 && g < 1;
}

static bool are_finite(const float* items, size_t count) {
    int32_t invalid = 0;
#pragma omp simd reduction(| : invalid)
    for (size_t i = 0; i < count; ++i) invalid |= fabsf(items[i]) <= TY_FLOAT_MAX ? 0 : 1;
    return invalid == 0;
}

static void scale_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const ty_ordinates_def* def = job->def;
    const size_t begin = (size_t)z * plane_cells(job);
    bool valid = true;
    for (int32_t t = 0; t < def->source_terms; ++t)
        valid = valid && are_finite(def->source[t] + begin, plane_cells(job));
    for (size_t i = begin; i < begin + plane_cells(job); ++i) {
        valid = valid && is_in_range(def, i);
        const double g = (double)def->g[i];
        const double forward = def->scattered != NULL ? 1 - (double)def->scattered[0] : power(g, def->bands);
        const double sigma = (double)def->extinction[i], scattering = (double)def->scattering[i];
        job->extinction[i] = (float)(sigma - forward * scattering);
        if (l->reduced == NULL) continue;
        const double first_moment = def->scattered != NULL ? (double)def->scattered[1] : g - forward;
        l->reduced[i] = (float)(sigma - (def->bands > 1 ? forward + first_moment : forward) * scattering);
        l->absorption[i] = (float)(sigma - scattering);
    }
    job->sums[z].change = valid ? 0 : 1;
}

bool ty_ordinates_scale(ty_ordinates_job* job, float* reduced, float* absorption) {
    loop l = {.job = job, .reduced = reduced, .absorption = absorption};
    ty_ordinates_planes(job, scale_plane, &l);
    double invalid = ty_ordinates_total(job).change;
    ty_ordinates_sum_ranks(job, &invalid, 1);
    return invalid <= 0;
}

/* ---- planes and cells ---- */

/* Row by row: planes lie a power of two apart, so that reading one cell of each plane at a time would map to the same
 * cache lines. */
static void gather_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const size_t begin = (size_t)z * plane_cells(l->job), terms = (size_t)l->terms,
                 cells = (size_t)l->job->def->size[0];
    for (size_t row = begin; row < begin + plane_cells(l->job); row += cells) {
        float* to = l->to + row * terms;
        for (size_t t = 0; t < terms; ++t) {
            const float* from = l->planes[t] + row;
            for (size_t x = 0; x < cells; ++x) to[x * terms + t] = from[x];
        }
    }
}

void ty_ordinates_gather(ty_ordinates_job* job, const float* const* planes, int32_t terms, float* cells) {
    loop l = {.job = job, .planes = planes, .terms = terms, .to = cells};
    ty_ordinates_planes(job, gather_plane, &l);
}

static void scatter_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const size_t begin = (size_t)z * plane_cells(l->job), terms = (size_t)l->terms,
                 cells = (size_t)l->job->def->size[0];
    for (size_t row = begin; row < begin + plane_cells(l->job); row += cells) {
        const float* from = l->from + row * terms;
        for (size_t t = 0; t < terms; ++t) {
            float* to = l->outputs[t] + row;
            for (size_t x = 0; x < cells; ++x) to[x] = from[x * terms + t];
        }
    }
}

void ty_ordinates_scatter(ty_ordinates_job* job, const float* cells, int32_t terms, float* const* planes) {
    loop l = {.job = job, .outputs = planes, .terms = terms, .from = cells};
    ty_ordinates_planes(job, scatter_plane, &l);
}

static void widen_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const size_t begin = (size_t)z * plane_cells(l->job), terms = (size_t)l->terms, count = (size_t)l->count;
    for (size_t i = begin; i < begin + plane_cells(l->job); ++i) {
        memcpy(l->to + i * terms, l->from + i * count, sizeof(float) * count);
        memset(l->to + i * terms + count, 0, sizeof(float) * (terms - count));
    }
}

void ty_ordinates_widen(ty_ordinates_job* job, const float* from, int32_t terms, float* to) {
    loop l = {.job = job, .from = from, .to = to, .count = job->terms, .terms = terms};
    ty_ordinates_planes(job, widen_plane, &l);
}

/* ---- emission ---- */

static ty_anderson_iterate make_iterate(const ty_ordinates_job* job) {
    ty_anderson_iterate m = {.cells = job->def->size[0], .bands = job->def->bands};
    for (int32_t i = 0; i < job->count; ++i) {
        if (job->anderson_weights[i] == 0) continue;
        m.moments[m.count] = job->moments[i];
        m.low_order[m.count] = job->low_order[i];
        m.anderson_weights[m.count++] = (float)job->anderson_weights[i];
    }
    m.scattering = job->def->scattering;
    m.g = job->def->g;
    m.scattered = job->def->scattered;
    m.source = job->def->source[0];
    m.source_lm = job->source_lm;
    m.diffusive = job->diffusive.count > 0 ? job->diffusive.slots : NULL;
    m.mixed = job->mixed;
    m.emission = job->emission;
    return m;
}

static void emit_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const ty_anderson_kernels* kernels = TY_BEST_KERNELS(ty_anderson_kernels);
    const ty_anderson_iterate m = make_iterate(job);
    const size_t begin = (size_t)z * plane_cells(job), cells = (size_t)job->def->size[0];
    double sum = 0;
    for (size_t i = begin; i < begin + plane_cells(job); i += cells) sum += kernels->emit(&m, i);
    job->sums[z] = (ty_ordinates_sums){.emitted = sum};
}

double ty_ordinates_emit(ty_ordinates_job* job) {
    loop l = {.job = job};
    ty_ordinates_planes(job, emit_plane, &l);
    const double volume = job->def->cell[0] * job->def->cell[1] * job->def->cell[2] * TY_SQRT_4PI_F64;
    const double walls = ty_ordinates_faces_emit(job), interfaces = ty_ordinates_diffusive_emit(job);
    return ty_ordinates_total(job).emitted + (walls + interfaces + job->stats->entering) / volume;
}

/* ---- energy ---- */

static void balance_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_def* def = l->job->def;
    const size_t begin = (size_t)z * plane_cells(l->job);
    ty_ordinates_sums sums = {0};
    for (size_t i = begin; i < begin + plane_cells(l->job); ++i) {
        sums.emitted += (double)def->source[0][i];
        sums.absorbed +=
            ((double)def->extinction[i] - (double)def->scattering[i]) * (double)l->from[i * (size_t)l->terms];
    }
    l->job->sums[z] = sums;
}

ty_ordinates_sums ty_ordinates_balance(ty_ordinates_job* job, const float* moments, int32_t terms) {
    loop l = {.job = job, .from = moments, .terms = terms};
    ty_ordinates_planes(job, balance_plane, &l);
    ty_ordinates_sums sums = ty_ordinates_total(job);
    const double volume = job->def->cell[0] * job->def->cell[1] * job->def->cell[2] * TY_SQRT_4PI_F64;
    sums.emitted *= volume;
    sums.absorbed *= volume;
    return sums;
}
