/* The adjoint of first-collision sources and of uncollided light. With q_lm = c_l b^l Y_lm(w) mean(sigma_s T) color of
 * a direction w of light, T its mean transmittance in fine cells and mean() that over coarse cells,
 *
 *     T* = color sigma_s A,   sigma_s* = color T A,   A = mean^T(sum_lm c_l b^l Y_lm(w) q*_lm),
 *
 * with * for the derivative of the loss by a quantity. By g likewise with the derivatives of c_l. */
#include "base/context.h"
#include "direct/uncollided/collimated_adjoint.h"
#include "direct/uncollided/uncollided.h"
#include "method/dom/gradient/gradient.h"
#include "method/dom/sources/sources.h"
#include "scene/scene.h"
#include "solve/angular/harmonics.h"

#include <string.h>

enum { CHUNK = 1 << 14, TERMS_MAX = TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX };

typedef struct source_job {
    ty_dom_gradient_job* all;
    int32_t plane, channel;          /* the channel has an adjoint of its own */
    const ty_discrete_light* source; /* at hand */
    float y[TERMS_MAX];              /* b^l Y_lm(w) */
    float color;                     /* of the source, times the weights of all channels with this adjoint */
    ty_dom_phase_slope slope;        /* of the plane, where g is uniform */
    float* coarse[2];                /* per coarse cell: the sum of A, and that by g, before their means' transpose */
    float *a, *a_by_g;               /* A of fine cells; by g */
    float* band;                     /* A of a single l, where g varies */
    float* transmittance;            /* T of fine cells */
    float* weight;                   /* dL/dT over color */
    float *extinction[3], *by_extinction;
} source_job;

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
    memset(job->coarse[0] + begin, 0, sizeof(float) * (end - begin));
    memset(job->coarse[1] + begin, 0, sizeof(float) * (end - begin));
    for (int32_t l = 0; l < light->bands; ++l)
        for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t) {
            const float* from = adjoint->source + light->cells * (size_t)t;
            const float factor = job->y[t] * (float)job->slope.scattered[l],
                        by_g = job->y[t] * (float)job->slope.scattered_by_g[l];
            for (size_t i = begin; i < end; ++i) job->coarse[0][i] += factor * from[i];
            for (size_t i = begin; i < end && by_g != 0; ++i) job->coarse[1][i] += by_g * from[i];
        }
}

static void spread(source_job* job, const float* coarse, float* fine) {
    const ty_grid_medium *medium = job->all->dom.fine, *from = job->all->dom.coarse;
    memset(fine, 0, sizeof *fine * medium->cells);
    ty_grid_spread(medium->context, coarse, from->box.size, medium->box.size, fine);
}

static int64_t chunks_of(size_t cells) {
    return (int64_t)((cells + CHUNK - 1) / CHUNK);
}

static void find_uniform(source_job* job) {
    ty_parallel_for(job->all->dom.context, chunks_of(job->all->dom.light->cells), sum_chunk, job);
    spread(job, job->coarse[0], job->a);
    spread(job, job->coarse[1], job->a_by_g);
}

/* Adds one l to A, by the g of each fine cell. */
static void add_band(source_job* job, int32_t l) {
    const ty_grid_medium* fine = job->all->dom.fine;
    for (size_t i = 0; i < fine->cells; ++i) {
        ty_dom_phase_slope slope;
        ty_dom_phase_slope_at(job->all, ty_dom_gradient_g(job->all, fine, job->plane, i), &slope);
        job->a[i] += (float)slope.scattered[l] * job->band[i];
        job->a_by_g[i] += (float)slope.scattered_by_g[l] * job->band[i];
    }
}

static void find_varying(source_job* job) {
    const ty_grid_medium* fine = job->all->dom.fine;
    memset(job->a, 0, sizeof *job->a * fine->cells);
    memset(job->a_by_g, 0, sizeof *job->a_by_g * fine->cells);
    for (int32_t l = 0; l < job->all->dom.light->bands; ++l) {
        memset(&job->slope, 0, sizeof job->slope);
        job->slope.scattered[l] = 1;
        ty_parallel_for(job->all->dom.context, chunks_of(job->all->dom.light->cells), sum_chunk, job);
        spread(job, job->coarse[0], job->band);
        add_band(job, l);
    }
}

/* ---- a direction ---- */

