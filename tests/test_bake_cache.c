/* Light in cells of media: what a bake looks up there. */
#include "bake_maker.h"

enum { PROBES = 3 };

static const float places[3 * PROBES] = {0, 0, 0, 1, 0.5f, -0.7f, -1.5f, 1, 1};

static double sum_of(const ty_bake_probe* probe, int channel) {
    double sum = 0;
    for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer) sum += (double)probe->sh[layer][channel][0];
    return sum / sqrt(4 * pi);
}

static void bake_probes(ty_context* context, const ty_scene* scene, const ty_bake_def* def, const float* at,
                        ty_bake_probe* out) {
    memset(out, 0, PROBES * sizeof *out);
    must(context, ty_bake_probes(scene, def, at, PROBES, out, NULL));
}

/* ---- a white sky about media that take nothing away: all is as bright as the sky ---- */

static const char sky_text[] = "{\"tyndall\": 1, \"lights\": [{\"type\": \"environment\", \"radiance\": 1}],"
                               " \"media\": [{\"bounds\": [[-2, -2, -2], [2, 2, 2]], %s}]}";

static void check_sky(ty_context* context, const char* medium, double tolerance) {
    char text[1000];
    ty_scene* scene = NULL;
    ty_bake_probe probes[PROBES];
    ty_bake_def def = ty_default_bake_def();
    snprintf(text, sizeof text, sky_text, medium);
    must(context, ty_scene_parse(context, text, strlen(text), "sky", ".", NULL, 0, &scene));
    def.spp = fewer_under_sanitizers(256, 8);
    def.cells = 8;
    def.cell_paths = fewer_under_sanitizers(1024, 32);
    def.scatterings = TY_IMPULSE_BOUNCES_MAX;
    bake_probes(context, scene, &def, places, probes);
    for (int i = 0; i < PROBES && numbers_count(); ++i)
        for (int c = 0; c < 3; ++c) {
            if (!(fabs(sum_of(&probes[i], c) - 1) < tolerance))
                fail_msg("%s: probe %d, channel %d: %g", medium, i, c, sum_of(&probes[i], c));
            assert_true(probes[i].sh[TY_BAKE_SINGLE][c][0] > 0.02f && probes[i].sh[TY_BAKE_MULTIPLE][c][0] > 0.005f);
        }
    ty_scene_destroy(scene);
}

static void all_is_as_bright_as_the_sky(void** state) {
    static const char noise[] =
        "\"density\": {\"noise\": {\"kind\": \"cloud\", \"resolution\": 24, \"frequency\": 2, \"coverage\": 0.7,"
        " \"sharpness\": 3, \"seed\": 3}}, \"sigma_a\": 0";
    char text[500];
    check_sky(*state, "\"sigma_s\": 0.5, \"sigma_a\": 0, \"g\": 0", 0.02);
    check_sky(*state, "\"sigma_s\": [0.4, 0.9, 2], \"sigma_a\": 0, \"g\": 0.6", 0.06);
    snprintf(text, sizeof text, "%s, \"sigma_s\": 1.5", noise);
    check_sky(*state, text, 0.02);
    snprintf(text, sizeof text, "%s, \"sigma_s\": [0.4, 0.8, 1.6]", noise);
    check_sky(*state, text, 0.02);
    check_sky(*state,
              "\"sigma_s\": 0.3, \"sigma_a\": 0}, {\"sigma_s\": [0.5, 0.2, 0.4], \"sigma_a\": 0,"
              " \"bounds\": [[-1.2, -2, -1], [2, 2, 2]]",
              0.03);
}

/* ---- a lamp between walls ---- */

/* Fog about a lamp that stands on one side of a wall, which is `thick`, or a sheet for 0; the other side is dark. */
static ty_scene* walled(ty_context* context, double thick, double g) {
    ty_scene* scene = new_scene(context);
    const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1};
    for (int side = 0; side < (thick > 0 ? 2 : 1); ++side) {
        const double at[3] = {side == 0 ? 0.03 : 0.03 + thick, 0, 0};
        const ty_shape_def wall = side == 0 ? square_shape(at, z, y, 40, 0.5) : square_shape(at, y, z, 40, 0.5);
        add_shape(scene, &wall);
    }
    const double floor_at[3] = {0, 0, -1};
    const ty_shape_def ground = square_shape(floor_at, x, y, 2, 0.5);
    add_shape(scene, &ground);
    ty_light_def lamp = light_of(TY_LIGHT_POINT, 20);
    set3(lamp.position, -1, 0, 0);
    add_light(scene, &lamp);
    ty_medium_def fog = medium_cube(2, 0.3, 0.05, g);
    add_medium(scene, &fog);
    commit(scene);
    return scene;
}

