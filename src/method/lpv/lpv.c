/* Entry points. */
#include "base/context.h"
#include "base/isa.h"
#include "direct/media/coverage.h"
#include "method/lpv/image/image.h"
#include "method/lpv/inject/inject.h"
#include "method/lpv/lpv_method.h"
#include "method/lpv/propagate/propagate.h"
#include "scene/camera.h"
#include "scene/interiors.h"

#include <string.h>

/* Progress after each stage of a solve, and the fraction of a render that the solve takes. */
static const double medium_until = 0.05, map_until = 0.4, inject_until = 0.7, solve_fraction = 0.4;

/* ---- solving ---- */

static bool scatters(const ty_lpv_job* job) {
    return (job->def->parts & TY_LPV_SCATTERING) != 0 && ty_scene_get_view(job->scene)->medium_count > 0;
}

/* The number of lights before those of emissive meshes. */
static int32_t untriangulated_lights(const ty_lpv_job* job) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    int32_t count = 0;
    while (count < lights->count && lights->lights[count].kind != TY_KIND_TRIANGLE) ++count;
    return count;
}

/* Creates the lattices and the media on their cells. */
static ty_result place(ty_lpv_job* job) {
    ty_grid_box boxes[TY_LPV_CASCADES_MAX];
    ty_lpv* light = job->light;
    const double begun = ty_wall_seconds();
    int32_t count;
    ty_result result = ty_lattice_place(job->scene, job->def, boxes, &count);
    for (int32_t i = 0; i < count && result == TY_OK; ++i) {
        result = ty_lattice_create(job->context, &boxes[i], job->def->bands, &light->lattices[i]);
        if (result != TY_OK) break;
        ++light->count;
        light->lattices[i]->reduces = job->def->mode == TY_LPV_MODE_LINKS;
        if (scatters(job)) result = ty_grid_medium_create(job->scene, &boxes[i], &light->lattices[i]->medium);
        if (result == TY_OK && job->def->mode == TY_LPV_MODE_LINKS)
            result = ty_lattice_find_border_scale(light->lattices[i]);
        if (result == TY_OK && job->def->mode == TY_LPV_MODE_LINKS)
            result = ty_lattice_find_extinction_floor(light->lattices[i], ty_scene_get_view(job->scene)->lights.lights,
                                                      untriangulated_lights(job));
        for (int a = 0; a < 3; ++a) job->stats.size[i][a] = boxes[i].size[a];
        job->stats.cell[i] = (double)light->lattices[i]->cell;
    }
    if (result == TY_OK && ty_scene_get_view(job->scene)->medium_count > 0) {
        ty_grid_box fine;
        result = ty_grid_box_fit(job->scene, ty_grid_box_longest(job->scene, 0), &fine);
        if (result == TY_OK) result = ty_grid_medium_create(job->scene, &fine, &light->medium);
        if (result == TY_OK && job->def->mode == TY_LPV_MODE_LINKS)
            result = ty_reduced_media_create(job->scene, light->medium, &light->reduced);
    }
    job->stats.medium_seconds = ty_wall_seconds() - begun;
    return result;
}

typedef ty_result (*inject_fn)(ty_lattice* lattice, const ty_lpv_def* def, const ty_lpv_light* lpv_light,
                               const ty_grid_medium* medium, double power[3]);

static ty_result inject(ty_lpv_job* job, ty_lattice* lattice, inject_fn function, double power[3], double* seconds) {
    const double begun = ty_wall_seconds();
    const ty_grid_medium* reduced = job->light->reduced.medium;
    const ty_grid_medium* medium = !scatters(job) ? NULL : reduced != NULL ? reduced : job->light->medium;
    ty_result result = TY_OK;
    for (int32_t i = 0; i < job->light->source_count && result == TY_OK; ++i)
        result = function(lattice, job->def, &job->light->sources[i], medium, power);
    *seconds += ty_wall_seconds() - begun;
    return result;
}

