/* The adjoint of first-collision sources and of uncollided light. With q_lm = c_l b^l Y_lm(w) mean(sigma_s T) color of
 * a direction w of light, T its mean transmittance in fine cells and mean() that over coarse cells,
 *
 *     T* = color sigma_s A,   sigma_s* = color T A,   A = mean^T(sum_lm c_l b^l Y_lm(w) q*_lm),
 *
 * with * for the derivative of the loss by a quantity. By g likewise with the derivatives of c_l. */
#include "base/context.h"
#include "direct/uncollided/collimated.h"
#include "direct/uncollided/collimated_adjoint.h"
#include "direct/uncollided/transpose.h"
#include "method/dom/gradient/gradient.h"
#include "method/dom/sources/sources.h"
#include "solve/angular/harmonics.h"

#include <string.h>

enum { CHUNK = 1 << 14, TERMS_MAX = TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX };

/* Arrays of fine cells; with x and z exchanged for light that crosses most of them along x. */
enum { EXTINCTION, SCATTERING, G, LOSS, INPUTS };
enum { BY_EXTINCTION = INPUTS, BY_SCATTERING, BY_G, RESULTS_END };
enum { A = RESULTS_END, A_BY_G, BAND, TRANSMITTANCE, WEIGHT, ARRAYS };

/* One channel that has an adjoint of its own, in one order of axes. */
typedef struct source_job {
    ty_dom_gradient_job* all;
    int32_t plane, channel;
    bool exchanged;
    ty_grid_medium medium; /* fine cells */
    int32_t coarse_size[3];
    const ty_discrete_light* source; /* at hand */
    float y[TERMS_MAX];              /* b^l Y_lm(w) */
    float color;                     /* of the source, times the weights of all channels with this adjoint */
    ty_dom_phase_slope slope;        /* of the plane, where g is uniform */
    float *coarse[2], *swapped;      /* of coarse cells: the sum of A and that by g; one with exchanged axes */
    float* fine[ARRAYS];
    ty_collimated_scratch scratch;
} source_job;

static int64_t chunks_of(size_t cells) {
    return (int64_t)((cells + CHUNK - 1) / CHUNK);
}

/* ---- A ---- */

static bool is_uniform(const source_job* job) {
    const ty_dom* light = job->all->dom.light;
    return job->all->uniform[job->plane] || light->fit.bands > 0 || ty_dom_legendre(light) != NULL;
}

/* The sums over harmonics of coarse cells: of all l where g is uniform, else of one. */
static void sum_chunk(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const source_job* job = user;
    const ty_dom* light = job->all->dom.light;
    const ty_dom_channel_adjoint* adjoint = &job->all->channels[job->channel];
    const size_t begin = (size_t)index * CHUNK, end = light->cells - begin < CHUNK ? light->cells : begin + CHUNK;
    float *sum = job->coarse[0], *by_g = job->coarse[1];
    memset(sum + begin, 0, sizeof *sum * (end - begin));
    memset(by_g + begin, 0, sizeof *by_g * (end - begin));
    for (int32_t l = 0; l < light->bands; ++l)
        for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t) {
            const float* from = adjoint->source + light->cells * (size_t)t;
            const float factor = job->y[t] * (float)job->slope.scattered[l],
                        slope = job->y[t] * (float)job->slope.scattered_by_g[l];
#pragma omp simd
            for (size_t i = begin; i < end; ++i) {
                sum[i] += factor * from[i];
                by_g[i] += slope * from[i];
            }
        }
}

/* The transpose of means: from coarse to fine cells. */
static void spread(const source_job* job, const float* coarse, float* fine) {
    const ty_dom_job* dom = &job->all->dom;
    if (job->exchanged) ty_exchange_axes(dom->context, dom->coarse->box.size, coarse, job->swapped, false);
    memset(fine, 0, sizeof *fine * job->medium.cells);
    ty_grid_spread(dom->context, job->exchanged ? job->swapped : coarse, job->coarse_size, job->medium.box.size, fine);
}

