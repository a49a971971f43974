/* Scenes: what is refused and in which words, what is copied, committing, reports. */
#include "checks.h"

#include "scene/scene.h"

#include <stddef.h>
#include <stdio.h>

static void refuse(ty_context* context, ty_result result, const char* words) {
    assert_int_equal(result, TY_ERROR_ARGUMENT);
    assert_error(context, words);
}

static void wrong_up_axes_are_refused(void** state) {
    ty_scene* scene = NULL;
    refuse(*state, ty_scene_create(*state, (ty_axis)0, &scene), "up_axis: 0");
    refuse(*state, ty_scene_create(*state, (ty_axis)3, &scene), "up_axis: 3");
    assert_null(scene);
}

#define CAMERA(field, type, value, words)                                                                              \
    { offsetof(ty_camera_def, field), type, value, words }

static void wrong_cameras_are_refused(void** state) {
    static const bad_field bad[] = {
        CAMERA(cookie, FIELD_INT, 0, "ty_default_camera_def"),
        CAMERA(position[1], FIELD_DOUBLE, NAN, "camera.position[1]"),
        CAMERA(position[2], FIELD_DOUBLE, 1e16, "outside [-1e15, 1e15]"),
        CAMERA(target[2], FIELD_DOUBLE, INFINITY, "camera.target[2]"),
        CAMERA(target[2], FIELD_DOUBLE, 5, "camera.target: it is where the camera is"),
        CAMERA(up[1], FIELD_DOUBLE, 0, "camera.up"),
        CAMERA(up[2], FIELD_DOUBLE, NAN, "camera.up"),
        CAMERA(up[2], FIELD_DOUBLE, 1e9, "camera.up: it is along the view"),
        CAMERA(fov_y, FIELD_DOUBLE, 0, "camera.fov_y: 0 is outside (0, 180)"),
        CAMERA(fov_y, FIELD_DOUBLE, 180, "camera.fov_y: 180"),
        CAMERA(fov_y, FIELD_DOUBLE, NAN, "camera.fov_y"),
        CAMERA(resolution[0], FIELD_INT, 0, "camera.resolution[0]: 0 is outside [1, 65536]"),
        CAMERA(resolution[1], FIELD_INT, 65537, "camera.resolution[1]: 65537"),
        CAMERA(exposure, FIELD_DOUBLE, INFINITY, "camera.exposure"),
        CAMERA(shift[1], FIELD_DOUBLE, 101, "camera.shift[1]: 101"),
        CAMERA(aperture_radius, FIELD_DOUBLE, -1, "camera.aperture_radius: -1"),
        CAMERA(focus_distance, FIELD_DOUBLE, NAN, "camera.focus_distance"),
    };
    ty_scene* scene = make_scene(*state);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        ty_camera_def def = ty_default_camera_def();
        set_field(&def, &bad[i]);
        refuse(*state, ty_scene_set_camera(scene, &def), bad[i].words);
    }
    refuse(*state, ty_scene_set_camera(scene, NULL), "ty_default_camera_def");
    assert_close(ty_scene_camera(scene).fov_y, 40, 0);
    ty_scene_destroy(scene);
}

#define MEDIUM(field, type, value, words)                                                                              \
    { offsetof(ty_medium_def, field), type, value, words }

static ty_medium_def unit_box_medium(void) {
    const double lower[3] = {0, 0, 0}, upper[3] = {1, 1, 1};
    return box_medium(lower, upper, 1, 1);
}

static void refuse_media(ty_context* context, const ty_medium_def* good, const bad_field* bad, size_t count) {
    ty_scene* scene = make_scene(context);
    for (size_t i = 0; i < count; ++i) {
        ty_medium_def def = *good;
        set_field(&def, &bad[i]);
        refuse(context, ty_scene_add_medium(scene, &def), bad[i].words);
    }
    assert_int_equal(ty_scene_get_info(scene).media, 0);
    ty_scene_destroy(scene);
}

