/* dom at the edges of media that are opaque within less than a pixel, beside a lamp: they are lit in a strip of one
 * mean free path, which one ray through each pixel's center misses, or sees over all of it. And lights with extent
 * within media that scatter forwards. */
#include "checks.h"

#include <tyndall/dom.h>

#include <math.h>

enum { SIDE = 12, FINE = 8 };

static ty_image* view(const ty_scene* scene, const ty_dom* light, ty_dom_def def, int32_t side) {
    ty_image* image = NULL;
    def.width = def.height = side;
    assert_int_equal(ty_dom_view(light, scene, &def, &image, NULL), TY_OK);
    return image;
}

/* Pixels around the middle, where the lamp is, are left out. */
static bool is_beside(int32_t pixel, int32_t side) {
    return fabs(pixel % side + 0.5 - 0.5 * side) > 2 || fabs(pixel / side + 0.5 - 0.5 * side) > 2;
}

static double mean_of(const ty_image* image, bool beside) {
    const float* red = ty_image_plane_const(image, 0);
    const int32_t count = ty_image_width(image) * ty_image_height(image);
    double sum = 0;
    for (int32_t i = 0; i < count; ++i)
        if (!beside || is_beside(i, ty_image_width(image))) sum += (double)red[i] / count;
    return sum;
}

static void set_camera(ty_scene* scene, double distance, double fov_y) {
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, 0, 0.1, distance);
    set3(camera.target, 0, 0, 0);
    camera.fov_y = fov_y;
    assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
}

/* A cube of 17 mean free paths a pixel, 1.03 of finer pixels as measured, whose front no light of the lamp reaches but
 * along its edges. */
static void strips_along_edges_are_seen(void** state) {
    static const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(*state);
    const ty_medium_def medium = box_medium(lower, upper, 75, 75);
    ty_light_def lamp = ty_default_light_def();
    lamp.kind = TY_LIGHT_POINT;
    set3(lamp.position, 1.4, 1.3, 0.8);
    set3f(lamp.color, 10, 10, 10);
    assert_int_equal(ty_scene_add_medium(scene, &medium), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &lamp), TY_OK);
    set_camera(scene, 4.2, 36);
    ty_dom_def def = ty_default_dom_def();
    ty_dom* light = NULL;
    def.resolution = 8;
    def.directions = 24;
    assert_int_equal(ty_dom_solve(scene, &def, &light, NULL), TY_OK);
    ty_image *few = view(scene, light, def, 2 * SIDE), *many = view(scene, light, def, 2 * FINE * SIDE);
    print_message("strips: %.4f of pixels %d times as fine\n", mean_of(few, false) / mean_of(many, false), FINE);
    assert_close(mean_of(few, false) / mean_of(many, false), 1, 0.08);
    ty_image_destroy(few);
    ty_image_destroy(many);
    ty_dom_destroy(light);
    ty_scene_destroy(scene);
}

static double hg(double mu, double g) {
    const double base = 1 + g * g - 2 * g * mu;
    return (1 - g * g) / (4 * acos(-1) * base * sqrt(base));
}

/* A small area light in thin fog, which shines at the eye. Measured is 1.02 of single scattering; directions that are
 * one within each cell of the ordinates had 1.16. */
static const double fog_half = 2, sigma_s = 0.02, fog_g = 0.9, lamp_half = 0.1, eye[3] = {0, 0.1, 6}, fov = 20;

/* Light of a point of the fog that scatters once to the eye: of 4 x 4 points of the lamp. */
static double scattered_at(const double at[3], const double wo[3]) {
    const double area = lamp_half * lamp_half / 4;
    double sum = 0;
    for (int i = 0; i < 16; ++i) {
        const double from[3] = {lamp_half * ((i % 4 + 0.5) / 2 - 1), lamp_half * ((i / 4 + 0.5) / 2 - 1), 0};
        double wi[3], square = 0, mu = 0;
        for (int a = 0; a < 3; ++a) wi[a] = at[a] - from[a];
        for (int a = 0; a < 3; ++a) square += wi[a] * wi[a];
        for (int a = 0; a < 3; ++a) mu += wi[a] / sqrt(square) * wo[a];
        if (at[2] > 0)
            sum += area * at[2] / ((square + area / acos(-1)) * sqrt(square)) * hg(mu, fog_g) *
                   exp(-sigma_s * sqrt(square));
    }
    return sum;
}

/* Single scattering through the pixels' centers, mean. */
static double single_scattering(void) {
    enum { STEPS = 4000 };
    double sum = 0, forward[3], right[3] = {1, 0, 0}, up[3];
    const double length = sqrt(eye[1] * eye[1] + eye[2] * eye[2]), half = tan(fov / 360 * acos(-1));
    for (int a = 0; a < 3; ++a) forward[a] = -eye[a] / length;
    up[0] = 0;
    up[1] = -forward[2];
    up[2] = forward[1];
    for (int pixel = 0; pixel < SIDE * SIDE; ++pixel) {
        const double x = ((pixel % SIDE + 0.5) / SIDE * 2 - 1) * half, y = (1 - (pixel / SIDE + 0.5) / SIDE * 2) * half;
        double along[3], norm = 0, wo[3];
        for (int a = 0; a < 3; ++a) along[a] = forward[a] + x * right[a] + y * up[a];
        for (int a = 0; a < 3; ++a) norm += along[a] * along[a];
        for (int a = 0; a < 3; ++a) along[a] /= sqrt(norm);
        for (int a = 0; a < 3; ++a) wo[a] = -along[a];
        const double begin = (eye[2] - fog_half) / -along[2], end = eye[2] / -along[2];
        for (int i = 0; i < STEPS && is_beside(pixel, SIDE); ++i) {
            const double t = begin + (end - begin) * (i + 0.5) / STEPS;
            const double at[3] = {eye[0] + t * along[0], eye[1] + t * along[1], eye[2] + t * along[2]};
            sum += sigma_s * exp(-sigma_s * (t - begin)) * scattered_at(at, wo) * (end - begin) / STEPS;
        }
    }
    return sum / (SIDE * SIDE);
}

static void forward_glow_of_lights_with_extent(void** state) {
    const double lower[3] = {-fog_half, -fog_half, -fog_half}, upper[3] = {fog_half, fog_half, fog_half};
    ty_scene* scene = make_scene(*state);
    ty_medium_def medium = box_medium(lower, upper, (float)sigma_s, 0);
    ty_light_def lamp = ty_default_light_def();
    ty_image* image = NULL;
    lamp.kind = TY_LIGHT_AREA;
    set3(lamp.position, -lamp_half, -lamp_half, 0);
    set3(lamp.u, 2 * lamp_half, 0, 0);
    set3(lamp.v, 0, 2 * lamp_half, 0);
    set3f(medium.g, (float)fog_g, (float)fog_g, (float)fog_g);
    assert_int_equal(ty_scene_add_medium(scene, &medium), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &lamp), TY_OK);
    set_camera(scene, eye[2], fov);
    ty_dom_def def = ty_default_dom_def();
    def.width = def.height = SIDE;
    def.directions = 48;
    assert_int_equal(ty_dom_render(scene, &def, &image, NULL), TY_OK);
    const double ratio = mean_of(image, true) / single_scattering();
    print_message("glow of an area light: %.4f of single scattering\n", ratio);
    assert_close(ratio, 1.03, 0.06);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(strips_along_edges_are_seen),
                                       cmocka_unit_test(forward_glow_of_lights_with_extent)};
    return cmocka_run_group_tests_name("dom_edges", tests, start_context, stop_context);
}
