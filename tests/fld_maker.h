/* Shared by tests of flux-limited diffusion: small scenes, and solves of a few cells. */
#ifndef TY_TESTS_FLD_MAKER_H
#define TY_TESTS_FLD_MAKER_H

#include "fog.h"

static inline ty_fld_def small_fld(void) {
    ty_fld_def def = ty_default_fld_def();
    def.resolution = 12;
    def.ratio = 2;
    def.width = WIDTH;
    def.height = HEIGHT;
    def.environment_beams = 4;
    return def;
}

static inline void check_result(ty_context* context, ty_result result) {
    if (result != TY_OK) fail_msg("%s: %s", ty_result_name(result), ty_take_error(context));
}

static inline void add_medium(ty_scene* scene, const ty_medium_def* def) {
    check_result(ty_scene_context(scene), ty_scene_add_medium(scene, def));
}

static inline void add_light(ty_scene* scene, const ty_light_def* def) {
    check_result(ty_scene_context(scene), ty_scene_add_light(scene, def));
}

static inline void commit(ty_scene* scene) {
    check_result(ty_scene_context(scene), ty_scene_commit(scene));
}

/* A block of fog, 2 m x 1.5 m x 1 m, that scatters red least and blue most; to be lit and committed. */
static inline ty_medium_def colored_block(void) {
    static const double lower[3] = {-1, -0.75, -0.5}, upper[3] = {1, 0.75, 0.5};
    ty_medium_def medium = box_medium(lower, upper, 0, 0);
    set3f(medium.sigma_s, 1, 3, 8);
    set3f(medium.sigma_a, 0.1f, 0.5f, 0.2f);
    set3f(medium.g, 0.2f, 0.5f, 0.7f);
    return medium;
}

static inline ty_light_def sun_light(float red, float green, float blue) {
    ty_light_def sun = ty_default_light_def();
    set3(sun.direction, -1, -2, -0.5);
    set3f(sun.color, red, green, blue);
    return sun;
}

static inline ty_light_def point_light(double x, double y, double z, float red, float green, float blue) {
    ty_light_def lamp = ty_default_light_def();
    lamp.kind = TY_LIGHT_POINT;
    set3(lamp.position, x, y, z);
    set3f(lamp.color, red, green, blue);
    return lamp;
}

static inline ty_fld* solve(const ty_scene* scene, const ty_fld_def* def, ty_fld_stats* stats) {
    ty_fld* light = NULL;
    check_result(ty_scene_context(scene), ty_fld_solve(scene, def, &light, stats));
    return light;
}

enum { SIDE = 6, CELLS = SIDE * SIDE * SIDE };

/* Light on cells of a box a little larger than the fog's. */
typedef struct cell_light {
    double fluence[3 * CELLS], beam[3 * CELLS], flux[9 * CELLS];
} cell_light;

static inline void look_up(const ty_fld* light, cell_light* out) {
    static const double lower[3] = {-1.1, -1, -0.8}, upper[3] = {1.1, 1.1, 0.7};
    static const int32_t size[3] = {SIDE, SIDE, SIDE};
    assert_int_equal(ty_fld_fluence(light, lower, upper, size, out->fluence, out->beam, out->flux), TY_OK);
}

static inline void solve_cells(const ty_scene* scene, const ty_fld_def* def, cell_light* out, ty_fld_stats* stats) {
    ty_fld* light = solve(scene, def, stats);
    look_up(light, out);
    ty_fld_destroy(light);
}

#endif
