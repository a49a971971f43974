#include "method/path/enclosed_light.h"

typedef struct surface_light {
    const ty_scene* scene;
    const ty_path_def* path;
} surface_light;

/* Radiance of surfaces around a dielectric, by one path per ray. */
static ty_result find_radiance(void* user, const ty_enclosed_field* fields, const double* rays, int64_t count,
                               double* radiance) {
    const surface_light* light = user;
    ty_path_def def = ty_default_path_def();
    def.enclosed = fields;
    def.spp = 1;
    def.seed = light->path->seed;
    def.max_depth = light->path->max_depth;
    def.energy_compensation = light->path->energy_compensation;
    return ty_path_radiance(light->scene, &def, rays, count, radiance, NULL);
}

ty_result ty_path_solve_enclosed(const ty_scene* scene, const ty_path_def* path, const ty_enclosed_def* def,
                                 ty_enclosed** out, ty_enclosed_stats* stats) {
    surface_light light = {scene, path};
    ty_enclosed_def with_surfaces = *def;
    with_surfaces.seed = path->seed;
    with_surfaces.radiance = find_radiance;
    with_surfaces.user = &light;
    return ty_enclosed_solve(scene, &with_surfaces, out, stats);
}
