/* Light of all ordinates of a scene, each on its own grid, summed on merged cells. */
#include "base/context.h"
#include "base/parallel.h"
#include "direct/uncollided/first_collision_source.h"
#include "method/pop/job.h"
#include "method/pop/published/propagate.h"
#include "method/pop/published/residuum.h"

#include <string.h>

/* Grids in memory at a time: a few per thread, so that they are still in the caches when they are merged, limited to
 * this many floats in total, with a minimum of BATCH_MIN grids. */
static const size_t batch_floats = (size_t)1 << 26;
enum { BATCH_EACH = 4, BATCH_MIN = 8, BATCH_MAX = 256, ALONG = 2 };

/* Iteration limit of the isotropic residuum, and the fraction of its initial light at which it stops. */
static const int32_t max_residuum_iterations = 1000;
static const double residuum_tolerance = 1e-3;

/* ---- ordinates ---- */

static bool has_environment(const ty_scene* scene) {
    const ty_light_set* lights = &ty_scene_get_view(scene)->lights;
    for (int32_t i = 0; i < lights->count; ++i)
        if (lights->lights[i].kind == TY_KIND_ENVIRONMENT) return true;
    return false;
}

/* Sweeps do not need cubic cells: thinner ones resolve the attenuation. */
static void refine_along(ty_pop_grid* grid) {
    grid->size[2] *= ALONG;
    grid->step.z /= ALONG;
    grid->growth /= ALONG;
}

/* Removes virtual point lights on surfaces that close faces of merged cells: diffusion has their light. */
static void remove_enclosed(const ty_pop_job* job, ty_discrete_light_set* vpls) {
    int32_t count = 0;
    if (job->surfaces.faces == NULL) return;
    for (int32_t i = 0; i < vpls->count; ++i)
        if (!ty_boundary_contains(job->medium, vpls->items[i].position)) vpls->items[count++] = vpls->items[i];
    vpls->count = count;
}

/* Joins all ordinates in one array, virtual point lights last. */
static ty_result join_ordinates(ty_pop_job* job, const ty_discrete_light_set* ordinates,
                                const ty_discrete_light_set* vpls) {
    ty_pop* light = job->light;
    const int32_t count = ordinates->count + vpls->count;
    if (count == 0) return TY_OK;
    light->ordinates = ty_alloc_array(job->context, (size_t)count, sizeof *light->ordinates, true);
    if (light->ordinates == NULL) return TY_ERROR_MEMORY;
    light->count = count;
    for (int32_t i = 0; i < count; ++i) {
        ty_pop_light* field = &light->ordinates[i];
        field->ordinate = i < ordinates->count ? ordinates->items[i] : vpls->items[i - ordinates->count];
        ty_pop_grid_fit(&light->medium->box, &field->ordinate, light->def.resolution, &field->grid);
        if (job->def->mode == TY_POP_MODE_SPLIT) refine_along(&field->grid);
    }
    job->stats.ordinates = count;
    job->stats.vpls = vpls->count;
    memcpy(job->stats.size, light->ordinates[0].grid.size, sizeof job->stats.size);
    return TY_OK;
}

static ty_result find_ordinates(ty_pop_job* job) {
    ty_discrete_light_set ordinates = {.items = NULL}, vpls = {.items = NULL};
    double begun = ty_wall_seconds();
    const bool matters = job->def->importance && has_environment(job->scene);
    const ty_vpl_def vpl_def = ty_pop_vpl_def(job->def);
    ty_result result = ty_part_show(&job->progress, "importance", 0);
    if (result == TY_OK && matters)
        result = ty_pop_importance_find(job->scene, job->def, job->light->medium, job->importance);
    job->stats.importance_seconds = ty_wall_seconds() - begun;
    begun = ty_wall_seconds();
    if (result == TY_OK)
        result = ty_pop_ordinates_create(job->scene, job->def, &job->medium->box, matters ? job->importance : NULL,
                                         &ordinates);
    job->stats.ordinate_seconds = ty_wall_seconds() - begun;
    begun = ty_wall_seconds();
    if (result == TY_OK && job->def->vpls > 0 && ty_scene_get_view(job->scene)->mesh != NULL)
        result = ty_vpls_create(job->scene, &vpl_def, job->light->medium, &vpls);
    if (result == TY_OK) remove_enclosed(job, &vpls);
    job->stats.vpl_seconds = ty_wall_seconds() - begun;
    if (result == TY_OK) result = join_ordinates(job, &ordinates, &vpls);
    ty_discrete_light_set_destroy(job->context, &ordinates);
    ty_discrete_light_set_destroy(job->context, &vpls);
    return result;
}