static void find_uniform(source_job* job) {
    ty_parallel_for(job->all->dom.context, chunks_of(job->all->dom.light->cells), sum_chunk, job);
    spread(job, job->coarse[0], job->fine[A]);
    spread(job, job->coarse[1], job->fine[A_BY_G]);
}

/* Adds one l to A, by the g of each fine cell. */
static void add_band(const source_job* job, int32_t l) {
    for (size_t i = 0; i < job->medium.cells; ++i) {
        ty_dom_phase_slope slope;
        ty_dom_phase_slope_at(job->all, (double)job->fine[G][i], &slope);
        job->fine[A][i] += (float)slope.scattered[l] * job->fine[BAND][i];
        job->fine[A_BY_G][i] += (float)slope.scattered_by_g[l] * job->fine[BAND][i];
    }
}

static void find_varying(source_job* job) {
    memset(job->fine[A], 0, sizeof(float) * job->medium.cells);
    memset(job->fine[A_BY_G], 0, sizeof(float) * job->medium.cells);
    for (int32_t l = 0; l < job->all->dom.light->bands; ++l) {
        memset(&job->slope, 0, sizeof job->slope);
        job->slope.scattered[l] = 1;
        ty_parallel_for(job->all->dom.context, chunks_of(job->all->dom.light->cells), sum_chunk, job);
        spread(job, job->coarse[0], job->fine[BAND]);
        add_band(job, l);
    }
}

/* ---- a direction ---- */

/* T* / color, with the weights of the fluence itself. */
static void weigh_chunk(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const source_job* job = user;
    const size_t begin = (size_t)index * CHUNK, cells = job->medium.cells;
    const size_t end = cells - begin < CHUNK ? cells : begin + CHUNK;
    const float *scattering = job->fine[SCATTERING], *a = job->fine[A], *loss = job->fine[LOSS];
    float* weight = job->fine[WEIGHT];
#pragma omp simd
    for (size_t i = begin; i < end; ++i) weight[i] = scattering[i] * a[i] + loss[i];
}

/* sigma_s* at constant g, and g* / sigma_s. */
static void scatter_chunk(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const source_job* job = user;
    const size_t begin = (size_t)index * CHUNK, cells = job->medium.cells;
    const size_t end = cells - begin < CHUNK ? cells : begin + CHUNK;
    const float *a = job->fine[A], *a_by_g = job->fine[A_BY_G], *transmittance = job->fine[TRANSMITTANCE];
    float *by_scattering = job->fine[BY_SCATTERING], *by_g = job->fine[BY_G];
#pragma omp simd
    for (size_t i = begin; i < end; ++i) {
        by_scattering[i] += job->color * transmittance[i] * a[i];
        by_g[i] += job->color * transmittance[i] * a_by_g[i];
    }
}

static ty_vec direction_of(const source_job* job, const ty_discrete_light* source) {
    const ty_vec w = source->direction;
    return job->exchanged ? ty_vec_make(w.z, w.y, w.x) : w;
}

static void find_harmonics(source_job* job) {
    const ty_discrete_light* source = job->source;
    const double w[3] = {(double)source->direction.x, (double)source->direction.y, (double)source->direction.z};
    const int32_t bands = job->all->dom.light->bands;
    double y[TERMS_MAX];
    float power = 1;
    ty_harmonics_at(w, bands, y);
    for (int32_t l = 0; l < bands; ++l, power *= source->mean_cosine)
        for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t) job->y[t] = power * (float)y[t];
}