static void wrong_media_are_refused(void** state) {
    static const bad_field bad[] = {
        MEDIUM(cookie, FIELD_INT, 0, "ty_default_medium_def"),
        MEDIUM(bounds, FIELD_INT, 0, "a homogeneous medium needs bounds"),
        MEDIUM(bounds, FIELD_INT, 7, "medium.bounds: 7"),
        MEDIUM(box_min[0], FIELD_DOUBLE, 1, "above its lower in x"),
        MEDIUM(box_max[2], FIELD_DOUBLE, -1, "above its lower in z"),
        MEDIUM(box_max[1], FIELD_DOUBLE, NAN, "medium.box_max[1]"),
        MEDIUM(box_min[1], FIELD_DOUBLE, -1e16, "medium.box_min[1]"),
        MEDIUM(transform.m[0], FIELD_DOUBLE, 0, "medium.transform"),
        MEDIUM(transform.m[3], FIELD_DOUBLE, NAN, "medium.transform"),
        MEDIUM(transform.m[7], FIELD_DOUBLE, INFINITY, "medium.transform"),
        MEDIUM(sigma_s[1], FIELD_FLOAT, -1, "medium.sigma_s[1]: -1 is outside [0,"),
        MEDIUM(sigma_a[2], FIELD_FLOAT, NAN, "medium.sigma_a[2]"),
        MEDIUM(sigma_a[0], FIELD_FLOAT, INFINITY, "medium.sigma_a[0]"),
        MEDIUM(scale, FIELD_FLOAT, -0.5, "medium.scale: -0.5"),
        MEDIUM(g[0], FIELD_FLOAT, 1, "medium.g[0]: 1 is outside (-1, 1)"),
        MEDIUM(g[2], FIELD_FLOAT, -1, "medium.g[2]: -1"),
        MEDIUM(g[1], FIELD_FLOAT, NAN, "medium.g[1]"),
    };
    static const bad_field bad_sphere[] = {
        MEDIUM(sphere_radius, FIELD_DOUBLE, 0, "medium.sphere_radius: 0"),
        MEDIUM(sphere_radius, FIELD_DOUBLE, NAN, "medium.sphere_radius"),
        MEDIUM(sphere_radius, FIELD_DOUBLE, INFINITY, "medium.sphere_radius"),
        MEDIUM(sphere_center[0], FIELD_DOUBLE, NAN, "medium.sphere_center[0]"),
    };
    const ty_medium_def box = unit_box_medium();
    refuse_media(*state, &box, bad, sizeof bad / sizeof *bad);
    ty_medium_def sphere = box;
    sphere.bounds = TY_BOUNDS_SPHERE;
    sphere.sphere_radius = 1;
    refuse_media(*state, &sphere, bad_sphere, sizeof bad_sphere / sizeof *bad_sphere);
}

static ty_grid* small_grid(ty_context* context, bool placed) {
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = def.size[1] = def.size[2] = 2;
    def.placed = placed;
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    return grid;
}

static void grids_need_bounds_unless_placed(void** state) {
    ty_scene* scene = make_scene(*state);
    ty_grid *filling = small_grid(*state, false), *placed = small_grid(*state, true);
    ty_medium_def def = unit_box_medium();
    def.bounds = TY_BOUNDS_NONE;
    def.density_grid = filling;
    refuse(*state, ty_scene_add_medium(scene, &def), "a grid without a transform needs bounds");
    def.bounds = TY_BOUNDS_SPHERE;
    def.sphere_radius = 1;
    refuse(*state, ty_scene_add_medium(scene, &def), "fills a box, not a sphere");
    def.density_grid = placed;
    assert_int_equal(ty_scene_add_medium(scene, &def), TY_OK);
    def.bounds = TY_BOUNDS_NONE;
    assert_int_equal(ty_scene_add_medium(scene, &def), TY_OK);
    ty_grid_release(filling);
    ty_grid_release(placed);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_scene_destroy(scene);
}

#define LIGHT(field, type, value, words)                                                                               \
    { offsetof(ty_light_def, field), type, value, words }

