/* Rooms of fog by fld and pop, whose diffusion surfaces enclose. */
#include "mean_fluence.h"

#include <stdio.h>

/* A closed room [-1, 1]^3 of an albedo within fog that reaches 3 m from its middle if `around`, else fills it. */
static ty_scene* room(ty_context* context, double albedo, double g, bool around, const ty_light_def* light) {
    ty_scene* scene = new_scene(context);
    const ty_medium_def fog = medium_cube(around ? 3 : 1, 0.8, 0.1, g);
    ty_shape_def walls = ty_default_shape_def();
    walls.kind = TY_SHAPE_BOX;
    set3(walls.origin, -1, -1, -1);
    set3(walls.u, 1, 1, 1);
    gray(walls.albedo, albedo);
    add_medium(scene, &fog);
    add_shape(scene, &walls);
    add_light(scene, light);
    commit(scene);
    return scene;
}

static const double half = 0.9; /* of the cube whose fluence is compared, m */

static double fld_fluence(const ty_scene* scene) {
    ty_fld_def def = ty_default_fld_def();
    def.resolution = 24;
    return fld_mean_fluence(scene, &def, half);
}

static double pop_fluence(const ty_scene* scene) {
    ty_pop_def def = ty_default_pop_def();
    def.resolution = 12;
    def.merged = 12;
    def.ordinates = 8;
    return pop_mean_fluence(scene, &def, half);
}

static double dom_fluence(const ty_scene* scene) {
    ty_dom_def def = ty_default_dom_def();
    def.resolution = 12;
    def.directions = 48;
    return dom_mean_fluence(scene, &def, half);
}

static ty_light_def lamp(void) {
    ty_light_def light = light_of(TY_LIGHT_POINT, 1);
    set3(light.position, 0.2, 0.1, -0.3);
    return light;
}

/* Means of the fluence in a lamp's room, relative to discrete ordinates. */
static void rooms_are_as_bright_as_by_ordinates(void** state) {
    static const double albedo[] = {0, 0.5, 0.9, 0.8}, g[] = {0, 0, 0, 0.6};
    for (int i = 0; i < 4; ++i) {
        const ty_light_def light = lamp();
        ty_scene* scene = room(*state, albedo[i], g[i], false, &light);
        const double truth = dom_fluence(scene), fld = fld_fluence(scene) / truth, pop = pop_fluence(scene) / truth;
        printf("albedo %g, g %g: fld %.3f, pop %.3f of dom\n", albedo[i], g[i], fld, pop);
        ty_scene_destroy(scene);
        assert_true(fabs(fld - 1) < 0.1);
        assert_true(fabs(pop - 1) < 0.1);
    }
}

/* The fluence inside of a closed room in the sun and under a sky, relative to that without the room. */
static void closed_rooms_are_dark(void** state) {
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 1);
    set3(sun.direction, -0.3, -1, -0.4);
    ty_scene* scene = room(*state, 0.7, 0.3, true, &sun);
    const double fld = fld_fluence(scene), pop = pop_fluence(scene);
    printf("behind walls in the sun: fld %.2g, pop %.2g\n", fld, pop);
    ty_scene_destroy(scene);
    assert_true(fld < 5e-3);
    assert_true(pop < 5e-3);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(rooms_are_as_bright_as_by_ordinates),
                                       cmocka_unit_test(closed_rooms_are_dark)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