static ty_result return_direction(source_job* job) {
    ty_dom_gradient_job* all = job->all;
    ty_discrete_light one = *job->source;
    float multiples[3];
    job->color = 0;
    for (int32_t c = 0; c < 3; ++c) {
        multiples[c] = all->channels[c].of == job->channel ? all->channels[c].factor : 0;
        job->color += multiples[c] * one.color[c];
    }
    find_harmonics(job);
    if (is_uniform(job))
        find_uniform(job);
    else
        find_varying(job);
    ty_parallel_for(all->dom.context, chunks_of(job->medium.cells), weigh_chunk, job);
    one.direction = direction_of(job, job->source);
    const ty_uncollided_loss loss = {.sources = &one,
                                     .count = 1,
                                     .extinction = job->fine[EXTINCTION],
                                     .channels = 1,
                                     .weight = {job->fine[WEIGHT]},
                                     .multiples = multiples,
                                     .transmittance = job->fine[TRANSMITTANCE],
                                     .scratch = &job->scratch,
                                     .progress = &all->dom.progress};
    const ty_result result =
        ty_collimated_adjoint(&job->medium, &loss, job->fine[BY_EXTINCTION], all->gradient->lights);
    ty_parallel_for(all->dom.context, chunks_of(job->medium.cells), scatter_chunk, job);
    return result;
}

/* ---- all directions ---- */

static bool goes_along_x(const source_job* job, const ty_discrete_light* source) {
    return ty_collimated_sweep_axis(job->all->dom.fine, source->direction) / 2 == 0;
}

static void swap_doubles(double* a, double* b) {
    const double kept = *a;
    *a = *b;
    *b = kept;
}

/* Sets the order of axes, the inputs in it, and results of 0. extinction: sigma* of the medium's own order. */
static void begin_order(source_job* job, bool exchanged, const float* extinction, const float* g) {
    const ty_dom_gradient_job* all = job->all;
    const ty_grid_medium* fine = all->dom.fine;
    const float* inputs[INPUTS] = {[EXTINCTION] = extinction,
                                   [SCATTERING] = fine->scattering[job->plane],
                                   [G] = g,
                                   [LOSS] = all->weight[job->channel]};
    job->exchanged = exchanged;
    job->medium = *fine;
    job->medium.planes = 1;
    memcpy(job->coarse_size, all->dom.coarse->box.size, sizeof job->coarse_size);
    if (exchanged) {
        job->medium.box.size[0] = fine->box.size[2];
        job->medium.box.size[2] = fine->box.size[0];
        job->coarse_size[0] = all->dom.coarse->box.size[2];
        job->coarse_size[2] = all->dom.coarse->box.size[0];
        swap_doubles(&job->medium.box.lower[0], &job->medium.box.lower[2]);
        swap_doubles(&job->medium.box.upper[0], &job->medium.box.upper[2]);
        swap_doubles(&job->medium.cell[0], &job->medium.cell[2]);
    }
    for (int i = 0; i < INPUTS; ++i)
        if (exchanged)
            ty_exchange_axes(fine->context, fine->box.size, inputs[i], job->fine[i], false);
        else
            memcpy(job->fine[i], inputs[i], sizeof(float) * fine->cells);
    for (int i = INPUTS; i < RESULTS_END; ++i) memset(job->fine[i], 0, sizeof(float) * fine->cells);
}

/* Adds the results to the derivatives by the media. */
static void end_order(const source_job* job, const float* g) {
    const ty_grid_medium* fine = job->all->dom.fine;
    ty_medium_gradient* media = &job->all->gradient->media;
    const float* results[3];
    for (int i = 0; i < 3; ++i) {
        results[i] = job->fine[INPUTS + i];
        if (!job->exchanged) continue;
        ty_exchange_axes(fine->context, job->medium.box.size, results[i], job->fine[A + i], false);
        results[i] = job->fine[A + i];
    }
    const int32_t p = job->plane;
    ty_dom_phase_slope slope = job->slope;
    for (size_t i = 0; i < fine->cells; ++i) {
        if (i == 0 || g[i] != g[i - 1]) ty_dom_phase_slope_at(job->all, (double)g[i], &slope);
        ty_dom_gradient_add_extinction(media, p, i, &slope, (double)g[i], (double)results[0][i]);
        media->scattering[p][i] += results[1][i] - g[i] * results[2][i];
        media->scattering_g[p][i] += results[2][i];
    }
}

