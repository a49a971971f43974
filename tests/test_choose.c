/* The method that auto chooses for scenes of each kind, its expectations and reasons, and what it finds in scenes. */
#include "effort.h"
#include "fld_maker.h"

/* Numbers of scenes that are put together here. */
typedef enum light_set { SUN = 1, LAMP = 2, SKY = 4, PANEL = 8 } light_set;

typedef struct setup {
    float thickness, albedo, g; /* of a cube with sides of 1 m; thickness 0: no medium */
    uint32_t lights;
    bool room, floor; /* surfaces all around; a floor some way below */
} setup;

static void add_quad(ty_scene* scene, const double origin[3], const double u[3], const double v[3]) {
    ty_shape_def quad = ty_default_shape_def();
    for (int a = 0; a < 3; ++a) {
        quad.origin[a] = origin[a];
        quad.u[a] = u[a];
        quad.v[a] = v[a];
    }
    check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &quad));
}

static void add_surfaces(ty_scene* scene, const setup* with) {
    static const double edges[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const double floor_corner[3] = {-20, -1.5, -20}, floor_u[3] = {0, 0, 40}, floor_v[3] = {40, 0, 0};
    if (with->floor) add_quad(scene, floor_corner, floor_u, floor_v);
    for (int a = 0; a < 3 && with->room; ++a)
        for (int side = 0; side < (a == 2 ? 1 : 2); ++side) {
            double corner[3] = {-0.5, -0.5, -0.5};
            corner[a] += side;
            add_quad(scene, corner, edges[(a + 1) % 3], edges[(a + 2) % 3]);
        }
}

static void add_lights(ty_scene* scene, uint32_t lights) {
    const ty_light_def sun = sun_light(1, 1, 1), lamp = point_light(0.2, 0.3, 0, 1, 1, 1);
    ty_light_def sky = ty_default_light_def(), panel = sky;
    sky.kind = TY_LIGHT_ENVIRONMENT;
    panel.kind = TY_LIGHT_AREA;
    set3(panel.position, -0.1, 0.4, -0.1);
    set3(panel.u, 0.2, 0, 0);
    set3(panel.v, 0, 0, 0.2);
    if (lights & SUN) add_light(scene, &sun);
    if (lights & LAMP) add_light(scene, &lamp);
    if (lights & SKY) add_light(scene, &sky);
    if (lights & PANEL) add_light(scene, &panel);
}

static ty_scene* set_up(ty_context* context, const setup* with) {
    static const double lower[3] = {-0.5, -0.5, -0.5}, upper[3] = {0.5, 0.5, 0.5};
    ty_scene* scene = make_scene(context);
    ty_medium_def medium =
        box_medium(lower, upper, with->thickness * with->albedo, with->thickness * (1 - with->albedo));
    ty_camera_def camera = ty_default_camera_def();
    set3f(medium.g, with->g, with->g, with->g);
    set3(camera.position, 0, 0, 3);
    camera.fov_y = 24;
    camera.resolution[0] = 160;
    camera.resolution[1] = 120;
    check_result(context, ty_scene_set_camera(scene, &camera));
    if (with->thickness > 0) add_medium(scene, &medium);
    add_surfaces(scene, with);
    add_lights(scene, with->lights);
    commit(scene);
    return scene;
}

static ty_choice choose_by(const ty_scene* scene, const ty_choose_def* def) {
    ty_choice choice;
    check_result(ty_scene_context(scene), ty_choose_method(scene, def, &choice));
    assert_true(choice.reason[0] != '\0');
    assert_true(choice.error > 0 && choice.error < 100);
    assert_true(choice.seconds > 0 && choice.seconds < 1e7);
    return choice;
}

/* Without trials. */
static ty_choice choose(const ty_scene* scene, uint32_t asks, uint32_t aovs) {
    ty_choose_def def = ty_default_choose_def();
    def.asks = asks;
    def.aovs = aovs;
    def.trials = false;
    return choose_by(scene, &def);
}

static bool is_candidate(const char* name) {
    for (int32_t i = 0; ty_choice_method_name(i) != NULL; ++i)
        if (strcmp(ty_choice_method_name(i), name) == 0) return true;
    return false;
}

static void scenes_of_all_kinds_have_a_method(void** state) {
    static const struct {
        setup with;
        const char* words;
    } cases[] = {
        {{0, 0, 0, SUN, true, false}, "no media"},
        {{0.001f, 1, 0, SUN, false, false}, "no media"},
        {{4, 1, 0.5f, SUN, false, false}, "lit by the sun;"},
        {{4, 1, 0.5f, SUN | LAMP | SKY, false, false}, "lit by the sun, lamps and an environment;"},
        {{40, 1, 0, PANEL, false, false}, "lit by glowing surfaces;"},
        {{1, 1, 0.3f, LAMP, true, false}, "optical thickness up to 1"},
        {{4000, 1, 0, SUN, false, false}, "comes next, at"},
        {{4, 1, 0.96f, SUN, false, false}, "g 0.96"},
        {{4, 0.8f, 0, SUN, false, true}, "even media"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        ty_scene* scene = set_up(*state, &cases[i].with);
        const ty_choice choice = choose(scene, 0, 0);
        if (!is_candidate(choice.method) || strstr(choice.reason, cases[i].words) == NULL)
            fail_msg("case %zu is %s (%s)", i, choice.method, choice.reason);
        ty_scene_destroy(scene);
    }
}

/* The error of path falls with the root of the samples, and its time grows with samples and pixels. */
static void expectations_of_path_follow_its_samples(void** state) {
    const setup cloud = {4, 1, 0.5f, SUN, false, false};
    ty_scene* scene = set_up(*state, &cloud);
    ty_choose_def def = ty_default_choose_def();
    def.asks = TY_ASK_SAMPLES;
    def.spp = 16;
    const ty_choice few = choose_by(scene, &def);
    def.spp = 64;
    const ty_choice more = choose_by(scene, &def);
    assert_close(more.error, 0.5 * few.error, 1e-9 * few.error);
    assert_close(more.seconds, 4 * few.seconds, 1e-9 * more.seconds);
    def.width = 320;
    def.height = 240;
    const ty_choice larger = choose_by(scene, &def);
    assert_close(larger.seconds, 4 * more.seconds, 1e-9 * larger.seconds);
    assert_close(larger.error, more.error, 1e-9);
    ty_scene_destroy(scene);
}

/* A large picture with many samples of a scene that cells resolve, where paths take minutes. */
static void large_pictures_choose_cells(void** state) {
    const setup cloud = {4, 1, 0.3f, SUN, false, false};
    ty_scene* scene = set_up(*state, &cloud);
    ty_choose_def def = ty_default_choose_def();
    def.trials = false;
    def.width = 1920;
    def.height = 1080;
    def.spp = 1024;
    assert_string_not_equal(choose_by(scene, &def).method, "path");
    ty_scene_destroy(scene);
}

/* Each method is tried, and one that is as bright as paths has a small difference. */
static void trials_compare_methods_with_paths(void** state) {
    const setup cloud = {2, 1, 0, SUN, false, false};
    const ty_choose_def def = ty_default_choose_def();
    ty_scene* scene = set_up(*state, &cloud);
    const ty_choice choice = choose_by(scene, &def);
    assert_true(is_candidate(choice.method));
    assert_true(choice.features.trial_noise > 0 && choice.features.trial_noise < 0.1);
    for (int32_t i = 1; ty_choice_method_name(i) != NULL; ++i) {
        assert_true(choice.features.trials[i] > 0);
        if (strcmp(ty_choice_method_name(i), "dom") == 0) assert_true(choice.features.trials[i] < 0.1);
    }
    assert_true(choose(scene, 0, 0).features.trial_noise == 0);
    ty_scene_destroy(scene);
}

/* Crops, bounds, resuming and some channels are for path tracing alone. */
static void requests_for_path_tracing_choose_path(void** state) {
    const setup cloud = {4, 1, 0.5f, SUN, false, false};
    static const uint32_t asks[] = {TY_ASK_CROP, TY_ASK_TIME, TY_ASK_ERROR, TY_ASK_RESUME, TY_ASK_SAMPLES};
    static const uint32_t others[] = {TY_AOV_VARIANCE, TY_AOV_NORMAL, TY_AOV_ALBEDO | TY_AOV_DEPTH};
    ty_scene* scene = set_up(*state, &cloud);
    for (size_t i = 0; i < sizeof asks / sizeof asks[0]; ++i)
        assert_string_equal(choose(scene, asks[i], 0).method, "path");
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i)
        assert_string_equal(choose(scene, 0, others[i]).method, "path");
    assert_true(is_candidate(choose(scene, 0, TY_AOV_DEPTH | TY_AOV_SINGLE | TY_AOV_SAMPLES).method));
    ty_scene_destroy(scene);
}

/* Numbers that are known: the cube fills the middle of the frame. */
static void features_are_those_of_the_scene(void** state) {
    const setup cloud = {4, 0.75f, 0.5f, SUN | SKY, false, false}, with_floor = {4, 0.75f, 0.5f, LAMP, false, true};
    ty_scene* scene = set_up(*state, &cloud);
    ty_scene_features look = choose(scene, 0, 0).features;
    assert_close(look.thickness, 4.05, 0.1);
    assert_close(look.g, 0.5, 1e-5);
    assert_close(look.albedo, 0.75, 1e-5);
    assert_close(look.cell, 0.1, 1e-5);
    assert_in_range((int)(100 * look.media), 40, 75);
    assert_close(look.opacity / look.media, 0.9, 0.08); /* 1 - exp(-4) but for edges */
    assert_true(look.surfaces == 0 && look.enclosed == 0);
    assert_false(look.heterogeneous || look.emissive_media || look.inside);
    assert_int_equal(look.lights, 1 << TY_LIGHT_DIRECTIONAL | 1 << TY_LIGHT_ENVIRONMENT);
    ty_scene_destroy(scene);
    scene = set_up(*state, &with_floor);
    look = choose(scene, 0, 0).features;
    assert_true(look.enclosed == 0); /* the floor is farther off than the cube is long */
    assert_true(look.surfaces > 0.05 && look.surfaces < 0.6);
    ty_scene_destroy(scene);
}

/* Of two media in one place both count; a camera within is noticed. */
static void overlapping_media_add_up(void** state) {
    const double lower[3] = {-10, -10, -10}, upper[3] = {10, 10, 10};
    const setup cloud = {4, 1, 0, SUN, false, false};
    ty_medium_def haze = box_medium(lower, upper, 0, 0.01f);
    haze.emission[1] = 1;
    ty_scene* scene = set_up(*state, &cloud);
    add_medium(scene, &haze);
    commit(scene);
    const ty_choice choice = choose(scene, 0, 0);
    assert_true(choice.features.inside && choice.features.emissive_media);
    assert_close(choice.features.thickness, 4.05 + 0.13, 0.1);
    assert_close(choice.features.media, 1, 1e-6);
    assert_close(choice.features.albedo, 1, 0.01);
    assert_non_null(strstr(choice.reason, "glow"));
    ty_scene_destroy(scene);
}

/* The same whatever the number of threads. */
static void threads_do_not_change_the_choice(void** state) {
    skip_under_address_sanitizer();
    const setup room = {1, 1, 0.3f, LAMP, true, true};
    ty_context* one = make_context(1);
    ty_scene *scene = set_up(*state, &room), *same = set_up(one, &room);
    const ty_choose_def def = ty_default_choose_def();
    const ty_choice a = choose_by(scene, &def), b = choose_by(same, &def);
    assert_string_equal(a.reason, b.reason);
    assert_memory_equal(&a.features, &b.features, sizeof a.features);
    ty_scene_destroy(scene);
    ty_scene_destroy(same);
    ty_context_destroy(one);
}

static void errors_are_reported(void** state) {
    const setup cloud = {4, 1, 0, SUN, false, false};
    ty_scene* scene = set_up(*state, &cloud);
    ty_choose_def def = ty_default_choose_def();
    ty_choice choice = {.method = "untouched"};
    def.cookie = 0;
    assert_int_equal(ty_choose_method(scene, &def, &choice), TY_ERROR_ARGUMENT);
    assert_error(*state, "ty_default_choose_def");
    def = ty_default_choose_def();
    add_lights(scene, SKY);
    assert_int_equal(ty_choose_method(scene, &def, &choice), TY_ERROR_ARGUMENT);
    assert_error(*state, "not committed");
    assert_string_equal(choice.method, "untouched");
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(scenes_of_all_kinds_have_a_method, start_context, stop_context),
        cmocka_unit_test_setup_teardown(expectations_of_path_follow_its_samples, start_context, stop_context),
        cmocka_unit_test_setup_teardown(large_pictures_choose_cells, start_context, stop_context),
        cmocka_unit_test_setup_teardown(trials_compare_methods_with_paths, start_context, stop_context),
        cmocka_unit_test_setup_teardown(requests_for_path_tracing_choose_path, start_context, stop_context),
        cmocka_unit_test_setup_teardown(features_are_those_of_the_scene, start_context, stop_context),
        cmocka_unit_test_setup_teardown(overlapping_media_add_up, start_context, stop_context),
        cmocka_unit_test_setup_teardown(threads_do_not_change_the_choice, start_context, stop_context),
        cmocka_unit_test_setup_teardown(errors_are_reported, start_context, stop_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
