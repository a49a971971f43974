/* Light propagation volumes with scattering as a method, which shades surfaces itself. */
#include "method/lpv/lpv_method.h"

#include "image/march/march.h"
#include "method/lpv/job.h"
#include "method/method.h"
#include "scene/camera.h"

#include <stdio.h>

_Static_assert(sizeof(ty_lpv_stats) <= TY_METHOD_STATS_MAX, "ty_method_run holds the stats");

static const ty_stat stats[] = {
    {.name = "lattices",
     .offset = offsetof(ty_lpv_stats, size),
     TY_STAT_LATTICES,
     .count = TY_LPV_CASCADES_MAX,
     .second_offset = offsetof(ty_lpv_stats, cell)},
    {TY_STAT_FIELD(ty_lpv_stats, iterations), TY_STAT_INT},
    {TY_STAT_FIELD(ty_lpv_stats, reflected), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_lpv_stats, scattered), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_lpv_stats, emitted), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_lpv_stats, absorbed), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_lpv_stats, blocked), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_lpv_stats, escaped), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_lpv_stats, left), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_lpv_stats, medium_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_lpv_stats, map_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_lpv_stats, shadow_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_lpv_stats, reflected_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_lpv_stats, scattered_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_lpv_stats, blocker_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_lpv_stats, prepare_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_lpv_stats, propagate_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_lpv_stats, gather_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_lpv_stats, view_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_lpv_stats, surface_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_lpv_stats, march_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_lpv_stats, single_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_lpv_stats, compose_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_lpv_stats, rays), TY_STAT_LONG},
    {TY_STAT_FIELD(ty_lpv_stats, ray_seconds), TY_STAT_NUMBER},
    {TY_STAT_FIELD(ty_lpv_stats, isa), TY_STAT_TEXT},
};

double ty_lpv_injection_seconds(const ty_lpv_stats* lpv) {
    return lpv->map_seconds + lpv->reflected_seconds + lpv->scattered_seconds + lpv->blocker_seconds;
}

double ty_lpv_propagation_seconds(const ty_lpv_stats* lpv) {
    return lpv->prepare_seconds + lpv->propagate_seconds + lpv->gather_seconds;
}

double ty_lpv_image_seconds(const ty_lpv_stats* lpv) {
    return lpv->view_seconds + lpv->surface_seconds + lpv->march_seconds + lpv->single_seconds + lpv->compose_seconds;
}

static ty_result make_def(const ty_scene* scene, const ty_render_request* request, ty_lpv_def* def) {
    *def = ty_default_lpv_def();
    const ty_result result = ty_method_options(scene, "lpv", def);
    TY_TAKE_REQUEST(def, request);
    return result;
}

static ty_result render(const ty_scene* scene, const ty_render_request* request, ty_image** out, ty_method_run* run) {
    ty_lpv_stats* lpv = ty_method_stats(run, sizeof *lpv);
    ty_lpv_def def;
    ty_result result = make_def(scene, request, &def);
    if (result == TY_OK) result = ty_lpv_render(scene, &def, out, lpv);
    run->own_seconds = run->path.seconds = lpv->seconds;
    return result;
}

static void coarsen(ty_lpv_def* def, ty_solve_quality quality) {
    ty_lower_option(&def->resolution, ty_coarse_bound(quality, 16));
    ty_lower_option(&def->map_side, ty_coarse_bound(quality, 128));
    ty_lower_option(&def->shadow_side, ty_coarse_bound(quality, 256));
    ty_lower_option(&def->samples, 4);
    ty_lower_option(&def->light_samples, 4);
    def->tolerance = fmax(def->tolerance, 0.03);
}

static ty_result solve(const ty_scene* scene, const ty_render_request* request, ty_solve_quality quality, void** light,
                       ty_method_run* run) {
    ty_lpv_stats* lpv = ty_method_stats(run, sizeof *lpv);
    ty_lpv_def def;
    ty_lpv* solved = NULL;
    ty_result result = make_def(scene, request, &def);
    if (quality != TY_SOLVE_FULL) coarsen(&def, quality);
    if (result == TY_OK) result = ty_lpv_solve(scene, &def, &solved, lpv);
    *light = solved;
    return result;
}

static ty_result view(const void* light, const ty_scene* scene, const ty_render_request* request,
                      const ty_image* unscattered, ty_image** out, ty_method_run* run) {
    (void)unscattered;
    *out = NULL;
    ty_lpv_stats* lpv = ty_method_stats(run, sizeof *lpv);
    ty_lpv_def def;
    const ty_result result = make_def(scene, request, &def);
    return result == TY_OK ? ty_lpv_view(light, scene, &def, out, lpv) : result;
}

static void destroy(void* light) {
    ty_lpv_destroy(light);
}

static ty_result check(const ty_scene* scene) {
    const ty_camera_def camera = ty_scene_camera(scene);
    return ty_camera_check_pinhole(ty_scene_context(scene), &camera, "lpv");
}

static bool follows_camera(const ty_scene* scene) {
    ty_lpv_def def = ty_default_lpv_def();
    return ty_method_options(scene, "lpv", &def) == TY_OK && def.place == TY_LPV_PLACE_CAMERA;
}

static void describe(const ty_method_run* run, char* text, size_t size) {
    const ty_lpv_stats* lpv = (const ty_lpv_stats*)run->stats;
    const int32_t* cells = lpv->size[0];
    snprintf(text, size,
             "%dx%dx%d cells of %.3g m, %d iterations, %.3f s (injection %.3f, propagation %.3f, image %.3f)", cells[0],
             cells[1], cells[2], lpv->cell[0], lpv->iterations, run->own_seconds, ty_lpv_injection_seconds(lpv),
             ty_lpv_propagation_seconds(lpv), ty_lpv_image_seconds(lpv));
}

const ty_method ty_method_lpv = {.name = "lpv",
                                 .summary = "light propagation volumes with scattering",
                                 .options = &ty_lpv_options,
                                 .aovs = TY_MARCH_AOVS | TY_AOV_NORMAL | TY_AOV_SAMPLES,
                                 .stats = stats,
                                 .stat_count = sizeof stats / sizeof stats[0],
                                 .check = check,
                                 .render = render,
                                 .solve = solve,
                                 .view = view,
                                 .destroy = destroy,
                                 .follows_camera = follows_camera,
                                 .of_interiors = TY_LPV_OF_INTERIORS,
                                 .describe = describe};
