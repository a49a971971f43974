/* Rendering by the name of a method: the images of the methods' own calls, their measurements, and what is refused. */
#include "checks.h"

#include <tyndall/tyndall.h>

static const char text[] = "{\"tyndall\":1,\"media\":[{\"bounds\":[[-1,-1,-1],[1,1,1]],\"sigma_s\":1,\"sigma_a\":0.1}],"
                           "\"lights\":[{\"type\":\"directional\",\"direction\":[0,-1,0],\"irradiance\":1}],"
                           "\"render\":{\"method\":\"path\",\"spp\":2,\"dom\":{\"resolution\":8}}}";

static ty_scene* parse(ty_context* context) {
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_parse(context, text, sizeof text - 1, "text", NULL, NULL, 0, &scene), TY_OK);
    return scene;
}

typedef struct notes {
    double spp, resolution;
    bool isa;
    int count;
} notes;

static void note(void* user, const char* name, const double* numbers, int32_t count, const char* word) {
    notes* n = user;
    ++n->count;
    assert_true((word != NULL) == (numbers == NULL));
    if (strcmp(name, "spp") == 0) n->spp = numbers[0];
    if (strcmp(name, "size") == 0 && count == 3) n->resolution = numbers[0];
    if (word != NULL) n->isa = true;
}

static void assert_same(const ty_image* a, const ty_image* b) {
    for (int32_t c = 0; c < 3; ++c)
        assert_memory_equal(ty_image_plane_const(a, c), ty_image_plane_const(b, c), 8 * 6 * sizeof(float));
}

static void images_are_those_of_the_methods(void** state) {
    ty_context* context = *state;
    ty_scene* scene = parse(context);
    ty_image *image = NULL, *expected = NULL;
    notes n = {.count = 0};
    ty_render_def def = ty_default_render_def();
    def.width = 8;
    def.height = 6;
    def.measurement = note;
    def.measurement_user = &n;
    ty_path_def path = ty_default_path_def();
    path.width = 8;
    path.height = 6;
    path.spp = 2;
    assert_int_equal(ty_path_render(scene, &path, &expected, NULL), TY_OK);
    assert_int_equal(ty_render(scene, &def, &image), TY_OK); /* by the scene's settings */
    assert_same(image, expected);
    assert_true(n.spp == 2);
    ty_image_destroy(image);
    ty_image_destroy(expected);

    ty_render_settings settings = {.method = "dom", .spp = 1};
    ty_dom_def dom = ty_default_dom_def();
    dom.width = 8;
    dom.height = 6;
    dom.resolution = 8;
    assert_int_equal(ty_dom_render(scene, &dom, &expected, NULL), TY_OK);
    def.settings = &settings;
    assert_int_equal(ty_render(scene, &def, &image), TY_OK);
    assert_same(image, expected);
    assert_true(n.resolution == 8);
    ty_image_destroy(image);
    ty_image_destroy(expected);
    ty_scene_destroy(scene);
}

static void every_method_renders_and_measures(void** state) {
    ty_scene* scene = parse(*state);
    for (int32_t i = 0; ty_method_name(i) != NULL; ++i) {
        ty_render_settings settings = {.spp = 1};
        strcpy(settings.method, ty_method_name(i));
        notes n = {.count = 0};
        ty_image* image = NULL;
        ty_render_def def = ty_default_render_def();
        def.settings = &settings;
        def.width = 6;
        def.height = 4;
        def.measurement = note;
        def.measurement_user = &n;
        assert_int_equal(ty_render(scene, &def, &image), TY_OK);
        assert_true(n.count >= 8);
        ty_image_destroy(image);
    }
    ty_scene_destroy(scene);
}

static bool stop(void* user, const ty_progress* progress) {
    (void)user, (void)progress;
    return false;
}

static void wrong_requests_are_refused(void** state) {
    ty_context* context = *state;
    ty_scene* scene = parse(context);
    ty_image* image = NULL;
    ty_render_settings settings = {.method = "dom", .spp = 1};
    ty_render_def def = ty_default_render_def();
    def.settings = &settings;
    def.aovs = TY_AOV_VARIANCE;
    assert_int_equal(ty_render(scene, &def, &image), TY_ERROR_ARGUMENT);
    assert_string_equal(ty_take_error(context), "the method dom has no channel variance.R");
    def.aovs = 0;
    def.crop[2] = def.crop[3] = 2;
    assert_int_equal(ty_render(scene, &def, &image), TY_ERROR_ARGUMENT);
    assert_non_null(strstr(ty_take_error(context), "renders whole frames"));
    def.crop[2] = def.crop[3] = 0;
    strcpy(settings.method, "auto");
    assert_int_equal(ty_render(scene, &def, &image), TY_ERROR_ARGUMENT);
    assert_non_null(strstr(ty_take_error(context), "there is no method auto; known: path, "));
    def.cookie = 0;
    assert_int_equal(ty_render(scene, &def, &image), TY_ERROR_ARGUMENT);
    ty_take_error(context);
    assert_int_equal(ty_render(NULL, &def, &image), TY_ERROR_ARGUMENT);
    ty_take_error(NULL);
    assert_null(image);

    def = ty_default_render_def();
    strcpy(settings.method, "dom");
    def.settings = &settings;
    def.resume = text;
    assert_int_equal(ty_render(scene, &def, &image), TY_ERROR_ARGUMENT);
    assert_string_equal(ty_take_error(context), "the method dom has no states; path has");
    strcpy(settings.method, "path");
    def.resume_size = sizeof text;
    assert_int_equal(ty_render(scene, &def, &image), TY_ERROR_INPUT);
    ty_take_error(context);
    assert_null(image);

    def = ty_default_render_def(); /* a partial image of path */
    def.seconds = 30;
    settings = (ty_render_settings){.method = "path", .spp = 1 << 20};
    def.settings = &settings;
    def.progress = stop;
    assert_int_equal(ty_render(scene, &def, &image), TY_CANCELLED);
    assert_non_null(image);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_are_those_of_the_methods),
        cmocka_unit_test(every_method_renders_and_measures),
        cmocka_unit_test(wrong_requests_are_refused),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
