/* Glossy surfaces in scenes: mirrors, thin walls and white bodies under an even sky, checks of their numbers. */
#include "fog.h"

#include <string.h>

/* The light of an even sky of radiance 1 from below that a quad at z = 0 sends along a ray. */
static void through_quad(ty_context* context, const ty_shape_def* like, const double ray[6], int32_t spp,
                         double radiance[3]) {
    ty_scene* scene = make_scene(context);
    const ty_light_def sky = sky_light(1, 1, 1);
    ty_shape_def quad = quad_shape((const double[3][3]){{-50, -50, 0}, {100, 0, 0}, {0, 100, 0}});
    memcpy(quad.albedo, like->albedo, sizeof quad.albedo);
    quad.gloss = like->gloss;
    assert_int_equal(ty_scene_add_shape(scene, &quad), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_path_def def = small_def(spp);
    assert_int_equal(ty_path_radiance(scene, &def, ray, 1, radiance, NULL), TY_OK);
    ty_scene_destroy(scene);
}

static const double straight[6] = {0, 0, 1, 0, 0, 1}, slanting[6] = {0, 0, 1, 0.8, 0, 0.6};

static void mirrors_have_their_colour(void** state) {
    ty_shape_def mirror = ty_default_shape_def();
    set3f(mirror.albedo, 0.9f, 0.6f, 0.3f);
    mirror.gloss.metallic = 1;
    mirror.gloss.roughness = 0;
    double radiance[3];
    through_quad(*state, &mirror, straight, 64, radiance);
    for (int c = 0; c < 3; ++c) assert_close(radiance[c], (double)mirror.albedo[c], 2e-3);
    /* Schlick's reflectance at a cosine of 0.6. */
    through_quad(*state, &mirror, slanting, 64, radiance);
    for (int c = 0; c < 3; ++c) {
        const double f0 = (double)mirror.albedo[c];
        assert_close(radiance[c], f0 + (1 - f0) * pow(0.4, 5), 2e-3);
    }
}

/* Without a reflection of its own a pane has its colour, from either side and however rough. */
static void panes_have_their_colour(void** state) {
    static const double from_behind[6] = {0, 0, -1, 0.8, 0, -0.6};
    ty_shape_def pane = ty_default_shape_def();
    set3f(pane.albedo, 0.9f, 0.6f, 0.3f);
    pane.gloss.transmission = 1;
    for (int i = 0; i < 4; ++i) {
        double radiance[3];
        pane.gloss.roughness = i < 2 ? 0 : 0.7f;
        through_quad(*state, &pane, i % 2 == 0 ? slanting : from_behind, i < 2 ? 64 : 4096, radiance);
        for (int c = 0; c < 3; ++c) assert_close(radiance[c], (double)pane.albedo[c], i < 2 ? 3e-3 : 1e-2);
    }
}

/* Lamps behind a pane shine through it. */
static void lamps_shine_through_panes(void** state) {
    ty_scene* scene = make_scene(*state);
    ty_light_def lamp = ty_default_light_def();
    ty_shape_def pane = quad_shape((const double[3][3]){{-5, -5, 0}, {10, 0, 0}, {0, 10, 0}});
    lamp.kind = TY_LIGHT_POINT;
    set3(lamp.position, 0, 0, -2);
    set3f(lamp.color, 4, 4, 4);
    set3f(pane.albedo, 1, 1, 1);
    pane.gloss.transmission = 1;
    pane.gloss.roughness = 0.5f;
    assert_int_equal(ty_scene_add_shape(scene, &pane), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &lamp), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_path_def def = small_def(16);
    def.max_depth = 1;
    def.energy_compensation = false;
    double radiance[3];
    assert_int_equal(ty_path_radiance(scene, &def, straight, 1, radiance, NULL), TY_OK);
    /* D / 4 at the normal, alpha = 1 / 4, times irradiance. */
    assert_close(radiance[0], 16 / 3.14159265358979 / 4, 1e-4);
    ty_scene_destroy(scene);
}

/* White balls of all kinds cannot be seen before a white sky. */
static void white_balls_vanish(void** state) {
    ty_scene* scene = make_scene(*state);
    const ty_light_def sky = sky_light(1, 1, 1);
    for (int i = 0; i < 6; ++i) {
        ty_shape_def ball = ty_default_shape_def();
        ball.kind = TY_SHAPE_SPHERE;
        ball.radius = 0.9;
        set3(ball.origin, 2.0 * (i % 3) - 2, 2.0 * (i / 3) - 1, 0);
        set3f(ball.albedo, 1, 1, 1);
        ball.gloss.specular = 1;
        ball.gloss.roughness = 0.2f * (float)i;
        ball.gloss.metallic = i % 3 == 0 ? 1 : 0;
        ball.gloss.transmission = i % 3 == 1 ? 0.8f : 0;
        assert_int_equal(ty_scene_add_shape(scene, &ball), TY_OK);
    }
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, 0, 0, 9);
    assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_path_def def = small_def(64);
    def.width = 48;
    def.height = 32;
    ty_image* image = NULL;
    assert_int_equal(ty_path_render(scene, &def, &image, NULL), TY_OK);
    double sum = 0;
    const float* green = ty_image_plane_const(image, 1);
    for (int i = 0; i < 48 * 32; ++i) sum += (double)green[i];
    assert_close(sum / (48 * 32), 1, 3e-3);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* A texture takes the metal away that its factor of 1 leaves to it: through a body of index 1 light goes straight on,
 * however rough, with the colour of both sides. */
static void textures_decide_on_metal(void** state) {
    ty_context* context = *state;
    ty_scene* scene = make_scene(context);
    static const uint8_t rough[] = {0, 255, 0, 255};
    ty_texture_def texture = ty_default_texture_def();
    texture.width = texture.height = 1;
    texture.rgba8 = rough;
    texture.linear = true;
    ty_shape_def box = ty_default_shape_def();
    box.kind = TY_SHAPE_BOX;
    set3(box.origin, -1, -1, -1);
    set3(box.u, 1, 1, 1);
    set3f(box.albedo, 0.5f, 0.5f, 0.5f);
    box.gloss.metallic = box.gloss.roughness = box.gloss.transmission = box.gloss.ior = 1;
    box.gloss.solid = true;
    assert_int_equal(ty_texture_create(context, &texture, &box.gloss.textures[TY_GLOSS_METALLIC_ROUGHNESS].texture),
                     TY_OK);
    ty_shape_def lamp = quad_shape((const double[3][3]){{-0.1, -0.1, -2}, {0.2, 0, 0}, {0, 0.2, 0}});
    set3f(lamp.emission, 4, 4, 4);
    assert_int_equal(ty_scene_add_shape(scene, &box), TY_OK);
    assert_int_equal(ty_scene_add_shape(scene, &lamp), TY_OK);
    ty_texture_release(box.gloss.textures[TY_GLOSS_METALLIC_ROUGHNESS].texture);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    static const double ray[6] = {0, 0, 3, 0, 0, 1};
    const ty_path_def def = small_def(16);
    double radiance[3];
    assert_int_equal(ty_path_radiance(scene, &def, ray, 1, radiance, NULL), TY_OK);
    assert_close(radiance[0], 1, 1e-5);
    ty_scene_destroy(scene);
}

static void wrong_numbers_are_refused(void** state) {
    ty_context* context = *state;
    ty_scene* scene = make_scene(context);
    ty_shape_def shape = quad_shape((const double[3][3]){{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    shape.gloss.ior = 0.5f;
    assert_int_equal(ty_scene_add_shape(scene, &shape), TY_ERROR_ARGUMENT);
    assert_error(context, "shape.gloss.ior: 0.5 is outside [1, 100]");
    shape.gloss.ior = 1.5f;
    shape.gloss.metallic = NAN;
    assert_int_equal(ty_scene_add_shape(scene, &shape), TY_ERROR_ARGUMENT);
    assert_error(context, "shape.gloss.metallic");
    shape.gloss.metallic = 0;
    shape.gloss.sheen_color[1] = 2;
    assert_int_equal(ty_scene_add_shape(scene, &shape), TY_ERROR_ARGUMENT);
    assert_error(context, "shape.gloss.sheen_color");
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mirrors_have_their_colour), cmocka_unit_test(panes_have_their_colour),
        cmocka_unit_test(lamps_shine_through_panes), cmocka_unit_test(white_balls_vanish),
        cmocka_unit_test(textures_decide_on_metal),  cmocka_unit_test(wrong_numbers_are_refused),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