static void refuse_lights(ty_context* context, ty_light_kind kind, const bad_field* bad, size_t count) {
    ty_scene* scene = make_scene(context);
    for (size_t i = 0; i < count; ++i) {
        ty_light_def def = ty_default_light_def();
        def.kind = kind;
        set3(def.u, 1, 0, 0);
        set3(def.v, 0, 0, 1);
        set_field(&def, &bad[i]);
        refuse(context, ty_scene_add_light(scene, &def), bad[i].words);
    }
    assert_int_equal(ty_scene_get_info(scene).lights, 0);
    ty_scene_destroy(scene);
}

static void wrong_lights_are_refused(void** state) {
    static const bad_field directional[] = {
        LIGHT(cookie, FIELD_INT, 0, "ty_default_light_def"),
        LIGHT(kind, FIELD_INT, 5, "light.kind: 5"),
        LIGHT(color[1], FIELD_FLOAT, -1, "light.color[1]: -1 is outside [0,"),
        LIGHT(color[2], FIELD_FLOAT, NAN, "light.color[2]"),
        LIGHT(color[0], FIELD_FLOAT, INFINITY, "light.color[0]"),
        LIGHT(direction[1], FIELD_DOUBLE, 0, "light.direction"),
        LIGHT(direction[0], FIELD_DOUBLE, INFINITY, "light.direction"),
    };
    static const bad_field point[] = {LIGHT(position[2], FIELD_DOUBLE, NAN, "light.position[2]"),
                                      LIGHT(radius, FIELD_DOUBLE, -1, "light.radius: -1 is outside [0,")};
    static const bad_field spot[] = {
        LIGHT(position[0], FIELD_DOUBLE, INFINITY, "light.position[0]"),
        LIGHT(direction[1], FIELD_DOUBLE, 0, "light.direction"),
        LIGHT(cone, FIELD_DOUBLE, 0, "light.cone: 0 is outside (0, 180]"),
        LIGHT(cone, FIELD_DOUBLE, 181, "light.cone: 181"),
        LIGHT(penumbra, FIELD_DOUBLE, -0.1, "light.penumbra: -0.1 is outside [0, 1]"),
        LIGHT(penumbra, FIELD_DOUBLE, 1.5, "light.penumbra"),
    };
    static const bad_field area[] = {
        LIGHT(position[1], FIELD_DOUBLE, NAN, "light.position[1]"),
        LIGHT(u[0], FIELD_DOUBLE, 0, "u and v span no area"),
        LIGHT(v[2], FIELD_DOUBLE, NAN, "light: the edges u and v"),
        LIGHT(u[0], FIELD_DOUBLE, 1e16, "outside [-1e15, 1e15]"),
    };
    static const bad_field environment[] = {
        LIGHT(scale, FIELD_FLOAT, -1, "light.scale: -1"),
        LIGHT(scale, FIELD_FLOAT, NAN, "light.scale"),
        LIGHT(rotation, FIELD_DOUBLE, INFINITY, "light.rotation"),
    };
    refuse_lights(*state, TY_LIGHT_DIRECTIONAL, directional, sizeof directional / sizeof *directional);
    refuse_lights(*state, TY_LIGHT_POINT, point, sizeof point / sizeof *point);
    refuse_lights(*state, TY_LIGHT_SPOT, spot, sizeof spot / sizeof *spot);
    refuse_lights(*state, TY_LIGHT_AREA, area, sizeof area / sizeof *area);
    refuse_lights(*state, TY_LIGHT_ENVIRONMENT, environment, sizeof environment / sizeof *environment);
}

static void environments_need_colour(void** state) {
    static const char* const names[] = {"R", "depth.Z"};
    ty_image* image = NULL;
    assert_int_equal(ty_image_create(*state, 4, 2, 2, names, &image), TY_OK);
    ty_scene* scene = make_scene(*state);
    ty_light_def def = ty_default_light_def();
    def.kind = TY_LIGHT_ENVIRONMENT;
    def.image = image;
    refuse(*state, ty_scene_add_light(scene, &def), "no R, G and B");
    ty_scene_destroy(scene);
    ty_image_destroy(image);
}

