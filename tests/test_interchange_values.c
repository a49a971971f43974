/* Conversion of numbers of pbrt's and Mitsuba's scenes: units, conventions, colours. */
#include "checks.h"
#include "files.h"

#include "base/context.h"
#include "io/interchange/blackbody_grid.h"
#include "io/interchange/convert.h"
#include "io/interchange/environment_map.h"
#include "io/interchange/mitsuba/serialized.h"
#include "io/interchange/spectrum.h"

#include <jansson.h>
#include <math.h>
#include <string.h>

typedef struct value_case {
    const char* text;
    const char* path; /* keys and indices with points between them */
    double expected[3];
    int count; /* of numbers; 0: the path leads nowhere */
    double tolerance;
} value_case;

/* The value at "lights.0.intensity"; NULL without. */
static const json_t* find(const json_t* value, const char* path) {
    char key[64];
    while (*path != '\0' && value != NULL) {
        const size_t length = strcspn(path, ".");
        snprintf(key, sizeof key, "%.*s", (int)length, path);
        path += length + (path[length] == '.');
        value = json_is_array(value) ? json_array_get(value, (size_t)atoi(key)) : json_object_get(value, key);
    }
    return value;
}

static void expect_converted(ty_context* context, ty_scene_language language, const value_case* c, const char* text) {
    char* scene = NULL;
    if (ty_convert_scene_text(context, language, text, strlen(text), &scene) != TY_OK)
        fail_msg("%s: %s", text, ty_take_error(context));
    json_t* root = json_loads(scene, 0, NULL);
    const json_t* value = find(root, c->path);
    if ((value == NULL) != (c->count == 0)) fail_msg("%s: %s is %s", text, c->path, value ? "there" : "missing");
    for (int i = 0; i < c->count; ++i) {
        const double number = json_number_value(json_is_array(value) ? json_array_get(value, (size_t)i) : value);
        if (!(fabs(number - c->expected[i]) <= c->tolerance))
            fail_msg("%s: %s[%d] is %.9g, not %.9g", text, c->path, i, number, c->expected[i]);
    }
    json_decref(root);
    ty_free_text(context, scene);
}

