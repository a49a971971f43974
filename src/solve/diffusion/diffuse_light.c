/* The diffuse light: one solve a channel (Eq. 20), and the field that is made of it. */
#include "solve/diffusion/diffuse_light.h"

#include "base/context.h"
#include "base/kernel.h"
#include "scene/phase.k.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

/* Relative difference of sources up to which one channel is a multiple of another. */
static const float alike = 1e-6f;

/* Light that enters a cell many free paths thick scatters within one of its surface and mostly leaves again, but for
 * the equations it comes from the cell's middle and piles up there: fluence would grow with thickness, without bound.
 * What a thick medium sends back depends on its albedo alone, so cells of more than this many transport mean free paths
 * are made that thin. Their fluence is then that of a surface; what passes through a medium of such cells is too much,
 * of little. It is the faces of the box that hold light back most; within, vacuum next to a thick cell takes it. */
static const double thickest_inside = 2.5, thickest_at_faces = 1.5;

/* Channels are solved side by side, one thread each, by few threads and on boxes of at most so many cells: a loop over
 * planes of small boxes is over before other threads have woken up. */
enum { SIDE_BY_SIDE_THREADS = 4, SIDE_BY_SIDE_CELLS = 1 << 20 };

struct solve_work;

/* One channel's solve. */
typedef struct channel_solve {
    struct solve_work* work;
    int32_t channel;
    void* memory;
    double done; /* of it, 0..1 */
    ty_diffusion_stats stats;
    ty_result result;
} channel_solve;

/* What the solves of all channels share. */
typedef struct solve_work {
    ty_context* context;
    const ty_grid_medium* medium;
    float* const* source; /* W m^-3 */
    bool reduced;
    const ty_diffuse_light* start; /* NULL: none */
    float* extinction[3];          /* sigma_t (1 - albedo g), 1/m */
    float* absorption[3];
    int32_t beside;  /* how many are solved side by side */
    void* memory[3]; /* of as many */
    size_t memory_size;
    ty_diffusion_def def;
    ty_diffuse_light* light;
    ty_diffuse_stats* stats;
    channel_solve solves[3];
    int32_t count;        /* of them */
    pthread_mutex_t lock; /* guards what follows, and how much of each is done */
    ty_part_progress* progress;
    bool cancelled;
} solve_work;

static int32_t count_beside(const solve_work* work) {
    const int32_t threads = ty_context_threads(work->context);
    if (threads > SIDE_BY_SIDE_THREADS || work->medium->cells > SIDE_BY_SIDE_CELLS) return 1;
    return threads < 3 ? threads : 3;
}

static ty_result begin_work(solve_work* work) {
    const ty_grid_medium* medium = work->medium;
    memcpy(work->def.size, medium->box.size, sizeof work->def.size);
    memcpy(work->def.cell, medium->cell, sizeof work->def.cell);
    bool whole = true;
    for (int32_t p = 0; p < medium->planes && whole; ++p) {
        work->extinction[p] = ty_alloc_array(work->context, medium->cells, sizeof(float), false);
        work->absorption[p] = ty_alloc_array(work->context, medium->cells, sizeof(float), false);
        whole = work->extinction[p] != NULL && work->absorption[p] != NULL;
    }
    return whole ? TY_OK : TY_ERROR_MEMORY;
}

