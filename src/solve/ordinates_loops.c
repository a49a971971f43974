/* Loops over all cells that sweeps are told from, and corrected with. Sums are made plane by plane, in order. */
#include "base/kernel.h"
#include "base/parallel.h"
#include "solve/ordinates_job.h"

#include <math.h>
#include <string.h>

/* What is inlined where the number of bands is known, so that loops over terms have no ends to look for. */
#define INLINE static inline __attribute__((always_inline))
#define SQRT_4PI 3.5449077018110318

/* Boxes with fewer cells are worked on by one thread: waking others takes longer. */
enum { CELLS_FOR_THREADS = 1 << 12 };

typedef struct loop {
    ty_ordinates_job* job;
    const float* const* planes;
    float* const* places;
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
        total.taken += s->taken;
        for (int i = 0; i < TY_ORDINATES_DEPTH; ++i) total.products[i] += s->products[i];
    }
    return total;
}

/* Cells of a plane, and where they begin. */
static size_t plane_cells(const ty_ordinates_job* job) {
    return (size_t)job->def->size[0] * (size_t)job->def->size[1];
}

/* ---- coefficients ---- */

static double power(double base, int32_t exponent) {
    double product = 1;
    for (int32_t i = 0; i < exponent; ++i) product *= base;
    return product;
}

static bool is_sound(const ty_ordinates_job* job, size_t i) {
    const ty_ordinates_def* def = job->def;
    const float sigma = def->extinction[i], scattering = def->scattering[i], g = def->g[i];
    bool sound = sigma >= 0 && sigma <= TY_FLOAT_MAX && scattering >= 0 && scattering <= sigma && g > -1 && g < 1;
    for (int32_t t = 0; t < def->source_terms; ++t) sound = sound && isfinite(def->source[t][i]);
    return sound;
}

static void scale_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const ty_ordinates_def* def = job->def;
    const size_t begin = (size_t)z * plane_cells(job);
    job->sums[z].change = 0;
    for (size_t i = begin; i < begin + plane_cells(job); ++i) {
        if (!is_sound(job, i)) job->sums[z].change = 1;
        const double g = (double)def->g[i], forward = power(g, def->bands);
        const double sigma = (double)def->extinction[i], scattering = (double)def->scattering[i];
        job->extinction[i] = (float)(sigma - forward * scattering);
        if (l->reduced == NULL) continue;
        l->reduced[i] = (float)(sigma - (def->bands > 1 ? g : forward) * scattering);
        l->absorption[i] = (float)(sigma - scattering);
    }
}

bool ty_ordinates_scale(ty_ordinates_job* job, float* reduced, float* absorption) {
    loop l = {.job = job, .reduced = reduced, .absorption = absorption};
    ty_ordinates_planes(job, scale_plane, &l);
    return ty_ordinates_total(job).change <= 0;
}

/* ---- planes and cells ---- */

static void gather_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const size_t begin = (size_t)z * plane_cells(l->job), terms = (size_t)l->terms;
    for (size_t i = begin; i < begin + plane_cells(l->job); ++i)
        for (size_t t = 0; t < terms; ++t) l->to[i * terms + t] = t < (size_t)l->count ? l->planes[t][i] : 0;
}

void ty_ordinates_gather(ty_ordinates_job* job, const float* const* planes, int32_t count, int32_t terms,
                         float* cells) {
    loop l = {.job = job, .planes = planes, .count = count, .terms = terms, .to = cells};
    ty_ordinates_planes(job, gather_plane, &l);
}

static void scatter_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const size_t begin = (size_t)z * plane_cells(l->job), terms = (size_t)l->terms;
    for (size_t t = 0; t < terms; ++t)
        for (size_t i = begin; i < begin + plane_cells(l->job); ++i) l->places[t][i] = l->from[i * terms + t];
}