static void pbrt_values_are_converted(void** state) {
    static const value_case cases[] = {
        /* A light's rgb is its radiance; all other spectra have the luminance 1, times scale, or the power asked for.
         */
        {"WorldBegin LightSource \"point\" \"float power\" 12.566370614359172", "lights.0.intensity", {1}, 1, 1e-12},
        {"WorldBegin LightSource \"point\" \"spectrum I\" [400 7 700 7] \"float scale\" 3",
         "lights.0.intensity",
         {3.615, 2.847, 2.708},
         3,
         0.02},
        {"WorldBegin LightSource \"point\" \"spectrum I\" \"stdillum-D65\"", "lights.0.intensity", {1, 1, 1}, 3, 0.002},
        {"WorldBegin LightSource \"spot\" \"float power\" 6.283185307179586 \"float coneangle\" 90 \"float "
         "conedeltaangle\" 0",
         "lights.0.intensity",
         {1},
         1,
         1e-12},
        {"WorldBegin LightSource \"infinite\" \"float illuminance\" 3.141592653589793",
         "lights.0.radiance",
         {1},
         1,
         1e-12},
        {"WorldBegin AreaLightSource \"diffuse\" \"float power\" 39.47841760435743 Shape \"sphere\"",
         "geometry.0.material.emission",
         {1},
         1,
         1e-9}, /* pi A L = 4 pi^2 */
        {"WorldBegin Scale 2 2 2 AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"float scale\" 2 Shape \"sphere\"",
         "geometry.0.sphere.radius",
         {2},
         1,
         1e-12},
        /* alpha is the root of pbrt's roughness, and the square of ours */
        {"WorldBegin Material \"conductor\" \"float roughness\" 0.0016 Shape \"sphere\"",
         "geometry.0.material.roughness",
         {0.2},
         1,
         1e-9},
        {"WorldBegin Material \"conductor\" \"float roughness\" 0.25 \"bool remaproughness\" false Shape \"sphere\"",
         "geometry.0.material.roughness",
         {0.5},
         1,
         1e-9},
        {"WorldBegin Material \"thindielectric\" \"float eta\" 1.5 Shape \"sphere\"",
         "geometry.0.material.ior",
         {1.76759},
         1,
         1e-4}, /* F0 = 2 (.04) / 1.04 */
        {"WorldBegin Material \"conductor\" \"float eta\" 1 \"float k\" 2 Shape \"sphere\"",
         "geometry.0.material.base_color",
         {0.5},
         1,
         1e-9}, /* k^2 / (4 + k^2) */
        {"WorldBegin Material \"diffuse\" \"spectrum reflectance\" [300 .25 900 .25] Shape \"sphere\"",
         "geometry.0.material.base_color",
         {0.25, 0.25, 0.25},
         1,
         1e-9},
        {"ColorSpace \"rec2020\" WorldBegin Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5] Shape \"sphere\"",
         "geometry.0.material.base_color",
         {0.5, 0.5, 0.5},
         3,
         1e-5},
        /* the angle of view is that of the shorter side */
        {"Film \"rgb\" \"integer xresolution\" 100 \"integer yresolution\" 200 Camera \"perspective\" \"float fov\" 90 "
         "WorldBegin",
         "camera.fov_y",
         {126.86989764584402},
         1,
         1e-9},
        {"Camera \"perspective\" \"float fov\" 90 \"float screenwindow\" [-1 1 -.5 .5] WorldBegin",
         "camera.fov_y",
         {53.13010235415598},
         1,
         1e-9},
        {"Film \"rgb\" \"float iso\" 400 Camera \"perspective\" \"float shutterclose\" 2 WorldBegin",
         "camera.exposure",
         {3},
         1,
         1e-12}, /* of 2 s times 4 */
        /* a left-handed world is mirrored, so that what is on the right stays there */
        {"WorldBegin Translate 1 2 3 Shape \"sphere\"", "geometry.0.sphere.center", {-1, 2, 3}, 3, 0},
        {"Scale -1 1 1 Camera \"perspective\" WorldBegin Translate 1 2 3 Shape \"sphere\"",
         "geometry.0.sphere.center",
         {1, 2, 3},
         3,
         0},
        {"WorldBegin Rotate 90 0 0 1 Translate 1 0 0 Shape \"sphere\"",
         "geometry.0.sphere.center",
         {0, 1, 0},
         3,
         1e-15},
        {"WorldBegin MakeNamedMedium \"a\" \"string type\" \"homogeneous\" \"string preset\" \"Skimmilk\" \"float "
         "scale\" 2 "
         "MediumInterface \"a\" \"\" Material \"interface\" Shape \"sphere\"",
         "media.0.sigma_s",
         {1.4, 2.44, 3.8},
         3,
         1e-6},
        {"WorldBegin MakeNamedMedium \"a\" \"string type\" \"homogeneous\" \"blackbody Le\" 6500 \"float Lescale\" 2 "
         "MediumInterface \"\" \"a\" ReverseOrientation Material \"interface\" Shape \"sphere\"",
         "media.0.emission.radiance",
         {2, 2, 2},
         3,
         0.12},
        {"MakeNamedMedium \"a\" \"string type\" \"homogeneous\" MediumInterface \"\" \"a\" Camera \"perspective\" "
         "WorldBegin "
         "Shape \"sphere\"",
         "media.0.bounds.0",
         {-1.02, -1.02, -1.02},
         3,
         1e-12},
        {"WorldBegin MakeNamedMedium \"a\" \"string type\" \"homogeneous\" Shape \"sphere\"", "media.0", {0}, 0, 0},
        {"WorldBegin Material \"diffuse\" Shape \"curve\"", "geometry.0", {0}, 0, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i)
        expect_converted(*state, TY_LANGUAGE_PBRT, &cases[i], cases[i].text);
}

static void mitsuba_values_are_converted(void** state) {
    static const value_case cases[] = {
        {"<sensor type='perspective'><float name='fov' value='90'/></sensor>",
         "camera.fov_y",
         {73.739795291688},
         1,
         1e-9},
        {"<sensor type='perspective'><float name='fov' value='90'/><string name='fovAxis' value='smaller'/></sensor>",
         "camera.fov_y",
         {90},
         1,
         1e-9},
        {"<sensor type='perspective'><string name='focal_length' value='21.633307653mm'/></sensor>",
         "camera.fov_y",
         {61.927513064147},
         1,
         1e-5}, /* half the diagonal of the film: 90 degrees along it */
        {"<sensor type='perspective'><transform name='to_world'><lookat origin='1,2,3' target='1,2,7' up='0,1,0'/>"
         "</transform></sensor>",
         "camera.target",
         {1, 2, 4},
         3,
         1e-12},
        {"<integrator type='path'><integer name='max_depth' value='-1'/></integrator>",
         "render.path.max_depth",
         {0},
         1,
         0},
        {"<emitter type='directional'><transform name='to_world'><rotate y='1' angle='90'/></transform></emitter>",
         "lights.0.direction",
         {1, 0, 0},
         3,
         1e-12},
        {"<emitter type='spot'><float name='cutoff_angle' value='40'/></emitter>",
         "lights.0.penumbra",
         {0.25},
         1,
         1e-12},
        {"<emitter type='constant'><rgb name='radiance' value='#ff0080'/></emitter>",
         "lights.0.radiance",
         {1, 0, 0.2158605},
         3,
         1e-6},
        /* Beckmann, the default: by the median slope alpha sqrt(ln 2) */
        {"<shape type='sphere'><bsdf type='roughconductor'><float name='alpha' value='0.25'/></bsdf></shape>",
         "geometry.0.material.roughness",
         {0.456222153},
         1,
         1e-9},
        {"<shape type='sphere'><bsdf type='roughconductor'><string name='distribution' value='ggx'/>"
         "<float name='alpha' value='0.25'/></bsdf></shape>",
         "geometry.0.material.roughness",
         {0.5},
         1,
         1e-12},
        {"<shape type='sphere'><bsdf type='dielectric'><string name='int_ior' value='water'/><string name='ext_ior' "
         "value='vacuum'/></bsdf></shape>",
         "geometry.0.material.ior",
         {1.333},
         1,
         1e-12},
        {"<medium type='homogeneous' id='a'><rgb name='sigmaT' value='4'/><rgb name='albedo' value='.5 .25 "
         "1'/></medium>"
         "<shape type='sphere'><ref name='interior' id='a'/></shape>",
         "media.0.sigma_s",
         {2, 1, 4},
         3,
         1e-12},
        {"<medium type='homogeneous' id='a'><rgb name='sigma_s' value='4'/><float name='scale' value='.5'/></medium>"
         "<shape type='sphere'><ref name='interior' id='a'/></shape>",
         "media.0.sigma_s",
         {2},
         1,
         1e-12},
        {"<shape type='shapegroup' id='g'><shape type='sphere'/></shape><shape type='instance'><ref id='g'/>"
         "<transform name='to_world'><translate x='3'/></transform></shape>",
         "geometry.0.sphere.center",
         {3, 0, 0},
         3,
         0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char text[1024];
        snprintf(text, sizeof text, "<scene version='3.0.0'>%s</scene>", cases[i].text);
        expect_converted(*state, TY_LANGUAGE_MITSUBA, &cases[i], text);
    }
}

static void colours_of_spectra(void** state) {
    (void)state;
    double rgb[3];
    ty_blackbody_colour(6504, rgb); /* on the Planckian locus, near D65 */
    assert_close(0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2], 1, 1e-3);
    for (int c = 0; c < 3; ++c) assert_close(rgb[c], 1, 0.06);
    static const double line[6] = {599, 0, 600, 1, 601, 0};
    ty_spectrum_light((ty_spectrum){line, 3}, rgb); /* x = 0.627, y = 0.372: outside of Rec. 709, red */
    assert_true(rgb[0] > 2 && rgb[2] < 0);
    static const double step[4] = {400, 1, 700, 3};
    assert_close(ty_spectrum_at((ty_spectrum){step, 2}, 550), 2, 1e-12);
    assert_close(ty_spectrum_at((ty_spectrum){step, 2}, 100), 1, 0);
    assert_close(ty_spectrum_at((ty_spectrum){step, 2}, 900), 3, 0);
}

/* The emission of the new temperatures has the luminance of normalized black bodies of the old ones. */
static void temperatures_emit_as_in_pbrt(void** state) {
    (void)state;
    static const float old[4] = {1000, 1500, 2200, 0};
    float kelvin[4];
    double factor;
    memcpy(kelvin, old, sizeof old);
    assert_true(ty_normalize_temperatures(kelvin, 4, 5, &factor));
    assert_close((double)kelvin[2], 2200, 0.1);
    assert_close((double)kelvin[3], 0, 0);
    for (int i = 0; i < 3; ++i) {
        float rgb[3];
        ty_blackbody((double)kelvin[i], rgb);
        const double luminance = 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
        const double expected = 5 * ty_normalized_blackbody_luminance((double)old[i]);
        assert_close(factor * luminance / expected, 1, 2e-3);
    }
    assert_false(ty_normalize_temperatures(kelvin + 3, 1, 5, &factor));
}

/* ---- Maps ---- */

/* The direction at the centre of a texel of an octahedral map (Clarberg 2008). */
static void octahedral_direction(double x, double y, double d[3]) {
    const double u = 2 * x - 1, v = 2 * y - 1, distance = 1 - (fabs(u) + fabs(v)), r = 1 - fabs(distance);
    const double phi = (r == 0 ? 1 : (fabs(v) - fabs(u)) / r + 1) * 0.78539816339744831;
    d[0] = copysign(cos(phi), u) * r * sqrt(2 - r * r);
    d[1] = copysign(sin(phi), v) * r * sqrt(2 - r * r);
    d[2] = copysign(1 - r * r, distance);
}

/* As octahedral_direction, of Mitsuba's maps. */
static void angles_direction(double u, double v, double d[3]) {
    const double phi = 6.283185307179586 * u, theta = 3.141592653589793 * v;
    d[0] = sin(theta) * sin(phi);
    d[1] = cos(theta);
    d[2] = -sin(theta) * cos(phi);
}

/* A map whose colours are its directions shows each direction at its place, moved by the light's rotation. */
static void maps_keep_directions(void** state) {
    enum { SIDE = 64 };
    static const ty_affine light = {{0, 0, 2, 0, 2, 0, 0, 0, 0, 2, 0, 0}}; /* x to y, y to z, z to x */
    for (int kind = 0; kind < 2; ++kind) {
        const int32_t width = kind == 0 ? SIDE : 2 * SIDE;
        ty_image *image = NULL, *map = NULL;
        assert_int_equal(ty_image_create_rgb(*state, width, SIDE, &image), TY_OK);
        for (int32_t y = 0; y < SIDE; ++y)
            for (int32_t x = 0; x < width; ++x) {
                double d[3];
                (kind == 0 ? octahedral_direction : angles_direction)((x + 0.5) / width, (y + 0.5) / SIDE, d);
                for (int32_t c = 0; c < 3; ++c) ty_image_plane(image, c)[y * width + x] = (float)(0.5 + 0.5 * d[c]);
            }
        assert_int_equal(
            ty_convert_map(*state, image, kind == 0 ? TY_MAP_OCTAHEDRAL : TY_MAP_ANGLES, &light, NULL, &map), TY_OK);
        const int32_t columns = ty_image_width(map), rows = ty_image_height(map);
        assert_int_equal(columns, 2 * SIDE);
        double sum = 0;
        for (int32_t y = 0; y < rows; ++y)
            for (int32_t x = 0; x < columns; ++x) {
                const double phi = 6.283185307179586 * ((x + 0.5) / columns - 0.5);
                const double theta = 3.141592653589793 * (y + 0.5) / rows;
                const double world[3] = {sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi)};
                for (int32_t c = 0; c < 3; ++c) { /* light space has x where the scene has y */
                    const double found = 2 * (double)ty_image_plane(map, c)[y * columns + x] - 1;
                    const double error = found - world[(c + 1) % 3];
                    assert_close(error, 0, 0.05); /* measured .031: a texel spans 0.06 */
                    sum += error * error;
                }
            }
        assert_true(sqrt(sum / (3.0 * rows * columns)) < 0.01); /* measured .0073 */
        ty_image_destroy(image);
        ty_image_destroy(map);
    }
}