#define SHAPE(field, type, value, words)                                                                               \
    { offsetof(ty_shape_def, field), type, value, words }

static void refuse_shapes(ty_context* context, ty_shape_kind kind, const bad_field* bad, size_t count) {
    ty_scene* scene = make_scene(context);
    for (size_t i = 0; i < count; ++i) {
        ty_shape_def def = ty_default_shape_def();
        def.kind = kind;
        set3(def.u, 1, kind == TY_SHAPE_BOX, kind == TY_SHAPE_BOX);
        set3(def.v, 0, 0, 1);
        def.radius = 1;
        set_field(&def, &bad[i]);
        refuse(context, ty_scene_add_shape(scene, &def), bad[i].words);
    }
    assert_int_equal(ty_scene_get_info(scene).shapes, 0);
    ty_scene_destroy(scene);
}

static void wrong_shapes_are_refused(void** state) {
    static const bad_field quad[] = {
        SHAPE(cookie, FIELD_INT, 0, "ty_default_shape_def"),
        SHAPE(kind, FIELD_INT, 3, "shape.kind: 3"),
        SHAPE(origin[0], FIELD_DOUBLE, NAN, "shape.origin[0]"),
        SHAPE(u[0], FIELD_DOUBLE, 0, "u and v span no area"),
        SHAPE(v[2], FIELD_DOUBLE, INFINITY, "shape: the edges u and v"),
        SHAPE(transform.m[10], FIELD_DOUBLE, 0, "shape.transform"),
        SHAPE(transform.m[11], FIELD_DOUBLE, NAN, "shape.transform"),
        SHAPE(albedo[0], FIELD_FLOAT, 1.01, "shape.albedo[0]: 1.01 is outside [0, 1]"),
        SHAPE(albedo[1], FIELD_FLOAT, -0.01, "shape.albedo[1]"),
        SHAPE(emission[2], FIELD_FLOAT, -1, "shape.emission[2]"),
        SHAPE(emission[0], FIELD_FLOAT, INFINITY, "shape.emission[0]"),
    };
    static const bad_field box[] = {
        SHAPE(u[0], FIELD_DOUBLE, 0, "above its lower in x"),
        SHAPE(u[2], FIELD_DOUBLE, -1, "above its lower in z"),
        SHAPE(u[1], FIELD_DOUBLE, INFINITY, "shape.u[1]"),
    };
    static const bad_field sphere[] = {
        SHAPE(radius, FIELD_DOUBLE, 0, "shape.radius: 0"),
        SHAPE(radius, FIELD_DOUBLE, NAN, "shape.radius"),
        SHAPE(radius, FIELD_DOUBLE, 1e16, "shape.radius"),
        SHAPE(transform.m[0], FIELD_DOUBLE, 2, "uniform scale only"),
        SHAPE(transform.m[1], FIELD_DOUBLE, 0.1, "uniform scale only"),
    };
    refuse_shapes(*state, TY_SHAPE_QUAD, quad, sizeof quad / sizeof *quad);
    refuse_shapes(*state, TY_SHAPE_BOX, box, sizeof box / sizeof *box);
    refuse_shapes(*state, TY_SHAPE_SPHERE, sphere, sizeof sphere / sizeof *sphere);
}

static void default_cameras_look_level(void** state) {
    ty_scene *y_up = make_scene(*state), *z_up = NULL;
    assert_int_equal(ty_scene_create(*state, TY_AXIS_Z, &z_up), TY_OK);
    assert_int_equal(ty_scene_up_axis(y_up), TY_AXIS_Y);
    assert_int_equal(ty_scene_up_axis(z_up), TY_AXIS_Z);
    assert_ptr_equal(ty_scene_context(z_up), *state);
    const ty_camera_def camera = ty_scene_camera(z_up);
    assert_int_equal(ty_scene_set_camera(z_up, &camera), TY_OK);
    assert_true(camera.position[2] == 0 && camera.up[2] == 1 && camera.up[1] == 0);
    ty_scene_destroy(y_up);
    ty_scene_destroy(z_up);
    ty_scene_destroy(NULL);
}

