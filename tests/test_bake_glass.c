/* Baked light on a floor under glass and around milk, against paths that refract; and the warnings of such scenes. */
#include "checks.h"
#include "effort.h"
#include "method/method.h"

#include <tyndall/tyndall.h>

#include <string.h>

enum { RECEIVERS = 5 };

typedef struct notes {
    char text[4096];
} notes;

static void keep_note(void* user, ty_log_level level, const char* text) {
    notes* n = user;
    if (level == TY_LOG_WARNING && strlen(n->text) + strlen(text) + 2 < sizeof n->text) {
        strcat(n->text, text);
        strcat(n->text, "\n");
    }
}

static ty_context* noted_context(notes* n) {
    ty_context_def def = ty_default_context_def();
    ty_context* context;
    n->text[0] = '\0';
    def.log = keep_note;
    def.log_user = n;
    assert_int_equal(ty_context_create(&def, &context), TY_OK);
    return context;
}

static ty_shape_def glass(float ior) {
    ty_shape_def shape = ty_default_shape_def();
    shape.gloss.specular = shape.gloss.transmission = 1;
    shape.gloss.ior = ior;
    shape.gloss.roughness = 0;
    shape.gloss.solid = true;
    for (int c = 0; c < 3; ++c) shape.albedo[c] = 1;
    return shape;
}

/* A floor under a sky of 1 and a lamp with a size, or in the sun. */
static ty_scene* new_floor(ty_context* context, bool sun) {
    ty_scene* scene;
    ty_shape_def floor = ty_default_shape_def();
    ty_light_def sky = ty_default_light_def(), lamp = ty_default_light_def();
    assert_int_equal(ty_scene_create(context, TY_AXIS_Y, &scene), TY_OK);
    floor.kind = TY_SHAPE_QUAD;
    const double corner[3] = {-20, 0, 20}, u[3] = {40, 0, 0}, v[3] = {0, 0, -40};
    memcpy(floor.origin, corner, sizeof corner);
    memcpy(floor.u, u, sizeof u);
    memcpy(floor.v, v, sizeof v);
    for (int c = 0; c < 3; ++c) floor.albedo[c] = 0.5f;
    sky.kind = TY_LIGHT_ENVIRONMENT;
    lamp.kind = TY_LIGHT_AREA;
    const double at[3] = {-4, 3, -1}, side[3] = {0, 0, 2}, up[3] = {1, 1, 0};
    memcpy(lamp.position, at, sizeof at);
    memcpy(lamp.u, up, sizeof up);
    memcpy(lamp.v, side, sizeof side);
    for (int c = 0; c < 3; ++c) lamp.color[c] = 4;
    assert_int_equal(ty_scene_add_shape(scene, &floor), TY_OK);
    if (sun) sky.kind = TY_LIGHT_DIRECTIONAL;
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    if (!sun) assert_int_equal(ty_scene_add_light(scene, &lamp), TY_OK);
    return scene;
}