static ty_result inject_extended_reflected(ty_lpv_job* job, ty_lattice* lattice, const ty_surfel_list* surfels,
                                           double power[3]) {
    const double begun = ty_wall_seconds();
    const ty_result result = ty_lpv_inject_extended_reflected(job, lattice, surfels, power);
    job->stats.reflected_seconds += ty_wall_seconds() - begun;
    return result;
}

static ty_result inject_in_media(ty_lpv_job* job, ty_lattice* lattice, double scattered[3], double emitted[3]) {
    const double begun = ty_wall_seconds();
    const ty_result result = ty_lpv_inject_in_media(job, lattice, scattered, emitted);
    job->stats.scattered_seconds += ty_wall_seconds() - begun;
    return result;
}

/* Copies the injected power that counts as light in its own cell. */
static ty_result copy_propagated_sh(const ty_lattice* lattice, float* own_cell_sh[3][TY_SH_TERMS]) {
    for (int c = 0; c < 3; ++c)
        for (int32_t t = 0; t < lattice->terms; ++t) {
            own_cell_sh[c][t] = ty_alloc_array(lattice->context, lattice->cells, sizeof(float), false);
            if (own_cell_sh[c][t] == NULL) return TY_ERROR_MEMORY;
            memcpy(own_cell_sh[c][t], lattice->propagated_sh[c][t], lattice->cells * sizeof(float));
        }
    return TY_OK;
}

static void free_propagated_sh(const ty_lattice* lattice, float* own_cell_sh[3][TY_SH_TERMS]) {
    for (int c = 0; c < 3; ++c)
        for (int32_t t = 0; t < lattice->terms; ++t)
            ty_free_array(lattice->context, own_cell_sh[c][t], lattice->cells, sizeof(float));
}

/* The energy balance of the statistics is that of the coarsest cascade. */
static void take_power(ty_lpv_job* job, const ty_lattice_power* power, bool widest) {
    ty_lpv_stats* stats = &job->stats;
    if (power->iterations > stats->iterations) stats->iterations = power->iterations;
    stats->prepare_seconds += power->prepare_seconds;
    stats->propagate_seconds += power->propagate_seconds;
    stats->gather_seconds += power->gather_seconds;
    for (int c = 0; c < 3 && widest; ++c) {
        stats->absorbed[c] = power->absorbed[c];
        stats->blocked[c] = power->blocked[c];
        stats->escaped[c] = power->escaped[c];
        stats->left[c] = power->left[c];
    }
}

static ty_result propagate(ty_lpv_job* job, int32_t index, double until) {
    ty_lattice* lattice = job->light->lattices[index];
    const bool widest = index == job->light->count - 1, published = job->def->mode == TY_LPV_MODE_PUBLISHED;
    float* own_cell_sh[3][TY_SH_TERMS] = {{NULL}};
    double narrower[3] = {0, 0, 0}, ignored[3] = {0, 0, 0};
    double* reflected = widest ? job->stats.reflected : narrower;
    double* scattered = widest ? job->stats.scattered : ignored;
    double* emitted = widest ? job->stats.emitted : ignored;
    ty_surfel_list surfels = {.items = NULL};
    ty_result result = ty_part_next(&job->progress, "light in the lattice", until);
    if (result == TY_OK) result = ty_lpv_find_blockers(job, lattice, &surfels);
    if (result == TY_OK && (job->def->parts & TY_LPV_REFLECTED) != 0)
        result = inject(job, lattice, ty_lattice_inject_reflected, reflected, &job->stats.reflected_seconds);
    if (result == TY_OK && (job->def->parts & TY_LPV_REFLECTED) != 0 && job->light->extended != NULL)
        result = inject_extended_reflected(job, lattice, &surfels, reflected);
    ty_surfel_list_free(job->context, &surfels);
    if (result == TY_OK && published) result = copy_propagated_sh(lattice, own_cell_sh);
    if (result == TY_OK && (job->def->parts & TY_LPV_SCATTERED) != 0 && scatters(job))
        result = inject(job, lattice, ty_lattice_inject_scattered, scattered, &job->stats.scattered_seconds);
    if (result == TY_OK && scatters(job)) result = inject_in_media(job, lattice, scattered, emitted);
    ty_lattice_power power = {.iterations = 0};
    if (result == TY_OK)
        result = ty_lattice_propagate(lattice, job->def, published ? own_cell_sh : NULL,
                                      widest ? NULL : job->light->lattices[index + 1], ty_part_report, &job->progress,
                                      &power);
    take_power(job, &power, widest);
    free_propagated_sh(lattice, own_cell_sh);
    return result;
}