/* Light beside a wall is that of its own side, whether cells lie on both or within it. */
static void walls_let_nothing_through(void** state) {
    static const double thicknesses[2] = {0, 0.9};
    for (int i = 0; i < 2; ++i) {
        ty_scene* scene = walled(*state, thicknesses[i], 0.4);
        const float at[3 * PROBES] = {-0.3f, 0.4f, 0.2f, 1.2f, 0.3f, 0.1f, 1.5f, -0.5f, -0.4f};
        ty_bake_probe is[PROBES], should[PROBES];
        ty_bake_def def = ty_default_bake_def();
        def.spp = fewer_under_sanitizers(4096, 32);
        def.cells = 9;
        def.cell_paths = fewer_under_sanitizers(def.cell_paths, 8);
        bake_probes(*state, scene, &def, at, is);
        def.method = TY_BAKE_PATH;
        def.seed = 1;
        bake_probes(*state, scene, &def, at, should);
        if (numbers_count()) assert_true(fabs(sum_of(&is[0], 1) / sum_of(&should[0], 1) - 1) < 0.06);
        for (int p = 1; p < PROBES; ++p) {
            assert_true(sum_of(&should[p], 1) < 0.02 * sum_of(&should[0], 1));
            assert_true(sum_of(&is[p], 1) < 0.02 * sum_of(&should[0], 1));
        }
        ty_scene_destroy(scene);
    }
}

enum { FACES = 4 };

static double scattered_on(const ty_bake_light* light) {
    return scattered_of(light, 0) + scattered_of(light, 1) + scattered_of(light, 2);
}

/* At few paths, surfaces take the light of cells as it is: beside a sheet, each side its own. */
static void surfaces_take_the_light_of_cells(void** state) {
    static const float at[FACES][3] = {{-0.5f, 0.3f, -1}, {0.03f, 0.2f, 0.1f}, {0.6f, 0.3f, -1}, {0.03f, 0.2f, 0.1f}};
    static const float normals[FACES][3] = {{0, 0, 1}, {-1, 0, 0}, {0, 0, 1}, {1, 0, 0}};
    ty_bake_receiver receivers[FACES];
    ty_bake_light is[FACES], should[FACES];
    ty_scene* scene = walled(*state, 0, 0.4);
    ty_bake_def def = ty_default_bake_def();
    for (int i = 0; i < FACES; ++i) {
        receivers[i] = (ty_bake_receiver){.margin = 1e-4f};
        memcpy(receivers[i].position, at[i], sizeof at[i]);
        memcpy(receivers[i].normal, normals[i], sizeof normals[i]);
        memcpy(receivers[i].face, normals[i], sizeof normals[i]);
    }
    def.cells = 9;
    def.cell_paths = fewer_under_sanitizers(1024, 32);
    must(*state, ty_bake_surfaces(scene, &def, receivers, FACES, is, NULL));
    def.method = TY_BAKE_PATH;
    def.spp = fewer_under_sanitizers(16384, 64);
    def.seed = 1;
    must(*state, ty_bake_surfaces(scene, &def, receivers, FACES, should, NULL));
    for (int i = 0; i < 2; ++i) {
        if (numbers_count() && !(fabs(scattered_on(&is[i]) / scattered_on(&should[i]) - 1) < 0.1))
            fail_msg("receiver %d: %g for %g", i, scattered_on(&is[i]), scattered_on(&should[i]));
        for (int layer = TY_BAKE_SINGLE; layer <= TY_BAKE_MULTIPLE; ++layer) {
            double along = 0; /* the vector irradiance along the normal is irradiance */
            for (int a = 0; a < 3; ++a) along += (double)is[i].vector_irradiance[layer][1][a] * (double)normals[i][a];
            assert_true(fabs(along / (double)is[i].irradiance[layer][1] - 1) < 1e-4);
        }
        assert_true(is[i].variance[1] > 0);
    }
    for (int i = 2; i < FACES; ++i) assert_true(scattered_on(&is[i]) < 0.02 * scattered_on(&should[0]));
    ty_scene_destroy(scene);
}

/* ---- what makes no difference ---- */

static void a_cache_of_ones_own_is_the_same(void** state) {
    ty_scene* scene = walled(*state, 0, 0);
    ty_bake_probe own[PROBES], given[PROBES];
    ty_bake_cache* cache = NULL;
    ty_bake_def def = ty_default_bake_def();
    ty_bake_cache_info about;
    ty_bake_stats stats = ty_default_bake_stats();
    def.cells = 8;
    bake_probes(*state, scene, &def, places, own);
    must(*state, ty_bake_cache_estimate(scene, &def, &about));
    must(*state, ty_bake_cache_create(scene, &def, &cache));
    const ty_bake_cache_info info = ty_bake_cache_get_info(cache);
    assert_memory_equal(info.size, about.size, sizeof info.size);
    assert_true(info.bytes == about.bytes && info.size[0] == 8 && info.filled == 8 * 8 * 8 && info.rays > info.paths);
    def.cache = cache;
    memset(given, 0, sizeof given);
    must(*state, ty_bake_probes(scene, &def, places, PROBES, given, &stats));
    assert_memory_equal(own, given, sizeof own);
    assert_true(stats.cache_seconds == 0);
    ty_bake_cache_destroy(cache);
    ty_scene_destroy(scene);
}

