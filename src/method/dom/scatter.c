/* Moments of what has scattered: one solve a channel. */
#include "base/context.h"
#include "method/dom/job.h"

#include <string.h>

/* Moments to start from: another light's, in units of this one's. */
typedef struct start_planes {
    float* floats; /* NULL: there are none */
    const float* planes[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX];
} start_planes;

static size_t term_count(int32_t bands) {
    return (size_t)bands * (size_t)bands;
}

static ty_result check_start(const ty_dom_job* job) {
    const ty_dom* start = job->def->start;
    const int32_t *has = start != NULL ? start->box.size : NULL, *needs = job->light->box.size;
    if (start == NULL || memcmp(has, needs, sizeof start->box.size) == 0) return TY_OK;
    return ty_fail(job->context, TY_ERROR_ARGUMENT, "dom.start: of %d x %d x %d cells, and these are %d x %d x %d",
                   (int)has[0], (int)has[1], (int)has[2], (int)needs[0], (int)needs[1], (int)needs[2]);
}

static ty_result take_start(const ty_dom_job* job, int32_t channel, start_planes* out) {
    const ty_dom *light = job->light, *start = job->def->start;
    const size_t terms = term_count(light->bands);
    out->floats = NULL;
    if (start == NULL) return TY_OK;
    out->floats = ty_alloc_array(job->context, light->cells, terms * sizeof(float), true);
    if (out->floats == NULL) return TY_ERROR_MEMORY;
    const float* from = start->moments[start->shared ? 0 : channel];
    const float factor = (start->shared ? start->color[channel] : 1) / (light->shared ? light->color[channel] : 1);
    const size_t known = term_count(start->kept) < terms ? term_count(start->kept) : terms;
    for (size_t i = 0; i < known * light->cells; ++i) out->floats[i] = factor * from[i];
    for (size_t t = 0; t < terms; ++t) out->planes[t] = out->floats + light->cells * t;
    return TY_OK;
}

/* The channel that a shared light's color is brightest in. */
static int32_t brightest(const ty_dom* light) {
    int32_t best = 0;
    for (int32_t c = 1; c < 3; ++c)
        if (light->color[c] > light->color[best]) best = c;
    return best;
}

static void note_solve(ty_dom_job* job, int32_t channel, const ty_ordinates_stats* solved) {
    const ty_dom* light = job->light;
    ty_dom_stats* stats = &job->stats;
    const int32_t end = light->shared ? 3 : channel + 1;
    stats->converged = stats->converged && solved->converged;
    stats->sweep_seconds += solved->sweep_seconds;
    if (solved->bytes > stats->bytes) stats->bytes = solved->bytes;
    for (int32_t c = channel; c < end; ++c) {
        const double factor = (double)light->color[c];
        stats->sweeps[c] = solved->sweeps;
        stats->cycles[c] = solved->cycles;
        stats->change[c] = solved->change;
        stats->emitted[c] = factor * solved->emitted;
        stats->absorbed[c] = factor * solved->absorbed;
        stats->leaving[c] = factor * solved->leaving;
    }
}

static ty_result solve_channel(ty_dom_job* job, int32_t channel) {
    ty_dom* light = job->light;
    const ty_dom_def* dom = job->def;
    const int32_t plane = light->planes == 3 ? channel : 0;
    const size_t terms = term_count(light->bands), kept = term_count(light->kept);
    const float* source[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX];
    float* moments[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX];
    for (size_t t = 0; t < terms; ++t) source[t] = job->source[channel] + light->cells * t;
    for (size_t t = 0; t < kept; ++t) moments[t] = light->moments[channel] + light->cells * t;
    start_planes start;
    ty_result result = take_start(job, light->shared ? brightest(light) : channel, &start);
    if (result != TY_OK) return result;
    ty_ordinates_def def = ty_default_ordinates_def();
    memcpy(def.size, light->box.size, sizeof def.size);
    memcpy(def.cell, job->coarse->cell, sizeof def.cell);
    def.set = job->set;
    def.bands = light->bands;
    def.kept = light->kept;
    def.extinction = job->coarse->extinction[plane];
    def.scattering = job->coarse->scattering[plane];
    def.g = job->coarse->g[plane];
    def.source = source;
    def.source_terms = (int32_t)terms;
    def.accelerated = dom->acceleration == TY_DOM_ACCELERATION_DIFFUSION;
    def.tolerance = dom->tolerance;
    def.sweeps = dom->iterations;
    def.start = start.floats != NULL ? start.planes : NULL;
    def.progress = ty_part_report;
    def.progress_user = &job->progress;
    ty_ordinates_stats solved = {.converged = false};
    result = ty_ordinates_solve(job->context, &def, moments, NULL, 0, &solved);
    ty_free_array(job->context, start.floats, start.floats != NULL ? light->cells : 0, terms * sizeof(float));
    if (result == TY_OK) note_solve(job, channel, &solved);
    return result;
}

static bool is_dark(const ty_dom_job* job, int32_t channel) {
    const float* source = job->source[channel];
    for (size_t i = 0; i < job->light->cells; ++i)
        if (source[i] != 0) return false;
    return true;
}

ty_result ty_dom_scatter(ty_dom_job* job) {
    ty_dom* light = job->light;
    const int32_t channels = ty_dom_channels(light);
    const double from = job->progress.from, share = job->progress.share;
    ty_result result = check_start(job);
    job->stats.converged = true;
    for (int32_t c = 0; c < channels && result == TY_OK; ++c) {
        light->moments[c] = ty_alloc_array(job->context, light->cells, term_count(light->kept) * sizeof(float), true);
        if (light->moments[c] == NULL) return TY_ERROR_MEMORY;
        job->progress.from = from + share * c / channels;
        job->progress.share = share / channels;
        if (!is_dark(job, c)) result = solve_channel(job, c);
    }
    job->progress.from = from;
    job->progress.share = share;
    return result;
}