static ty_result run_stages(ty_lpv_job* job, double fraction) {
    ty_result result = ty_part_next(&job->progress, "media", fraction * medium_until);
    if (result == TY_OK) result = place(job);
    if (result == TY_OK) result = ty_part_next(&job->progress, "maps", fraction * map_until);
    if (result == TY_OK) result = ty_extended_lights_create(job->scene, &job->light->extended);
    if (result == TY_OK) result = ty_lpv_find_maps(job);
    for (int32_t i = job->light->count - 1; i >= 0 && result == TY_OK; --i)
        result = propagate(job, i, fraction * (1 - (1 - inject_until) * i / job->light->count));
    return result;
}

/* fraction: the fraction of the caller's progress that the solve covers. */
static ty_result solve(const ty_scene* scene, const ty_lpv_def* def, double fraction, ty_lpv** out,
                       ty_lpv_stats* stats) {
    ty_context* context = ty_scene_context(scene);
    if (ty_scene_get_view(scene) == NULL) return TY_ERROR_ARGUMENT;
    ty_result result = ty_scene_check_open(scene, "lpv");
    if (result == TY_OK) result = ty_lpv_check_maps(scene, def);
    if (result != TY_OK) return result;
    ty_interiors_warn(scene, "lpv", TY_LPV_OF_INTERIORS);
    ty_lpv_job job = {.context = context, .scene = scene, .def = def};
    job.progress = ty_part_begin(def->progress, def->progress_user, 0, 0);
    job.light = ty_alloc_array(context, 1, sizeof *job.light, true);
    if (job.light == NULL) return TY_ERROR_MEMORY;
    job.light->context = context;
    result = run_stages(&job, fraction);
    job.stats.seconds = ty_wall_seconds() - job.progress.begun;
    job.stats.rays = atomic_load(&job.counter.rays);
    job.stats.ray_seconds = 1e-9 * (double)atomic_load(&job.counter.nanoseconds) / ty_context_threads(context);
    job.stats.isa = ty_isa_name(ty_best_isa());
    if (result != TY_OK) {
        ty_lpv_destroy(job.light);
        return result;
    }
    *stats = job.stats;
    *out = job.light;
    return TY_OK;
}

ty_result ty_lpv_solve(const ty_scene* scene, const ty_lpv_def* def, ty_lpv** out, ty_lpv_stats* stats) {
    *out = NULL;
    ty_lpv_known known;
    ty_lpv_stats own;
    ty_result result = ty_lpv_take_def(ty_scene_context(scene), &def, &known);
    if (result == TY_OK)
        result = ty_take_stats(ty_scene_context(scene), stats, "ty_default_lpv_stats", &own, sizeof own);
    if (result == TY_OK) result = solve(scene, def, 1, out, &own);
    if (result == TY_OK) ty_give_stats(&own, sizeof own, stats);
    return result;
}

void ty_lpv_destroy(ty_lpv* light) {
    if (light == NULL) return;
    for (int32_t i = 0; i < light->count; ++i) ty_lattice_destroy(light->lattices[i]);
    ty_lpv_free_maps(light);
    ty_extended_lights_destroy(light->extended);
    ty_grid_medium_destroy(light->medium);
    ty_reduced_media_destroy(light->context, &light->reduced);
    ty_free_array(light->context, light, 1, sizeof *light);
}

/* ---- images ---- */