/* ---- Files and memory ---- */

/* A scene whose meshes, map, texture and grids are written, and which loads. */
static void files_are_written(void** state) {
    ty_image* image = NULL;
    assert_int_equal(ty_image_create_rgb(*state, 8, 8, &image), TY_OK);
    for (int32_t c = 0; c < 3; ++c)
        for (int i = 0; i < 64; ++i) ty_image_plane(image, c)[i] = 0.25f;
    assert_int_equal(ty_image_write_exr(*state, image, "map.exr"), TY_OK);
    ty_image_destroy(image);
    static const char text[] =
        "WorldBegin LightSource \"infinite\" \"string filename\" \"map.exr\" \"float scale\" 2\n"
        "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"map.exr\" \"float uscale\" 3\n"
        "MakeNamedMedium \"fire\" \"string type\" \"uniformgrid\" \"integer nx\" 2 \"float density\" [1 2]\n"
        "  \"float temperature\" [900 1500] \"float Lescale\" .5\n"
        "MediumInterface \"fire\" \"\" Material \"diffuse\" \"texture reflectance\" \"t\"\n"
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1] \"integer indices\" [0 2 1 0 1 3 0 3 2 1 2 3]\n"
        "  \"point2 uv\" [0 0 1 0 0 1 1 1]\n"
        "ObjectBegin \"o\" Shape \"disk\" ObjectEnd ObjectInstance \"o\" Translate 2 0 0 ObjectInstance \"o\"\n";
    assert_int_equal(ty_bytes_write(*state, "written.pbrt", text, sizeof text - 1), TY_OK);
    if (ty_convert_scene(*state, "written.pbrt", "written.json", false, NULL, NULL) != TY_OK)
        fail_msg("%s", ty_take_error(*state));
    ty_scene* scene = NULL;
    if (ty_scene_load(*state, "written.json", NULL, 0, &scene) != TY_OK) fail_msg("%s", ty_take_error(*state));
    const ty_scene_info info = ty_scene_get_info(scene);
    assert_int_equal(info.media, 1);
    assert_int_equal(info.lights, 1);
    assert_int_equal(info.triangles, 4 + 2 * 256);
    assert_true(info.textures >= 1);
    float radiance[3];
    ty_scene_environment(scene, radiance);
    for (int c = 0; c < 3; ++c) assert_close((double)radiance[c], 0.5, 1e-5);
    ty_scene_destroy(scene);
}

