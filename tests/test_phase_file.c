/* Phase functions from text files: tables by angle, Legendre series against Henyey-Greenstein, whose moments are g^l,
 * scattering tables of SHDOM, in scenes, and broken files. */
#include "strict_fixture.h"

#include <tyndall/io.h>

#include <math.h>

static double cosines[TY_PHASE_NODES_MAX], values[TY_PHASE_NODES_MAX];
static int32_t count;

static void put_text(const char* path, const char* text) {
    put_file(path, text, strlen(text));
}

static void read_phase(const char* path, ty_phase_content content, double radius) {
    if (ty_phase_file_read(context, path, content, radius, cosines, values, &count) != TY_OK)
        fail_msg("%s", ty_take_error(context));
}

static double hg(double g, double mu) {
    return (1 - g * g) / (4 * 3.14159265358979 * pow(1 + g * g - 2 * g * mu, 1.5));
}

/* The moments of the table that was read, as the library has them. */
static void assert_moments(double g, double tolerance) {
    const ty_phase_lobe lobe = {
        .kind = TY_PHASE_TABLE, .weight = {1, 1, 1}, .cosines = cosines, .values = values, .count = count};
    double moments[3 * 4];
    assert_int_equal(ty_phase_moments(context, &lobe, 1, 3, moments), TY_OK);
    for (int l = 0; l < 4; ++l) assert_float_equal(moments[l], pow(g, l), tolerance);
}

static void angles_and_cosines_are_read(void** state) {
    (void)state;
    put_text("a.txt", "# degrees, p, and what it comes from\n0 3e0 1\n\n  60,1 2 # forward\n180 2\n");
    read_phase("a.txt", TY_PHASE_FILE_ANGLES, 0);
    assert_int_equal(count, 3);
    assert_float_equal(cosines[0], 1, 0);
    assert_float_equal(cosines[1], 0.5, 1e-15);
    assert_float_equal(cosines[2], -1, 0);
    assert_float_equal(values[1], 1, 0);
    put_text("c.txt", "-1 2\r\n0 1\r\n1 3");
    read_phase("c.txt", TY_PHASE_FILE_COSINES, 0);
    assert_int_equal(count, 3);
    assert_float_equal(values[2], 3, 0);
}

/* Nodes meet the formula to 1e-6 (measured: 3.5e-7, the terms left out), moments of the lines between them to 2e-5
 * (measured: 1e-5). */
static void series_are_summed(void** state) {
    (void)state;
    enum { ORDER = 60 };
    for (int form = 0; form < 2; ++form) {
        char text[8192] = "! moments\n";
        for (int l = 0; l < ORDER; ++l)
            snprintf(text + strlen(text), sizeof text - strlen(text), "%.12g%s",
                     pow(0.7, l) * (form == 0 ? 1 : 2 * l + 1), l % 5 == 4 ? "\n" : " ");
        put_text("series.txt", text);
        read_phase("series.txt", form == 0 ? TY_PHASE_FILE_MOMENTS : TY_PHASE_FILE_COEFFICIENTS, 0);
        assert_int_equal(count, 8 * ORDER + 1);
        for (int32_t i = 0; i < count; ++i) assert_float_equal(values[i] / hg(0.7, cosines[i]), 1, 1e-6);
        assert_moments(0.7, 2e-5);
    }
}

/* Two radii, with more coefficients of the second than stand in one line. */
static void put_table(const char* path) {
    char text[8192] =
        "! Mie scattering table vs. effective radius (LWC=1 g/m^3)\n    0.670    0.670  wavelength\n 1.000  W   "
        "particle density\n  0.133E+01  0.1E-07  index\n7.0 gamma\n   2    5.000   10.000  number, starting, "
        "ending effective radius\n   200  maximum number of legendre coefficients allowed\n";
    for (int r = 0; r < 2; ++r) {
        const double g = r == 0 ? 0.5 : 0.7;
        const int order = r == 0 ? 30 : 50;
        snprintf(text + strlen(text), sizeof text - strlen(text), " %8.4f %12.5E 1.0 %6d  Reff  Ext  Alb  Nleg\n",
                 5.0 * (r + 1), 300.0, order);
        for (int l = 0; l <= order; ++l)
            snprintf(text + strlen(text), sizeof text - strlen(text), " %.10g%s", (2 * l + 1) * pow(g, l),
                     l % 20 == 19 || l == order ? "\n" : "");
    }
    put_text(path, text);
}

static void tables_are_interpolated(void** state) {
    (void)state;
    put_table("mie.scat");
    read_phase("mie.scat", TY_PHASE_FILE_SHDOM, 5);
    assert_moments(0.5, 1e-4);
    read_phase("mie.scat", TY_PHASE_FILE_SHDOM, 10);
    assert_moments(0.7, 1e-4);
    read_phase("mie.scat", TY_PHASE_FILE_SHDOM, 7.5);
    for (int32_t i = 0; i < count; ++i)
        assert_float_equal(values[i], (hg(0.5, cosines[i]) + hg(0.7, cosines[i])) / 2, 2e-4);
}

