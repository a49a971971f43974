/* Scene files that are right: what each key becomes, units, overrides, files, builtin and reference scenes, the manual.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <jansson.h>
#include <sys/stat.h>

#include "dicom_maker.h"

#include "io/scenes/builtin.h"
#include "netcdf_maker.h"
#include "scene/scene.h"

#include <tyndall/dom.h>
#include <tyndall/io.h>
#include <tyndall/lpv.h>
#include <tyndall/method.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])
#define BOX "\"bounds\":[[0,0,0],[1,1,1]]"

static ty_context* make_context(void) {
    const ty_context_def def = ty_default_context_def();
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&def, &context), TY_OK);
    return context;
}

static void expect_ok(ty_context* context, ty_result result) {
    if (result != TY_OK) fail_msg("%s: %s", ty_result_name(result), ty_take_error(context));
}

static ty_scene* parse_with(ty_context* context, const char* text, const char* const* overrides, int32_t count) {
    ty_scene* scene = NULL;
    expect_ok(context, ty_scene_parse(context, text, strlen(text), "test", "", overrides, count, &scene));
    assert_non_null(scene);
    return scene;
}

static ty_scene* parse(ty_context* context, const char* text) {
    return parse_with(context, text, NULL, 0);
}

static void expect_vector(const double v[3], double x, double y, double z) {
    const double expected[3] = {x, y, z};
    for (int a = 0; a < 3; ++a)
        if (fabs(v[a] - expected[a]) > 1e-9) fail_msg("(%g, %g, %g), expected (%g, %g, %g)", v[0], v[1], v[2], x, y, z);
}

static void expect_rgb(const float v[3], double r, double g, double b) {
    const double expected[3] = {r, g, b};
    for (int c = 0; c < 3; ++c)
        if (fabs(v[c] - expected[c]) > 1e-6 * (1 + fabs(expected[c])))
            fail_msg("(%g, %g, %g), expected (%g, %g, %g)", (double)v[0], (double)v[1], (double)v[2], r, g, b);
}

/* ---- Defaults and values ---- */

/* An option of a method, as the scene keeps it. */
static void expect_option(const ty_scene* scene, const char* method, const char* key, const char* value) {
    const char* kept = ty_scene_get_option(scene, method, key);
    if (kept == NULL || strcmp(kept, value) != 0)
        fail_msg("render.%s.%s is %s, not %s", method, key, kept == NULL ? "not there" : kept, value);
}

