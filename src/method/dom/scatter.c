/* Moments of what has scattered: one solve a channel. */
#include "base/context.h"
#include "method/dom/job.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

/* Channels are solved side by side, one thread each, by few threads and on boxes of at most so many cells: a stage of a
 * sweep through a small box is over before other threads have woken up. What is left over has all threads. */
enum { SIDE_BY_SIDE_THREADS = 4, SIDE_BY_SIDE_CELLS = 1 << 16 };

struct scattering;

/* One channel's solve. */
typedef struct channel_solve {
    struct scattering* all;
    int32_t channel;
    void* memory;
    double done; /* of it, 0..1 */
    ty_ordinates_stats stats;
    ty_dom_wall_power walls;
    ty_result result;
} channel_solve;

/* What the solves of all channels share. */
typedef struct scattering {
    ty_dom_job* job;
    channel_solve solves[3];
    int32_t count;   /* of them */
    int32_t beside;  /* how many are solved side by side */
    void* memory[3]; /* of as many */
    size_t memory_size;
    pthread_mutex_t lock; /* guards what follows, and how much of each is done */
    bool cancelled;
} scattering;

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

/* Of a solve that had as many beside it, with itself: on the clock its sweeps took a share of what they did. */
static void note_solve(ty_dom_job* job, const channel_solve* solve, int32_t beside) {
    const ty_dom* light = job->light;
    const ty_ordinates_stats* solved = &solve->stats;
    ty_dom_stats* stats = &job->stats;
    const int32_t channel = solve->channel, end = light->shared ? 3 : channel + 1;
    const ty_dom_wall_power* walls = &solve->walls;
    stats->converged = stats->converged && solved->converged && walls->converged;
    stats->sweep_seconds += (solved->sweep_seconds + walls->sweep_seconds) / beside;
    stats->bytes = fmax(stats->bytes, solved->bytes * beside);
    for (int32_t c = channel; c < end; ++c) {
        const double factor = (double)light->color[c];
        stats->sweeps[c] = solved->sweeps + walls->sweeps;
        stats->cycles[c] = solved->cycles;
        stats->change[c] = solved->change;
        stats->emitted[c] = factor * (solved->emitted + walls->emitted);
        stats->absorbed[c] = factor * (solved->absorbed + walls->absorbed);
        stats->absorbed_by_surfaces[c] = factor * (solved->walls_absorbed + walls->by_walls);
        stats->leaving[c] = factor * (solved->leaving + walls->leaving);
    }
}

/* Tells the caller of all channels together. Once one was told to stop, all are. */
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

/* All but the planes. */
static ty_ordinates_def define(const ty_dom_job* job) {
    const ty_dom* light = job->light;
    const ty_dom_def* dom = job->def;
    ty_ordinates_def def = ty_default_ordinates_def();
    memcpy(def.size, light->box.size, sizeof def.size);
    memcpy(def.cell, job->coarse->cell, sizeof def.cell);
    def.set = job->set;
    def.final_set = job->last;
    def.bands = light->bands;
    def.output_order = light->kept;
    def.source_terms = (int32_t)term_count(light->bands);
    def.accelerated = dom->acceleration == TY_DOM_ACCELERATION_DIFFUSION;
    def.tolerance = dom->tolerance;
    def.sweeps = dom->iterations;
    def.walls.count = job->walls != NULL ? job->walls->count : 0;
    def.progress = report;
    return def;
}

static ty_result solve_from(channel_solve* solve, const start_planes* start) {
    const ty_dom_job* job = solve->all->job;
    ty_dom* light = job->light;
    const int32_t channel = solve->channel, plane = light->planes == 3 ? channel : 0;
    const size_t terms = term_count(light->bands), kept = term_count(light->kept);
    const float* source[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX];
    float* moments[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX];
    for (size_t t = 0; t < terms; ++t) source[t] = job->source[channel] + light->cells * t;
    for (size_t t = 0; t < kept; ++t) moments[t] = light->moments[channel] + light->cells * t;
    ty_ordinates_def def = define(job);
    def.extinction = job->coarse->extinction[plane];
    def.scattering = job->coarse->scattering[plane];
    def.g = job->coarse->g[plane];
    def.source = source;
    if (light->fit.bands > 0) def.scattered = light->fit.moments;
    def.face_fluence = light->seen[channel];
    def.start = start->floats != NULL ? start->planes : NULL;
    def.memory = solve->memory;
    def.progress_user = solve;
    float* none = NULL;
    ty_result result = ty_dom_carry_walls(solve->all->job, channel, &def, &solve->walls);
    if (result == TY_OK) result = ty_dom_reflect(solve->all->job, channel, &def, &none);
    if (result == TY_OK) result = ty_ordinates_solve(job->context, &def, moments, NULL, 0, &solve->stats);
    if (none != NULL) ty_free_array(job->context, none, (size_t)job->walls->count, sizeof *none);
    return result;
}

