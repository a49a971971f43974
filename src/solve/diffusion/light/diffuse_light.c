/* Diffuse light: one solve per channel by Eq. 20 (Koerner 2014), and the field made from it. */
#include "solve/diffusion/light/diffuse_light.h"

#include "base/context.h"
#include "base/kernel.h"
#include "scene/media/phase.k.h"
#include "solve/diffusion/divided/joint.h"
#include "solve/diffusion/light/surface_light.h"
#include "solve/diffusion/light/thickness.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

/* Relative difference of sources up to which one channel counts as a multiple of another. */
static const float MAX_DIFFERENCE = 1e-6f;

/* Residual, relative to the source, above which a solve with limited flux counts as divergent: D and the fluence then
 * grow in turn. Diffusion without a limiter is linear and converges; it takes its place. */
static const double max_residual = 1;

/* Channels are solved concurrently, one thread each, with few threads and on boxes of limited size: a loop over planes
 * of a small box ends before other threads have woken up. */
enum { CONCURRENT_THREADS = 4, CONCURRENT_CELLS = 1 << 20 };

struct solve_work;

/* Solve of one channel. */
typedef struct channel_solve {
    struct solve_work* work;
    int32_t channel;
    void* memory;
    double done; /* fraction, 0..1 */
    ty_diffusion_stats stats;
    ty_result result;
} channel_solve;

/* Data shared by the solves of all channels. */
typedef struct solve_work {
    ty_context* context;
    const ty_grid_medium* medium;
    float* const* source; /* W m^-3 */
    bool reduced;
    const ty_diffuse_light* start;    /* NULL: no initial guess */
    ty_diffuse_surfaces* surfaces;    /* NULL: none */
    const ty_incident_flux* incident; /* NULL: none */
    float* unscattered[3];            /* with them, where light scatters forwards: sigma_t */
    float* extinction[3];             /* sigma_t (1 - albedo g), 1/m */
    float* absorption[3];
    bool joint;         /* all ranks make each solve together */
    int32_t concurrent; /* number of concurrent solves */
    void* memory[3];    /* one per concurrent solve */
    size_t memory_size;
    ty_diffusion_def def;
    ty_diffuse_light* light;
    ty_diffuse_stats* stats;
    channel_solve solves[3];
    int32_t count;        /* number of solves */
    pthread_mutex_t lock; /* guards the following fields and the solves' done */
    ty_part_progress* progress;
    bool cancelled;
} solve_work;

static int32_t count_concurrent(const solve_work* work) {
    const int32_t threads = ty_context_threads(work->context);
    if (work->joint) return 1;
    if (threads > CONCURRENT_THREADS || work->medium->cells > CONCURRENT_CELLS) return 1;
    return threads < 3 ? threads : 3;
}

static ty_result begin_work(solve_work* work) {
    const ty_grid_medium* medium = work->medium;
    memcpy(work->def.size, medium->box.size, sizeof work->def.size);
    memcpy(work->def.cell, medium->cell, sizeof work->def.cell);
    bool complete = true;
    for (int32_t p = 0; p < medium->planes && complete; ++p) {
        work->extinction[p] = ty_alloc_array(work->context, medium->cells, sizeof(float), false);
        work->absorption[p] = ty_alloc_array(work->context, medium->cells, sizeof(float), false);
        complete = work->extinction[p] != NULL && work->absorption[p] != NULL;
        if (work->surfaces == NULL || !work->reduced || work->light->isotropic) continue;
        work->unscattered[p] = ty_alloc_array(work->context, medium->cells, sizeof(float), false);
        complete = complete && work->unscattered[p] != NULL;
    }
    return complete ? TY_OK : TY_ERROR_MEMORY;
}