static void settings_and_hash_are_kept(void** state) {
    ty_scene* scene = make_scene(*state);
    ty_render_settings settings = ty_scene_render_settings(scene);
    assert_string_equal(settings.method, "auto");
    assert_int_equal(settings.spp, 64);
    assert_true(settings.seed == 0 && ty_scene_hash(scene) == 0);
    settings.seed = 7;
    ty_scene_set_render_settings(scene, &settings);
    ty_scene_set_hash(scene, 99);
    assert_int_equal(ty_scene_render_settings(scene).seed, 7);
    assert_int_equal(ty_scene_hash(scene), 99);
    ty_scene_destroy(scene);
}

static void media_are_copied(void** state) {
    ty_scene* scene = make_scene(*state);
    char name[] = "smoke";
    ty_medium_def def = unit_box_medium(), copy;
    def.name = name;
    def.density_grid = small_grid(*state, false);
    assert_int_equal(ty_scene_add_medium(scene, &def), TY_OK);
    ty_grid_release(def.density_grid);
    memset(name, 'x', sizeof name - 1);
    assert_int_equal(ty_scene_get_medium(scene, 0, &copy), TY_OK);
    assert_string_equal(copy.name, "smoke");
    assert_int_equal(ty_grid_get_info(copy.density_grid).size[0], 2);
    def.name = NULL;
    def.density_grid = NULL;
    assert_int_equal(ty_scene_add_medium(scene, &def), TY_OK);
    assert_int_equal(ty_scene_get_medium(scene, 1, &copy), TY_OK);
    assert_string_equal(copy.name, "");
    refuse(*state, ty_scene_get_medium(scene, 2, &copy), "no medium 2");
    refuse(*state, ty_scene_get_medium(scene, -1, &copy), "no medium -1");
    ty_scene_destroy(scene);
}

static void there_is_a_most_of_media(void** state) {
    ty_scene* scene = make_scene(*state);
    ty_medium_def def = unit_box_medium();
    for (int i = 0; i < TY_MEDIA_MAX; ++i) assert_int_equal(ty_scene_add_medium(scene, &def), TY_OK);
    char words[32];
    snprintf(words, sizeof words, "more than %d", (int)TY_MEDIA_MAX);
    refuse(*state, ty_scene_add_medium(scene, &def), words);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    assert_int_equal(ty_scene_get_view(scene)->medium_count, TY_MEDIA_MAX);
    ty_scene_destroy(scene);
}

static void assert_uncommitted(ty_scene* scene) {
    assert_null(ty_scene_get_view(scene));
    assert_error(ty_scene_context(scene), "not committed");
}

static void changes_need_another_commit(void** state) {
    ty_scene* scene = make_scene(*state);
    assert_uncommitted(scene);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    assert_non_null(ty_scene_get_view(scene));
    const ty_medium_def medium = unit_box_medium();
    assert_int_equal(ty_scene_add_medium(scene, &medium), TY_OK);
    assert_uncommitted(scene);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    const ty_light_def light = ty_default_light_def();
    assert_int_equal(ty_scene_add_light(scene, &light), TY_OK);
    assert_uncommitted(scene);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_shape_def shape = ty_default_shape_def();
    shape.kind = TY_SHAPE_SPHERE;
    shape.radius = 1;
    assert_int_equal(ty_scene_add_shape(scene, &shape), TY_OK);
    assert_uncommitted(scene);
    for (int i = 0; i < 2; ++i) assert_int_equal(ty_scene_commit(scene), TY_OK);
    const ty_scene_view* view = ty_scene_get_view(scene);
    assert_true(view->medium_count == 1 && view->lights.count == 1 && view->mesh != NULL &&
                view->media[0].has_grid == 0);
    ty_scene_destroy(scene);
}

static void assert_box(const ty_scene* scene, const double lower[3], const double upper[3]) {
    const ty_scene_info info = ty_scene_get_info(scene);
    assert_true(info.bounded);
    for (int a = 0; a < 3; ++a) {
        assert_close(info.lower[a], lower[a], 1e-9);
        assert_close(info.upper[a], upper[a], 1e-9);
    }
}

