/* Images of the marcher beside media: surfaces, skies, images of both; threads, cancelling, refusals. */
#include "fog.h"
#include "march_maker.h"

static const double low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};

/* An even fog in the cube, seen along -z, with a field; both to be changed before the scene is committed. */
typedef struct lit_fog {
    ty_scene* scene;
    ty_medium_def medium;
    even_field even;
    ty_march_def def;
} lit_fog;

static void begin_fog(ty_context* context, lit_fog* fog) {
    fog->scene = make_scene(context);
    march_look(fog->scene, 0, 0, 50, 0, 0, 0);
    fog->medium = box_medium(low, high, 0.4f, 0.1f);
    even_begin(&fog->even, low, high, 3);
    fog->def = march_def(1, 1);
    fog->def.field = &fog->even.field;
    fog->def.aovs = TY_AOV_TRANSMITTANCE | TY_AOV_DEPTH | TY_AOV_SINGLE | TY_AOV_MULTIPLE;
}

static void add_wall(ty_scene* scene, double z, float albedo) {
    ty_shape_def wall = quad_shape((const double[3][3]){{-5, -5, z}, {10, 0, 0}, {0, 10, 0}});
    set3f(wall.albedo, albedo, albedo, albedo);
    check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &wall));
}

static void add_sky(ty_scene* scene, float r, float g, float b) {
    ty_light_def sky = sky_light(r, g, b);
    check_result(ty_scene_context(scene), ty_scene_add_light(scene, &sky));
}

static ty_image* finish(lit_fog* fog) {
    ty_context* context = ty_scene_context(fog->scene);
    check_result(context, ty_scene_add_medium(fog->scene, &fog->medium));
    check_result(context, ty_scene_commit(fog->scene));
    return march_image(fog->scene, &fog->def, NULL);
}

static void walls_before_in_and_behind(void** state) {
    const double at[] = {2, 0.5, -3};
    const double through[] = {0, 0.5, 2};
    for (int i = 0; i < 3; ++i) {
        lit_fog fog;
        begin_fog(*state, &fog);
        add_wall(fog.scene, at[i], 0);
        ty_image* image = finish(&fog);
        assert_close(march_value(image, "R", 0), 0.8 * 3 * -expm1(-0.5 * through[i]), 1e-5);
        assert_close(march_value(image, "transmittance.R", 0), exp(-0.5 * through[i]), 1e-6);
        assert_close(march_value(image, "depth.Z", 0), 50 - at[i], 1e-4);
        ty_image_destroy(image);
        ty_scene_destroy(fog.scene);
    }
}

/* Even light L makes a wall of albedo a as bright as a L; what has a direction comes to one side only. */
static void walls_in_the_field_reflect(void** state) {
    for (int side = 0; side < 2; ++side) {
        lit_fog fog;
        begin_fog(*state, &fog);
        march_look(fog.scene, 0, 0, side == 0 ? 50 : -50, 0, 0, 0);
        fog.even.field.term_count = 4;
        fog.even.values[3] = side == 0 ? 0.0f : 1.5f;
        add_wall(fog.scene, side == 0 ? 0.5 : -0.5, 0.6f);
        ty_image* image = finish(&fog);
        /* From behind, the normal is -z, and light that goes along z comes to that side. */
        const double irradiance = 3.14159265358979 * (3 + (side == 0 ? 0 : 1.5 * 2 / 3));
        const double expected = 0.8 * 3 * -expm1(-0.25) + exp(-0.25) * 0.6 / 3.14159265358979 * irradiance;
        assert_close(march_value(image, "R", 0), expected, 1e-5);
        assert_close(march_value(image, "multiple.R", 0), expected, 1e-5);
        assert_true(march_value(image, "single.R", 0) == 0);
        ty_image_destroy(image);
        ty_scene_destroy(fog.scene);
    }
}

