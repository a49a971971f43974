/* Preparation common to all runs: option checks, guiding lights, kernel, memory. */
#include "method/path/outlines.h"
#include "method/path/guide_choice.h"

#include "base/context.h"
#include "base/dispatch.h"
#include "method/path/trace/collision.k.h"
#include "method/path/trace/equiangular.k.h"
#include "method/path/trace/light_path.k.h"
#include "scene/interiors.h"
#include "scene/lights/light.h"

/* Contributions are traced by chance below this fraction of the radiance that an isotropic medium scatters under the
 * typical light. */
static const float contribution_fraction = 0.5f;

/* Lamp directions per vertex beside a lamp and unit optical thickness of the scene, at most 1 in all: in thin media
 * light that is scattered twice is a small part, and they cost time. The squared distance at which they are half as
 * many, and the squared length of the optical thickness, both over the squared reach of the lamp. */
static const double point_light_rate = 0.5, point_light_reach_factor = 60, thickness_factor = 1 / 0.015;

/* Within sqrt(point_light_near) reaches of a lamp, rays sample the light that it sends into them, peak of the phase
 * function included: in thick media, where rays that do not point at a lamp are scattered towards it, and in thin ones,
 * where such samples only cost time. */
static const double near_factor_thick = 10, near_factor_thin = 3;

/* Chooses the guiding lights of high-g media: local and directional lights, most probable first. */
static void choose_guides(ty_path_request* request) {
    const ty_scene_view* scene = request->scene;
    float sum = 0;
    while (request->guide_count < TY_GUIDES_MAX) {
        int32_t best = -1;
        for (int32_t i = 0; i < scene->lights.count; ++i) {
            bool usable = scene->lights.lights[i].kind != TY_KIND_ENVIRONMENT && scene->lights.lights[i].typical > 0;
            for (int32_t j = 0; j < request->guide_count; ++j) usable = usable && request->guide_light[j] != i;
            if (usable && (best < 0 || scene->lights.lights[i].typical > scene->lights.lights[best].typical)) best = i;
        }
        if (best < 0) break;
        sum += scene->lights.lights[best].typical;
        request->guide_weight[request->guide_count] = scene->lights.lights[best].typical;
        request->guide_light[request->guide_count++] = best;
    }
    for (int32_t j = 0; j < request->guide_count; ++j) request->guide_weight[j] /= sum;
}

static float contribution_threshold(const ty_light_set* lights) {
    float sum = 0;
    for (int32_t i = 0; i < lights->count; ++i) sum += contribution_fraction * lights->lights[i].typical * TY_INV_4PI;
    return sum;
}

ty_result ty_path_prepare(const ty_scene* scene, const ty_path_def* def, ty_path_run* run) {
    memset(run, 0, sizeof *run);
    run->context = ty_scene_context(scene);
    const ty_result result = ty_path_take_def(run->context, def, &run->known);
    if (result != TY_OK) return result;
    def = run->def = &run->known;
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    run->scene = scene;
    run->view = *view;
    if (def->ignore_media) run->view.medium_count = 0;
    run->request.scene = &run->view;
    ty_sobol_matrices(&run->sobol);
    run->request.sobol = &run->sobol;
    run->request.seed = def->seed;
    run->request.max_depth = def->max_depth;
    run->request.unscattered = def->unscattered && run->view.medium_count > 0;
    run->request.single_reflection = !def->energy_compensation;
    run->request.enclosed = def->enclosed;
    const bool periodic = run->view.periodic.axes != 0;
    if (periodic && def->guide == TY_PATH_GUIDE_DOM)
        return ty_fail(run->context, TY_ERROR_ARGUMENT, "path.guide: paths of a periodic scene have no guide");
    if (periodic) run->known.guide = TY_PATH_GUIDE_NONE;
    run->kernel = periodic ? TY_BEST_KERNELS(ty_path_periodic_kernel) : TY_BEST_KERNELS(ty_path_kernel);
    run->stats.isa = ty_isa_name(ty_best_isa());
    return TY_OK;
}