static void threads_change_nothing(void** state) {
    ty_bake_probe probes[2][PROBES];
    (void)state;
    for (int i = 0; i < 2; ++i) {
        ty_context* context = truth_context(i == 0 ? 1 : 3);
        ty_scene* scene = walled(context, 0.2, 0.3);
        ty_bake_def def = ty_default_bake_def();
        def.cells = 7;
        def.cell_paths = 16;
        bake_probes(context, scene, &def, places, probes[i]);
        ty_scene_destroy(scene);
        ty_context_destroy(context);
    }
    assert_true(probes[0][0].sh[TY_BAKE_SINGLE][0][0] > 0 && probes[0][0].sh[TY_BAKE_MULTIPLE][0][0] > 0);
    assert_memory_equal(probes[0], probes[1], sizeof probes[0]);
}

/* Smoke in a corner of its grid: cells elsewhere are left empty, and no light is missed for it. */
static void empty_cells_are_not_filled(void** state) {
    static const char text[] =
        "{\"tyndall\": 1, \"lights\": [{\"type\": \"environment\", \"radiance\": 1}],"
        " \"media\": [{\"bounds\": [[-2, -2, -2], [2, 2, 2]], \"sigma_s\": 2, \"sigma_a\": 0,"
        "  \"density\": {\"noise\": {\"kind\": \"cloud\", \"resolution\": 96, \"frequency\": 2, \"coverage\": 0.15,"
        "   \"sharpness\": 8, \"seed\": 4}}}]}";
    ty_scene* scene = NULL;
    ty_bake_cache* cache = NULL;
    ty_bake_probe probes[PROBES];
    ty_bake_def def = ty_default_bake_def();
    must(*state, ty_scene_parse(*state, text, strlen(text), "smoke", ".", NULL, 0, &scene));
    def.cells = 24;
    def.cell_paths = 16;
    def.scatterings = TY_IMPULSE_BOUNCES_MAX;
    must(*state, ty_bake_cache_create(scene, &def, &cache));
    const ty_bake_cache_info info = ty_bake_cache_get_info(cache);
    assert_true(info.filled > 0 && info.filled < 24 * 24 * 24 * 9 / 10);
    def.cache = cache;
    bake_probes(*state, scene, &def, places, probes);
    for (int i = 0; i < PROBES; ++i) assert_true(fabs(sum_of(&probes[i], 1) - 1) < 0.02);
    ty_bake_cache_destroy(cache);
    ty_scene_destroy(scene);
}

/* ---- options ---- */

static bool stop(void* user, const ty_progress* progress) {
    *(const char**)user = progress->stage;
    return false;
}

static void filling_can_be_cancelled(void** state) {
    ty_scene* scene = walled(*state, 0, 0);
    ty_bake_cache* cache = NULL;
    const char* stage = NULL;
    ty_bake_def def = ty_default_bake_def();
    def.progress = stop;
    def.progress_user = &stage;
    assert_int_equal(ty_bake_cache_create(scene, &def, &cache), TY_CANCELLED);
    assert_true(cache == NULL);
    assert_string_equal(stage, "fog");
    ty_scene_destroy(scene);
}

static void wrong_options_are_refused(void** state) {
    ty_scene* scene = walled(*state, 0, 0);
    ty_bake_cache* cache = NULL;
    ty_bake_def def = ty_default_bake_def();
    def.cells = 513;
    assert_int_equal(ty_bake_cache_create(scene, &def, &cache), TY_ERROR_ARGUMENT);
    def = ty_default_bake_def();
    def.cell_paths = -1;
    assert_int_equal(ty_bake_cache_create(scene, &def, &cache), TY_ERROR_ARGUMENT);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_is_as_bright_as_the_sky),      cmocka_unit_test(walls_let_nothing_through),
        cmocka_unit_test(surfaces_take_the_light_of_cells), cmocka_unit_test(a_cache_of_ones_own_is_the_same),
        cmocka_unit_test(threads_change_nothing),           cmocka_unit_test(empty_cells_are_not_filled),
        cmocka_unit_test(filling_can_be_cancelled),         cmocka_unit_test(wrong_options_are_refused),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
