/* The adjoint of ordinates, channel by channel. */
#include "base/constants.h"
#include "base/context.h"
#include "method/dom/gradient/gradient.h"
#include "solve/ordinates/adjoint.h"

#include <math.h>
#include <string.h>

/* Bound of the estimated remaining error of adjoint light, or this part of the light's own; change of the light by a
 * sweep above which it is no solution.
 */
static const double TOLERANCE = 2e-5, PART_OF_ERROR = 0.1, MAX_IMBALANCE = 0.1;

static size_t terms_of(const ty_dom_gradient_job* job) {
    return (size_t)job->dom.light->bands * (size_t)job->dom.light->bands;
}

/* ---- channels ---- */

static ty_result allocate(ty_dom_gradient_job* job, ty_dom_channel_adjoint* channel) {
    ty_context* context = job->dom.context;
    const size_t cells = job->dom.light->cells;
    channel->source = ty_alloc_array(context, cells, terms_of(job) * sizeof(float), true);
    channel->extinction = ty_alloc_array(context, cells, sizeof(float), true);
    bool whole = channel->source != NULL && channel->extinction != NULL;
    for (int32_t l = 0; l < job->dom.light->bands; ++l) {
        channel->scattered[l] = ty_alloc_array(context, cells, sizeof(float), true);
        whole = whole && channel->scattered[l] != NULL;
    }
    return whole ? TY_OK : TY_ERROR_MEMORY;
}

void ty_dom_gradient_free_channels(ty_dom_gradient_job* job) {
    ty_context* context = job->dom.context;
    for (int c = 0; c < 3; ++c) {
        ty_dom_channel_adjoint* channel = &job->channels[c];
        ty_free_array(context, channel->source, job->dom.light->cells, terms_of(job) * sizeof(float));
        ty_free_array(context, channel->extinction, job->dom.light->cells, sizeof(float));
        for (int32_t l = 0; l < job->dom.light->bands; ++l)
            ty_free_array(context, channel->scattered[l], job->dom.light->cells, sizeof(float));
    }
}

/* The channel whose adjoint is a multiple of this one's. */
static void choose_adjoint(ty_dom_gradient_job* job, int32_t c) {
    ty_dom_channel_adjoint* channel = &job->channels[c];
    *channel = (ty_dom_channel_adjoint){.of = c, .factor = 1};
    for (int32_t other = 0; other < c && job->light->shared; ++other) {
        float factor, fine_factor;
        if (job->channels[other].of != other) continue;
        if (!ty_is_multiple(job->source_weight[c], job->source_weight[other], job->dom.coarse->cells, &factor) ||
            !ty_is_multiple(job->weight[c], job->weight[other], job->dom.fine->cells, &fine_factor))
            continue;
        channel->of = other;
        channel->factor = factor;
        return;
    }
}

/* ---- the solve ---- */

static bool report(void* user, const ty_progress* part) {
    ty_progress adjoint = *part;
    adjoint.stage = "adjoint";
    return ty_part_report(user, &adjoint);
}

static ty_ordinates_def define(ty_dom_gradient_job* job, int32_t plane) {
    const ty_dom* light = job->dom.light;
    ty_ordinates_def def = ty_default_ordinates_def();
    memcpy(def.size, light->box.size, sizeof def.size);
    memcpy(def.cell, job->dom.coarse->cell, sizeof def.cell);
    def.set = job->dom.set;
    def.bands = def.output_order = light->bands;
    def.source_terms = (int32_t)terms_of(job);
    def.accelerated = job->dom.def->acceleration == TY_DOM_ACCELERATION_DIFFUSION;
    def.diffusive_paths = job->dom.diffusive_paths;
    def.extinction = job->dom.coarse->extinction[plane];
    def.scattering = job->dom.coarse->scattering[plane];
    def.g = job->dom.coarse->g[plane];
    if (light->fit.bands > 0) def.scattered = light->fit.moments;
    if (ty_dom_legendre(light) != NULL) def.scattered = light->scattered;
    def.progress = report;
    def.progress_user = &job->dom.progress;
    return def;
}