/* Lights for a scene without its media: their sampling probabilities depend on the scene's extent. */
static ty_result replace_lights(ty_path_run* run, const ty_scene* scene) {
    ty_light_set* set = &run->view.lights;
    if (!run->def->ignore_media || set->count == 0) return TY_OK;
    double lower[3], upper[3];
    run->lights = ty_alloc_array(run->context, (size_t)set->count, sizeof *run->lights, false);
    if (run->lights == NULL) return TY_ERROR_MEMORY;
    memcpy(run->lights, set->lights, (size_t)set->count * sizeof *run->lights);
    ty_scene_surface_extent(scene, lower, upper);
    set->tree_probability = ty_light_set_choice(run->lights, (size_t)set->count, lower, upper);
    set->lights = run->lights;
    return TY_OK;
}

static ty_result allocate_items(ty_path_run* run, bool with_aov_sums) {
    const size_t count = (size_t)run->item_count;
    run->items = ty_alloc_array(run->context, count, sizeof *run->items, true);
    if (run->items != NULL && with_aov_sums)
        run->aov_sums = ty_alloc_array(run->context, count, sizeof *run->aov_sums, true);
    const bool with_halves = run->request.kind == TY_PATH_PIXELS && (run->known.aovs & TY_AOV_HALF) != 0;
    if (run->aov_sums != NULL && with_halves)
        run->halves = ty_alloc_array(run->context, count, sizeof *run->halves, true);
    return run->items != NULL && (run->aov_sums != NULL) == with_aov_sums && (run->halves != NULL) == with_halves
               ? TY_OK
               : TY_ERROR_MEMORY;
}

/* True if all lights are far away, and a homogeneous medium is so thick that they hardly light its inside. Only
 * environments take so long to sample that a closer look pays. */
static bool is_deep(const ty_scene_view* scene) {
    bool sky = false, deep = false;
    if (scene->lights.distant_count < scene->lights.count) return false;
    for (int32_t i = 0; i < scene->lights.count; ++i) sky = sky || scene->lights.lights[i].kind == TY_KIND_ENVIRONMENT;
    if (!sky) return false;
    for (int32_t m = 0; m < scene->medium_count; ++m) {
        const ty_medium_view* medium = &scene->media[m];
        deep = deep || (medium->heterogeneous == 0 &&
                        ty_medium_depth(medium, ty_vec_make(0, 0, 0)) > -logf(TY_PATH_FAINT_TRANSMITTANCE));
    }
    return deep;
}

/* Rates of lamp directions, where lamps shine into media: off if the def, or the request, leaves no light for them. */
static void set_point_light_rate(ty_path_run* run) {
    const ty_light_set* lights = &run->view.lights;
    float reach2 = 0;
    for (int32_t i = 0; i < lights->count; ++i)
        if (ty_light_is_point_or_spot(lights->lights[i].kind)) reach2 = fmaxf(reach2, lights->lights[i].reach2);
    run->request.point_light_near = 1;
    if (!run->known.point_light_directions || run->request.unscattered != 0 || run->view.medium_count == 0 ||
        !(reach2 > 0))
        return;
    double scattering = 0, forward = 0;
    for (int32_t m = 0; m < run->view.medium_count; ++m) {
        const ty_medium_view* medium = &run->view.media[m];
        scattering += (double)medium->sigma_s[1];
        forward += (double)medium->sigma_s[1] * medium->g[1];
    }
    run->request.point_light_rate =
        (float)fmin(point_light_rate * scattering * sqrt(thickness_factor * (double)reach2), 1);
    run->request.point_light_near =
        (float)fmax(near_factor_thick * (double)run->request.point_light_rate, near_factor_thin);
    run->request.point_light_g = scattering > 0 ? (float)fmin(fmax(forward / scattering, 0), 0.98) : 0;
    run->request.point_light_reach2 = (float)(point_light_reach_factor * (double)reach2);
}