static ty_result return_order(source_job* job, bool along_x, const float* extinction, const float* g) {
    ty_part_progress* progress = &job->all->dom.progress;
    const ty_discrete_light_set* sources = &job->all->dom.sources;
    ty_result result = TY_OK;
    int32_t count = 0;
    for (int32_t i = 0; i < sources->count; ++i) count += goes_along_x(job, &sources->items[i]) == along_x ? 1 : 0;
    if (count == 0) return TY_OK;
    begin_order(job, along_x, extinction, g);
    for (int32_t i = 0; i < sources->count && result == TY_OK; ++i) {
        job->source = &sources->items[i];
        if (goes_along_x(job, job->source) != along_x) continue;
        result = ty_part_show(progress, "adjoint", (double)i / sources->count);
        if (result == TY_OK) result = return_direction(job);
    }
    if (result == TY_OK) end_order(job, g);
    return result;
}

static ty_result return_channel(source_job* job, float* const extinction[3], float* g) {
    const ty_grid_medium* fine = job->all->dom.fine;
    job->plane = fine->planes == 3 ? job->channel : 0;
    ty_dom_phase_slope_at(job->all, (double)job->all->g[job->plane], &job->slope);
    for (size_t i = 0; i < fine->cells; ++i) g[i] = (float)ty_dom_gradient_g(job->all, fine, job->plane, i);
    ty_result result = return_order(job, false, extinction[job->plane], g);
    if (result == TY_OK) result = return_order(job, true, extinction[job->plane], g);
    return result;
}

static ty_result allocate(source_job* job, float* extinction[3], float** g) {
    ty_context* context = job->all->dom.context;
    const size_t cells = job->all->dom.fine->cells, coarse = job->all->dom.light->cells;
    float** const on_coarse[] = {&job->coarse[0], &job->coarse[1], &job->swapped};
    bool whole = true;
    for (int i = 0; i < 3; ++i) {
        *on_coarse[i] = ty_alloc_array(context, coarse, sizeof(float), false);
        whole = whole && *on_coarse[i] != NULL;
    }
    for (int i = 0; i < ARRAYS; ++i) {
        job->fine[i] = ty_alloc_array(context, cells, sizeof(float), false);
        whole = whole && job->fine[i] != NULL;
    }
    for (int32_t p = 0; p < job->all->dom.fine->planes; ++p) {
        extinction[p] = ty_alloc_array(context, cells, sizeof(float), false);
        whole = whole && extinction[p] != NULL;
    }
    *g = ty_alloc_array(context, cells, sizeof(float), false);
    return whole && *g != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static void free_all(const source_job* job, float* const extinction[3], float* g) {
    ty_context* context = job->all->dom.context;
    const size_t cells = job->all->dom.fine->cells, coarse = job->all->dom.light->cells;
    for (int i = 0; i < ARRAYS; ++i) ty_free_array(context, job->fine[i], cells, sizeof(float));
    for (int i = 0; i < 2; ++i) ty_free_array(context, job->coarse[i], coarse, sizeof(float));
    ty_free_array(context, job->swapped, coarse, sizeof(float));
    for (int p = 0; p < 3; ++p) ty_free_array(context, extinction[p], cells, sizeof(float));
    ty_free_array(context, g, cells, sizeof(float));
}

ty_result ty_dom_gradient_return_sources(ty_dom_gradient_job* all) {
    source_job job = {.all = all};
    float *extinction[3] = {NULL}, *g = NULL;
    ty_result result = allocate(&job, extinction, &g);
    if (result == TY_OK) ty_dom_uncollided_extinction(&all->dom, extinction);
    for (int32_t c = 0; c < 3 && result == TY_OK; ++c) {
        job.channel = c;
        if (all->channels[c].of == c) result = return_channel(&job, extinction, g);
    }
    free_all(&job, extinction, g);
    ty_collimated_scratch_free(all->dom.context, &job.scratch);
    return result;
}