/* A wall outside of the field sees a ball of fog so thick that its radiance is even: the form factor is closed. */
static void walls_outside_gather(void** state) {
    const double lower[3] = {-2, -2, -2}, upper[3] = {2, 2, 2};
    lit_fog fog;
    begin_fog(*state, &fog);
    fog.medium.bounds = TY_BOUNDS_SPHERE;
    fog.medium.sphere_radius = 1;
    fog.medium.scale = 2000;
    even_begin(&fog.even, lower, upper, 3);
    march_look(fog.scene, 3, 0, 2, 0, 0, -2.5);
    add_wall(fog.scene, -2.5, 0.5f);
    fog.def = march_def(32, 32);
    fog.def.field = &fog.even.field;
    ty_image* image = finish(&fog);
    /* Seen from below its middle the ball takes (r / d)^2 of the cosine-weighted hemisphere. */
    const double expected = 0.5 * 0.8 * 3 / (2.5 * 2.5);
    assert_close(total(image, 0) / (32 * 32) / expected, 1, 0.06);
    ty_image_destroy(image);
    ty_scene_destroy(fog.scene);
}

static void skies_and_images_behind(void** state) {
    for (int with_image = 0; with_image < 2; ++with_image) {
        ty_image* behind = NULL;
        lit_fog fog;
        begin_fog(*state, &fog);
        add_sky(fog.scene, 1, 2, 4);
        check_result(*state, ty_image_create_rgb(*state, 1, 1, &behind));
        for (int c = 0; c < 3; ++c) *ty_image_plane(behind, c) = 10.0f + (float)c;
        if (with_image) fog.def.unscattered = behind;
        ty_image* image = finish(&fog);
        const char* names[3] = {"R", "G", "B"};
        for (int c = 0; c < 3; ++c) {
            const double back = with_image ? 10.0 + c : exp(-1) * (1 << c);
            assert_close(march_value(image, names[c], 0), 0.8 * 3 * -expm1(-1) + back, 1e-5);
        }
        assert_true(march_value(image, "depth.Z", 0) == 0);
        ty_image_destroy(image);
        ty_image_destroy(behind);
        ty_scene_destroy(fog.scene);
    }
}

/* A wall that an image shows is not shown twice: what it reflects of the fog's light comes on top. */
static void images_of_walls_take_fog_light(void** state) {
    ty_image* behind = NULL;
    lit_fog fog;
    begin_fog(*state, &fog);
    add_sky(fog.scene, 7, 7, 7);
    add_wall(fog.scene, 0.5, 0.6f);
    check_result(*state, ty_image_create_rgb(*state, 1, 1, &behind));
    *ty_image_plane(behind, 0) = 1.5f;
    fog.def.unscattered = behind;
    ty_image* image = finish(&fog);
    assert_close(march_value(image, "R", 0), 1.5 + 0.8 * 3 * -expm1(-0.25) + exp(-0.25) * 0.6 * 3, 1e-5);
    ty_image_destroy(image);
    ty_image_destroy(behind);
    ty_scene_destroy(fog.scene);
}

