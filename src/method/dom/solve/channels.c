/* Solves for the moments of collided light, one per channel. */
#include "base/context.h"
#include "base/mapping.h"
#include "method/dom/flux_request.h"
#include "method/dom/solve/solve.h"
#include "solve/ordinates/divided/joint_solve.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

/* With few threads and few cells, channels are solved concurrently with one thread each: a stage of a sweep through a
 * small box ends before other threads have woken up. The remaining solve has all threads. */
enum { MAX_CONCURRENT_THREADS = 4, MAX_CONCURRENT_CELLS = 1 << 16 };

struct scattering;

/* One channel's solve. */
typedef struct channel_solve {
    struct scattering* all;
    int32_t channel;
    void* memory;
    double done; /* fraction, 0..1 */
    ty_ordinates_stats stats;
    ty_dom_boundary_power boundary;
    ty_result result;
} channel_solve;

/* State shared by the channels' solves. */
typedef struct scattering {
    ty_dom_job* job;
    channel_solve solves[3];
    int32_t count;      /* number of solves */
    int32_t concurrent; /* number of solves that run concurrently */
    void* memory[3];    /* one block per concurrent solve */
    size_t memory_size;
    pthread_mutex_t lock; /* guards `cancelled` and the solves' `done` */
    bool cancelled;
} scattering;