static void solve_channel(void* user, int64_t index, int32_t worker) {
    (void)worker;
    channel_solve* solve = (channel_solve*)user + index;
    const ty_dom_job* job = solve->all->job;
    const ty_dom* light = job->light;
    start_planes start;
    solve->result = take_start(job, light->shared ? brightest(light) : solve->channel, &start);
    if (solve->result != TY_OK) return;
    solve->result = solve_from(solve, &start);
    ty_free_array(job->context, start.floats, start.floats != NULL ? light->cells : 0,
                  term_count(light->bands) * sizeof(float));
}

static bool is_dark(const ty_dom_job* job, int32_t channel) {
    const float* source = job->source[channel];
    for (size_t i = 0; i < job->light->cells; ++i)
        if (source[i] != 0) return false;
    return ty_dom_walls_are_dark(job, channel);
}

/* Whether cells may be diffusion's. */
static bool is_thick(const ty_dom_job* job, int32_t channel) {
    const double* cell = job->coarse->cell;
    const float* extinction = job->coarse->extinction[job->light->planes == 3 ? channel : 0];
    const double longest = fmax(fmax(cell[0], cell[1]), cell[2]);
    for (size_t i = 0; i < job->light->cells; ++i)
        if ((double)extinction[i] * longest > TY_DIFFUSIVE_FREE_PATHS) return true;
    return false;
}

/* Places for the moments of all channels, and the channels there is anything to solve for. */
static ty_result choose_channels(scattering* all) {
    ty_dom_job* job = all->job;
    ty_dom* light = job->light;
    for (int32_t c = 0; c < ty_dom_channels(light); ++c) {
        const bool dark = is_dark(job, c);
        light->moments[c] = ty_alloc_array(job->context, light->cells, term_count(light->kept) * sizeof(float), dark);
        if (light->moments[c] == NULL) return TY_ERROR_MEMORY;
        if (dark) continue;
        if (is_thick(job, c)) light->seen[c] = ty_alloc_array(job->context, 6 * light->cells, sizeof(float), false);
        if (is_thick(job, c) && light->seen[c] == NULL) return TY_ERROR_MEMORY;
        all->solves[all->count++] = (channel_solve){.all = all, .channel = c};
    }
    return TY_OK;
}

static int32_t count_beside(const scattering* all) {
    const int32_t threads = ty_context_threads(all->job->context);
    if (threads > SIDE_BY_SIDE_THREADS || all->job->light->cells > SIDE_BY_SIDE_CELLS) return 1;
    return threads < all->count ? threads : all->count;
}

/* Memory of as many solves as there are at a time, which the next ones have as well: new pages are made by the system,
 * and all of them are blank at first. */
static ty_result take_memory(scattering* all) {
    if (all->count == 0) return TY_OK;
    const ty_ordinates_def def = define(all->job);
    all->beside = count_beside(all);
    all->memory_size = ty_ordinates_memory(&def);
    for (int32_t i = 0; i < all->beside; ++i) {
        all->memory[i] = ty_alloc_array(all->job->context, all->memory_size, 1, false);
        if (all->memory[i] == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

static void free_memory(scattering* all) {
    for (int32_t i = 0; i < all->beside; ++i)
        if (all->memory[i] != NULL) ty_free_array(all->job->context, all->memory[i], all->memory_size, 1);
}

/* The solves from `first` on, as many as there are side by side; a single one has all threads. */
static ty_result solve_some(scattering* all, int32_t first) {
    const int32_t left = all->count - first, count = left < all->beside ? left : all->beside;
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

ty_result ty_dom_scatter(ty_dom_job* job) {
    scattering all = {.job = job};
    ty_result result = check_start(job);
    job->stats.converged = true;
    pthread_mutex_init(&all.lock, NULL);
    if (result == TY_OK) result = choose_channels(&all);
    if (result == TY_OK) result = take_memory(&all);
    for (int32_t i = 0; i < all.count && result == TY_OK; i += all.beside) result = solve_some(&all, i);
    free_memory(&all);
    pthread_mutex_destroy(&all.lock);
    return result;
}
