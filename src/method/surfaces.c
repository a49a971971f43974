/* Surfaces by path tracing, for methods that compute light in media alone, with media inside dielectrics, whose light
 * is solved before. */
#include "method/method.h"

#include "base/context.h"
#include "base/progress.h"
#include "solve/enclosed/enclosed.h"

typedef struct surface_light {
    const ty_scene* scene;
    const ty_path_def* def;
} surface_light;

/* Radiance of surfaces around a dielectric, by one path per ray. */
static ty_result find_radiance(void* user, const ty_enclosed_field* fields, const double* rays, int64_t count,
                               double* radiance) {
    const surface_light* light = user;
    ty_path_def def = *light->def;
    def.enclosed = fields;
    def.spp = 1;
    def.seconds = def.error = 0;
    def.progress = NULL;
    return ty_path_radiance(light->scene, &def, rays, count, radiance, NULL);
}

static ty_result solve_enclosed(const ty_scene* scene, const ty_path_def* def, bool diffusion, ty_enclosed** out,
                                ty_enclosed_stats* stats) {
    surface_light light = {scene, def};
    ty_enclosed_def enclosed = ty_default_enclosed_def();
    enclosed.diffusion = diffusion;
    enclosed.seed = def->seed;
    enclosed.radiance = find_radiance;
    enclosed.user = &light;
    return ty_enclosed_solve(scene, &enclosed, out, stats);
}

ty_result ty_trace_surfaces(const ty_scene* scene, const ty_render_request* request, bool diffusion, ty_image** out,
                            ty_method_run* run) {
    const ty_scene_info info = ty_scene_get_info(scene);
    if (info.shapes == 0 && info.meshes == 0) return TY_OK;
    ty_path_def def;
    ty_enclosed* enclosed = NULL;
    ty_enclosed_stats stats = {.interiors = 0};
    ty_result result = ty_request_path_def(scene, request, &def);
    if (result != TY_OK) return result;
    def.aovs = 0;
    def.state = NULL;
    def.partial = NULL;
    def.resume = NULL;
    def.resume_size = 0;
    result = solve_enclosed(scene, &def, diffusion, &enclosed, &stats);
    if (result == TY_OK) {
        def.unscattered = true;
        def.enclosed = ty_enclosed_fields(enclosed);
        run->path = ty_default_path_stats();
        result = ty_path_render(scene, &def, out, &run->path);
    }
    ty_enclosed_destroy(enclosed);
    if (result != TY_CANCELLED) return result;
    ty_image_destroy(*out);
    *out = NULL;
    return result;
}