void ty_ordinates_scatter(ty_ordinates_job* job, const float* cells, int32_t terms, float* const* planes) {
    loop l = {.job = job, .places = planes, .terms = terms, .from = cells};
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

/* Iterates that the mixture has a share of. */
typedef struct mixture {
    const float *moments[TY_ORDINATES_DEPTH], *low[TY_ORDINATES_DEPTH];
    float shares[TY_ORDINATES_DEPTH];
    int32_t count;
} mixture;

static mixture mixture_of(const ty_ordinates_job* job) {
    mixture m = {0};
    for (int32_t i = 0; i < job->count; ++i) {
        if (job->shares[i] == 0) continue;
        m.moments[m.count] = job->moments[i];
        m.low[m.count] = job->low[i];
        m.shares[m.count++] = (float)job->shares[i];
    }
    return m;
}

/* Low terms of a row, of which it has `count`. */
static void mix_low(const mixture* m, size_t begin, size_t count, float* mixed) {
    memset(mixed, 0, sizeof(float) * count);
    for (int32_t k = 0; k < m->count; ++k) {
        const float share = m->shares[k], *low = m->low[k] + begin;
#pragma omp simd
        for (size_t i = 0; i < count; ++i) mixed[i] += share * low[i];
    }
}

INLINE void mix_cell(const mixture* m, size_t i, const size_t lows, const size_t terms, float* mixed) {
    for (size_t t = lows; t < terms; ++t) mixed[t] = 0;
    for (int32_t k = 0; k < m->count; ++k) {
        const float share = m->shares[k], *moments = m->moments[k] + i * terms;
        for (size_t t = lows; t < terms; ++t) mixed[t] += share * moments[t];
    }
}

/* Of a row from cell `begin` on; returns the sum of what leaves in all directions alike. */
INLINE double emit_row(const ty_ordinates_job* job, const mixture* m, size_t begin, const int32_t bands) {
    const ty_ordinates_def* def = job->def;
    const size_t cells = (size_t)def->size[0], terms = (size_t)(bands * bands), lows = bands > 1 ? 4 : 1;
    float* low = job->before + begin * lows;
    double sum = 0;
    mix_low(m, begin * lows, cells * lows, low);
    for (size_t x = 0; x < cells; ++x) {
        const size_t i = begin + x;
        float mixed[TY_ORDINATE_BANDS_MAX * TY_ORDINATE_BANDS_MAX], *emission = job->emission + i * terms;
        mix_cell(m, i, lows, terms, mixed);
        for (size_t t = 0; t < lows; ++t) mixed[t] = low[t * cells + x];
        const float scattering = def->scattering[i], g = def->g[i];
        float forward = 1, power_of_g = 1;
        for (int32_t l = 0; l < bands; ++l) forward *= g;
        for (int32_t l = 0; l < bands; ++l) {
            const float s = scattering * (power_of_g - forward);
            for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t) emission[t] = s * mixed[t];
            power_of_g *= g;
        }
        if (job->fixed == NULL)
            emission[0] += def->source[0][i];
        else
            for (size_t t = 0; t < terms; ++t) emission[t] += job->fixed[i * terms + t];
        /* Thick cells send what their skins do. */
        if (job->thick.count > 0 && job->thick.slots[i] >= 0) memset(emission, 0, sizeof *emission * terms);
        sum += (double)emission[0];
    }
    return sum;
}

static double emit_any(const ty_ordinates_job* job, const mixture* m, size_t begin) {
    switch (job->def->bands) {
    case 1: return emit_row(job, m, begin, 1);
    case 2: return emit_row(job, m, begin, 2);
    case 3: return emit_row(job, m, begin, 3);
    case 4: return emit_row(job, m, begin, 4);
    case 5: return emit_row(job, m, begin, 5);
    case 6: return emit_row(job, m, begin, 6);
    default: return emit_row(job, m, begin, job->def->bands);
    }
}

static void emit_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const loop* l = user;
    const ty_ordinates_job* job = l->job;
    const mixture m = mixture_of(job);
    const size_t begin = (size_t)z * plane_cells(job), cells = (size_t)job->def->size[0];
    double sum = 0;
    for (size_t i = begin; i < begin + plane_cells(job); i += cells) sum += emit_any(job, &m, i);
    job->sums[z] = (ty_ordinates_sums){.emitted = sum};
}

double ty_ordinates_emit(ty_ordinates_job* job) {
    loop l = {.job = job};
    ty_ordinates_planes(job, emit_plane, &l);
    const double volume = job->def->cell[0] * job->def->cell[1] * job->def->cell[2] * SQRT_4PI;
    const double walls = ty_ordinates_walls_send(job), skins = ty_ordinates_thick_send(job);
    return ty_ordinates_total(job).emitted + (walls + skins + job->stats->entering) / volume;
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
    const double volume = job->def->cell[0] * job->def->cell[1] * job->def->cell[2] * SQRT_4PI;
    sums.emitted *= volume;
    sums.absorbed *= volume;
    return sums;
}
