/* The air and the haze of a sky as media: aerial perspective. */
#include "base/context.h"
#include "scene/lights/atmosphere.h"

#include <tyndall/scene.h>

/* Fills the box with a constituent of which density and phase are given, and releases the grid. */
static ty_result add_constituent(ty_scene* scene, ty_medium_def* def, double scale_height, int32_t axis) {
    ty_grid* grid = NULL;
    ty_result result = ty_grid_create_exponential(ty_scene_context(scene), axis, 0,
                                                  def->box_max[axis] - def->box_min[axis], scale_height, &grid);
    def->density_grid = grid;
    def->phase_count = 1;
    if (result == TY_OK) result = ty_scene_add_medium(scene, def);
    ty_grid_release(grid);
    return result;
}

ty_result ty_scene_add_sky_air(ty_scene* scene, const ty_sky_def* sky, const double box_min[3],
                               const double box_max[3]) {
    ty_context* context = scene != NULL ? ty_scene_context(scene) : NULL;
    if (scene == NULL || box_min == NULL || box_max == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_scene_add_sky_air: a pointer is NULL");
    ty_sky_def own = ty_default_sky_def();
    ty_result result = ty_take_def(context, sky, "ty_default_sky_def", &own, sizeof own);
    if (result != TY_OK) return result;
    const int32_t axis = ty_scene_up_axis(scene) == TY_AXIS_Y ? 1 : 2;
    if (!(own.haze >= 0 && own.haze <= 10))
        return ty_fail(context, TY_ERROR_ARGUMENT, "sky.haze: %g is outside [0, 10]", own.haze);
    const double height = box_max[axis] - box_min[axis];
    if (!(height >= ty_observer_height && height <= TY_SKY_HEIGHT_MAX))
        return ty_fail(context, TY_ERROR_ARGUMENT, "air: its box is %g m high, outside [%g, %d]", height,
                       ty_observer_height, TY_SKY_HEIGHT_MAX);
    ty_medium_def air = ty_default_medium_def();
    air.bounds = TY_BOUNDS_BOX;
    for (int a = 0; a < 3; ++a) {
        air.box_min[a] = box_min[a];
        air.box_max[a] = box_max[a];
    }
    ty_medium_def haze = air;
    air.name = "air";
    air.phase[0] = (ty_phase_lobe){.kind = TY_PHASE_DRAINE, .weight = {1, 1, 1}, .alpha = 1};
    haze.name = "haze";
    haze.phase[0] = (ty_phase_lobe){.kind = TY_PHASE_DRAINE, .weight = {1, 1, 1}, .g = ty_haze_g, .alpha = 1};
    for (int c = 0; c < 3; ++c) {
        air.sigma_s[c] = (float)ty_air_scattering[c];
        haze.sigma_s[c] = (float)(own.haze * ty_haze_scattering);
        haze.sigma_a[c] = (float)(own.haze * (ty_haze_extinction - ty_haze_scattering));
    }
    result = add_constituent(scene, &air, ty_air_scale, axis);
    return result == TY_OK && own.haze > 0 ? add_constituent(scene, &haze, ty_haze_scale, axis) : result;
}