static void scenes_name_files(void** state) {
    (void)state;
    put_table("mie.scat");
    put_text("scene.json", "{\"tyndall\": 1, \"media\": [{\"sigma_s\": 1, \"bounds\": [[0, 0, 0], [1, 1, 1]],\n"
                           "\"phase\": {\"type\": \"table\", \"file\": \"mie.scat\", \"content\": \"shdom\",\n"
                           "\"effective_radius\": 10}}]}");
    ty_scene* scene = NULL;
    if (ty_scene_load(context, "scene.json", NULL, 0, &scene) != TY_OK) fail_msg("%s", ty_take_error(context));
    ty_scene_destroy(scene);
    const char* far[] = {"media[0].phase.effective_radius=20"};
    ty_result result = ty_scene_load(context, "scene.json", far, 1, &scene);
    assert_failed(context, result, TY_ERROR_INPUT, "mie.scat", "effective radii from 5 to 10, not 20");
    const char* gone[] = {"media[0].phase.file=gone.txt"};
    result = ty_scene_load(context, "scene.json", gone, 1, &scene);
    assert_true(result == TY_ERROR_FILE || result == TY_ERROR_INPUT);
    assert_failed(context, result, result, "gone.txt", NULL);
}

static void broken_files_are_refused(void** state) {
    (void)state;
    static const struct {
        const char* text;
        ty_phase_content content;
        const char* matter;
    } cases[] = {
        {"", TY_PHASE_FILE_ANGLES, "2..4096"},
        {"0 1\n180\n", TY_PHASE_FILE_ANGLES, ":2: a number is missing"},
        {"0 1\n180 x\n", TY_PHASE_FILE_ANGLES, ":2: a number is missing"},
        {"0 1\n180 inf\n", TY_PHASE_FILE_ANGLES, ":2: a number is missing or too large"},
        {"0 1\n90 1\n", TY_PHASE_FILE_ANGLES, "broken.txt"},
        {"0 1\n120 1\n90 1\n180 1\n", TY_PHASE_FILE_ANGLES, "broken.txt"},
        {"0 1\n180 -1\n", TY_PHASE_FILE_ANGLES, "broken.txt"},
        {"0.9 .5", TY_PHASE_FILE_MOMENTS, "the first moment is not 1"},
        {"", TY_PHASE_FILE_COEFFICIENTS, "the first moment is not 1"},
        {"1 .5 x", TY_PHASE_FILE_MOMENTS, ":1: a number is missing"},
        {"! table\n1 2 3\n", TY_PHASE_FILE_SHDOM, "Reff Ext Alb Nleg"},
        {"! Polarized Mie scattering table\n", TY_PHASE_FILE_SHDOM, "polarized"},
        {"!\n5 1 1 3 Reff Ext Alb Nleg\n1 2 3\n", TY_PHASE_FILE_SHDOM, "ends within a phase function"},
        {"!\n5 1 1 3e9 Reff Ext Alb Nleg\n1 2 3\n", TY_PHASE_FILE_SHDOM, "out of range"},
        {"!\n5 1 1 0 Reff Ext Alb Nleg\n1\n4 1 1 0 Reff Ext Alb Nleg\n1\n", TY_PHASE_FILE_SHDOM, "do not ascend"},
        {"!\n5 1 1 0 Reff Ext Alb Nleg\n1\n9 1 1 0 Reff Ext Alb Nleg\n1\n", TY_PHASE_FILE_SHDOM, "from 5 to 9, not 0"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        put_text("broken.txt", cases[i].text);
        const ty_result result =
            ty_phase_file_read(context, "broken.txt", cases[i].content, 0, cosines, values, &count);
        assert_failed(context, result, TY_ERROR_INPUT, "broken.txt", cases[i].matter);
    }
    put_file("broken.txt", "0 1\0", 4);
    assert_failed(context, ty_phase_file_read(context, "broken.txt", TY_PHASE_FILE_ANGLES, 0, cosines, values, &count),
                  TY_ERROR_INPUT, "broken.txt", "zero");
}

static ty_result read_again(ty_context* own, void* user) {
    (void)user;
    return ty_phase_file_read(own, "memory.scat", TY_PHASE_FILE_SHDOM, 7, cosines, values, &count);
}

static void short_memory_is_told(void** state) {
    (void)state;
    put_table("memory.scat");
    assert_true(check_short_memory(context, &memory, read_again, NULL) >= 3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(angles_and_cosines_are_read, start, stop),
        cmocka_unit_test_setup_teardown(series_are_summed, start, stop),
        cmocka_unit_test_setup_teardown(tables_are_interpolated, start, stop),
        cmocka_unit_test_setup_teardown(scenes_name_files, start, stop),
        cmocka_unit_test_setup_teardown(broken_files_are_refused, start, stop),
        cmocka_unit_test_setup_teardown(short_memory_is_told, start, stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