/* Fog in an octahedron: what a ray passes of it. */
static void shells_bound(void** state) {
    static const float corners[] = {1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
    static const uint32_t faces[] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    ty_closed_mesh* shell = NULL;
    lit_fog fog;
    begin_fog(*state, &fog);
    march_look(fog.scene, 0.25, 0.125, 50, 0.25, 0.125, 0);
    check_result(*state, ty_closed_mesh_create(*state, corners, 6, faces, 8, &shell));
    fog.medium.bounds = TY_BOUNDS_SHELL;
    fog.medium.shell = shell;
    ty_image* image = finish(&fog);
    const double length = 2 * (1 - 0.25 - 0.125);
    assert_close(march_value(image, "transmittance.R", 0), exp(-0.5 * length), 1e-5);
    assert_close(march_value(image, "R", 0), 0.8 * 3 * -expm1(-0.5 * length), 1e-5);
    ty_image_destroy(image);
    ty_closed_mesh_release(shell);
    ty_scene_destroy(fog.scene);
}

/* ---- runs ---- */

static ty_image* march_foggy(ty_context* context, ty_march_stats* stats) {
    ty_scene* scene = foggy_scene(context);
    even_field even;
    even_begin(&even, low, high, 0.3f);
    ty_march_def def = march_def(61, 35);
    def.field = &even.field;
    def.spp = 3;
    def.seed = 5;
    def.step = 0.3;
    ty_image* image = march_image(scene, &def, stats);
    ty_scene_destroy(scene);
    return image;
}

static void threads_change_nothing(void** state) {
    (void)state;
    ty_context *alone = make_context(1), *many = make_context(4);
    ty_march_stats stats[2];
    ty_image *one = march_foggy(alone, &stats[0]), *four = march_foggy(many, &stats[1]);
    assert_true(same_images(one, four));
    assert_true(stats[0].steps > 0 && stats[0].steps == stats[1].steps && stats[0].isa != NULL);
    ty_image_destroy(one);
    ty_image_destroy(four);
    ty_context_destroy(alone);
    ty_context_destroy(many);
}

static bool stop_at_once(void* user, const ty_progress* progress) {
    assert_string_equal(progress->stage, "march");
    ++*(int*)user;
    return false;
}

static bool go_on(void* user, const ty_progress* progress) {
    *(double*)user = progress->fraction;
    return true;
}

static void cancelled_and_reported(void** state) {
    ty_scene* scene = foggy_scene(*state);
    int calls = 0;
    double fraction = 0;
    ty_march_def def = march_def(4000, 4000);
    def.aovs = TY_AOV_TRANSMITTANCE;
    def.spp = 16;
    def.progress = stop_at_once;
    def.progress_user = &calls;
    ty_image* image = (ty_image*)scene;
    assert_int_equal(ty_march(scene, &def, &image, NULL), TY_CANCELLED);
    assert_null(image);
    assert_int_equal(calls, 1);
    def.width = def.height = 20;
    def.progress = go_on;
    def.progress_user = &fraction;
    image = march_image(scene, &def, NULL);
    assert_true(fraction == 1);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

static void refusals(void** state) {
    static const bad_field bad[] = {
        {offsetof(ty_march_def, width), FIELD_INT, 0, "width"},
        {offsetof(ty_march_def, height), FIELD_INT, 70000, "height"},
        {offsetof(ty_march_def, spp), FIELD_INT, 65, "spp"},
        {offsetof(ty_march_def, step), FIELD_DOUBLE, 0.01, "step"},
        {offsetof(ty_march_def, step), FIELD_DOUBLE, 9, "step"},
        {offsetof(ty_march_def, bilateral_sigma), FIELD_DOUBLE, -1, "bilateral_sigma"},
        {offsetof(ty_march_def, aovs), FIELD_INT, TY_AOV_VARIANCE, "aovs"},
        {offsetof(ty_march_def, light_count), FIELD_INT, 1, "light_box"},
    };
    ty_scene* scene = foggy_scene(*state);
    ty_image* image = NULL;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        ty_march_def def = march_def(4, 4);
        set_field(&def, &bad[i]);
        assert_int_equal(ty_march(scene, &def, &image, NULL), TY_ERROR_ARGUMENT);
        assert_error(*state, bad[i].words);
    }
    even_field even;
    even_begin(&even, low, high, 1);
    ty_march_def def = march_def(4, 4);
    def.field = &even.field;
    even.field.term_count = 3;
    assert_int_equal(ty_march(scene, &def, &image, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "terms");
    even_begin(&even, high, low, 1);
    assert_int_equal(ty_march(scene, &def, &image, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "march.field");
    ty_image* small = NULL;
    check_result(*state, ty_image_create_rgb(*state, 3, 4, &small));
    def = march_def(4, 4);
    def.unscattered = small;
    assert_int_equal(ty_march(scene, &def, &image, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "3 x 4");
    ty_image_destroy(small);
    ty_scene_destroy(scene);
    scene = make_scene(*state);
    def = march_def(4, 4);
    assert_int_equal(ty_march(scene, &def, &image, NULL), TY_ERROR_ARGUMENT);
    ty_take_error(*state);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(walls_before_in_and_behind),
        cmocka_unit_test(walls_in_the_field_reflect),
        cmocka_unit_test(walls_outside_gather),
        cmocka_unit_test(skies_and_images_behind),
        cmocka_unit_test(images_of_walls_take_fog_light),
        cmocka_unit_test(shells_bound),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(cancelled_and_reported),
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests_name("march scenes", tests, start_context, stop_context);
}