/* The second of two shapes of a file, and messages about broken ones. */
static void serialized_meshes_are_read(void** state) {
    uint8_t* bytes = NULL;
    size_t size = 0;
    ty_model_mesh mesh;
    assert_int_equal(
        ty_bytes_read(*state, TYNDALL_SOURCE_DIR "/tests/fuzz/corpus/serialized/two", 1 << 20, &bytes, &size), TY_OK);
    for (int32_t index = 0; index < 2; ++index) {
        if (ty_read_serialized(*state, "two", bytes, size, index, &mesh) != TY_OK)
            fail_msg("%s", ty_take_error(*state));
        assert_int_equal(mesh.vertex_count, 3);
        assert_int_equal(mesh.triangle_count, 1);
        assert_true((mesh.normals != NULL) == (index == 0));
        assert_close((double)mesh.positions[3], 1, 0);
        assert_close((double)mesh.uv[0][5], 0, 0); /* v = 1 of the third vertex, downwards */
        assert_int_equal(mesh.indices[2], 2);
        ty_model_free_mesh(*state, &mesh);
    }
    assert_int_equal(ty_read_serialized(*state, "two", bytes, size, 2, &mesh), TY_ERROR_INPUT);
    assert_error(*state, "two: there is no shape 2");
    assert_int_equal(ty_read_serialized(*state, "two", bytes, 30, 0, &mesh), TY_ERROR_INPUT);
    assert_error(*state, "two: the serialized mesh is damaged or cut short");
    ty_bytes_destroy(*state, bytes, size);
}