static ty_result make_image(const ty_lpv* light, const ty_scene* scene, const ty_lpv_def* def, ty_image** out,
                            ty_lpv_stats* stats) {
    const ty_camera_def camera = ty_scene_camera(scene);
    const size_t count = (size_t)light->source_count;
    ty_lpv_def sized = *def;
    const ty_result allowed = ty_camera_check_pinhole(light->context, &camera, "lpv");
    if (allowed != TY_OK) return allowed;
    ty_airlight *airlight = NULL, *single = NULL;
    const ty_shadow_hierarchy** maps = ty_alloc_array(light->context, count, sizeof(const ty_shadow_hierarchy*), false);
    if (maps == NULL) return TY_ERROR_MEMORY;
    sized.width = def->width > 0 ? def->width : camera.resolution[0];
    sized.height = def->width > 0 ? def->height : camera.resolution[1];
    for (size_t i = 0; i < count; ++i) maps[i] = light->sources[i].hierarchy;
    ty_result result = TY_OK;
    if (light->medium != NULL) {
        ty_airlight_def airlight_def = {
            .medium = light->medium, .reduced = &light->reduced, .maps = maps, .count = light->source_count};
        const bool splits = light->reduced.medium != NULL && (def->aovs & (TY_AOV_SINGLE | TY_AOV_MULTIPLE)) != 0;
        result = ty_airlight_create(scene, &airlight_def, &airlight);
        airlight_def.reduced = NULL;
        if (result == TY_OK && splits) result = ty_airlight_create(scene, &airlight_def, &single);
    }
    const ty_lpv_image_job job = {.scene = scene,
                                  .def = &sized,
                                  .light = {light->lattices, light->count},
                                  .extended = light->extended,
                                  .medium = light->medium,
                                  .reduced = &light->reduced,
                                  .airlight = airlight,
                                  .single = single,
                                  .shadow_maps = maps,
                                  .shadow_map_count = light->source_count};
    if (result == TY_OK) result = ty_lpv_image(&job, out, stats);
    ty_airlight_destroy(airlight);
    ty_airlight_destroy(single);
    ty_free_array(light->context, maps, count, sizeof(const ty_shadow_hierarchy*));
    return result;
}

/* Renders with the rest of the caller's progress. */
static ty_result view_from(const ty_lpv* light, const ty_scene* scene, const ty_lpv_def* def,
                           ty_part_progress* progress, ty_image** out, ty_lpv_stats* stats) {
    ty_lpv_def own = *def;
    const double begun = ty_wall_seconds();
    own.progress = ty_part_report;
    own.progress_user = progress;
    const ty_result result = make_image(light, scene, &own, out, stats);
    stats->seconds += ty_wall_seconds() - begun;
    return result;
}

ty_result ty_lpv_view(const ty_lpv* light, const ty_scene* scene, const ty_lpv_def* def, ty_image** out,
                      ty_lpv_stats* stats) {
    *out = NULL;
    ty_lpv_known known;
    ty_lpv_stats own;
    ty_result result = ty_lpv_take_def(ty_scene_context(scene), &def, &known);
    if (result == TY_OK)
        result = ty_take_stats(ty_scene_context(scene), stats, "ty_default_lpv_stats", &own, sizeof own);
    if (result != TY_OK) return result;
    ty_part_progress progress = ty_part_begin(def->progress, def->progress_user, 0, 1);
    result = view_from(light, scene, def, &progress, out, &own);
    if (result == TY_OK) ty_give_stats(&own, sizeof own, stats);
    return result;
}

ty_result ty_lpv_render(const ty_scene* scene, const ty_lpv_def* def, ty_image** out, ty_lpv_stats* stats) {
    *out = NULL;
    ty_lpv* light = NULL;
    ty_lpv_stats own;
    const double begun = ty_wall_seconds();
    ty_lpv_known known;
    ty_result result = ty_lpv_take_def(ty_scene_context(scene), &def, &known);
    if (result == TY_OK)
        result = ty_take_stats(ty_scene_context(scene), stats, "ty_default_lpv_stats", &own, sizeof own);
    if (result == TY_OK) result = solve(scene, def, solve_fraction, &light, &own);
    if (result != TY_OK) return result;
    ty_part_progress progress = ty_part_begin(def->progress, def->progress_user, solve_fraction, 1 - solve_fraction);
    progress.begun = begun;
    result = view_from(light, scene, def, &progress, out, &own);
    ty_lpv_destroy(light);
    ty_give_stats(&own, sizeof own, stats);
    return result;
}