/* Memory of as many solves as there are at a time. */
static ty_result take_memory(solve_work* work) {
    work->beside = count_beside(work);
    if (work->beside > work->count) work->beside = work->count;
    work->memory_size = ty_diffusion_memory(&work->def);
    for (int32_t i = 0; i < work->beside; ++i) {
        work->memory[i] = ty_alloc_array(work->context, work->memory_size, 1, false);
        if (work->memory[i] == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

static void end_work(solve_work* work) {
    for (int32_t p = 0; p < work->medium->planes; ++p) {
        ty_free_array(work->context, work->extinction[p], work->medium->cells, sizeof(float));
        ty_free_array(work->context, work->absorption[p], work->medium->cells, sizeof(float));
    }
    for (int i = 0; i < 3; ++i) ty_free_array(work->context, work->memory[i], work->memory_size, 1);
    pthread_mutex_destroy(&work->lock);
}

static bool is_at_face(const ty_grid_box* box, size_t cell) {
    for (int a = 0; a < 3; ++a) {
        const size_t size = (size_t)box->size[a], at = cell % size;
        if (at == 0 || at + 1 == size) return true;
        cell /= size;
    }
    return false;
}

/* Makes a plane of cells at most so thick, with their albedo as it is, and gives channels first..end what they emit. */
static void thin_cells(const solve_work* work, int32_t plane, int32_t first, int32_t end) {
    const ty_grid_medium* medium = work->medium;
    const double side = fmin(medium->cell[0], fmin(medium->cell[1], medium->cell[2]));
    const float most_inside = (float)(thickest_inside / side), most_at_faces = (float)(thickest_at_faces / side);
    for (size_t i = 0; i < medium->cells; ++i) {
        const float most = is_at_face(&medium->box, i) ? most_at_faces : most_inside;
        const float extinction = work->extinction[plane][i], part = extinction > most ? most / extinction : 1.0f;
        work->extinction[plane][i] = extinction * part;
        work->absorption[plane][i] *= part;
        for (int32_t c = first; c < end && medium->emission[c] != NULL; ++c)
            work->source[c][i] += medium->emission[c][i] * part;
    }
}

/* The paper takes media as isotropic. */
static void find_coefficients(const solve_work* work) {
    const ty_grid_medium* medium = work->medium;
    if (work->reduced) ty_grid_medium_reduce(medium, 1, work->extinction);
    for (int32_t p = 0; p < medium->planes; ++p) {
        if (!work->reduced) memcpy(work->extinction[p], medium->extinction[p], medium->cells * sizeof(float));
        for (size_t i = 0; i < medium->cells; ++i)
            work->absorption[p][i] = ty_maxf(0.0f, medium->extinction[p][i] - medium->scattering[p][i]);
        if (medium->planes == 3)
            thin_cells(work, p, p, p + 1);
        else
            thin_cells(work, p, 0, 3);
    }
}

/* Whether a channel's light is `factor` times that of another: its source is, and the media are gray. */
static bool is_multiple(const solve_work* work, int32_t channel, int32_t of, float* factor) {
    const float* a = work->source[channel];
    const float* b = work->source[of];
    double sums[2] = {0, 0};
    if (work->medium->planes == 3) return false;
    for (size_t i = 0; i < work->medium->cells; ++i) {
        sums[0] += (double)a[i];
        sums[1] += (double)b[i];
    }
    if (!(sums[1] > 0)) return false;
    *factor = (float)(sums[0] / sums[1]);
    for (size_t i = 0; i < work->medium->cells; ++i)
        if (fabsf(a[i] - *factor * b[i]) > alike * ty_maxf(a[i], *factor * b[i])) return false;
    return true;
}

static void scale_channel(solve_work* work, int32_t channel, int32_t of, float factor) {
    ty_diffuse_stats* stats = work->stats;
    const ty_diffuse_light* light = work->light;
    for (int t = 0; t < TY_FIELD_TERMS; ++t)
        for (size_t i = 0; i < light->cells; ++i) light->terms[channel][t][i] = factor * light->terms[of][t][i];
    stats->emitted[channel] = (double)factor * stats->emitted[of];
    stats->absorbed[channel] = (double)factor * stats->absorbed[of];
    stats->leaving[channel] = (double)factor * stats->leaving[of];
    stats->residual[channel] = stats->residual[of];
}

/* Limiters bound what flows by what there is (R F <= 1) with the gradient between a cell's neighbours; the mean of what
 * its faces let through can be a little more. */
static void limit_flux(float* const terms[TY_FIELD_TERMS], size_t cells) {
    for (size_t i = 0; i < cells; ++i) {
        const float square = terms[1][i] * terms[1][i] + terms[2][i] * terms[2][i] + terms[3][i] * terms[3][i];
        const float most = 3 * terms[0][i];
        if (square <= most * most) continue;
        const float factor = most / sqrtf(square);
        for (int t = 1; t < TY_FIELD_TERMS; ++t) terms[t][i] *= factor;
    }
}

/* The diffuse radiance (phi + 3 E . way) / (4 pi) (Eq. 9) from fluence and the flux through faces that are where the
 * terms will be: a cell's is the mean of its two faces along each axis. */
static void make_terms(const solve_work* work, int32_t channel) {
    const int32_t* size = work->medium->box.size;
    float* const* terms = work->light->terms[channel];
    const size_t step[3] = {1, (size_t)size[0], (size_t)size[0] * (size_t)size[1]};
    for (size_t i = 0; i < work->light->cells; ++i) terms[0][i] *= TY_INV_4PI;
    for (int a = 0; a < 3; ++a) {
        /* Along its own axis an array of faces is one longer, so that no face is overwritten before it is read. */
        const size_t slab = step[a] * (size_t)size[a];
        for (size_t i = 0; i < work->light->cells; ++i) {
            const size_t face = i + i / slab * step[a];
            terms[1 + a][i] = 1.5f * TY_INV_4PI * (terms[1 + a][face] + terms[1 + a][face + step[a]]);
        }
    }
    limit_flux(terms, work->light->cells);
}

/* Tells the caller of all channels together. Once one was told to stop, all are. */
static bool report(void* user, const ty_progress* part) {
    channel_solve* solve = user;
    solve_work* work = solve->work;
    ty_progress whole = *part;
    pthread_mutex_lock(&work->lock);
    solve->done = part->fraction;
    whole.fraction = 0;
    for (int32_t i = 0; i < work->count; ++i) whole.fraction += work->solves[i].done / work->count;
    work->cancelled = work->cancelled || !ty_part_report(work->progress, &whole);
    const bool goes_on = !work->cancelled;
    pthread_mutex_unlock(&work->lock);
    return goes_on;
}

static void solve_channel(void* user, int64_t index, int32_t worker) {
    (void)worker;
    channel_solve* solve = (channel_solve*)user + index;
    const solve_work* work = solve->work;
    const int32_t plane = work->medium->planes == 3 ? solve->channel : 0;
    ty_diffusion_def def = work->def;
    def.extinction = work->extinction[plane];
    def.absorption = work->absorption[plane];
    def.source = work->source[solve->channel];
    def.memory = solve->memory;
    def.progress = report;
    def.progress_user = solve;
    float* const* terms = work->light->terms[solve->channel];
    if (work->start != NULL) {
        /* Where the fluence will be: it is read before it is written. */
        ty_diffuse_light_prolong(work->start, solve->channel, work->medium->box.size, terms[0]);
        def.start = terms[0];
    }
    const ty_diffusion_out out = {.fluence = terms[0], .flux = {terms[1], terms[2], terms[3]}};
    solve->result = ty_diffusion_solve(work->context, &def, &out, &solve->stats);
    if (solve->result == TY_OK) make_terms(work, solve->channel);
}

static void note_solve(ty_diffuse_stats* stats, const channel_solve* solve) {
    const ty_diffusion_stats* solved = &solve->stats;
    const int32_t channel = solve->channel;
    stats->converged = stats->converged && solved->converged;
    stats->iterations[channel] = solved->iterations;
    stats->cycles[channel] = solved->cycles;
    stats->residual[channel] = solved->residual;
    stats->work[channel] = solved->work;
    stats->emitted[channel] = solved->emitted;
    stats->absorbed[channel] = solved->absorbed;
    stats->leaving[channel] = solved->leaving;
}

/* The solves from `first` on, as many as there are side by side; a single one has all threads. */
static ty_result solve_some(solve_work* work, int32_t first) {
    const int32_t left = work->count - first, count = left < work->beside ? left : work->beside;
    ty_result result = ty_part_show(work->progress, "fluence");
    if (result != TY_OK) return result;
    for (int32_t i = 0; i < count; ++i) work->solves[first + i].memory = work->memory[i];
    ty_parallel_for(work->context, count, solve_channel, &work->solves[first]);
    for (int32_t i = first; i < first + count; ++i) {
        work->solves[i].done = 1;
        if (result == TY_OK) result = work->solves[i].result;
        if (result == TY_OK) note_solve(work->stats, &work->solves[i]);
    }
    return result;
}

/* Finds which channels have to be solved: of[c] is c itself, or a channel whose light channel c's is a multiple of. */
static void choose_channels(solve_work* work, int32_t of[3]) {
    work->light->shared = true;
    for (int32_t c = 0; c < 3; ++c) {
        float factor = 1;
        of[c] = 0;
        while (of[c] < c && !is_multiple(work, c, of[c], &factor)) ++of[c];
        work->light->color[c] = of[c] < c ? factor : 1;
        if (of[c] > 0) work->light->shared = false;
        if (of[c] == c) work->solves[work->count++] = (channel_solve){.work = work, .channel = c};
    }
}

static ty_result solve_channels(solve_work* work) {
    int32_t of[3];
    work->stats->converged = true;
    choose_channels(work, of);
    ty_result result = take_memory(work);
    for (int32_t i = 0; i < work->count && result == TY_OK; i += work->beside) result = solve_some(work, i);
    for (int32_t c = 0; c < 3 && result == TY_OK; ++c)
        if (of[c] < c) scale_channel(work, c, of[c], work->light->color[c]);
    return result;
}

static bool scatters_evenly(const ty_grid_medium* medium) {
    for (int32_t p = 0; p < medium->planes; ++p)
        for (size_t i = 0; i < medium->cells; ++i)
            if (medium->g[p][i] != 0) return false;
    return true;
}

/* Floats of a term's array: room for the faces along its axis, where its flux comes from. */
static size_t term_size(const ty_diffuse_light* light, int term) {
    if (term == 0 || light->cells == 0) return light->cells;
    return light->cells + light->cells / (size_t)light->box.size[term - 1];
}

static ty_result take_light(ty_context* context, const ty_grid_medium* medium, ty_diffuse_light** out) {
    ty_diffuse_light* light = ty_alloc_array(context, 1, sizeof *light, true);
    *out = light;
    if (light == NULL) return TY_ERROR_MEMORY;
    light->context = context;
    light->box = medium->box;
    light->cells = medium->cells;
    light->even = scatters_evenly(medium);
    for (int c = 0; c < 3; ++c) {
        for (int t = 0; t < TY_FIELD_TERMS; ++t) {
            light->terms[c][t] = ty_alloc_array(context, term_size(light, t), sizeof(float), true);
            if (light->terms[c][t] == NULL) return TY_ERROR_MEMORY;
        }
    }
    return TY_OK;
}

void ty_diffuse_light_destroy(ty_diffuse_light* light) {
    if (light == NULL) return;
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < TY_FIELD_TERMS; ++t)
            ty_free_array(light->context, light->terms[c][t], term_size(light, t), sizeof(float));
    ty_free_array(light->context, light, 1, sizeof *light);
}

ty_result ty_diffuse_light_solve(const ty_diffusion_def* solver, bool reduced, const ty_grid_medium* medium,
                                 float* const source[3], ty_part_progress* progress, ty_diffuse_light** out,
                                 ty_diffuse_stats* stats) {
    return ty_diffuse_light_refine(NULL, solver, reduced, medium, source, progress, out, stats);
}

ty_result ty_diffuse_light_refine(const ty_diffuse_light* start, const ty_diffusion_def* solver, bool reduced,
                                  const ty_grid_medium* medium, float* const source[3], ty_part_progress* progress,
                                  ty_diffuse_light** out, ty_diffuse_stats* stats) {
    solve_work work = {.context = medium->context,
                       .medium = medium,
                       .source = source,
                       .reduced = reduced,
                       .start = start,
                       .def = *solver,
                       .progress = progress,
                       .stats = stats};
    pthread_mutex_init(&work.lock, NULL);
    ty_result result = take_light(medium->context, medium, &work.light);
    if (result == TY_OK) result = begin_work(&work);
    if (result == TY_OK) {
        find_coefficients(&work);
        result = solve_channels(&work);
    }
    stats->bytes = (double)work.memory_size * work.beside;
    end_work(&work);
    *out = result == TY_OK ? work.light : NULL;
    if (result != TY_OK) ty_diffuse_light_destroy(work.light);
    return result;
}

ty_source_field ty_diffuse_light_field(const ty_diffuse_light* light, bool directed) {
    ty_source_field field = {
        .box = light->box, .term_count = directed || !light->even ? TY_FIELD_TERMS : 1, .shared = light->shared};
    for (int c = 0; c < 3; ++c) {
        field.color[c] = light->color[c];
        for (int t = 0; t < TY_FIELD_TERMS; ++t) field.terms[c][t] = light->terms[c][t];
    }
    return field;
}