static void take_guide(ty_path_run* run, ty_path_guide* guide) {
    run->guide = guide;
    run->request.guide = guide != NULL ? &guide->view : NULL;
    run->kernel = guide != NULL ? TY_BEST_KERNELS(ty_path_guided_kernel) : TY_BEST_KERNELS(ty_path_kernel);
    run->stats.guide = run->known.guide = guide != NULL ? TY_PATH_GUIDE_DOM : TY_PATH_GUIDE_NONE;
}

/* The guide, where the def asks for one, or a pilot finds that it pays, and there is light in media to sample. */
static ty_result make_guide(ty_path_run* run, const ty_scene* scene) {
    const bool possible = run->view.medium_count > 0 && run->request.unscattered == 0;
    const ty_path_guide_kind given = run->known.guide,
                             kind = given == TY_PATH_GUIDE_AUTO ? ty_path_guide_expected(run) : given;
    if (kind == TY_PATH_GUIDE_NONE || !possible) {
        if (given == TY_PATH_GUIDE_AUTO) run->known.guide = TY_PATH_GUIDE_NONE;
        return TY_OK;
    }
    const double begun = ty_wall_seconds(), cpu_begun = ty_cpu_seconds();
    ty_path_guide* guide = NULL;
    const ty_result result = ty_path_guide_create(scene, &run->view, 0, &guide);
    if (result != TY_OK) return result;
    take_guide(run, guide);
    if (kind == TY_PATH_GUIDE_AUTO && !ty_path_guide_pays(run)) {
        take_guide(run, NULL);
        ty_path_guide_destroy(guide);
    }
    run->guide_seconds = ty_wall_seconds() - begun;
    run->guide_cpu_seconds = ty_cpu_seconds() - cpu_begun;
    return TY_OK;
}

ty_result ty_path_run_begin(ty_path_run* run, const ty_scene* scene, bool with_aov_sums) {
    ty_result result = replace_lights(run, scene);
    if (result == TY_OK) result = allocate_items(run, with_aov_sums);
    if (result != TY_OK) {
        ty_path_run_end(run);
        return result;
    }
    if (run->view.interior_count > 0)
        ty_interiors_around(&run->view, run->request.camera.origin, &run->request.camera_inside);
    run->request.deep = is_deep(&run->view);
    choose_guides(&run->request);
    set_point_light_rate(run);
    run->request.min_contribution = contribution_threshold(&run->view.lights);
    result = make_guide(run, scene);
    if (result == TY_OK) result = ty_path_prepare_outlines(run);
    if (result != TY_OK) ty_path_run_end(run);
    return result;
}

void ty_path_run_end(ty_path_run* run) {
    ty_path_guide_destroy(run->guide);
    ty_free_array(run->context, run->outlines, (size_t)run->item_count, 1);
    run->guide = NULL;
    run->outlines = NULL;
    ty_free_array(run->context, run->lights, (size_t)run->view.lights.count, sizeof *run->lights);
    ty_free_array(run->context, run->items, (size_t)run->item_count, sizeof *run->items);
    ty_free_array(run->context, run->aov_sums, (size_t)run->item_count, sizeof *run->aov_sums);
    ty_free_array(run->context, run->halves, (size_t)run->item_count, sizeof *run->halves);
    run->lights = NULL;
    run->items = NULL;
    run->aov_sums = NULL;
    run->halves = NULL;
}

double ty_path_item_mean(const ty_path_item* item, int channel) {
    return item->count > 0 ? item->sums.mean[channel] / item->count : 0;
}

double ty_path_item_variance(const ty_path_item* item, int channel) {
    if (item->count < 2) return 0;
    const double n = item->count, mean = item->sums.mean[channel] / n;
    const double variance = (item->sums.square[channel] - n * mean * mean) / (n - 1);
    return variance > 0 ? variance / n : 0;
}