static void the_smallest_scene_has_the_defaults(void** state) {
    (void)state;
    ty_context* context = make_context();
    ty_scene* scene = parse(context, "\xef\xbb\xbf{\"tyndall\":1}");
    const ty_camera_def camera = ty_scene_camera(scene);
    expect_vector(camera.position, 0, 0, 5);
    expect_vector(camera.up, 0, 1, 0);
    assert_int_equal(camera.resolution[0], 800);
    const ty_render_settings render = ty_scene_render_settings(scene);
    assert_string_equal(render.method, "auto");
    assert_int_equal(render.spp, 64);
    assert_int_equal(render.seed, 0);
    ty_dom_def dom = ty_default_dom_def();
    const ty_dom_def plain = ty_default_dom_def();
    expect_ok(context, ty_method_options(scene, "dom", &dom));
    assert_memory_equal(&dom, &plain, sizeof dom);
    assert_null(ty_scene_get_option(scene, "dom", "directions"));
    assert_int_equal(ty_scene_up_axis(scene), TY_AXIS_Y);
    assert_int_equal(ty_scene_get_info(scene).media, 0);
    ty_scene_destroy(scene);
    scene = parse(context, "{\"tyndall\":1,\"up_axis\":\"z\"}");
    const ty_camera_def above = ty_scene_camera(scene);
    expect_vector(above.position, 0, -5, 0);
    expect_vector(above.up, 0, 0, 1);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

static void camera_and_render_are_read(void** state) {
    (void)state;
    ty_context* context = make_context();
    ty_scene* scene = parse(
        context, "{\"tyndall\":1,\"camera\":{\"position\":[1,2,3],\"target\":[4,5,7],\"up\":[0,0,2],"
                 "\"fov_y\":30.5,\"resolution\":[64,32.0],\"exposure\":-1.5},"
                 "\"render\":{\"method\":\"path\",\"spp\":7,\"seed\":9007199254740991,"
                 "\"path\":{\"max_depth\":3},\"screen\":{\"variant\":\"naive\",\"spread\":\"gaussian\",\"filter\":6,"
                 "\"levels\":5,\"environment\":\"lights\",\"balance\":false}}}");
    const ty_camera_def camera = ty_scene_camera(scene);
    expect_vector(camera.position, 1, 2, 3);
    expect_vector(camera.target, 4, 5, 7);
    assert_float_equal(camera.fov_y, 30.5, 0);
    assert_int_equal(camera.resolution[1], 32);
    assert_float_equal(camera.exposure, -1.5, 0);
    const ty_render_settings render = ty_scene_render_settings(scene);
    assert_int_equal(render.spp, 7);
    assert_true(render.seed == 9007199254740991u);
    assert_int_equal(camera.moves, 0);
    expect_option(scene, "path", "max_depth", "3");
    expect_option(scene, "screen", "variant", "naive");
    expect_option(scene, "screen", "spread", "gaussian");
    expect_option(scene, "screen", "filter", "6");
    expect_option(scene, "screen", "levels", "5");
    expect_option(scene, "screen", "environment", "lights");
    expect_option(scene, "screen", "balance", "false");
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

static void lenses_and_motion_are_read(void** state) {
    (void)state;
    ty_context* context = make_context();
    ty_scene* scene = parse(context, "{\"tyndall\":1,\"meters_per_unit\":0.5,\"camera\":{\"position\":[1,2,3],"
                                     "\"target\":[4,5,7],\"shift\":[0.25,-0.5],\"aperture_radius\":0.25,"
                                     "\"focus_distance\":8,\"motion\":{\"position\":[2,2,3]}}}");
    const ty_camera_def camera = ty_scene_camera(scene);
    assert_true(camera.shift[0] == 0.25 && camera.shift[1] == -0.5);
    assert_float_equal(camera.aperture_radius, 0.125, 0);
    assert_float_equal(camera.focus_distance, 4, 0);
    assert_int_equal(camera.moves, 1);
    expect_vector(camera.end_position, 1, 1, 1.5);
    expect_vector(camera.end_target, 2, 2.5, 3.5);
    expect_vector(camera.end_up, 0, 1, 0);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

typedef struct coefficient_case {
    const char* members;
    double sigma_s[3], sigma_a[3], g[3];
    double scale;
} coefficient_case;

static const coefficient_case coefficient_cases[] = {
    {"\"sigma_s\":2", {2, 2, 2}, {0, 0, 0}, {0, 0, 0}, 1},
    {"\"sigma_a\":[1,2,3],\"g\":-0.5", {0, 0, 0}, {1, 2, 3}, {-0.5, -0.5, -0.5}, 1},
    {"\"sigma_s\":[1,2,3],\"sigma_a\":4,\"g\":[0.1,0.2,0.3]", {1, 2, 3}, {4, 4, 4}, {0.1, 0.2, 0.3}, 1},
    {"\"sigma_t\":[2,4,8],\"albedo\":0.75", {1.5, 3, 6}, {0.5, 1, 2}, {0, 0, 0}, 1},
    {"\"sigma_t\":10,\"albedo\":[1,0.5,0]", {10, 5, 0}, {0, 5, 10}, {0, 0, 0}, 1},
    {"\"sigma_s\":1,\"density\":3,\"scale\":0.5", {1, 1, 1}, {0, 0, 0}, {0, 0, 0}, 1.5},
    {"\"preset\":\"wholemilk\",\"scale\":0.01", {2550, 3210, 3770}, {1.1, 2.4, 14}, {0, 0, 0}, 0.01},
    {"\"preset\":\"Apple\",\"g\":[0.5,0,-1e-9]", {4580, 2390, 1970}, {3, 3.4, 46}, {0.5, 0, 0}, 1},
    {"\"preset\":\"jerlov 9c\",\"g\":0.8", {2.546, 3.12, 4.39}, {0.4268, 0.348, 0.943}, {0.8, 0.8, 0.8}, 1},
    {"\"preset\":\"fog\",\"visibility\":0.5",
     {5.9914645, 5.9914645, 5.9914645},
     {0, 0, 0},
     {0.864164, 0.864164, 0.864164},
     1},
    {"\"preset\":\"apple\",\"dilution\":2",
     {1145.0004, 1195.0007, 985.00175},
     {1.63775, 1.72825, 23.00461},
     {0, 0, 0},
     1},
    {"\"sigma_s\":1,\"g\":[0.99999999999,-0.99999999999,0]", {1, 1, 1}, {0, 0, 0}, {1 - 6e-8, 6e-8 - 1, 0}, 1},
};

static void coefficients_are_read(void** state) {
    (void)state;
    ty_context* context = make_context();
    for (size_t i = 0; i < COUNT(coefficient_cases); ++i) {
        const coefficient_case* row = &coefficient_cases[i];
        char text[512];
        snprintf(text, sizeof text, "{\"tyndall\":1,\"media\":[{%s," BOX "}]}", row->members);
        ty_scene* scene = parse(context, text);
        ty_medium_def medium;
        assert_int_equal(ty_scene_get_medium(scene, 0, &medium), TY_OK);
        expect_rgb(medium.sigma_s, row->sigma_s[0], row->sigma_s[1], row->sigma_s[2]);
        expect_rgb(medium.sigma_a, row->sigma_a[0], row->sigma_a[1], row->sigma_a[2]);
        float g[3];
        assert_int_equal(ty_medium_mean_cosine(context, &medium, g), TY_OK);
        expect_rgb(g, row->g[0], row->g[1], row->g[2]);
        assert_float_equal(medium.scale, row->scale, 1e-6);
        for (int c = 0; c < 3; ++c) assert_true(fabsf(medium.g[c]) < 1);
        ty_scene_destroy(scene);
    }
    ty_context_destroy(context);
}

static void phase_functions_are_read(void** state) {
    (void)state;
    ty_context* context = make_context();
    ty_scene* scene = parse(
        context, "{\"tyndall\":1,\"media\":["
                 "{\"sigma_s\":1," BOX ",\"phase\":{\"type\":\"mix\",\"lobes\":[{\"weight\":0.9,\"g\":0.85},"
                 "{\"weight\":0.1,\"g\":-0.3,\"alpha\":2}]}},"
                 "{\"sigma_s\":1," BOX ",\"phase\":{\"type\":\"table\",\"angles\":[0,60,180],\"values\":[3,1,2]}},"
                 "{\"sigma_s\":1," BOX ",\"phase\":{\"type\":\"fournier_forand\",\"n\":1.1,\"mu\":3.6}},"
                 "{\"sigma_s\":1," BOX ",\"phase\":{\"type\":\"rayleigh\"}}]}");
    ty_medium_def media[4];
    for (int i = 0; i < 4; ++i) assert_int_equal(ty_scene_get_medium(scene, i, &media[i]), TY_OK);
    assert_int_equal(media[0].phase_count, 2);
    assert_float_equal(media[0].phase[0].weight[2], 0.9, 1e-6);
    assert_float_equal(media[0].phase[0].g, 0.85, 0);
    assert_float_equal(media[0].phase[1].g, -0.3, 0);
    assert_float_equal(media[0].phase[1].alpha, 2, 0);
    assert_int_equal(media[1].phase[0].kind, TY_PHASE_TABLE);
    assert_int_equal(media[1].phase[0].count, 3);
    assert_float_equal(media[1].phase[0].cosines[0], 1, 0);
    assert_float_equal(media[1].phase[0].cosines[1], 0.5, 1e-15);
    assert_float_equal(media[1].phase[0].cosines[2], -1, 0);
    assert_float_equal(media[1].phase[0].values[2], 2, 0);
    assert_int_equal(media[2].phase[0].kind, TY_PHASE_FOURNIER_FORAND);
    assert_float_equal(media[2].phase[0].n, 1.1, 0);
    assert_float_equal(media[2].phase[0].mu, 3.6, 0);
    assert_float_equal(media[3].phase[0].alpha, 1, 0);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

static void lights_are_read(void** state) {
    (void)state;
    ty_context* context = make_context();
    ty_scene* scene = parse(
        context,
        "{\"tyndall\":1,\"lights\":["
        "{\"type\":\"directional\",\"direction\":[0,-2,0],\"irradiance\":[1,2,3]},"
        "{\"type\":\"point\",\"position\":[1,2,3],\"intensity\":4,\"radius\":0.5},"
        "{\"type\":\"spot\",\"position\":[1,2,3],\"direction\":[1,0,0],\"intensity\":5,\"cone\":60,\"penumbra\":0.5},"
        "{\"type\":\"area\",\"origin\":[1,2,3],\"u\":[1,0,0],\"v\":[0,2,0],\"radiance\":6},"
        "{\"type\":\"environment\",\"radiance\":7,\"scale\":2},"
        "{\"type\":\"environment\",\"scale\":2,\"sky\":{\"resolution\":16,\"solar\":[1,2,3],\"sun_direction\":[0,-1,0]}"
        "},"
        "{\"type\":\"environment\",\"sky\":{\"resolution\":16,\"sun\":false}},"
        "{\"type\":\"environment\",\"sky\":{\"resolution\":16,\"sun_direction\":[0,1,0]}}]}");
    static const ty_light_kind kinds[] = {TY_LIGHT_DIRECTIONAL, TY_LIGHT_POINT,       TY_LIGHT_SPOT,
                                          TY_LIGHT_AREA,        TY_LIGHT_ENVIRONMENT, TY_LIGHT_ENVIRONMENT,
                                          TY_LIGHT_DIRECTIONAL, TY_LIGHT_ENVIRONMENT, TY_LIGHT_ENVIRONMENT};
    assert_int_equal(scene->light_count, COUNT(kinds)); /* no sun below the horizon, none where it is not wanted */
    for (size_t i = 0; i < COUNT(kinds); ++i) assert_int_equal(scene->lights[i].kind, kinds[i]);
    const ty_light_def* lights = scene->lights;
    expect_vector(lights[0].direction, 0, -2, 0);
    expect_rgb(lights[0].color, 1, 2, 3);
    expect_vector(lights[1].position, 1, 2, 3);
    expect_rgb(lights[1].color, 4, 4, 4);
    assert_float_equal(lights[1].radius, 0.5, 0);
    assert_float_equal(lights[2].radius, 0, 0);
    assert_float_equal(lights[2].cone, 60, 0);
    assert_float_equal(lights[2].penumbra, 0.5, 0);
    expect_vector(lights[3].position, 1, 2, 3);
    expect_vector(lights[3].v, 0, 2, 0);
    expect_rgb(lights[4].color, 14, 14, 14);
    assert_float_equal(lights[4].scale, 1, 0);
    assert_float_equal(lights[5].scale, 2, 0);
    expect_vector(lights[6].direction, 0, -1, 0);
    assert_true(lights[6].color[0] > 1 && lights[6].color[0] < 2); /* twice what the air lets through of 1 */
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

static void shapes_are_read(void** state) {
    (void)state;
    ty_context* context = make_context();
    ty_scene* scene =
        parse(context, "{\"tyndall\":1,\"geometry\":["
                       "{\"quad\":{\"origin\":[1,2,3],\"u\":[1,0,0],\"v\":[0,2,0]}},"
                       "{\"box\":[[0,0,0],[1,2,3]],\"material\":{\"albedo\":[0.1,0.2,0.3],\"emission\":2}},"
                       "{\"sphere\":{\"center\":[1,0,0],\"radius\":2},"
                       "\"transform\":{\"rotate\":[0,0,90],\"scale\":3,\"translate\":[0,0,1]}}]}");
    assert_int_equal(scene->shape_count, 3);
    expect_rgb(scene->shapes[0].albedo, 0.5, 0.5, 0.5);
    expect_vector(scene->shapes[0].u, 1, 0, 0);
    expect_vector(scene->shapes[1].u, 1, 2, 3);
    expect_rgb(scene->shapes[1].albedo, 0.1, 0.2, 0.3);
    expect_rgb(scene->shapes[1].emission, 2, 2, 2);
    double center[3];
    ty_affine_point(&scene->shapes[2].transform, scene->shapes[2].origin, center);
    expect_vector(center, 0, 3, 1);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

/* ---- Units ---- */

static void meters_per_unit_scales_lengths(void** state) {
    (void)state;
    ty_context* context = make_context();
    ty_scene* scene = parse(
        context, "{\"tyndall\":1,\"meters_per_unit\":0.01,\"camera\":{\"position\":[0,0,100]},"
                 "\"media\":[{\"sigma_s\":3,\"bounds\":[[0,0,0],[100,200,300]],"
                 "\"transform\":{\"scale\":2,\"translate\":[100,0,0]}},"
                 "{\"sigma_s\":3,\"bounds\":{\"sphere\":{\"center\":[100,0,0],\"radius\":50}}}],"
                 "\"lights\":[{\"type\":\"area\",\"origin\":[100,0,0],\"u\":[100,0,0],\"v\":[0,100,0],\"radiance\":1}],"
                 "\"geometry\":[{\"sphere\":{\"center\":[100,0,0],\"radius\":50},"
                 "\"transform\":[1,0,0,100, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]}");
    expect_vector(ty_scene_camera(scene).position, 0, 0, 1);
    ty_medium_def medium;
    double corner[3];
    assert_int_equal(ty_scene_get_medium(scene, 0, &medium), TY_OK);
    ty_affine_point(&medium.transform, medium.box_max, corner);
    expect_vector(corner, 3, 4, 6);
    expect_rgb(medium.sigma_s, 3, 3, 3);
    assert_int_equal(ty_scene_get_medium(scene, 1, &medium), TY_OK);
    expect_vector(medium.sphere_center, 1, 0, 0);
    assert_float_equal(medium.sphere_radius, 0.5, 1e-12);
    expect_vector(scene->lights[0].position, 1, 0, 0);
    expect_vector(scene->lights[0].u, 1, 0, 0);
    ty_affine_point(&scene->shapes[0].transform, scene->shapes[0].origin, corner);
    expect_vector(corner, 2, 0, 0);
    assert_float_equal(scene->shapes[0].radius, 0.5, 1e-12);
    ty_scene_destroy(scene);
    scene = parse(context, "{\"tyndall\":1,\"meters_per_unit\":0.01}");
    expect_vector(ty_scene_camera(scene).position, 0, 0, 0.05);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

/* ---- Files ---- */

static void write_text(const char* path, const char* text) {
    FILE* file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* density.vdb with a grid "density", sky.exr, map.png, tetra.obj and camera.gltf, in the current folder. */
static void write_files(ty_context* context) {
    write_text("mie.scat", "! table\n 7.0 1.0 1.0 1  Reff  Ext  Alb  Nleg\n 1.0 0.9\n");
    write_text("tetra.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n");
    write_text("camera.gltf",
               "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"camera\":0}],"
               "\"cameras\":[{\"type\":\"perspective\",\"name\":\"front\","
               "\"perspective\":{\"yfov\":1,\"znear\":0.1}}]}");
    float values[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    ty_grid_def def = ty_default_grid_def();
    for (int a = 0; a < 3; ++a) def.size[a] = 2;
    def.values = values;
    def.placed = true;
    def.index_to_local = ty_affine_compose((double[3]){10, 0, 0}, (double[3]){0, 0, 0}, (double[3]){4, 4, 4});
    ty_grid* grid = NULL;
    expect_ok(context, ty_grid_create(context, &def, &grid));
    expect_ok(context, ty_vdb_write(context, grid, "density", "none", "density.vdb"));
    ty_grid_release(grid);
    ty_image* image = NULL;
    expect_ok(context, ty_image_create_rgb(context, 8, 4, &image));
    for (int32_t c = 0; c < 3; ++c)
        for (int i = 0; i < 32; ++i) ty_image_plane(image, c)[i] = 1;
    expect_ok(context, ty_image_write_exr(context, image, "sky.exr"));
    expect_ok(context, ty_image_write_png(context, image, 0, TY_TONE_CLIP, "map.png"));
    ty_image_destroy(image);
    static dicom_writer writer;
    const dicom_form form = dicom_default_form();
    dicom_slice(&writer, &form, "0\\0\\0");
    dicom_pixels(&writer, &form, (const int64_t[6]){1, 2, 3, 4, 5, 6});
    mkdir("slice", 0777);
    put_file("slice/a.dcm", writer.bytes, writer.size);
}

static const char volume_scene[] =
    "{\"tyndall\":1,\"meters_per_unit\":0.5,\"media\":["
    "{\"density\":{\"file\":\"density.vdb\"},\"sigma_s\":1,\"transform\":{\"translate\":[2,0,0]}},"
    "{\"density\":{\"file\":\"density.VDB\",\"grid\":\"density\"},\"sigma_a\":1,\"bounds\":[[10,0,0],[14,4,2]]},"
    "{\"density\":{\"file\":\"density.vdb\",\"grid\":\"density\"},\"sigma_a\":1}],"
    "\"lights\":[{\"type\":\"environment\",\"file\":\"sky.exr\",\"scale\":2,\"rotation\":90}]}";

static void files_are_placed_in_units_and_shared(void** state) {
    (void)state;
    ty_context* context = make_context();
    write_files(context);
    assert_int_equal(rename("density.vdb", "density.VDB"), 0);
    write_files(context);
    ty_scene* scene = parse(context, volume_scene);
    ty_medium_def first, second, third;
    assert_int_equal(ty_scene_get_medium(scene, 0, &first), TY_OK);
    assert_int_equal(ty_scene_get_medium(scene, 1, &second), TY_OK);
    assert_int_equal(ty_scene_get_medium(scene, 2, &third), TY_OK);
    assert_ptr_equal(first.density_grid, third.density_grid);
    assert_ptr_not_equal(first.density_grid, second.density_grid);
    /* Voxel (1, 0, 0) is at 14 units, moved by 2, half a metre each. */
    const ty_affine place = ty_grid_get_info(first.density_grid).index_to_local;
    const double index[3] = {1, 0, 0};
    double local[3], world[3];
    ty_affine_point(&place, index, local);
    ty_affine_point(&first.transform, local, world);
    expect_vector(world, 8, 0, 0);
    assert_int_equal(first.bounds, TY_BOUNDS_NONE);
    assert_int_equal(second.bounds, TY_BOUNDS_BOX);
    ty_affine_point(&second.transform, second.box_max, world);
    expect_vector(world, 7, 2, 1);
    assert_float_equal(scene->lights[0].rotation, 90, 0);
    assert_float_equal(scene->lights[0].scale, 2, 0);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

static void paths_start_at_the_scene(void** state) {
    (void)state;
    ty_context* context = make_context();
    write_files(context);
    write_text("scene.json", "{\"tyndall\":1,\"lights\":[\n{\"type\":\"environment\",\"file\":\"sky.exr\"}]}");
    ty_scene* scene = NULL;
    expect_ok(context, ty_scene_load(context, "./scene.json", NULL, 0, &scene));
    ty_scene_destroy(scene);
    expect_ok(context, ty_scene_load(context, "scene.json", NULL, 0, &scene));
    ty_scene_destroy(scene);
    write_text("scene.json", "{\"tyndall\":1,\"lights\":[\n{\"type\":\"environment\",\"file\":\"scene.json\"}]}");
    assert_int_equal(ty_scene_load(context, "./scene.json", NULL, 0, &scene), TY_ERROR_INPUT);
    assert_memory_equal(ty_take_error(context), "./scene.json:2: lights[0].file: ./scene.json", 44);
    ty_context_destroy(context);
}

static uint64_t hash_of(ty_context* context, const char* text, const char* override) {
    ty_scene* scene = parse_with(context, text, &override, override != NULL);
    const uint64_t hash = ty_scene_hash(scene);
    ty_scene_destroy(scene);
    return hash;
}

static void the_hash_follows_the_content(void** state) {
    (void)state;
    ty_context* context = make_context();
    write_files(context);
    const char* text = "{\"tyndall\":1,\"lights\":[{\"type\":\"environment\",\"file\":\"sky.exr\"}]}";
    const char* spaced = "{\"lights\": [{\"file\": \"sky.exr\", \"type\": \"environment\"}],\n\"tyndall\": 1}";
    const uint64_t hash = hash_of(context, text, NULL);
    assert_true(hash != 0);
    assert_true(hash == hash_of(context, spaced, NULL));
    assert_true(hash != hash_of(context, text, "render.spp=1"));
    assert_true(hash_of(context, text, "render.spp=1") == hash_of(context, spaced, "render={\"spp\":1}"));
    ty_image* image = NULL;
    expect_ok(context, ty_image_create_rgb(context, 8, 4, &image));
    expect_ok(context, ty_image_write_exr(context, image, "sky.exr"));
    ty_image_destroy(image);
    assert_true(hash != hash_of(context, text, NULL));
    ty_context_destroy(context);
}

/* ---- Overrides ---- */

static void overrides_change_the_scene(void** state) {
    (void)state;
    ty_context* context = make_context();
    const char* text = "{\"tyndall\":1,\"media\":[{\"sigma_s\":1," BOX "},{\"sigma_s\":1," BOX ",\"g\":[0,0,0]}]}";
    const char* overrides[] = {"render.path.max_depth=5", "render.spp=3",   "render.spp=4", "media[1].g[2]=-0.5",
                               "media[0].name=grey fog",  "media[0].name=", "up_axis=z",    "camera={\"fov_y\":20}",
                               "camera.exposure= 2"};
    ty_scene* scene = parse_with(context, text, overrides, COUNT(overrides));
    const ty_render_settings render = ty_scene_render_settings(scene);
    assert_int_equal(render.spp, 4);
    expect_option(scene, "path", "max_depth", "5");
    ty_medium_def medium;
    assert_int_equal(ty_scene_get_medium(scene, 1, &medium), TY_OK);
    expect_rgb(medium.g, 0, 0, -0.5);
    assert_int_equal(ty_scene_get_medium(scene, 0, &medium), TY_OK);
    assert_string_equal(medium.name, "");
    assert_int_equal(ty_scene_up_axis(scene), TY_AXIS_Z);
    assert_float_equal(ty_scene_camera(scene).fov_y, 20, 0);
    assert_float_equal(ty_scene_camera(scene).exposure, 2, 0);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

/* ---- Every key ---- */

static const char every_key[] =
    "{\"$schema\":\"scene.schema.json\",\"tyndall\":1,\"comment\":[\"by "
    "hand\"],\"meters_per_unit\":1,\"up_axis\":\"z\",\"frame\":1,"
    "\"camera\":{\"file\":\"camera.gltf\",\"name\":\"front\",\"position\":[0,-5,0],\"target\":[0,0,0],\"up\":[0,0,1],"
    "\"fov_y\":40,\"resolution\":[8,6],"
    "\"exposure\":0,\"shift\":[0,0],\"aperture_radius\":0,\"focus_distance\":5,\"motion\":{\"position\":[0,-5,0],"
    "\"target\":[0,0,0],\"up\":[0,0,1]}},"
    "\"media\":[{\"name\":\"a\",\"density\":1,\"bounds\":{\"sphere\":{\"center\":[0,0,0],\"radius\":1}},"
    "\"transform\":{\"translate\":[0,0,0],\"rotate\":[0,0,0],\"scale\":[1,1,1]},\"sigma_s\":1,\"sigma_a\":1,\"scale\":"
    "1,\"g\":0},"
    "{\"density\":{\"file\":\"density.vdb\",\"grid\":\"density\",\"component\":0,\"frame\":2,\"storage\":\"sparse\"},"
    "\"sigma_t\":1,"
    "\"transfer\":[{\"value\":0,\"density\":1,\"albedo\":1},{\"value\":1,\"density\":2,\"albedo\":[1,1,1]}]},"
    "{\"density\":{\"file\":\"camera.gltf\",\"raw\":{\"size\":[2,2,2],\"type\":\"uint8\",\"spacing\":1,\"offset\":-1,"
    "\"big_endian\":true}},\"sigma_t\":1,\"albedo\":{\"file\":\"density.vdb\",\"grid\":\"density\"},"
    "\"g\":{\"file\":\"density.vdb\",\"grid\":\"density\"},\"bounds\":{\"file\":\"tetra.obj\",\"transform\":{}},"
    "\"emission\":{\"radiance\":1,\"temperature\":{\"file\":\"density.vdb\",\"grid\":\"density\"},"
    "\"kelvin\":[300,900],\"scale\":1}},"
    "{\"preset\":\"apple\"," BOX ",\"density\":{\"noise\":{\"kind\":\"fbm\",\"resolution\":[4,5,6],\"seed\":4294967295,"
    "\"frequency\":2,\"octaves\":2,\"gain\":0.5,\"lacunarity\":2,\"coverage\":0.5,\"sharpness\":4}}},"
    "{\"preset\":\"apple\",\"dilution\":2," BOX "},{\"preset\":\"fog\",\"visibility\":9," BOX "},"
    "{\"sigma_s\":1," BOX ",\"density\":{\"noise\":{\"kind\":\"constant\",\"resolution\":2}}},"
    "{\"sigma_s\":1," BOX ",\"density\":{\"exponential\":{\"scale_height\":3,\"base\":1}}},"
    "{\"sigma_s\":1," BOX ",\"phase\":{\"type\":\"hg\",\"g\":0.5}},"
    "{\"sigma_s\":1," BOX ",\"phase\":{\"type\":\"rayleigh\"}},"
    "{\"sigma_s\":1," BOX ",\"phase\":{\"type\":\"draine\",\"g\":0.5,\"alpha\":2}},"
    "{\"sigma_s\":1," BOX ",\"phase\":{\"type\":\"mie\",\"diameter\":8}},"
    "{\"sigma_s\":1," BOX ",\"phase\":{\"type\":\"mix\",\"lobes\":[{\"weight\":1,\"g\":0.5,\"alpha\":1}]}},"
    "{\"sigma_s\":1," BOX ",\"phase\":{\"type\":\"fournier_forand\",\"n\":1.1,\"mu\":3.6}},"
    "{\"sigma_s\":1," BOX ",\"phase\":{\"type\":\"fournier_forand\",\"backscatter\":0.02}},"
    "{\"sigma_s\":1," BOX ",\"phase\":{\"type\":\"table\",\"angles\":[0,90,180],\"values\":[3,1,2]}},"
    "{\"sigma_s\":1," BOX ",\"phase\":{\"type\":\"table\",\"cosines\":[-1,0,1],\"values\":[3,1,2]}},"
    "{\"sigma_s\":1,\"density\":{\"file\":\"slice/a.dcm\",\"series\":\"3\"}},"
    "{\"sigma_s\":1," BOX
    ",\"phase\":{\"type\":\"table\",\"file\":\"mie.scat\",\"content\":\"shdom\",\"effective_radius\":7}}],"
    "\"lights\":[{\"type\":\"directional\",\"direction\":[0,0,-1],\"irradiance\":1},"
    "{\"type\":\"point\",\"position\":[0,0,0],\"intensity\":1},"
    "{\"type\":\"spot\",\"position\":[0,0,0],\"direction\":[0,0,-1],\"intensity\":1,\"cone\":40,\"penumbra\":0.1},"
    "{\"type\":\"area\",\"origin\":[0,0,0],\"u\":[1,0,0],\"v\":[0,1,0],\"radiance\":1},"
    "{\"type\":\"environment\",\"file\":\"sky.exr\",\"scale\":1,\"rotation\":0},"
    "{\"type\":\"environment\",\"radiance\":1},"
    "{\"type\":\"environment\",\"sky\":{\"sun_direction\":[0,0,-1],\"solar\":1,\"haze\":1,\"ground\":0.1,\"sun\":true,"
    "\"resolution\":16,\"ozone\":1,\"multiple_scattering\":\"none\",\"air\":[[0,0,0],[9,9,9]]}}],"
    "\"geometry\":[{\"quad\":{\"origin\":[0,0,0],\"u\":[1,0,0],\"v\":[0,1,0]},\"material\":{\"albedo\":0.5,"
    "\"emission\":1,\"metallic\":0,\"roughness\":0.5,\"ior\":1.5,\"specular\":1,\"specular_color\":[1,1,1],"
    "\"transmission\":0.5,\"clearcoat\":1,\"clearcoat_roughness\":0.1,\"sheen_color\":0.5,"
    "\"sheen_roughness\":0.5},"
    "\"transform\":{}},{\"file\":\"tetra.obj\",\"meshes\":true,\"lights\":true,\"gloss\":false,\"light_scale\":1,"
    "\"emission_scale\":1,\"material\":{\"base_color\":{\"file\":\"map.png\",\"factor\":0.5,\"repeat\":2},"
    "\"normal_map\":{\"file\":\"map.png\",\"scale\":2},\"clearcoat_normal_map\":{\"file\":\"map.png\"}}},"
    "{\"box\":[[0,0,0],[1,1,1]],\"material\":{\"transmission\":1,"
    "\"volume\":{\"attenuation_color\":0.5,\"attenuation_distance\":2,\"priority\":1}}},{\"sphere\":{\"center\":[0,0,"
    "0],\"radius\":1}}],"
    "\"render\":{\"method\":\"path\",\"spp\":1,\"seed\":1,\"path\":{\"max_depth\":0,\"point_light_directions\":true,"
    "\"energy_compensation\":true,\"guide\":\"auto\"},"
    "\"screen\":{\"variant\":\"scatter\",\"spread\":\"gaussian\",\"filter\":4,\"levels\":\"auto\",\"environment\":"
    "\"none\","
    "\"balance\":false},"
    "\"fld\":{\"interreflection\":false,\"limiter\":\"larsen\",\"larsen_power\":3,\"max_flux_fraction\":1,\"boundary\":"
    "\"dirichlet\",\"solver\":"
    "\"sor\","
    "\"relaxation\":1.5,\"tolerance\":1e-3,\"iterations\":9,\"sigma_eps\":0.1,\"beam\":\"published\",\"resolution\":32,"
    "\"ratio\":2,\"environment_beams\":8,\"surface_points\":4,\"interior_resolution\":40,\"spp\":2,\"step\":0.5,\"ray_"
    "spacing\":2},"
    "\"pop\":{\"mode\":\"collided\",\"resolution\":16,\"merged\":24,\"fine_lights\":false,\"direct\":40,\"ordinates\":"
    "27,"
    "\"prefilter\":0.5,\"importance\":false,\"surface_points\":5,\"vpls\":7,\"shadow_texels\":32,\"vpl_min_distance\":"
    "0.1,"
    "\"iterations\":11,\"residuum\":0.2,\"residuum_iterations\":12,\"max_flux_fraction\":0.7,\"tolerance\":1e-2,"
    "\"spp\":3,"
    "\"step\":0.25,\"ray_spacing\":8},"
    "\"lpv\":{\"mode\":\"published\",\"light_samples\":3,\"parts\":\"both\",\"place\":\"camera\",\"resolution\":24,"
    "\"extent\":20,"
    "\"cascades\":3,\"bands\":3,\"window\":0.1,\"iterations\":10,\"tolerance\":0.02,\"map_side\":64,\"samples\":4,"
    "\"block_side\":2,\"shadow_side\":128,\"shadow_rays\":false,\"half\":false,\"step\":0.75,\"spp\":5},"
    "\"dom\":{\"resolution\":20,\"direct\":60,\"directions\":48,\"last_directions\":80,\"bands\":4,\"acceleration\":"
    "\"none\","
    "\"tolerance\":1e-4,\"iterations\":50,\"environment_beams\":9,\"surface_points\":6,\"differentiable\":true,\"spp\":"
    "4,\"step\":2,\"ray_"
    "spacing\":4},"
    "\"octaves\":{\"count\":3,\"scattering\":0.4,\"extinction\":0.6,\"anisotropy\":0.3,\"view_extinction\":\"scaled\","
    "\"resolution\":30,\"environment_beams\":8,\"surface_points\":4,\"spp\":2,\"step\":0.5,\"ray_spacing\":2,"
    "\"froxels\":80,\"froxel_slices\":32}}}";

/* The keys of scenes that repeat, which cannot have all of the others. */
static const char periodic_keys[] =
    "{\"tyndall\":1,\"up_axis\":\"z\",\"boundary\":{\"periodic\":[\"x\",\"y\"],\"cell\":[[0,0,0],[9,9,9]]},"
    "\"media\":[{\"sigma_s\":1," BOX "}],"
    "\"lights\":[{\"type\":\"directional\",\"zenith\":60,\"azimuth\":90,\"horizontal_irradiance\":1},"
    "{\"type\":\"directional\",\"zenith\":30,\"irradiance\":[1,2,3]}]}";

/* Liquid water in mass per mass of air, 0.5 g/kg at one of eight voxels. */
static const char droplets_scene[] =
    "{\"tyndall\":1,\"meters_per_unit\":1000,\"media\":[{\"density\":{\"file\":\"cloud.nc\",\"grid\":\"qc\","
    "\"droplets\":{\"effective_radius\":\"reff\",\"air_density\":1.2}},\"sigma_t\":1,\"albedo\":1}]}";

/* Droplets scatter as those of their mean diameter, unless the medium has a mean cosine. */
static void droplets_scatter_by_their_size(void** state) {
    (void)state;
    static const double line[] = {1000, 3000}, water[8] = {0, 0, 0, 0, 0, 0, 0, 0.5}, radii[] = {5, 12};
    const made_file file = {{"z", "y", "x"},
                            {2, 2, 2},
                            {{"z", {0}, 1, {{"units", "m"}}, MADE_DOUBLE, line},
                             {"y", {1}, 1, {{"units", "m"}}, MADE_DOUBLE, line},
                             {"x", {2}, 1, {{"units", "m"}}, MADE_DOUBLE, line},
                             {"qc", {0, 1, 2}, 3, {{"units", "g/kg"}}, MADE_FLOAT, water},
                             {"reff", {0}, 1, {{"units", "um"}}, MADE_FLOAT, radii}}};
    make_netcdf("cloud.nc", &file);
    ty_context* context = make_context();
    const ty_volume_def def = ty_default_volume_def();
    int32_t times = 0;
    const bool available = ty_volume_components(context, "cloud.nc", &def, &times) == TY_OK;
    ty_take_error(context);
    if (!available) {
        ty_context_destroy(context);
        skip(); /* the build, or the machine, has no NetCDF */
    }
    ty_scene* scene = parse(context, droplets_scene);
    ty_medium_def medium;
    assert_int_equal(ty_scene_get_medium(scene, 0, &medium), TY_OK);
    assert_int_equal(medium.phase_count, 1);
    assert_int_equal(medium.phase[0].kind, TY_PHASE_MIE);
    assert_float_equal(medium.phase[0].diameter, 24, 1e-6);
    const ty_grid_info info = ty_grid_get_info(medium.density_grid);
    assert_float_equal(info.max, 3 * 0.5e-3 * 1.2 / (2 * 1000 * 12e-6), 1e-8);
    assert_float_equal(info.index_to_local.m[0], 2, 1e-12); /* km, the scene's units */
    assert_float_equal(info.index_to_local.m[3], 1, 1e-12);
    ty_scene_destroy(scene);
    const char* g = "media[0].g=0.5";
    expect_ok(context, ty_scene_parse(context, droplets_scene, strlen(droplets_scene), "s", "", &g, 1, &scene));
    assert_int_equal(ty_scene_get_medium(scene, 0, &medium), TY_OK);
    assert_int_equal(medium.phase_count, 0);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

/* Fails on a key under "properties" anywhere in the schema that does not stand in the text. */
static void expect_keys(const json_t* schema, const char* text) {
    const char* key;
    json_t* value;
    size_t i;
    json_array_foreach(schema, i, value) expect_keys(value, text);
    json_object_foreach((json_t*)schema, key, value) {
        const char* name;
        json_t* property;
        if (strcmp(key, "properties") == 0) json_object_foreach(value, name, property) {
                char quoted[80];
                snprintf(quoted, sizeof quoted, "\"%s\":", name);
                if (strstr(text, quoted) == NULL) fail_msg("%s is not tried", name);
            }
        expect_keys(value, text);
    }
}

static void every_key_is_accepted(void** state) {
    (void)state;
    ty_context* context = make_context();
    write_files(context);
    json_t* schema = json_loads(ty_scene_schema(), 0, NULL);
    static char text[sizeof every_key + sizeof droplets_scene + sizeof periodic_keys];
    snprintf(text, sizeof text, "%s%s%s", every_key, droplets_scene, periodic_keys);
    expect_keys(schema, text);
    json_decref(schema);
    ty_scene* scene = parse(context, every_key);
    const ty_scene_info info = ty_scene_get_info(scene);
    assert_int_equal(info.media, 21); /* two of them the air of the sky */
    assert_int_equal(info.lights, 8);
    assert_int_equal(info.meshes, 1);
    assert_int_equal(info.shapes, 3);
    ty_medium_def medium;
    assert_int_equal(ty_scene_get_medium(scene, 3, &medium), TY_OK);
    const int32_t size[3] = {4, 5, 6};
    assert_memory_equal(ty_grid_get_info(medium.density_grid).size, size, sizeof size);
    expect_option(scene, "screen", "spread", "gaussian");
    expect_option(scene, "fld", "limiter", "larsen");
    expect_option(scene, "fld", "relaxation", "1.5");
    expect_option(scene, "pop", "fine_lights", "false");
    expect_option(scene, "pop", "merged", "24");
    expect_option(scene, "lpv", "window", "0.1");
    expect_option(scene, "octaves", "view_extinction", "scaled");
    ty_lpv_def lpv = ty_default_lpv_def();
    expect_ok(context, ty_method_options(scene, "lpv", &lpv));
    assert_int_equal(lpv.mode, TY_LPV_MODE_PUBLISHED);
    assert_int_equal(lpv.parts, TY_LPV_PLAIN | TY_LPV_MARCH | TY_LPV_SINGLE);
    assert_true(lpv.tolerance == 0.02 && lpv.step == 0.75 && !lpv.shadow_rays && !lpv.half_resolution_march);
    ty_dom_def dom = ty_default_dom_def();
    expect_ok(context, ty_method_options(scene, "dom", &dom));
    assert_int_equal(dom.acceleration, TY_DOM_ACCELERATION_NONE);
    assert_true(dom.resolution == 20 && dom.last_directions == 80 && dom.tolerance == 1e-4);
    ty_scene_destroy(scene);
    scene = parse(context, periodic_keys);
    const ty_periodic_def periodic = ty_scene_periodic(scene);
    assert_true(periodic.axes[0] && periodic.axes[1] && !periodic.axes[2] && periodic.upper[0] == 9);
    /* A sun at 60 degrees in the north, and another one at 30 degrees in the east, of irradiance 2 and 1, 2, 3. */
    const ty_light_def *first = &scene->lights[0], *second = &scene->lights[1];
    expect_vector(first->direction, 0, -sqrt(0.75), -0.5);
    expect_rgb(first->color, 2, 2, 2);
    expect_vector(second->direction, -0.5, 0, -sqrt(0.75));
    expect_rgb(second->color, 1, 2, 3);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

/* ---- Scenes and manual ---- */

/* The whole of docs/scene.md; freed by the caller. */
static char* read_manual(void) {
    FILE* file = fopen(TYNDALL_SOURCE_DIR "/docs/scene.md", "r");
    assert_non_null(file);
    const size_t size = 1 << 16;
    char* text = calloc(size, 1);
    assert_non_null(text);
    assert_true(fread(text, 1, size - 1, file) < size - 1);
    fclose(file);
    return text;
}

static void builtin_scenes_load_and_are_documented(void** state) {
    (void)state;
    ty_context* context = make_context();
    char* manual = read_manual();
    for (const ty_builtin_scene* builtin = ty_builtin_scenes; builtin->name != NULL; ++builtin) {
        char path[128];
        snprintf(path, sizeof path, "`%s`", builtin->name);
        if (strstr(manual, path) == NULL) fail_msg("docs/scene.md does not name %s", path);
        snprintf(path, sizeof path, "builtin:%s", builtin->name);
        /* Noise at full resolution would take seconds under sanitizers. */
        const char* coarse = "media[0].density.noise.resolution=8";
        ty_scene* scene = NULL;
        expect_ok(context, ty_scene_load(context, path, &coarse, strstr(builtin->text, "\"noise\"") != NULL, &scene));
        assert_true(ty_scene_get_info(scene).bounded);
        assert_true(ty_scene_get_info(scene).lights > 0);
        ty_scene_destroy(scene);
    }
    free(manual);
    ty_scene* scene = NULL;
    const char* override = "render.spp=2";
    expect_ok(context, ty_scene_load(context, "builtin:cornell_fog", &override, 1, &scene));
    assert_int_equal(ty_scene_get_info(scene).shapes, 7);
    assert_int_equal(ty_scene_render_settings(scene).spp, 2);
    ty_scene_destroy(scene);
    expect_ok(context, ty_scene_load(context, "builtin:cube_g0.96", NULL, 0, &scene));
    ty_medium_def medium;
    assert_int_equal(ty_scene_get_medium(scene, 0, &medium), TY_OK);
    expect_rgb(medium.g, 0.96, 0.96, 0.96);
    expect_rgb(medium.sigma_s, 4, 4, 4);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

static void reference_scenes_load(void** state) {
    (void)state;
    static const char* const names[] = {"cube_g0", "cube_g0.7", "cube_g0.96", "cornell_gray"};
    const char* folder = getenv("TYNDALL_DATA");
    if (folder == NULL) folder = TYNDALL_DATA_DIR;
    ty_context* context = make_context();
    for (size_t i = 0; i < COUNT(names); ++i) {
        char path[512];
        snprintf(path, sizeof path, "%s/reference/%s.json", folder, names[i]);
        FILE* file = fopen(path, "r");
        if (file == NULL) {
            print_message("skipped: %s is not there\n", path);
            ty_context_destroy(context);
            skip();
        }
        fclose(file);
        ty_scene* scene = NULL;
        expect_ok(context, ty_scene_load(context, path, NULL, 0, &scene));
        assert_int_equal(ty_scene_camera(scene).resolution[0], 256);
        assert_int_equal(ty_scene_get_info(scene).media, 1);
        ty_scene_destroy(scene);
    }
    ty_context_destroy(context);
}

static void the_manuals_example_parses(void** state) {
    (void)state;
    static const char fence[] = "\n```json\n";
    char* manual = read_manual();
    char* text = strstr(manual, fence);
    assert_non_null(text);
    text += strlen(fence);
    char* end = strstr(text, "\n```");
    assert_non_null(end);
    *end = '\0';
    ty_context* context = make_context();
    ty_scene* scene = parse(context, text);
    assert_int_equal(ty_scene_get_info(scene).lights, 2);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
    free(manual);
}

static void the_manual_lists_every_preset(void** state) {
    (void)state;
    char* manual = read_manual();
    for (char* c = manual; *c != '\0'; ++c)
        if (*c == '\n') *c = ' ';
    for (int32_t i = 0; i < ty_medium_preset_count(); ++i)
        if (strstr(manual, ty_medium_preset_name(i)) == NULL) fail_msg("no preset %s", ty_medium_preset_name(i));
    free(manual);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_smallest_scene_has_the_defaults),
        cmocka_unit_test(camera_and_render_are_read),
        cmocka_unit_test(lenses_and_motion_are_read),
        cmocka_unit_test(coefficients_are_read),
        cmocka_unit_test(phase_functions_are_read),
        cmocka_unit_test(lights_are_read),
        cmocka_unit_test(shapes_are_read),
        cmocka_unit_test(meters_per_unit_scales_lengths),
        cmocka_unit_test(files_are_placed_in_units_and_shared),
        cmocka_unit_test(paths_start_at_the_scene),
        cmocka_unit_test(the_hash_follows_the_content),
        cmocka_unit_test(overrides_change_the_scene),
        cmocka_unit_test(droplets_scatter_by_their_size),
        cmocka_unit_test(every_key_is_accepted),
        cmocka_unit_test(builtin_scenes_load_and_are_documented),
        cmocka_unit_test(reference_scenes_load),
        cmocka_unit_test(the_manuals_example_parses),
        cmocka_unit_test(the_manual_lists_every_preset),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
