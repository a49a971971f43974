/* All ordinates of a scene, each on its own grid, and all of them on merged cells. */
#include "base/context.h"
#include "base/parallel.h"
#include "direct/uncollided/first_collision_source.h"
#include "method/pop/job.h"

#include <math.h>
#include <string.h>

/* Ordinates whose grids are in memory at a time: a few for each thread, so that they are still in its caches when they
 * are merged; but no more than fit into so many floats, if that is enough for a few. */
static const size_t batch_floats = (size_t)1 << 26;
enum { BATCH_EACH = 4, BATCH_MIN = 8, BATCH_MAX = 256, ALONG = 2 };

/* Iterations of the isotropic rest at most, and of what there was the part that may be left. */
static const int32_t residuum_most = 1000;
static const double residuum_least = 1e-3;

/* ---- memory ---- */

ty_result ty_pop_merged_create(ty_context* context, const ty_grid_box* box, bool with_left, ty_pop_merged* out) {
    const size_t cells = (size_t)box->size[0] * (size_t)box->size[1] * (size_t)box->size[2];
    out->box = *box;
    for (int c = 0; c < 3; ++c) {
        out->seen[c] = ty_alloc_array(context, cells, sizeof(float), true);
        out->fluence[c] = ty_alloc_array(context, cells, sizeof(float), true);
        if (with_left) out->left[c] = ty_alloc_array(context, cells, sizeof(float), true);
        if (out->seen[c] == NULL || out->fluence[c] == NULL || (with_left && out->left[c] == NULL))
            return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

void ty_pop_merged_destroy(ty_context* context, ty_pop_merged* merged) {
    const int32_t* size = merged->box.size;
    const size_t cells = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    for (int c = 0; c < 3; ++c) {
        ty_free_array(context, merged->seen[c], cells, sizeof(float));
        ty_free_array(context, merged->fluence[c], cells, sizeof(float));
        ty_free_array(context, merged->left[c], cells, sizeof(float));
    }
}

/* ---- which ordinates ---- */

static bool has_environment(const ty_scene* scene) {
    const ty_light_set* lights = &ty_scene_get_view(scene)->lights;
    for (int32_t i = 0; i < lights->count; ++i)
        if (lights->lights[i].kind == TY_KIND_ENVIRONMENT) return true;
    return false;
}

/* What is swept has no need of cubes: thinner cells show how light fades. */
static void refine_along(ty_pop_frame* frame) {
    frame->size[2] *= ALONG;
    frame->step.z /= ALONG;
    frame->growth /= ALONG;
}

/* All ordinates in one array, the virtual lights' at the end. */
static ty_result join(ty_pop_job* job, const ty_discrete_light_set* own, const ty_discrete_light_set* vpls) {
    ty_pop* light = job->light;
    const int32_t count = own->count + vpls->count;
    if (count == 0) return TY_OK;
    light->ordinates = ty_alloc_array(job->context, (size_t)count, sizeof *light->ordinates, true);
    if (light->ordinates == NULL) return TY_ERROR_MEMORY;
    light->count = count;
    for (int32_t i = 0; i < count; ++i) {
        ty_pop_light* grid = &light->ordinates[i];
        grid->ordinate = i < own->count ? own->items[i] : vpls->items[i - own->count];
        ty_pop_frame_fit(&light->medium->box, &grid->ordinate, light->def.resolution, &grid->frame);
        if (job->def->mode == TY_POP_MODE_SPLIT) refine_along(&grid->frame);
    }
    job->stats.ordinates = count;
    job->stats.vpls = vpls->count;
    memcpy(job->stats.size, light->ordinates[0].frame.size, sizeof job->stats.size);
    return TY_OK;
}

static ty_result find_ordinates(ty_pop_job* job) {
    ty_discrete_light_set own = {.items = NULL}, vpls = {.items = NULL};
    double begun = ty_wall_seconds();
    const bool matters = job->def->importance && has_environment(job->scene);
    const ty_vpl_def vpl_def = ty_pop_vpl_def(job->def);
    ty_result result = ty_part_show(&job->progress, "importance");
    if (result == TY_OK && matters)
        result = ty_pop_importance_find(job->scene, job->def, job->light->medium, job->importance);
    job->stats.importance_seconds = ty_wall_seconds() - begun;
    begun = ty_wall_seconds();
    if (result == TY_OK)
        result =
            ty_pop_ordinates_create(job->scene, job->def, &job->medium->box, matters ? job->importance : NULL, &own);
    job->stats.ordinate_seconds = ty_wall_seconds() - begun;
    begun = ty_wall_seconds();
    if (result == TY_OK && job->def->vpls > 0 && ty_scene_get_view(job->scene)->mesh != NULL)
        result = ty_vpls_create(job->scene, &vpl_def, job->light->medium, &vpls);
    job->stats.vpl_seconds = ty_wall_seconds() - begun;
    if (result == TY_OK) result = join(job, &own, &vpls);
    ty_discrete_light_set_destroy(job->context, &own);
    ty_discrete_light_set_destroy(job->context, &vpls);
    return result;
}

/* ---- their light ---- */

/* Grids that are worked on at a time. */
typedef struct batch {
    ty_pop_job* job;
    ty_pop_light* lights;
    int32_t most, count, iterations, floats;
    size_t seen_floats;    /* of the largest grid */
    size_t scratch_floats; /* likewise, for one thread */
    ty_pop_merged* rest;   /* where what is not passed on comes together; NULL: nowhere */
    float *seen, *scratch;
    ty_pop_walk_stats walks[BATCH_MAX];
} batch;

static size_t larger(size_t a, size_t b) {
    return a > b ? a : b;
}

static int32_t least(int32_t a, int32_t b) {
    return a < b ? a : b;
}

static ty_result begin_batch(batch* b) {
    const ty_pop* light = b->job->light;
    const ty_pop_def* def = &light->def;
    for (int32_t i = 0; i < light->count; ++i) {
        const ty_pop_frame* frame = &light->ordinates[i].frame;
        b->seen_floats = larger(b->seen_floats, ty_pop_seen_floats(frame, b->floats));
        b->scratch_floats = larger(b->scratch_floats, ty_pop_scratch_floats(frame, def, light->medium->planes));
    }
    const size_t fit = larger(BATCH_MIN, batch_floats / b->seen_floats);
    const int32_t room = fit < BATCH_MAX ? (int32_t)fit : BATCH_MAX;
    const int32_t wanted = least(light->count, BATCH_EACH * ty_context_threads(light->context));
    b->most = least(wanted, room);
    b->seen = ty_alloc_array(light->context, b->seen_floats * (size_t)b->most, sizeof(float), false);
    b->scratch = ty_alloc_array(light->context, b->scratch_floats * (size_t)ty_context_threads(light->context),
                                sizeof(float), false);
    return b->seen != NULL && b->scratch != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static void end_batch(batch* b) {
    const ty_pop* light = b->job->light;
    ty_free_array(light->context, b->seen, b->seen_floats * (size_t)b->most, sizeof(float));
    ty_free_array(light->context, b->scratch, b->scratch_floats * (size_t)ty_context_threads(light->context),
                  sizeof(float));
}

static void light_one(void* user, int64_t index, int32_t worker) {
    batch* b = user;
    const ty_pop* light = b->job->light;
    ty_pop_light* grid = &b->lights[index];
    grid->floats = b->floats;
    grid->seen = b->seen + b->seen_floats * (size_t)index;
    if (light->def.mode == TY_POP_MODE_SPLIT)
        ty_pop_sweep(b->job->scene, light->medium, light->eye, grid);
    else
        ty_pop_walk(b->job->scene, &light->def, light->medium, light->eye, b->iterations,
                    b->scratch + b->scratch_floats * (size_t)worker, grid, &b->walks[index]);
}

static ty_result keep_lobes(ty_pop* light, int32_t iterations) {
    for (int32_t i = 0; i < light->count; ++i) {
        ty_pop_light* grid = &light->ordinates[i];
        const size_t floats = ty_pop_lobe_floats(&grid->frame, &light->def, light->medium->planes, iterations);
        grid->lobes = ty_alloc_array(light->context, floats, sizeof(float), true);
        grid->lobe_floats = floats;
        if (grid->lobes == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

/* Batch by batch: `run` for each of its ordinates, then they are merged. */
static ty_result run_batches(batch* b, ty_parallel_fn run) {
    ty_pop_job* job = b->job;
    ty_pop* light = job->light;
    ty_pop_stats* stats = &job->stats;
    for (int32_t first = 0; first < light->count; first += b->most) {
        const double begun = ty_wall_seconds();
        double initial = 0, passing = 0;
        b->lights = light->ordinates + first;
        b->count = light->count - first < b->most ? light->count - first : b->most;
        memset(b->walks, 0, sizeof b->walks);
        ty_parallel_flushed(job->context, b->count, run, b);
        const double done = ty_wall_seconds();
        ty_pop_merge(job->context, b->lights, b->count, &light->merged);
        if (b->rest != NULL) ty_pop_residuum_take(job->context, b->lights, b->count, b->rest);
        stats->merge_seconds += ty_wall_seconds() - done;
        for (int32_t i = 0; i < b->count; ++i) {
            initial += b->walks[i].initial_seconds;
            passing += b->walks[i].propagation_seconds;
            stats->left += b->walks[i].left;
            job->entered += b->walks[i].entered;
        }
        /* Threads work side by side: their parts are as long as those of the whole. */
        const double share = initial + passing > 0 ? passing / (initial + passing) : 0;
        stats->propagation_seconds += share * (done - begun);
        stats->initial_seconds += (1 - share) * (done - begun);
        const ty_progress part = {.stage = "ordinates", .fraction = (double)(first + b->count) / light->count};
        if (!ty_part_report(&job->progress, &part)) return TY_CANCELLED;
    }
    return TY_OK;
}

/* ---- split mode: energy ---- */

/* Cells beside each other in light and shade share some of it when they are merged; all together they get what was
 * turned aside on the ordinates' own cells. */
static const float scale_least = 0.25f, scale_most = 4;

static void scale_merged(ty_pop* light) {
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < light->cells; ++i) light->merged.fluence[c][i] *= light->scale[c];
}

static void balance(ty_pop_job* job) {
    ty_pop* light = job->light;
    const ty_grid_medium* medium = job->medium;
    const double volume = medium->cell[0] * medium->cell[1] * medium->cell[2];
    for (int32_t c = 0; c < 3; ++c) {
        const int32_t p = medium->planes == 3 ? c : 0;
        double merged = 0, own = 0;
        for (int32_t i = 0; i < light->count; ++i) own += light->ordinates[i].turned[c];
        for (size_t i = 0; i < light->cells; ++i)
            merged += (double)(ty_reduced_scattering(medium->scattering[p][i], medium->g[p][i]) *
                               light->merged.fluence[c][i]) *
                      volume;
        light->scale[c] = merged > 0 ? ty_clampf((float)(own / merged), scale_least, scale_most) : 1;
    }
    scale_merged(light);
}

/* ---- modes published and collided: how long, and what is left ---- */

static int32_t walk_length(const ty_pop_job* job) {
    const ty_pop* light = job->light;
    int32_t most = light->def.resolution;
    if (job->def->iterations > 0) return job->def->iterations;
    if (!(job->def->residuum > 0)) return most;
    for (int32_t i = 0; i < light->count; ++i) {
        const ty_pop_light* grid = &light->ordinates[i];
        const int32_t length = ty_pop_walk_length(job->def, light->medium, grid->ordinate.mean_cosine,
                                                  ty_pop_length(&grid->frame, grid->frame.size[2] / 2));
        most = length > most ? length : most;
    }
    return most;
}

static ty_result begin_rest(ty_pop_job* job, ty_pop_merged* rest) {
    const ty_pop* light = job->light;
    const ty_grid_box box = ty_pop_residuum_box(&light->medium->box, light->ordinates, light->count);
    return ty_pop_merged_create(job->context, &box, true, rest);
}

static ty_result pass_on(ty_pop_job* job, ty_pop_merged* rest) {
    ty_pop* light = job->light;
    const double begun = ty_wall_seconds();
    const int32_t asked = job->def->residuum_iterations;
    double left = 1;
    const ty_result result = ty_pop_merged_create(job->context, &job->medium->box, false, &light->residuum);
    if (result != TY_OK) return result;
    job->stats.residuum_iterations =
        ty_pop_residuum(job->context, light->medium, residuum_least, asked > 0 ? asked : residuum_most, rest, &left);
    if (job->stats.residuum_iterations < 0) return TY_ERROR_MEMORY;
    ty_pop_merged_add(job->context, rest, &light->residuum);
    job->stats.left *= left;
    job->stats.residuum_seconds = ty_wall_seconds() - begun;
    return TY_OK;
}

/* ---- all of it ---- */

/* rest: NULL, or where what is not passed on comes together. */
static ty_result light_grids(ty_pop_job* job, ty_pop_merged* rest) {
    ty_pop* light = job->light;
    const bool split = job->def->mode == TY_POP_MODE_SPLIT;
    batch b = {.job = job,
               .floats = split ? TY_POP_SEEN : TY_POP_SEEN_LEFT,
               .iterations = split ? 0 : walk_length(job),
               .rest = rest};
    job->stats.iterations = b.iterations;
    ty_result result = begin_batch(&b);
    if (result == TY_OK && job->def->keep_lobes) result = keep_lobes(light, b.iterations);
    if (result == TY_OK) result = run_batches(&b, light_one);
    job->stats.bytes = (double)(b.seen_floats * sizeof(float)) * light->count;
    end_batch(&b);
    return result;
}

static ty_result light_and_pass_on(ty_pop_job* job) {
    ty_pop_merged rest = {.box.size = {0, 0, 0}};
    ty_result result = begin_rest(job, &rest);
    if (result == TY_OK) result = light_grids(job, &rest);
    if (result == TY_OK) result = pass_on(job, &rest);
    ty_pop_merged_destroy(job->context, &rest);
    return result;
}

ty_result ty_pop_light_ordinates(ty_pop_job* job) {
    ty_pop* light = job->light;
    const bool split = job->def->mode == TY_POP_MODE_SPLIT;
    ty_result result = find_ordinates(job);
    if (result == TY_OK) result = ty_pop_merged_create(job->context, &job->medium->box, false, &light->merged);
    job->stats.converged = true;
    if (result != TY_OK || light->count == 0) return result;
    result = !split && job->def->residuum > 0 ? light_and_pass_on(job) : light_grids(job, NULL);
    if (result == TY_OK && split) balance(job);
    if (!split) {
        job->stats.left = job->entered > 0 ? job->stats.left / job->entered : 0;
        job->stats.converged = job->stats.left <= residuum_least;
    }
    return result;
}

static void see_one(void* user, int64_t index, int32_t worker) {
    (void)worker;
    batch* b = user;
    ty_pop_light* grid = &b->lights[index];
    grid->seen = b->seen + b->seen_floats * (size_t)index;
    ty_pop_see(b->job->light->medium, b->job->light->eye, grid);
}

ty_result ty_pop_see_from(ty_pop* light, const float eye[3]) {
    ty_pop_job job = {.context = light->context, .def = &light->def, .light = light};
    batch b = {.job = &job, .floats = light->def.mode == TY_POP_MODE_SPLIT ? TY_POP_SEEN : TY_POP_SEEN_LEFT};
    memcpy(light->eye, eye, sizeof light->eye);
    if (light->count == 0) return TY_OK;
    const bool split = light->def.mode == TY_POP_MODE_SPLIT;
    for (int c = 0; c < 3; ++c) {
        memset(light->merged.seen[c], 0, light->cells * sizeof(float));
        if (split) memset(light->merged.fluence[c], 0, light->cells * sizeof(float));
    }
    ty_result result = begin_batch(&b);
    if (result == TY_OK) result = run_batches(&b, see_one);
    if (result == TY_OK && split) scale_merged(light);
    end_batch(&b);
    return result;
}