static void reports_hold_media_and_surfaces(void** state) {
    ty_scene* scene = make_scene(*state);
    assert_false(ty_scene_get_info(scene).bounded);
    const double none[3] = {0, 0, 0}, one[3] = {1, 1, 1}, quarter[3] = {0, 0, 90}, move[3] = {10, 0, 0};
    const double box_lower[3] = {0, 0, 0}, box_upper[3] = {1, 2, 3};
    ty_medium_def medium = box_medium(box_lower, box_upper, 1, 0);
    medium.transform = ty_affine_compose(move, quarter, one);
    assert_int_equal(ty_scene_add_medium(scene, &medium), TY_OK);
    const double turned_lower[3] = {8, 0, 0}, turned_upper[3] = {10, 1, 3};
    assert_box(scene, turned_lower, turned_upper);
    ty_shape_def ball = ty_default_shape_def();
    ball.kind = TY_SHAPE_SPHERE;
    ball.radius = 0.5;
    const double twice[3] = {2, 2, 2};
    ball.transform = ty_affine_compose(none, none, twice);
    set3(ball.origin, 0, 0, -1);
    assert_int_equal(ty_scene_add_shape(scene, &ball), TY_OK);
    const double both_lower[3] = {-1, -1, -3};
    assert_box(scene, both_lower, turned_upper);
    ty_scene_destroy(scene);
}

/* A placed grid without bounds reaches one voxel beyond its outermost centres; bounds cut it. */
static void placed_grids_have_their_place(void** state) {
    ty_grid* grid = small_grid(*state, true);
    ty_scene* scene = make_scene(*state);
    ty_medium_def def = ty_default_medium_def();
    def.density_grid = grid;
    assert_int_equal(ty_scene_add_medium(scene, &def), TY_OK);
    const double lower[3] = {-1, -1, -1}, upper[3] = {2, 2, 2};
    assert_box(scene, lower, upper);
    ty_scene_destroy(scene);
    ty_grid_release(grid);
}

static void reports_count_bytes_once(void** state) {
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = def.size[1] = def.size[2] = 40;
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(*state, &def, &grid), TY_OK);
    ty_scene* scene = make_scene(*state);
    ty_medium_def medium = unit_box_medium();
    medium.density_grid = grid;
    for (int i = 0; i < 2; ++i) assert_int_equal(ty_scene_add_medium(scene, &medium), TY_OK);
    const size_t bytes = ty_scene_get_info(scene).bytes, grid_bytes = ty_grid_get_info(grid).bytes;
    assert_true(bytes > grid_bytes && bytes < grid_bytes + grid_bytes / 2);
    ty_shape_def shape = ty_default_shape_def();
    shape.kind = TY_SHAPE_SPHERE;
    shape.radius = 1;
    assert_int_equal(ty_scene_add_shape(scene, &shape), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    const ty_scene_info info = ty_scene_get_info(scene);
    assert_true(info.bytes > bytes);
    assert_true(info.media == 2 && info.shapes == 1 && info.lights == 0);
    ty_scene_destroy(scene);
    ty_grid_release(grid);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_up_axes_are_refused),       cmocka_unit_test(wrong_cameras_are_refused),
        cmocka_unit_test(wrong_media_are_refused),         cmocka_unit_test(grids_need_bounds_unless_placed),
        cmocka_unit_test(wrong_lights_are_refused),        cmocka_unit_test(environments_need_colour),
        cmocka_unit_test(wrong_shapes_are_refused),        cmocka_unit_test(default_cameras_look_level),
        cmocka_unit_test(settings_and_hash_are_kept),      cmocka_unit_test(media_are_copied),
        cmocka_unit_test(there_is_a_most_of_media),        cmocka_unit_test(changes_need_another_commit),
        cmocka_unit_test(reports_hold_media_and_surfaces), cmocka_unit_test(placed_grids_have_their_place),
        cmocka_unit_test(reports_count_bytes_once),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