/* Initial moments from another solution, in units of this one's channels. */
typedef struct start_planes {
    float* floats; /* NULL: no initial moments */
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

static ty_result allocate_start(const ty_dom_job* job, int32_t channel, start_planes* out) {
    const ty_dom *light = job->light, *start = job->def->start;
    const size_t terms = term_count(light->bands);
    out->floats = NULL;
    if (start == NULL) return TY_OK;
    out->floats = ty_alloc_large(job->context, light->cells, terms * sizeof(float), true);
    if (out->floats == NULL) return TY_ERROR_MEMORY;
    const float* from = start->moments[start->shared ? 0 : channel];
    const float factor = (start->shared ? start->color[channel] : 1) / (light->shared ? light->color[channel] : 1);
    const size_t known = term_count(start->output_bands) < terms ? term_count(start->output_bands) : terms;
    for (size_t i = 0; i < known * light->cells; ++i) out->floats[i] = factor * from[i];
    for (size_t t = 0; t < terms; ++t) out->planes[t] = out->floats + light->cells * t;
    return TY_OK;
}

/* The channel with the largest factor of a shared solve. */
static int32_t brightest(const ty_dom* light) {
    int32_t best = 0;
    for (int32_t c = 1; c < 3; ++c)
        if (light->color[c] > light->color[best]) best = c;
    return best;
}

/* Adds a solve's statistics. concurrent: number of solves that ran at a time, among which its sweeps' wall time is
 * divided. */
static void note_solve(ty_dom_job* job, const channel_solve* solve, int32_t concurrent) {
    const ty_dom* light = job->light;
    const ty_ordinates_stats* solved = &solve->stats;
    ty_dom_stats* stats = &job->stats;
    const int32_t channel = solve->channel, end = light->shared ? 3 : channel + 1;
    const ty_dom_boundary_power* boundary = &solve->boundary;
    stats->converged = stats->converged && solved->converged && boundary->converged;
    stats->sweep_seconds += (solved->sweep_seconds + boundary->sweep_seconds) / concurrent;
    stats->memory_bytes = fmax(stats->memory_bytes, solved->bytes * concurrent);
    for (int32_t c = channel; c < end; ++c) {
        const double factor = (double)light->color[c];
        stats->sweeps[c] = solved->sweeps + boundary->sweeps;
        stats->cycles[c] = solved->cycles;
        stats->change[c] = solved->change;
        stats->emitted[c] = factor * (solved->emitted + boundary->emitted);
        stats->absorbed[c] = factor * (solved->absorbed + boundary->absorbed);
        stats->absorbed_by_surfaces[c] = factor * (solved->walls_absorbed + boundary->by_walls);
        stats->leaving[c] = factor * (solved->leaving + boundary->leaving);
    }
}

/* Reports the mean progress of all channels. Cancelling one solve cancels all. */
static bool report(void* user, const ty_progress* part) {
    channel_solve* solve = user;
    scattering* all = solve->all;
    ty_progress whole = *part;
    pthread_mutex_lock(&all->lock);
    solve->done = part->fraction;
    whole.fraction = 0;
    for (int32_t i = 0; i < all->count; ++i) whole.fraction += all->solves[i].done / all->count;
    all->cancelled = all->cancelled || !ty_part_report(&all->job->progress, &whole);
    const bool goes_on = !all->cancelled;
    pthread_mutex_unlock(&all->lock);
    return goes_on;
}

/* The definition of a channel's solve without its planes. */
static ty_ordinates_def define_solve(const ty_dom_job* job) {
    const ty_dom* light = job->light;
    const ty_dom_def* dom = job->def;
    ty_ordinates_def def = ty_default_ordinates_def();
    memcpy(def.size, light->box.size, sizeof def.size);
    memcpy(def.cell, job->coarse->cell, sizeof def.cell);
    def.set = job->set;
    def.final_set = job->last_set;
    def.bands = light->bands;
    def.output_order = light->output_bands;
    def.source_terms = (int32_t)term_count(light->bands);
    def.accelerated = dom->acceleration == TY_DOM_ACCELERATION_DIFFUSION;
    def.diffusive_paths = job->diffusive_paths;
    def.periodic = job->coarse->periodic;
    def.tolerance = dom->tolerance;
    def.sweeps = dom->iterations == TY_AUTO ? 0 : dom->iterations;
    def.walls.count = job->boundary != NULL ? job->boundary->count : 0;
    def.progress = report;
    return def;
}

/* Tells why other ranks do not take part. */
static void tell_if_undivided(const channel_solve* solve, const ty_ordinates_def* def) {
    const char* why = ty_ordinates_why_undivided(solve->all->job->context, def);
    if (why == NULL || why[0] == 0 || solve != solve->all->solves) return;
    ty_log(solve->all->job->context, TY_LOG_WARNING, "dom: rank 0 solves alone, because %s", why);
}

static ty_result solve_from(channel_solve* solve, const start_planes* start) {
    const ty_dom_job* job = solve->all->job;
    ty_dom* light = job->light;
    const int32_t channel = solve->channel, plane = light->planes == 3 ? channel : 0;
    const size_t terms = term_count(light->bands), kept = term_count(light->output_bands);
    const float* source[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX];
    float* moments[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX];
    for (size_t t = 0; t < terms; ++t) source[t] = job->source[channel] + light->cells * t;
    for (size_t t = 0; t < kept; ++t) moments[t] = light->moments[channel] + light->cells * t;
    ty_ordinates_def def = define_solve(job);
    def.extinction = job->coarse->extinction[plane];
    def.scattering = job->coarse->scattering[plane];
    def.g = job->coarse->g[plane];
    def.source = source;
    if (light->fit.bands > 0) def.scattered = light->fit.moments;
    if (ty_dom_legendre(light) != NULL) def.scattered = light->scattered;
    def.face_fluence = light->face_fluence[channel];
    def.face_incident = light->face_even[channel];
    def.start = start->floats != NULL ? start->planes : NULL;
    def.memory = solve->memory;
    def.progress_user = solve;
    for (int i = 0; i < 2 && job->flux != NULL; ++i) def.passing[i] = job->flux->passing[channel][i];
    def.passing_axis = job->scene->up == TY_AXIS_Z ? 2 : 1;
    const float* centers[4] = {NULL};
    for (size_t n = 0; n < 4 && job->centers[channel] != NULL; ++n)
        centers[n] = job->centers[channel] + light->cells * n;
    def.source_center = centers[0] != NULL ? centers : NULL;
    def.displaces_sources = job->tells_positions;
    float* zeros = NULL;
    ty_result result = ty_dom_solve_boundary_light(solve->all->job, channel, &def, &solve->boundary);
    if (result == TY_OK) result = ty_dom_set_reflection(solve->all->job, channel, &def, &zeros);
    tell_if_undivided(solve, &def);
    if (result == TY_OK) result = ty_ordinates_solve_jointly(job->context, &def, moments, &solve->stats);
    if (zeros != NULL) ty_free_array(job->context, zeros, (size_t)job->boundary->count, sizeof *zeros);
    return result;
}

/* The fraction of even light that a half-space reflects (van de Hulst 1980), by its similarity parameter s. */
static float reflected_fraction(const ty_dom* light, int32_t plane, size_t cell) {
    const float s = light->similarity[plane][cell];
    return (1 - s) * (1 - 0.139f * s) / (1 + 1.17f * s);
}

/* The part of a cell's first-collision source that light of surfaces makes. */
static float lit_by_surfaces(const ty_dom_job* job, int32_t channel, size_t cell) {
    const float* surfaces = job->light->wall_moments[channel];
    if (surfaces == NULL) return 0;
    const float from = job->coarse->scattering[job->light->planes == 3 ? channel : 0][cell] * surfaces[cell];
    const float lights = job->centers[channel] != NULL ? job->centers[channel][cell] : 0;
    return from > 0 ? from / (from + lights) : 0;
}

/* Turns the fluence of faces into what scatters last in their cells, which the marcher multiplies with sigma_s and
 * attenuates by sigma_t, or by sigma* where the phase function is fitted; and what is incident on them into the part of
 * it that comes from even light. */
static void keep_scattered(const ty_dom_job* job, int32_t channel) {
    const ty_dom* light = job->light;
    const ty_grid_medium* medium = job->coarse;
    const int32_t plane = light->planes == 3 ? channel : 0;
    const float total = light->color[0] + light->color[1] + light->color[2];
    float *faces = light->face_fluence[channel], *even = light->face_even[channel];
    for (size_t i = 0; faces != NULL && i < light->cells; ++i) {
        const float sigma_t = medium->extinction[plane][i], sigma_s = medium->scattering[plane][i];
        const float attenuating = sigma_t - (light->fit.bands > 0 ? light->fit.forward_fraction * sigma_s : 0);
        float emission = medium->emission[0] != NULL ? medium->emission[channel][i] : 0;
        if (light->shared && medium->emission[0] != NULL)
            emission = (medium->emission[0][i] + medium->emission[1][i] + medium->emission[2][i]) / total;
        const float fraction = reflected_fraction(light, plane, i), lit = lit_by_surfaces(job, channel, i);
        for (size_t face = 6 * i; face < 6 * i + 6; ++face) {
            if (faces[face] < 0) continue;
            const float reflected = ty_minf(faces[face], fraction * even[face]);
            even[face] = sigma_s > 0 ? (reflected + lit * (faces[face] - reflected)) * attenuating / sigma_s : 0;
        }
        for (size_t face = 6 * i; face < 6 * i + 6; ++face)
            if (faces[face] >= 0)
                faces[face] =
                    sigma_s > 0 ? ty_maxf(0, faces[face] - (float)TY_SH_0 * emission / sigma_t) * attenuating / sigma_s
                                : 0;
    }
}

static void solve_channel(void* user, int64_t index, int32_t worker) {
    (void)worker;
    channel_solve* solve = (channel_solve*)user + index;
    const ty_dom_job* job = solve->all->job;
    const ty_dom* light = job->light;
    start_planes start;
    solve->result = allocate_start(job, light->shared ? brightest(light) : solve->channel, &start);
    if (solve->result != TY_OK) return;
    solve->result = solve_from(solve, &start);
    if (solve->result == TY_OK) keep_scattered(job, solve->channel);
    ty_free_large(job->context, start.floats, start.floats != NULL ? light->cells : 0,
                  term_count(light->bands) * sizeof(float));
}

static bool is_dark(const ty_dom_job* job, int32_t channel) {
    const float* source = job->source[channel];
    for (size_t i = 0; i < job->light->cells; ++i)
        if (source[i] != 0) return false;
    return ty_dom_boundary_is_dark(job, channel);
}

/* True if some cell may be thick enough for diffusion. */
static bool has_diffusive_cells(const ty_dom_job* job, int32_t channel) {
    for (size_t i = 0; i < job->light->cells; ++i)
        if (ty_dom_cell_thickness(job, job->light->planes == 3 ? channel : 0, i) > job->diffusive_paths) return true;
    return false;
}

/* Slope of the multiply scattered radiance that leaves a half-space without absorption, in the cosine: of H(mu) H(mu_0)
 * - 1 over 1 + mu / mu_0, by Chandrasekhar's H. It falls off with absorption as the fourth power of P1's weight. Even
 * light leaves evenly. */
static const double max_darkening = 0.57;

/* Keeps what images need of media with diffusive cells. */
static ty_result keep_media(ty_dom_job* job) {
    ty_dom* light = job->light;
    const ty_grid_medium* medium = job->coarse;
    if (light->extinction[0] != NULL) return TY_OK;
    for (int32_t p = 0; p < light->planes; ++p) {
        light->extinction[p] = ty_alloc_array(job->context, light->cells, sizeof(float), false);
        light->darkening[p] = ty_alloc_array(job->context, light->cells, sizeof(float), false);
        light->similarity[p] = ty_alloc_array(job->context, light->cells, sizeof(float), false);
        if (light->extinction[p] == NULL || light->darkening[p] == NULL || light->similarity[p] == NULL)
            return TY_ERROR_MEMORY;
        memcpy(light->extinction[p], medium->extinction[p], light->cells * sizeof(float));
        for (size_t i = 0; i < light->cells; ++i) {
            const double sigma_t = (double)medium->extinction[p][i], sigma_s = (double)medium->scattering[p][i];
            const double reduced = sigma_t - (double)medium->g[p][i] * sigma_s;
            const double s = sqrt(reduced > 0 ? fmax(0, fmin((sigma_t - sigma_s) / reduced, 1)) : 1);
            light->darkening[p][i] = job->even_light ? 0 : (float)(max_darkening * pow(1 - s, 4));
            light->similarity[p][i] = (float)s;
        }
    }
    return TY_OK;
}

/* Allocates the channels' moments and lists the channels with a source. */
static ty_result choose_channels(scattering* all) {
    ty_dom_job* job = all->job;
    ty_dom* light = job->light;
    bool diffusive = false;
    for (int32_t c = 0; c < ty_dom_channels(light); ++c) {
        const bool without_source = is_dark(job, c);
        light->moments[c] =
            ty_alloc_large(job->context, light->cells, term_count(light->output_bands) * sizeof(float), without_source);
        if (light->moments[c] == NULL) return TY_ERROR_MEMORY;
        if (without_source) continue;
        if (has_diffusive_cells(job, c)) {
            light->face_fluence[c] = ty_alloc_array(job->context, 6 * light->cells, sizeof(float), false);
            light->face_even[c] = ty_alloc_array(job->context, 6 * light->cells, sizeof(float), false);
            if (light->face_fluence[c] == NULL || light->face_even[c] == NULL) return TY_ERROR_MEMORY;
            diffusive = true;
        }
        all->solves[all->count++] = (channel_solve){.all = all, .channel = c};
    }
    return diffusive ? keep_media(job) : TY_OK;
}

static int32_t count_concurrent(const scattering* all) {
    const int32_t threads = ty_context_threads(all->job->context);
    if (ty_context_queue(all->job->context) != NULL) return 1; /* all ranks help with one at a time */
    if (threads > MAX_CONCURRENT_THREADS || all->job->light->cells > MAX_CONCURRENT_CELLS) return 1;
    return threads < all->count ? threads : all->count;
}

/* Memory of the concurrent solves, which later solves reuse: fresh pages cost page faults. */
static ty_result allocate_memory(scattering* all) {
    if (all->count == 0) return TY_OK;
    const ty_ordinates_def def = define_solve(all->job);
    all->concurrent = count_concurrent(all);
    if (ty_context_queue(all->job->context) != NULL) return TY_OK; /* a solve takes what its part needs */
    all->memory_size = ty_ordinates_memory(&def);
    for (int32_t i = 0; i < all->concurrent; ++i) {
        all->memory[i] = ty_alloc_array(all->job->context, all->memory_size, 1, false);
        if (all->memory[i] == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

static void free_memory(scattering* all) {
    for (int32_t i = 0; i < all->concurrent; ++i)
        if (all->memory[i] != NULL) ty_free_array(all->job->context, all->memory[i], all->memory_size, 1);
}

/* Runs the solves from `first` on, up to `concurrent` of them; a single one has all threads. */
static ty_result solve_some(scattering* all, int32_t first) {
    const int32_t left = all->count - first, count = left < all->concurrent ? left : all->concurrent;
    for (int32_t i = 0; i < count; ++i) all->solves[first + i].memory = all->memory[i];
    ty_parallel_for(all->job->context, count, solve_channel, &all->solves[first]);
    ty_result result = TY_OK;
    for (int32_t i = first; i < first + count; ++i) {
        all->solves[i].done = 1;
        if (result == TY_OK) result = all->solves[i].result;
        if (result == TY_OK) note_solve(all->job, &all->solves[i], count);
    }
    return result;
}

ty_result ty_dom_solve_channels(ty_dom_job* job) {
    scattering all = {.job = job};
    ty_result result = check_start(job);
    job->stats.converged = true;
    pthread_mutex_init(&all.lock, NULL);
    if (result == TY_OK) result = choose_channels(&all);
    if (result == TY_OK) result = allocate_memory(&all);
    for (int32_t i = 0; i < all.count && result == TY_OK; i += all.concurrent) result = solve_some(&all, i);
    free_memory(&all);
    pthread_mutex_destroy(&all.lock);
    return result;
}