static ty_result note_solve(const ty_dom_gradient_job* job, const ty_ordinates_adjoint_stats* solved) {
    ty_gradient_stats* stats = job->stats;
    stats->converged = stats->converged && solved->converged;
    stats->iterations += solved->sweeps;
    stats->residual = fmax(stats->residual, solved->change);
    stats->imbalance = fmax(stats->imbalance, solved->imbalance);
    if (solved->imbalance <= MAX_IMBALANCE) return TY_OK;
    return ty_fail(job->dom.context, TY_ERROR_ARGUMENT,
                   "gradient: the light is no solution of this scene: a sweep changes it by %g of itself",
                   solved->imbalance);
}

static ty_result solve_channel(ty_dom_gradient_job* job, int32_t c) {
    const ty_dom* light = job->dom.light;
    const size_t terms = terms_of(job), cells = light->cells;
    const int32_t solved = light->shared ? 0 : c;
    ty_dom_channel_adjoint* channel = &job->channels[c];
    const float *source[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX], *moments[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX];
    float* by_source[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX];
    ty_ordinates_adjoint_stats stats;
    ty_result result = allocate(job, channel);
    if (result != TY_OK) return result;
    for (size_t t = 0; t < terms; ++t) {
        source[t] = job->light->source[solved] + cells * t;
        moments[t] = job->light->moments[solved] + cells * t;
        by_source[t] = channel->source + cells * t;
    }
    ty_ordinates_def def = define(job, light->planes == 3 ? c : 0);
    def.source = source;
    const ty_ordinates_adjoint_out out = {by_source, channel->extinction, channel->scattered};
    for (size_t i = 0; i < cells; ++i) job->source_weight[c][i] *= (float)TY_SQRT_4PI_F64;
    const double tolerance = fmax(TOLERANCE, PART_OF_ERROR * job->dom.def->tolerance);
    result = ty_ordinates_adjoint(job->dom.context, &def, moments, job->source_weight[c], tolerance, &out, &stats);
    if (result != TY_OK) return result;
    return note_solve(job, &stats);
}

/* Adds a channel's derivatives by sigma* and s_l of coarse cells to those by their media. */
static void add_media(ty_dom_gradient_job* job, int32_t c) {
    const ty_dom_channel_adjoint *own = &job->channels[c], *from = &job->channels[own->of];
    const ty_dom* light = job->dom.light;
    const int32_t plane = light->planes == 3 ? c : 0;
    const double factor = (double)(own->factor * light->color[c]);
    ty_dom_phase_slope slope;
    for (size_t i = 0; i < light->cells; ++i) {
        const double g = ty_dom_gradient_g(job, job->dom.coarse, plane, i);
        double by_scattering = 0, by_g = 0;
        ty_dom_phase_slope_at(job, g, &slope);
        for (int32_t l = 0; l < light->bands; ++l) {
            by_scattering += slope.scattered[l] * (double)from->scattered[l][i];
            by_g += slope.scattered_by_g[l] * (double)from->scattered[l][i];
        }
        job->coarse.scattering[plane][i] += (float)(factor * (by_scattering - g * by_g));
        job->coarse.scattering_g[plane][i] += (float)(factor * by_g);
        ty_dom_gradient_add_extinction(&job->coarse, plane, i, &slope, g, factor * (double)from->extinction[i]);
    }
}

ty_result ty_dom_gradient_solve(ty_dom_gradient_job* job) {
    ty_result result = TY_OK;
    job->stats->converged = true;
    for (int32_t c = 0; c < 3; ++c) choose_adjoint(job, c);
    for (int32_t c = 0; c < 3 && result == TY_OK; ++c)
        if (job->channels[c].of == c) result = solve_channel(job, c);
    for (int32_t c = 0; c < 3 && result == TY_OK; ++c) add_media(job, c);
    return result;
}