/* ---- light on the ordinates' grids ---- */

/* Grids in memory at a time. */
typedef struct batch {
    ty_pop_job* job;
    ty_pop_light* lights;
    int32_t capacity, count, iterations, floats;
    size_t accumulated_floats; /* of the largest grid */
    size_t scratch_floats;     /* of the largest grid, for one thread */
    ty_pop_merged* residuum;   /* receives light not yet propagated; NULL: discarded */
    float *accumulated, *scratch;
    ty_pop_propagation_stats propagations[BATCH_MAX];
} batch;

static size_t larger(size_t a, size_t b) {
    return a > b ? a : b;
}

static int32_t min_int(int32_t a, int32_t b) {
    return a < b ? a : b;
}

static ty_result begin_batch(batch* b) {
    const ty_pop* light = b->job->light;
    const ty_pop_def* def = &light->def;
    for (int32_t i = 0; i < light->count; ++i) {
        const ty_pop_grid* grid = &light->ordinates[i].grid;
        b->accumulated_floats = larger(b->accumulated_floats, ty_pop_accumulated_floats(grid, b->floats));
        b->scratch_floats = larger(b->scratch_floats, ty_pop_scratch_floats(grid, def, light->medium->planes));
    }
    const size_t fit = larger(BATCH_MIN, batch_floats / b->accumulated_floats);
    const int32_t max_count = fit < BATCH_MAX ? (int32_t)fit : BATCH_MAX;
    const int32_t preferred = min_int(light->count, BATCH_EACH * ty_context_threads(light->context));
    b->capacity = min_int(preferred, max_count);
    b->accumulated = ty_alloc_array(light->context, b->accumulated_floats * (size_t)b->capacity, sizeof(float), false);
    b->scratch = ty_alloc_array(light->context, b->scratch_floats * (size_t)ty_context_threads(light->context),
                                sizeof(float), false);
    return b->accumulated != NULL && b->scratch != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static void end_batch(batch* b) {
    const ty_pop* light = b->job->light;
    ty_free_array(light->context, b->accumulated, b->accumulated_floats * (size_t)b->capacity, sizeof(float));
    ty_free_array(light->context, b->scratch, b->scratch_floats * (size_t)ty_context_threads(light->context),
                  sizeof(float));
}

static void light_one(void* user, int64_t index, int32_t worker) {
    batch* b = user;
    const ty_pop* light = b->job->light;
    ty_pop_light* field = &b->lights[index];
    field->floats = b->floats;
    field->accumulated = b->accumulated + b->accumulated_floats * (size_t)index;
    if (light->def.mode == TY_POP_MODE_SPLIT)
        ty_pop_sweep(b->job->scene, light->medium, light->eye, field);
    else
        ty_pop_propagate(b->job->scene, &light->def, light->medium, light->eye, b->iterations,
                         b->scratch + b->scratch_floats * (size_t)worker, field, &b->propagations[index]);
}

static ty_result allocate_lobes(ty_pop* light, int32_t iterations) {
    for (int32_t i = 0; i < light->count; ++i) {
        ty_pop_light* field = &light->ordinates[i];
        const size_t floats = ty_pop_lobe_floats(&field->grid, &light->def, light->medium->planes, iterations);
        field->lobes = ty_alloc_array(light->context, floats, sizeof(float), true);
        field->lobe_floats = floats;
        if (field->lobes == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

/* Calls `run` for each ordinate of a batch and merges the batch. */
static ty_result run_batches(batch* b, ty_parallel_fn run) {
    ty_pop_job* job = b->job;
    ty_pop* light = job->light;
    ty_pop_stats* stats = &job->stats;
    for (int32_t first = 0; first < light->count; first += b->capacity) {
        const double begun = ty_wall_seconds();
        double initial = 0, propagation = 0;
        b->lights = light->ordinates + first;
        b->count = light->count - first < b->capacity ? light->count - first : b->capacity;
        memset(b->propagations, 0, sizeof b->propagations);
        ty_parallel_flushed(job->context, b->count, run, b);
        const double done = ty_wall_seconds();
        ty_pop_merge(job->context, b->lights, b->count, &light->merged);
        if (b->residuum != NULL) ty_pop_residuum_deposit(job->context, b->lights, b->count, b->residuum);
        stats->merge_seconds += ty_wall_seconds() - done;
        for (int32_t i = 0; i < b->count; ++i) {
            initial += b->propagations[i].initial_seconds;
            propagation += b->propagations[i].propagation_seconds;
            stats->left += b->propagations[i].unpropagated;
            job->initial_light += b->propagations[i].initial;
        }
        /* Wall time is divided in the ratio of the threads' summed times. */
        const double fraction = initial + propagation > 0 ? propagation / (initial + propagation) : 0;
        stats->propagation_seconds += fraction * (done - begun);
        stats->initial_seconds += (1 - fraction) * (done - begun);
        const ty_progress part = {.stage = "ordinates", .fraction = (double)(first + b->count) / light->count};
        if (!ty_part_report(&job->progress, &part)) return TY_CANCELLED;
    }
    return TY_OK;
}

/* ---- split mode: power balance ---- */

/* Bounds of the scale of merged fluence. Merging blurs light across shadow edges; the scale restores the power that
 * was scattered out of the lobes on the ordinates' own grids. */
static const float min_scale = 0.25f, max_scale = 4;

static void scale_merged(ty_pop* light) {
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < light->cells; ++i) light->merged.fluence[c][i] *= light->scale[c];
}

static void balance_power(ty_pop_job* job) {
    ty_pop* light = job->light;
    const ty_grid_medium* medium = job->medium;
    const double volume = medium->cell[0] * medium->cell[1] * medium->cell[2];
    for (int32_t c = 0; c < 3; ++c) {
        const int32_t p = medium->planes == 3 ? c : 0;
        double merged = 0, ordinates = 0;
        for (int32_t i = 0; i < light->count; ++i) ordinates += light->ordinates[i].diffuse_power[c];
        for (size_t i = 0; i < light->cells; ++i)
            merged += (double)(ty_reduced_scattering(medium->scattering[p][i], medium->g[p][i]) *
                               light->merged.fluence[c][i]) *
                      volume;
        light->scale[c] = merged > 0 ? ty_clampf((float)(ordinates / merged), min_scale, max_scale) : 1;
    }
    scale_merged(light);
}

/* ---- modes published and collided: iterations and residuum ---- */

static int32_t count_iterations(const ty_pop_job* job) {
    const ty_pop* light = job->light;
    int32_t max_iterations = light->def.resolution;
    if (job->def->iterations > 0) return job->def->iterations;
    if (!(job->def->residuum > 0)) return max_iterations;
    for (int32_t i = 0; i < light->count; ++i) {
        const ty_pop_light* field = &light->ordinates[i];
        const int32_t length = ty_pop_iteration_count(job->def, light->medium, field->ordinate.mean_cosine,
                                                      ty_pop_cell_length(&field->grid, field->grid.size[2] / 2));
        max_iterations = length > max_iterations ? length : max_iterations;
    }
    return max_iterations;
}

static ty_result begin_residuum(ty_pop_job* job, ty_pop_merged* residuum) {
    const ty_pop* light = job->light;
    const ty_grid_box box = ty_pop_residuum_box(&light->medium->box, light->ordinates, light->count);
    return ty_pop_merged_create(job->context, &box, true, residuum);
}

static ty_result propagate_residuum(ty_pop_job* job, ty_pop_merged* residuum) {
    ty_pop* light = job->light;
    const double begun = ty_wall_seconds();
    const int32_t asked = job->def->residuum_iterations;
    double left = 1;
    const ty_result result = ty_pop_merged_create(job->context, &job->medium->box, false, &light->residuum);
    if (result != TY_OK) return result;
    job->stats.residuum_iterations = ty_pop_residuum(job->context, light->medium, residuum_tolerance,
                                                     asked > 0 ? asked : max_residuum_iterations, residuum, &left);
    if (job->stats.residuum_iterations < 0) return TY_ERROR_MEMORY;
    ty_pop_merged_add(job->context, residuum, &light->residuum);
    job->stats.left *= left;
    job->stats.residuum_seconds = ty_wall_seconds() - begun;
    return TY_OK;
}

/* ---- all stages ---- */

/* residuum: receives light not yet propagated; NULL: discarded. */
static ty_result light_grids(ty_pop_job* job, ty_pop_merged* residuum) {
    ty_pop* light = job->light;
    const bool split = job->def->mode == TY_POP_MODE_SPLIT;
    batch b = {.job = job,
               .floats = split ? TY_POP_CELL_FLOATS : TY_POP_CELL_FLOATS_PROPAGATED,
               .iterations = split ? 0 : count_iterations(job),
               .residuum = residuum};
    job->stats.iterations = b.iterations;
    ty_result result = begin_batch(&b);
    if (result == TY_OK && job->def->keep_lobes) result = allocate_lobes(light, b.iterations);
    if (result == TY_OK) result = run_batches(&b, light_one);
    job->stats.memory_bytes = (double)(b.accumulated_floats * sizeof(float)) * light->count;
    end_batch(&b);
    return result;
}

static ty_result propagate_with_residuum(ty_pop_job* job) {
    ty_pop_merged residuum = {.box.size = {0, 0, 0}};
    ty_result result = begin_residuum(job, &residuum);
    if (result == TY_OK) result = light_grids(job, &residuum);
    if (result == TY_OK) result = propagate_residuum(job, &residuum);
    ty_pop_merged_destroy(job->context, &residuum);
    return result;
}

ty_result ty_pop_light_ordinates(ty_pop_job* job) {
    ty_pop* light = job->light;
    const bool split = job->def->mode == TY_POP_MODE_SPLIT;
    ty_result result = split ? ty_diffuse_surfaces_find(job->scene, job->medium, &job->surfaces) : TY_OK;
    if (result == TY_OK) result = find_ordinates(job);
    if (result == TY_OK) result = ty_pop_merged_create(job->context, &job->medium->box, false, &light->merged);
    job->stats.converged = true;
    if (result != TY_OK || light->count == 0) return result;
    result = !split && job->def->residuum > 0 ? propagate_with_residuum(job) : light_grids(job, NULL);
    if (result == TY_OK && split) balance_power(job);
    if (!split) {
        job->stats.left = job->initial_light > 0 ? job->stats.left / job->initial_light : 0;
        job->stats.converged = job->stats.left <= residuum_tolerance;
    }
    return result;
}

static void evaluate_one(void* user, int64_t index, int32_t worker) {
    (void)worker;
    batch* b = user;
    ty_pop_light* field = &b->lights[index];
    field->accumulated = b->accumulated + b->accumulated_floats * (size_t)index;
    ty_pop_evaluate_lobes(b->job->light->medium, b->job->light->eye, field);
}

ty_result ty_pop_move_eye(const ty_pop* light, const float eye[3], const ty_part_progress* progress, ty_pop* out) {
    ty_context* context = light->context;
    const bool split = light->def.mode == TY_POP_MODE_SPLIT;
    *out = *light;
    memcpy(out->eye, eye, sizeof out->eye);
    out->merged = (ty_pop_merged){.box.size = {0, 0, 0}};
    out->ordinates = ty_alloc_array(context, (size_t)light->count, sizeof *out->ordinates, false);
    ty_result result = ty_pop_merged_create(context, &light->merged.box, false, &out->merged);
    if (out->ordinates == NULL) return TY_ERROR_MEMORY;
    memcpy(out->ordinates, light->ordinates, (size_t)light->count * sizeof *out->ordinates);
    if (result != TY_OK) return result;
    for (int c = 0; c < 3 && !split; ++c)
        memcpy(out->merged.fluence[c], light->merged.fluence[c], light->cells * sizeof(float));
    ty_pop_job job = {.context = context, .def = &out->def, .light = out};
    job.progress = ty_part_begin(progress->function, progress->user, progress->from, 0);
    batch b = {.job = &job, .floats = split ? TY_POP_CELL_FLOATS : TY_POP_CELL_FLOATS_PROPAGATED};
    result = begin_batch(&b);
    if (result == TY_OK) result = run_batches(&b, evaluate_one);
    if (result == TY_OK && split) scale_merged(out);
    end_batch(&b);
    return result;
}

void ty_pop_end_view(const ty_pop* light, ty_pop* view) {
    ty_pop_merged_destroy(light->context, &view->merged);
    ty_free_array(light->context, view->ordinates, (size_t)light->count, sizeof *view->ordinates);
}