/* Allocates the solver memory of all concurrent solves. */
static ty_result allocate_memory(solve_work* work) {
    ty_diffusion_def def = work->def;
    const ty_diffusion_faces faces = {.count = 0};
    const char* reason = NULL;
    if (work->surfaces != NULL) def.faces = &faces;
    work->joint = ty_diffusion_is_joint(work->context, &def, &reason);
    if (reason != NULL)
        ty_log(work->context, TY_LOG_WARNING, "rank 0 solves for diffusion on %d x %d x %d cells alone: %s",
               (int)def.size[0], (int)def.size[1], (int)def.size[2], reason);
    work->concurrent = count_concurrent(work);
    if (work->concurrent > work->count) work->concurrent = work->count;
    if (work->joint) return TY_OK; /* each rank has that of its box */
    work->memory_size = ty_diffusion_memory(&def);
    for (int32_t i = 0; i < work->concurrent; ++i) {
        work->memory[i] = ty_alloc_array(work->context, work->memory_size, 1, false);
        if (work->memory[i] == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

static void end_work(solve_work* work) {
    for (int32_t p = 0; p < work->medium->planes; ++p) {
        ty_free_array(work->context, work->extinction[p], work->medium->cells, sizeof(float));
        ty_free_array(work->context, work->absorption[p], work->medium->cells, sizeof(float));
        ty_free_array(work->context, work->unscattered[p], work->medium->cells, sizeof(float));
    }
    for (int i = 0; i < 3; ++i) ty_free_array(work->context, work->memory[i], work->memory_size, 1);
    pthread_mutex_destroy(&work->lock);
}

/* Limits the thickness of cells of a media plane at constant albedo, and adds their emission to the sources of channels
 * [first, end). */
static void limit_thickness(const solve_work* work, int32_t plane, int32_t first, int32_t end) {
    const ty_grid_medium* medium = work->medium;
    const ty_max_extinction max = ty_max_extinction_of(medium, work->surfaces);
    for (size_t i = 0; i < medium->cells; ++i) {
        const float max_extinction = ty_max_extinction_at(&max, i), extinction = work->extinction[plane][i],
                    scale = extinction > max_extinction ? max_extinction / extinction : 1.0f;
        work->extinction[plane][i] = extinction * scale;
        work->absorption[plane][i] *= scale;
        if (work->unscattered[plane] != NULL) work->unscattered[plane][i] = medium->extinction[plane][i] * scale;
        for (int32_t c = first; c < end && medium->emission[c] != NULL; ++c)
            work->source[c][i] += medium->emission[c][i] * scale;
    }
}

/* The paper assumes isotropic media. */
static void compute_coefficients(const solve_work* work) {
    const ty_grid_medium* medium = work->medium;
    if (work->reduced) ty_grid_medium_reduce(medium, 1, work->extinction);
    for (int32_t p = 0; p < medium->planes; ++p) {
        if (!work->reduced) memcpy(work->extinction[p], medium->extinction[p], medium->cells * sizeof(float));
        for (size_t i = 0; i < medium->cells; ++i)
            work->absorption[p][i] = ty_maxf(0.0f, medium->extinction[p][i] - medium->scattering[p][i]);
        if (medium->planes == 3)
            limit_thickness(work, p, p, p + 1);
        else
            limit_thickness(work, p, 0, 3);
    }
}

/* True if the light that enters is so, too. */
static bool incident_is_multiple(const solve_work* work, int32_t channel, int32_t of, float factor) {
    const int32_t* size = work->medium->box.size;
    for (int side = 0; side < 6 && work->incident != NULL; ++side) {
        const float *a = work->incident->sides[side][channel], *b = work->incident->sides[side][of];
        const size_t count = work->medium->cells / (size_t)size[side / 2];
        for (size_t i = 0; i < count; ++i)
            if (fabsf(a[i] - factor * b[i]) > MAX_DIFFERENCE * ty_maxf(a[i], factor * b[i])) return false;
    }
    return true;
}

/* Sum of the light that enters in a channel. */
static double sum_incident(const solve_work* work, int32_t channel) {
    const int32_t* size = work->medium->box.size;
    double sum = 0;
    for (int side = 0; side < 6 && work->incident != NULL; ++side)
        for (size_t i = 0; i < work->medium->cells / (size_t)size[side / 2]; ++i)
            sum += (double)work->incident->sides[side][channel][i];
    return sum;
}

/* True if a channel's light is `factor` times that of another: proportional sources in gray media. */
static bool is_multiple(const solve_work* work, int32_t channel, int32_t of, float* factor) {
    const float* a = work->source[channel];
    const float* b = work->source[of];
    double sums[2] = {0, 0};
    if (work->medium->planes == 3) return false;
    for (size_t i = 0; i < work->medium->cells; ++i) {
        sums[0] += (double)a[i];
        sums[1] += (double)b[i];
    }
    if (!(sums[1] > 0)) {
        sums[0] = sum_incident(work, channel);
        sums[1] = sum_incident(work, of);
    }
    if (!(sums[1] > 0)) return false;
    *factor = (float)(sums[0] / sums[1]);
    for (size_t i = 0; i < work->medium->cells; ++i)
        if (fabsf(a[i] - *factor * b[i]) > MAX_DIFFERENCE * ty_maxf(a[i], *factor * b[i])) return false;
    if (!incident_is_multiple(work, channel, of, *factor)) return false;
    return work->surfaces == NULL || ty_diffuse_surfaces_are_multiple(work->surfaces, channel, of, *factor);
}

static void scale_channel(solve_work* work, int32_t channel, int32_t of, float factor) {
    ty_diffuse_stats* stats = work->stats;
    const ty_diffuse_light* light = work->light;
    for (int t = 0; t < TY_FIELD_TERMS; ++t)
        for (size_t i = 0; i < light->cells; ++i) {
            light->terms[channel][t][i] = factor * light->terms[of][t][i];
            if (light->surface_terms[of][t] != NULL)
                light->surface_terms[channel][t][i] = factor * light->surface_terms[of][t][i];
        }
    stats->emitted[channel] = (double)factor * stats->emitted[of];
    stats->absorbed[channel] = (double)factor * stats->absorbed[of];
    stats->leaving[channel] = (double)factor * stats->leaving[of];
    stats->surfaces_absorbed[channel] = (double)factor * stats->surfaces_absorbed[of];
    stats->residual[channel] = stats->residual[of];
}

/* Limiters bound the flux by the fluence (R F <= 1) with the gradient between a cell's neighbours; the mean of its face
 * fluxes can be slightly larger. */
static void limit_flux(float* const terms[TY_FIELD_TERMS], size_t cells) {
    for (size_t i = 0; i < cells; ++i) {
        const float square = terms[1][i] * terms[1][i] + terms[2][i] * terms[2][i] + terms[3][i] * terms[3][i];
        const float max_flux = 3 * terms[0][i];
        if (square <= max_flux * max_flux) continue;
        const float factor = max_flux / sqrtf(square);
        for (int t = 1; t < TY_FIELD_TERMS; ++t) terms[t][i] *= factor;
    }
}

/* Adds the flux of closed faces, which are none of the face fluxes. */
static void add_side_flux(const int32_t size[3], float* const terms[TY_FIELD_TERMS], const ty_boundary_faces* faces,
                          const float* side_flux) {
    const int64_t rows = (int64_t)size[1] * size[2];
    for (int64_t row = 0; row < rows; ++row)
        for (int32_t side = faces->first[row]; side < faces->first[row + 1]; ++side) {
            const float outwards = (faces->face[side] & 1) != 0 ? 1.5f * TY_INV_4PI : -1.5f * TY_INV_4PI;
            terms[1 + faces->face[side] / 2][row * size[0] + faces->x[side]] += outwards * side_flux[side];
        }
}

/* Eq. 7 (Koerner 2014). */
void ty_diffuse_terms_make(const int32_t size[3], float* const terms[TY_FIELD_TERMS], const ty_boundary_faces* faces,
                           const float* side_flux) {
    const size_t step[3] = {1, (size_t)size[0], (size_t)size[0] * (size_t)size[1]};
    const size_t cells = step[2] * (size_t)size[2];
    for (size_t i = 0; i < cells; ++i) terms[0][i] *= TY_INV_4PI;
    for (int a = 0; a < 3; ++a) {
        /* A face array is one longer along its own axis, so that no face is overwritten before it is read. */
        const size_t slab = step[a] * (size_t)size[a];
        for (size_t i = 0; i < cells; ++i) {
            const size_t face = i + i / slab * step[a];
            terms[1 + a][i] = 1.5f * TY_INV_4PI * (terms[1 + a][face] + terms[1 + a][face + step[a]]);
        }
    }
    if (faces != NULL) add_side_flux(size, terms, faces, side_flux);
    limit_flux(terms, cells);
}

/* Reports the progress of all channels together; one cancellation cancels all channels. */
static bool report(void* user, const ty_progress* channel_progress) {
    channel_solve* solve = user;
    solve_work* work = solve->work;
    ty_progress total = *channel_progress;
    pthread_mutex_lock(&work->lock);
    solve->done = channel_progress->fraction;
    total.fraction = 0;
    for (int32_t i = 0; i < work->count; ++i) total.fraction += work->solves[i].done / work->count;
    work->cancelled = work->cancelled || !ty_part_report(work->progress, &total);
    const bool continues = !work->cancelled;
    pthread_mutex_unlock(&work->lock);
    return continues;
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
    for (int side = 0; side < 6 && work->incident != NULL; ++side)
        if (def.boundary[side].kind == TY_BOUNDARY_MARSHAK)
            def.boundary[side].value = work->incident->sides[side][solve->channel];
    if (work->start != NULL) {
        /* The output array holds the initial guess, which is read before it is overwritten. */
        ty_diffuse_light_prolong(work->start, solve->channel, work->medium->box.size, terms[0]);
        def.start = terms[0];
    }
    if (work->surfaces != NULL) {
        solve->result = ty_surface_light_solve(&def, work->unscattered[plane], work->surfaces, work->incident,
                                               solve->channel, work->light, &solve->stats);
        return;
    }
    const ty_diffusion_out out = {.fluence = terms[0], .flux = {terms[1], terms[2], terms[3]}};
    solve->result = ty_diffusion_solve_jointly(work->context, &def, &out, &solve->stats);
    if (solve->result == TY_OK && !(solve->stats.residual <= max_residual)) {
        def.limiter = TY_LIMITER_NONE;
        def.start = NULL;
        solve->result = ty_diffusion_solve_jointly(work->context, &def, &out, &solve->stats);
    }
    if (solve->result == TY_OK) ty_diffuse_terms_make(work->medium->box.size, terms, NULL, NULL);
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
    stats->surfaces_absorbed[channel] = solved->surfaces_absorbed;
    stats->ranks = solved->ranks;
    stats->bytes = solved->bytes;
}

/* Solves the channels from `first` concurrently; a single solve uses all threads. */
static ty_result solve_batch(solve_work* work, int32_t first) {
    const int32_t remaining = work->count - first, count = remaining < work->concurrent ? remaining : work->concurrent;
    ty_result result = ty_part_show(work->progress, "fluence", 0);
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

/* Selects the channels to solve: of[c] is c itself, or a channel whose light channel c's is a multiple of. */
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
    ty_result result = allocate_memory(work);
    for (int32_t i = 0; i < work->count && result == TY_OK; i += work->concurrent) result = solve_batch(work, i);
    for (int32_t c = 0; c < 3 && result == TY_OK; ++c)
        if (of[c] < c) scale_channel(work, c, of[c], work->light->color[c]);
    return result;
}

static bool is_isotropic(const ty_grid_medium* medium) {
    for (int32_t p = 0; p < medium->planes; ++p)
        for (size_t i = 0; i < medium->cells; ++i)
            if (medium->g[p][i] != 0) return false;
    return true;
}

/* Array length of a term, with space for the faces along its axis, from which it is computed. */
static size_t term_size(const ty_diffuse_light* light, int term) {
    if (term == 0 || light->cells == 0) return light->cells;
    return light->cells + light->cells / (size_t)light->box.size[term - 1];
}

static ty_result create_light(ty_context* context, const ty_grid_medium* medium, bool surfaces,
                              ty_diffuse_light** out) {
    ty_diffuse_light* light = ty_alloc_array(context, 1, sizeof *light, true);
    *out = light;
    if (light == NULL) return TY_ERROR_MEMORY;
    light->context = context;
    light->box = medium->box;
    light->cells = medium->cells;
    light->isotropic = is_isotropic(medium);
    for (int c = 0; c < 3; ++c) {
        for (int t = 0; t < TY_FIELD_TERMS; ++t) {
            light->terms[c][t] = ty_alloc_array(context, term_size(light, t), sizeof(float), true);
            if (light->terms[c][t] == NULL) return TY_ERROR_MEMORY;
            if (!surfaces) continue;
            light->surface_terms[c][t] = ty_alloc_array(context, light->cells, sizeof(float), true);
            if (light->surface_terms[c][t] == NULL) return TY_ERROR_MEMORY;
        }
    }
    return TY_OK;
}

void ty_diffuse_light_destroy(ty_diffuse_light* light) {
    if (light == NULL) return;
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < TY_FIELD_TERMS; ++t) {
            ty_free_array(light->context, light->terms[c][t], term_size(light, t), sizeof(float));
            ty_free_array(light->context, light->surface_terms[c][t], light->cells, sizeof(float));
        }
    ty_boundary_faces_destroy(light->faces);
    ty_free_array(light->context, light, 1, sizeof *light);
}

/* Runs a request, of which the results are not yet set. */
static ty_result run(solve_work* work, ty_diffuse_light** out) {
    pthread_mutex_init(&work->lock, NULL);
    ty_result result = create_light(work->context, work->medium, work->surfaces != NULL, &work->light);
    if (result == TY_OK) result = begin_work(work);
    if (result == TY_OK) {
        compute_coefficients(work);
        result = solve_channels(work);
    }
    if (!work->joint) work->stats->bytes = (double)work->memory_size * work->concurrent;
    end_work(work);
    *out = result == TY_OK ? work->light : NULL;
    if (result != TY_OK) ty_diffuse_light_destroy(work->light);
    return result;
}

ty_result ty_diffuse_light_solve_between(const ty_diffusion_def* solver, bool reduced, const ty_grid_medium* medium,
                                         ty_diffuse_surfaces* surfaces, float* const source[3],
                                         const ty_incident_flux* incident, ty_part_progress* progress,
                                         ty_diffuse_light** out, ty_diffuse_stats* stats) {
    solve_work work = {.context = medium->context,
                       .medium = medium,
                       .source = source,
                       .reduced = reduced,
                       .surfaces = surfaces->faces != NULL ? surfaces : NULL,
                       .incident = incident,
                       .def = *solver,
                       .progress = progress,
                       .stats = stats};
    if (work.surfaces != NULL) work.def.solver = TY_DIFFUSION_MULTIGRID;
    const ty_result result = run(&work, out);
    if (result != TY_OK) return result;
    (*out)->faces = surfaces->faces;
    surfaces->faces = NULL;
    return TY_OK;
}

ty_result ty_diffuse_light_refine(const ty_diffuse_light* start, const ty_diffusion_def* solver, bool reduced,
                                  const ty_grid_medium* medium, float* const source[3],
                                  const ty_incident_flux* incident, ty_part_progress* progress, ty_diffuse_light** out,
                                  ty_diffuse_stats* stats) {
    solve_work work = {.context = medium->context,
                       .medium = medium,
                       .source = source,
                       .reduced = reduced,
                       .start = start,
                       .incident = incident,
                       .def = *solver,
                       .progress = progress,
                       .stats = stats};
    return run(&work, out);
}

void ty_diffuse_light_add(ty_diffuse_light* light, const ty_diffuse_light* other, float factor) {
    light->shared = light->shared && other->shared;
    for (int c = 0; c < 3; ++c)
        light->shared = light->shared && fabsf(light->color[c] - other->color[c]) <= MAX_DIFFERENCE * light->color[c];
    for (int c = 0; c < 3; ++c) {
        if (!light->shared) light->color[c] = 1;
        for (int t = 0; t < TY_FIELD_TERMS; ++t)
            for (size_t i = 0; i < light->cells; ++i) {
                light->terms[c][t][i] += factor * other->terms[c][t][i];
                if (light->surface_terms[c][t] != NULL)
                    light->surface_terms[c][t][i] += factor * other->surface_terms[c][t][i];
            }
    }
}

ty_source_field ty_diffuse_light_field(const ty_diffuse_light* light, bool directed) {
    ty_source_field field = {
        .box = light->box, .term_count = directed || !light->isotropic ? TY_FIELD_TERMS : 1, .shared = light->shared};
    for (int c = 0; c < 3; ++c) {
        field.color[c] = light->color[c];
        for (int t = 0; t < TY_FIELD_TERMS; ++t) field.terms[c][t] = light->terms[c][t];
    }
    return field;
}

ty_source_field ty_diffuse_light_surface_field(const ty_diffuse_light* light) {
    ty_source_field field = {.box = light->box, .term_count = TY_FIELD_TERMS, .shared = light->shared};
    for (int c = 0; c < 3; ++c) {
        field.color[c] = light->color[c];
        for (int t = 0; t < TY_FIELD_TERMS; ++t) field.terms[c][t] = light->surface_terms[c][t];
    }
    return field;
}