/* ---- fluence and irradiance ---- */

typedef struct fluence_job {
    const ty_lpv* light;
    ty_coverage_box cells;
    double* fluence;
} fluence_job;

/* The finest cascade that contains a cell of the caller's; the coarsest if none does. */
static const ty_lattice* lattice_around(const fluence_job* job, const int32_t cell[3]) {
    for (int32_t i = 0; i < job->light->count - 1; ++i) {
        const ty_grid_box* box = &job->light->lattices[i]->box;
        bool inside = true;
        for (int a = 0; a < 3; ++a) {
            const double side = (job->cells.upper[a] - job->cells.lower[a]) / job->cells.size[a];
            const double lower = job->cells.lower[a] + side * cell[a];
            inside &= lower >= box->lower[a] && lower + side <= box->upper[a];
        }
        if (inside) return job->light->lattices[i];
    }
    return job->light->lattices[job->light->count - 1];
}

static void fill_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const fluence_job* job = user;
    const double per_term = 1 / (double)TY_SH_0;
    for (int32_t i = 0; i < job->cells.size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % job->cells.size[1]), (int32_t)(row / job->cells.size[1])};
        const size_t at = (size_t)row * (size_t)job->cells.size[0] + (size_t)i;
        const ty_lattice* lattice = lattice_around(job, cell);
        ty_coverage axes[3];
        ty_coverage_of_cell(&lattice->box, &job->cells, cell, axes);
        for (int c = 0; c < 3; ++c) {
            const float* terms[1] = {lattice->light[c][0]};
            job->fluence[3 * at + (size_t)c] = 0;
            ty_coverage_add(&lattice->box, axes, terms, 1, per_term, &job->fluence[3 * at + (size_t)c]);
        }
    }
}

ty_result ty_lpv_fluence(const ty_lpv* light, const double lower[3], const double upper[3], const int32_t size[3],
                         double* fluence) {
    const ty_coverage_box cells = {lower, upper, size};
    const ty_result result = ty_coverage_check(light->context, &cells);
    if (result != TY_OK) return result;
    fluence_job job = {light, cells, fluence};
    ty_parallel_for(light->context, (int64_t)size[1] * size[2], fill_row, &job);
    return TY_OK;
}

ty_result ty_lpv_irradiance(const ty_lpv* light, const float* points, const float* normals, int64_t count,
                            float* irradiance) {
    const ty_lpv_light_view view = {light->lattices, light->count};
    if (count < 0 || (count > 0 && (points == NULL || normals == NULL || irradiance == NULL)))
        return ty_fail(light->context, TY_ERROR_ARGUMENT, "lpv: irradiance at %lld points needs arrays for them",
                       (long long)count);
    for (int64_t i = 0; i < count; ++i)
        ty_lpv_irradiance_at(&view, ty_vec_load(points + 3 * i), ty_vec_load(normals + 3 * i), irradiance + 3 * i);
    return TY_OK;
}

bool ty_lpv_get_lattice(const ty_lpv* light, int32_t cascade, ty_lpv_lattice* out) {
    if (cascade < 0 || cascade >= light->count) return false;
    const ty_lattice* lattice = light->lattices[cascade];
    *out = (ty_lpv_lattice){.cell = (double)lattice->cell, .bands = lattice->bands};
    for (int a = 0; a < 3; ++a) {
        out->lower[a] = lattice->box.lower[a];
        out->size[a] = lattice->box.size[a];
    }
    for (int c = 0; c < 3; ++c)
        for (int32_t t = 0; t < lattice->terms; ++t) out->coefficients[c][t] = lattice->light[c][t];
    return true;
}
