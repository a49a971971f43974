/* Interreflection of media with the surfaces outside of their box. */
#include "mean_fluence.h"

#include <stdio.h>

/* ---- a white furnace ---- */

/* A wall of the room [-1.5, 1.5]^3 across an axis, which emits inwards. */
static void add_wall(ty_scene* scene, int axis, double side) {
    ty_shape_def wall = ty_default_shape_def();
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    wall.kind = TY_SHAPE_QUAD;
    wall.origin[axis] = side;
    wall.origin[b] = wall.origin[c] = -1.5;
    wall.u[side < 0 ? b : c] = 3;
    wall.v[side < 0 ? c : b] = 3;
    gray(wall.albedo, 0.6);
    gray(wall.emission, 1);
    add_shape(scene, &wall);
}

/* Glowing walls around a cube of 1 m that absorbs nothing. */
static ty_scene* furnace(ty_context* context) {
    ty_scene* scene = new_scene(context);
    const ty_medium_def fog = medium_cube(0.5, 8, 0, 0.3);
    add_medium(scene, &fog);
    for (int axis = 0; axis < 3; ++axis) {
        add_wall(scene, axis, -1.5);
        add_wall(scene, axis, 1.5);
    }
    commit(scene);
    return scene;
}

enum { LAMP_POINTS = 36 };
static const double half = 0.5; /* of the cube, m */

static double fld_fluence(const ty_scene* scene, bool interreflection) {
    ty_fld_def def = ty_default_fld_def();
    def.resolution = 24;
    def.surface_points = LAMP_POINTS;
    def.interreflection = interreflection;
    return fld_mean_fluence(scene, &def, half);
}

static double pop_fluence(const ty_scene* scene, bool interreflection) {
    ty_pop_def def = ty_default_pop_def();
    def.resolution = 8;
    def.merged = 8;
    def.surface_points = 9;
    def.interreflection = interreflection;
    return pop_mean_fluence(scene, &def, half);
}

static double dom_fluence(const ty_scene* scene, bool interreflection) {
    ty_dom_def def = ty_default_dom_def();
    def.resolution = 12;
    def.direct = 12;
    def.directions = 48;
    def.surface_points = LAMP_POINTS;
    def.interreflection = interreflection;
    return dom_mean_fluence(scene, &def, half);
}

/* In a closed room whose walls emit e and reflect a the radiance is e / (1 - a), also in a medium that absorbs nothing.
 * Without the light that the medium sends to the walls and back there is less. Walls are lit by few points of one
 * another, which are lights: with 100 of them fld has 0.952 and dom 0.982. */
static void furnaces_are_even(void** state) {
    static const struct {
        const char* name;
        double (*fluence)(const ty_scene* scene, bool interreflection);
        double measured;
    } methods[] = {{"fld", fld_fluence, 0.927}, {"pop", pop_fluence, 1.024}, {"dom", dom_fluence, 0.947}};
    const double expected = 4 * pi * 1 / (1 - 0.6);
    ty_scene* scene = furnace(*state);
    for (int i = 0; i < 3; ++i) {
        const double all = methods[i].fluence(scene, true) / expected;
        const double without = methods[i].fluence(scene, false) / expected;
        printf("%s: %.3f of the light, %.3f without interreflection\n", methods[i].name, all, without);
        assert_true(fabs(all - methods[i].measured) < 0.03);
        assert_true(all - without > 0.1);
    }
    ty_scene_destroy(scene);
}

/* ---- light gathered by a floor ---- */

/* Relative difference of the pixels of a floor below glowing fog from the mean of those beside them. */
static double grain(const ty_scene* scene) {
    enum { WIDTH = 64, HEIGHT = 24 };
    ty_context* context = ty_scene_context(scene);
    ty_fld_def def = ty_default_fld_def();
    ty_image* image = NULL;
    double difference = 0, sum = 0;
    def.resolution = 24;
    def.width = WIDTH;
    def.height = HEIGHT;
    must(context, ty_fld_render(scene, &def, &image, NULL));
    const float* plane = ty_image_plane_const(image, 0);
    for (int i = 1; i + 1 < WIDTH * HEIGHT; ++i) {
        if (i % WIDTH == 0 || i % WIDTH == WIDTH - 1) continue;
        difference += fabs(0.5 * ((double)plane[i - 1] + (double)plane[i + 1]) - (double)plane[i]);
        sum += (double)plane[i];
    }
    assert_true(sum > 0);
    ty_image_destroy(image);
    return difference / sum;
}

static void floors_are_smooth(void** state) {
    ty_scene* scene = new_scene(*state);
    ty_medium_def fog = medium_cube(0.5, 3, 1, 0);
    ty_shape_def floor_quad = ty_default_shape_def();
    floor_quad.kind = TY_SHAPE_QUAD;
    set3(floor_quad.origin, -20, -2, 20);
    set3(floor_quad.u, 40, 0, 0);
    set3(floor_quad.v, 0, 0, -40);
    gray(floor_quad.albedo, 0.5);
    gray(fog.emission, 1);
    add_medium(scene, &fog);
    add_shape(scene, &floor_quad);
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, 0, 2, 6);
    set3(camera.target, 0, -2, 0.5);
    camera.fov_y = 20;
    must(*state, ty_scene_set_camera(scene, &camera));
    commit(scene);
    const double found = grain(scene);
    printf("pixels of a floor differ from those beside them by %.4f of their light\n", found);
    assert_true(found < 0.005); /* 0.07 where each pixel gathers for itself */
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(furnaces_are_even),
        cmocka_unit_test(floors_are_smooth),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
