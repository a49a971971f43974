/* Shared by the tests of rendering: small scenes, and images of them. */
#ifndef TY_TESTS_FOG_H
#define TY_TESTS_FOG_H

#include "checks.h"

enum { WIDTH = 19, HEIGHT = 11, PIXELS = WIDTH * HEIGHT };

/* A foggy box and a ball under a sun and a constant sky. */
static inline ty_scene* foggy_scene(ty_context* context) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(context);
    ty_medium_def fog = box_medium(lower, upper, 2, 0.1f);
    fog.g[0] = 0.6f;
    ty_light_def sun = ty_default_light_def(), sky = sun;
    set3(sun.direction, -1, -2, -0.5);
    sky.kind = TY_LIGHT_ENVIRONMENT;
    set3f(sky.color, 0.25f, 0.5f, 0.75f);
    ty_shape_def ball = ty_default_shape_def();
    ball.kind = TY_SHAPE_SPHERE;
    ball.radius = 0.4;
    assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sun), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    assert_int_equal(ty_scene_add_shape(scene, &ball), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

/* Fog that only absorbs, before a sky of radiance 1. */
static inline ty_scene* dark_scene(ty_context* context) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(context);
    const ty_medium_def fog = box_medium(lower, upper, 0, 0.5f);
    ty_light_def sky = sky_light(1, 1, 1);
    assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

/* Lamps, a sky and a ball; the fog reaches far beyond them, so that it decides which light is likely. */
static inline ty_scene* lit_scene(ty_context* context, bool foggy) {
    const double lower[3] = {-9, -8, -7}, upper[3] = {6, 7, 11};
    ty_scene* scene = make_scene(context);
    ty_medium_def fog = box_medium(lower, upper, 0.1f, 0.02f);
    ty_light_def sky = ty_default_light_def(), lamp = sky, far = sky;
    sky.kind = TY_LIGHT_ENVIRONMENT;
    set3f(sky.color, 0.25f, 0.5f, 0.75f);
    lamp.kind = far.kind = TY_LIGHT_POINT;
    set3(lamp.position, 1, 1, 1);
    set3(far.position, -3, 1, 4);
    ty_shape_def ball = ty_default_shape_def(), glowing = ball;
    ball.kind = glowing.kind = TY_SHAPE_SPHERE;
    ball.radius = 0.5;
    set3(glowing.origin, 0.7, 0, 0.5);
    glowing.radius = 0.1;
    set3f(glowing.emission, 3, 2, 1);
    if (foggy) assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &lamp), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &far), TY_OK);
    assert_int_equal(ty_scene_add_shape(scene, &ball), TY_OK);
    assert_int_equal(ty_scene_add_shape(scene, &glowing), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

static inline ty_path_def small_def(int32_t spp) {
    ty_path_def def = ty_default_path_def();
    def.spp = spp;
    def.width = WIDTH;
    def.height = HEIGHT;
    return def;
}

static inline ty_image* render(const ty_scene* scene, const ty_path_def* def, ty_path_stats* stats) {
    ty_image* image = NULL;
    assert_int_equal(ty_path_render(scene, def, &image, stats), TY_OK);
    return image;
}

/* The sum of one channel. */
static inline double total(const ty_image* image, int channel) {
    const int64_t count = (int64_t)ty_image_width(image) * ty_image_height(image);
    double sum = 0;
    for (int64_t i = 0; i < count; ++i) sum += (double)ty_image_plane_const(image, channel)[i];
    return sum;
}

static inline bool same_images(const ty_image* a, const ty_image* b) {
    const int32_t width = ty_image_width(a), height = ty_image_height(a), channels = ty_image_channel_count(a);
    if (width != ty_image_width(b) || height != ty_image_height(b) || channels != ty_image_channel_count(b))
        return false;
    const size_t size = (size_t)width * (size_t)height * sizeof(float);
    for (int32_t c = 0; c < channels; ++c)
        if (memcmp(ty_image_plane_const(a, c), ty_image_plane_const(b, c), size) != 0) return false;
    return true;
}

#endif
