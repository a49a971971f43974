/* White boxes of fog that are open on one side, by discrete ordinates: what enters by the opening is all there is, and
 * light alike from everywhere shows nothing of them. Walls are in the faces of the fog's box, or a little within. */
#include "truth.h"

#include <tyndall/dom.h>

#include <stdio.h>

/* Pixels of a picture's side, and cells of the box's. */
enum { ACROSS = 32, CUT = 6 };

/* A cube of fog of half side `half` that absorbs nothing, and white walls in the faces of [-1, 1]^3 but for the one
 * towards +z. */
static ty_scene* white_box(ty_context* context, double half, double sigma, double g, const ty_light_def* light) {
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    ty_scene* scene = new_scene(context);
    const ty_medium_def fog = medium_cube(half, sigma, 0, g);
    ty_camera_def camera = ty_default_camera_def();
    for (int face = 0; face < 5; ++face) {
        const int a = face / 2;
        double center[3] = {0, 0, 0};
        center[a] = face % 2 == 0 ? -1 : 1;
        const ty_shape_def wall = square_shape(center, axes[(a + 1) % 3], axes[(a + 2) % 3], 1, 1);
        add_shape(scene, &wall);
    }
    set3(camera.position, 0.9, 0.6, 4.5);
    set3(camera.target, 0, 0, 0);
    camera.fov_y = 34;
    must(context, ty_scene_set_camera(scene, &camera));
    add_medium(scene, &fog);
    add_light(scene, light);
    commit(scene);
    return scene;
}

/* Errors of numbers that should be 1. */
typedef struct spread {
    double mean, rms;
} spread;

static spread spread_of(const double* values, int count) {
    spread s = {0, 0};
    for (int i = 0; i < count; ++i) {
        s.mean += (values[i] - 1) / count;
        s.rms += (values[i] - 1) * (values[i] - 1) / count;
    }
    s.rms = sqrt(s.rms);
    return s;
}

static spread fluence_off(ty_context* context, const ty_dom* light) {
    static const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    static const int32_t size[3] = {CUT, CUT, CUT};
    static double fluence[3 * CUT * CUT * CUT];
    must(context, ty_dom_fluence(light, lower, upper, size, fluence, NULL));
    for (int i = 0; i < 3 * CUT * CUT * CUT; ++i) fluence[i] /= 4 * pi;
    return spread_of(fluence, 3 * CUT * CUT * CUT);
}

static spread picture_off(const ty_scene* scene, const ty_dom* light, ty_dom_def def) {
    static double pixels[ACROSS * ACROSS];
    ty_image *image = NULL, *surfaces = NULL;
    ty_path_def path = ty_default_path_def();
    path.width = path.height = def.width = def.height = ACROSS;
    path.spp = 256;
    path.unscattered = true;
    must(ty_scene_context(scene), ty_path_render(scene, &path, &surfaces, NULL));
    def.spp = 4;
    def.unscattered = surfaces;
    must(ty_scene_context(scene), ty_dom_view(light, scene, &def, &image, NULL));
    for (int i = 0; i < ACROSS * ACROSS; ++i) pixels[i] = (double)ty_image_plane_const(image, 1)[i];
    ty_image_destroy(image);
    ty_image_destroy(surfaces);
    return spread_of(pixels, ACROSS * ACROSS);
}

/* Error of the box, which should be nowhere to be seen. Numbers below 0 are not looked at. */
typedef struct box_case {
    double half, sigma, g; /* m; 1/m; mean cosine */
    double emitted, fluence, picture;
} box_case;

static bool is_unseen(ty_context* context, const box_case* c) {
    const ty_light_def sky = light_of(TY_LIGHT_ENVIRONMENT, 1);
    ty_scene* scene = white_box(context, c->half, c->sigma, c->g, &sky);
    const ty_dom_def def = ty_default_dom_def();
    ty_dom* light = NULL;
    ty_dom_stats stats = ty_default_dom_stats();
    must(context, ty_dom_solve(scene, &def, &light, &stats));
    assert_true(stats.converged);
    const double emitted = stats.emitted[1] / (4 * pi) - 1;
    const spread fluence = fluence_off(context, light), picture = picture_off(scene, light, def);
    printf("white box, %g/m in %g m, g %g: emitted %+.4f; fluence %+.4f, rms %.4f; picture %+.4f, rms %.4f\n", c->sigma,
           2 * c->half, c->g, emitted, fluence.mean, fluence.rms, picture.mean, picture.rms);
    ty_dom_destroy(light);
    ty_scene_destroy(scene);
    return (c->emitted < 0 || fabs(emitted) <= c->emitted) && (c->fluence < 0 || fabs(fluence.mean) <= c->fluence) &&
           fabs(picture.mean) <= c->picture;
}

/* Of all that is emitted 1.3 % and more is what 64 beams make of the sky's irradiance. At 20/m cells of ordinates are
 * 1.7 mean free paths thick, and light that has entered is on the mean nearer to the opening than their middles. Fog
 * beyond the walls is lit as well, and adds to what is emitted. With g = 0.9 the picture lacked 3 % while walls did not
 * show the light that had scattered nearly straight on between them. */
static void a_white_box_is_unseen(void** state) {
    static const box_case cases[] = {
        {1, 0.5, 0, 0.03, 0.05, 0.03},    {1, 2, 0, 0.03, 0.05, 0.03},    {1, 20, 0, 0.03, -1, 0.1},
        {1.01, 2, 0, -1, 0.05, 0.05},     {1.03, 0.5, 0, -1, 0.05, 0.05}, {1.03, 8, 0, -1, -1, 0.05},
        {1, 0.5, 0.9, 0.03, 0.05, 0.025},
    };
    bool unseen = true;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) unseen = is_unseen(*state, &cases[i]) && unseen;
    assert_true(unseen);
}

/* Slanting at the opening, whose plane it meets at a cosine. */
static bool keeps_the_sun(ty_context* context, double x, double y, double sigma) {
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 1);
    set3(sun.direction, x, y, -1);
    ty_scene* scene = white_box(context, 1, sigma, 0, &sun);
    const ty_dom_def def = ty_default_dom_def();
    ty_dom* light = NULL;
    ty_dom_stats stats = ty_default_dom_stats();
    must(context, ty_dom_solve(scene, &def, &light, &stats));
    const double entered = stats.emitted[1] / (4 / sqrt(x * x + y * y + 1));
    printf("sun along %g, %g, -1, %g/m: emitted %.4f of what enters\n", x, y, sigma, entered);
    ty_dom_destroy(light);
    ty_scene_destroy(scene);
    return fabs(entered - 1) <= 0.03;
}

static void the_sun_in_a_box(void** state) {
    bool kept = true;
    for (int i = 0; i < 3; ++i) {
        const double sigma = (const double[]){0.5, 2, 20}[i];
        kept = keeps_the_sun(*state, 0.3, 0.8, sigma) && kept;
        kept = keeps_the_sun(*state, -1.7, 0.6, sigma) && kept;
    }
    assert_true(kept);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_white_box_is_unseen), cmocka_unit_test(the_sun_in_a_box)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