/* A thick tinted pane over the floor. */
static ty_scene* make_pane(ty_context* context) {
    ty_scene* scene = new_floor(context, false);
    ty_shape_def pane = glass(1.5f);
    pane.kind = TY_SHAPE_BOX;
    const double lower[3] = {-2, 0.5, -2}, upper[3] = {2, 0.6, 2};
    memcpy(pane.origin, lower, sizeof lower);
    memcpy(pane.u, upper, sizeof upper);
    pane.gloss.attenuation_color[0] = 0.5f;
    pane.gloss.attenuation_distance = 0.1f;
    assert_int_equal(ty_scene_add_shape(scene, &pane), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

/* A ball of milk just above the floor. */
static ty_scene* make_milk(ty_context* context, bool sun) {
    ty_scene* scene = new_floor(context, sun);
    ty_shape_def ball = glass(1.33f);
    ty_medium_def medium = ty_default_medium_def();
    ball.kind = TY_SHAPE_SPHERE;
    medium.bounds = TY_BOUNDS_SPHERE;
    medium.sphere_radius = ball.radius = 0.5;
    medium.sphere_center[1] = ball.origin[1] = 0.52;
    for (int c = 0; c < 3; ++c) {
        medium.sigma_s[c] = 20;
        medium.sigma_a[c] = 0.2f * (float)c;
        medium.g[c] = 0.7f;
    }
    assert_int_equal(ty_scene_add_shape(scene, &ball), TY_OK);
    assert_int_equal(ty_scene_add_medium(scene, &medium), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

static void bake(const ty_scene* scene, ty_bake_method method, int32_t spp, ty_bake_light out[RECEIVERS]) {
    static const float at[RECEIVERS][2] = {{0, 0}, {0.3f, 0.2f}, {0.7f, 0}, {-0.6f, 0.5f}, {1.4f, -0.4f}};
    ty_bake_receiver receivers[RECEIVERS];
    ty_bake_def def = ty_default_bake_def();
    memset(receivers, 0, sizeof receivers);
    for (int i = 0; i < RECEIVERS; ++i) {
        receivers[i].position[0] = at[i][0];
        receivers[i].position[2] = at[i][1];
        receivers[i].normal[1] = receivers[i].face[1] = 1;
        receivers[i].margin = 1e-4f;
    }
    def.method = method;
    def.spp = spp;
    def.bounces = 0;
    assert_int_equal(ty_bake_surfaces(scene, &def, receivers, RECEIVERS, out, NULL), TY_OK);
}

/* tolerance: of each receiver's irradiance, with the noise of both; mean: of the mean ratio. */
static void compare(const char* name, const ty_scene* scene, double tolerance, double mean) {
    ty_bake_light cached[RECEIVERS], paths[RECEIVERS];
    double sum = 0;
    const int32_t spp = fewer_under_sanitizers(1024, 16);
    bake(scene, TY_BAKE_CACHE, spp, cached);
    bake(scene, TY_BAKE_PATH, spp, paths);
    if (!numbers_count()) return;
    for (int i = 0; i < RECEIVERS; ++i) {
        double a[3] = {0, 0, 0}, b[3] = {0, 0, 0};
        for (int c = 0; c < 3; ++c)
            for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer) {
                a[c] += (double)cached[i].irradiance[layer][c];
                b[c] += (double)paths[i].irradiance[layer][c];
            }
        print_message("%s %d: %.3f %.3f %.3f, paths %.3f %.3f %.3f\n", name, i, a[0], a[1], a[2], b[0], b[1], b[2]);
        for (int c = 0; c < 3; ++c) {
            assert_close(a[c] / b[c], 1, tolerance);
            sum += a[c] / b[c] / (3 * RECEIVERS);
        }
    }
    print_message("%s: mean ratio %.4f\n", name, sum);
    assert_close(sum, 1, mean);
}

static void light_passes_a_pane(void** state) {
    ty_scene* scene = make_pane(*state);
    compare("pane", scene, 0.06, 0.03);
    ty_scene_destroy(scene);
}

static void milk_lights_the_floor(void** state) {
    skip_under_sanitizers();
    ty_scene* scene = make_milk(*state, false);
    compare("milk", scene, 0.12, 0.05);
    ty_scene_destroy(scene);
}

/* lpv and the baker say what they do not see of glass. */
static void scenes_of_glass_warn(void** state) {
    notes n;
    ty_context* context = noted_context(&n);
    ty_scene* scene = make_milk(context, true);
    ty_bake_light light[RECEIVERS];
    ty_image* image = NULL;
    (void)state;
    n.text[0] = '\0';
    bake(scene, TY_BAKE_SURFACES, 16, light);
    assert_non_null(strstr(n.text, "bake: glass passes light straight on"));
    const ty_render_request request = {.spp = 1, .width = 8, .height = 8};
    static ty_method_run run;
    n.text[0] = '\0';
    assert_int_equal(ty_method_find("lpv")->render(scene, &request, &image, &run), TY_OK);
    assert_non_null(strstr(n.text, "lpv: solid dielectrics are opaque"));
    assert_non_null(ty_method_of_interiors(ty_method_find("lpv"), scene));
    assert_null(ty_method_of_interiors(ty_method_find("fld"), scene));
    ty_image_destroy(image);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(light_passes_a_pane, start_context, stop_context),
        cmocka_unit_test_setup_teardown(milk_lights_the_floor, start_context, stop_context),
        cmocka_unit_test(scenes_of_glass_warn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