/* T* / color, with the weights of the fluence itself; sigma_s* and g*. */
static void weigh_chunk(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const source_job* job = user;
    const ty_grid_medium* fine = job->all->dom.fine;
    const float *scattering = fine->scattering[job->plane], *loss = job->all->weight[job->channel];
    ty_medium_gradient* media = &job->all->gradient->media;
    const size_t begin = (size_t)index * CHUNK, end = fine->cells - begin < CHUNK ? fine->cells : begin + CHUNK;
    for (size_t i = begin; i < end; ++i) {
        const float light = job->color * job->transmittance[i];
        const float g = (float)ty_dom_gradient_g(job->all, fine, job->plane, i);
        job->weight[i] = scattering[i] * job->a[i] + loss[i];
        media->scattering[job->plane][i] += light * (job->a[i] - g * job->a_by_g[i]);
        media->scattering_g[job->plane][i] += light * job->a_by_g[i];
    }
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

/* Adds the derivatives by a light's factor in each channel that has this adjoint, from that by all of them. */
static void add_strength(const source_job* job, double strength) {
    for (int32_t c = 0; c < 3; ++c) {
        const ty_dom_channel_adjoint* channel = &job->all->channels[c];
        if (channel->of != job->channel || job->color == 0) continue;
        job->all->gradient->lights[job->source->light][c] +=
            strength * (double)(channel->factor * job->source->color[c] / job->color);
    }
}

static ty_result return_direction(source_job* job, ty_part_progress* progress) {
    ty_dom_gradient_job* all = job->all;
    const ty_grid_medium* fine = all->dom.fine;
    ty_discrete_light one = *job->source;
    double strength[1][3] = {{0}};
    float* planes[3] = {job->transmittance, job->transmittance, job->transmittance};
    job->color = 0;
    for (int32_t c = 0; c < 3; ++c)
        if (all->channels[c].of == job->channel) job->color += all->channels[c].factor * one.color[c];
    find_harmonics(job);
    if (is_uniform(job))
        find_uniform(job);
    else
        find_varying(job);
    one.color[0] = job->color;
    one.light = 0;
    /* One plane of the medium at a time. */
    ty_grid_medium gray = *fine;
    gray.planes = 1;
    ty_result result =
        ty_uncollided_transmittance(all->dom.scene, &gray, &job->extinction[job->plane], job->source, planes, NULL);
    if (result != TY_OK) return result;
    ty_parallel_for(all->dom.context, chunks_of(fine->cells), weigh_chunk, job);
    const ty_collimated_loss loss = {.sources = &one,
                                     .count = 1,
                                     .extinction = job->extinction[job->plane],
                                     .channels = 1,
                                     .weight = {job->weight},
                                     .progress = progress};
    result = ty_collimated_adjoint(fine, &loss, job->by_extinction, strength);
    add_strength(job, strength[0][0]);
    return result;
}

/* ---- all directions ---- */

/* The adjoint of sigma*, by which uncollided light is attenuated. */
static void return_extinction(const source_job* job) {
    const ty_grid_medium* fine = job->all->dom.fine;
    ty_dom_phase_slope slope;
    for (size_t i = 0; i < fine->cells; ++i) {
        const double g = ty_dom_gradient_g(job->all, fine, job->plane, i);
        ty_dom_phase_slope_at(job->all, g, &slope);
        ty_dom_gradient_add_extinction(&job->all->gradient->media, job->plane, i, &slope, g,
                                       (double)job->by_extinction[i]);
    }
}

static ty_result return_channel(source_job* job) {
    ty_dom_gradient_job* all = job->all;
    const ty_discrete_light_set* sources = &all->dom.sources;
    const double from = all->dom.progress.from, span = all->dom.progress.span;
    ty_result result = TY_OK;
    job->plane = all->dom.fine->planes == 3 ? job->channel : 0;
    ty_dom_phase_slope_at(all, (double)all->g[job->plane], &job->slope);
    memset(job->by_extinction, 0, sizeof(float) * all->dom.fine->cells);
    for (int32_t i = 0; i < sources->count && result == TY_OK; ++i) {
        job->source = &sources->items[i];
        all->dom.progress.span = span / sources->count;
        result = return_direction(job, &all->dom.progress);
        all->dom.progress.from += all->dom.progress.span;
    }
    all->dom.progress.from = from;
    all->dom.progress.span = span;
    if (result == TY_OK) return_extinction(job);
    return result;
}

static ty_result allocate(source_job* job) {
    ty_context* context = job->all->dom.context;
    const size_t cells = job->all->dom.fine->cells;
    float** const fine[] = {&job->a, &job->a_by_g, &job->band, &job->transmittance, &job->weight, &job->by_extinction};
    for (size_t i = 0; i < sizeof fine / sizeof *fine; ++i) {
        *fine[i] = ty_alloc_array(context, cells, sizeof(float), false);
        if (*fine[i] == NULL) return TY_ERROR_MEMORY;
    }
    for (int32_t p = 0; p < job->all->dom.fine->planes; ++p) {
        job->extinction[p] = ty_alloc_array(context, cells, sizeof(float), false);
        if (job->extinction[p] == NULL) return TY_ERROR_MEMORY;
    }
    for (int i = 0; i < 2; ++i) {
        job->coarse[i] = ty_alloc_array(context, job->all->dom.light->cells, sizeof(float), false);
        if (job->coarse[i] == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

static void free_all(const source_job* job) {
    ty_context* context = job->all->dom.context;
    float* const fine[] = {job->a,
                           job->a_by_g,
                           job->band,
                           job->transmittance,
                           job->weight,
                           job->by_extinction,
                           job->extinction[0],
                           job->extinction[1],
                           job->extinction[2]};
    for (size_t i = 0; i < sizeof fine / sizeof *fine; ++i)
        ty_free_array(context, fine[i], job->all->dom.fine->cells, sizeof(float));
    for (int i = 0; i < 2; ++i) ty_free_array(context, job->coarse[i], job->all->dom.light->cells, sizeof(float));
}

ty_result ty_dom_gradient_return_sources(ty_dom_gradient_job* all) {
    source_job job = {.all = all};
    ty_result result = allocate(&job);
    if (result == TY_OK) ty_dom_uncollided_extinction(&all->dom, job.extinction);
    for (int32_t c = 0; c < 3 && result == TY_OK; ++c) {
        job.channel = c;
        if (all->channels[c].of == c) result = return_channel(&job);
    }
    free_all(&job);
    return result;
}