/* Whichever allocation fails, the conversion ends with a message and gives back what it took. */
static void every_allocation_may_fail(void** state) {
    (void)state;
    static const struct {
        ty_scene_language language;
        const char* path;
    } cases[2] = {{TY_LANGUAGE_PBRT, TYNDALL_SOURCE_DIR "/tests/interchange/room.pbrt"},
                  {TY_LANGUAGE_MITSUBA, TYNDALL_SOURCE_DIR "/tests/interchange/room.xml"}};
    for (int i = 0; i < 2; ++i) {
        uint8_t* text = NULL;
        size_t size = 0;
        ty_context* plain = make_context(1);
        assert_int_equal(ty_bytes_read(plain, cases[i].path, 1 << 20, &text, &size), TY_OK);
        ty_result result = TY_ERROR_MEMORY;
        for (int64_t n = 0; result != TY_OK; ++n) {
            strict_memory memory = {.limit = 1 << 26, .until_refusal = -1};
            ty_context* context = strict_context(&memory);
            const size_t before = memory.used;
            memory.until_refusal = n;
            char* scene = NULL;
            result = ty_convert_scene_text(context, cases[i].language, (const char*)text, size, &scene);
            memory.until_refusal = -1;
            if (result != TY_OK) {
                assert_int_equal(result, TY_ERROR_MEMORY);
                assert_string_not_equal(ty_take_error(context), "");
            }
            ty_free_text(context, scene);
            assert_int_equal(memory.used, before);
            ty_context_destroy(context);
        }
        ty_bytes_destroy(plain, text, size);
        ty_context_destroy(plain);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(pbrt_values_are_converted, start_context, stop_context),
        cmocka_unit_test_setup_teardown(mitsuba_values_are_converted, start_context, stop_context),
        cmocka_unit_test(colours_of_spectra),
        cmocka_unit_test(temperatures_emit_as_in_pbrt),
        cmocka_unit_test_setup_teardown(maps_keep_directions, start_context, stop_context),
        cmocka_unit_test_setup_teardown(files_are_written, start_context, stop_context),
        cmocka_unit_test_setup_teardown(serialized_meshes_are_read, start_context, stop_context),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
