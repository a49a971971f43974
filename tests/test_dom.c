/* Discrete ordinates' calls: arguments, cancelling, memory, progress, threads, views, and what holds of any light; not
 * whether the light is right. */
#include "volume_calls.h"

static ty_dom_def small_dom(void) {
    ty_dom_def def = ty_default_dom_def();
    def.resolution = 8;
    def.direct = 16;
    def.directions = 24;
    def.width = WIDTH;
    def.height = HEIGHT;
    def.environment_beams = 4;
    return def;
}

static ty_dom* solve_dom(const ty_scene* scene, const ty_dom_def* def, ty_dom_stats* stats) {
    ty_dom* light = NULL;
    check_result(ty_scene_context(scene), ty_dom_solve(scene, def, &light, stats));
    return light;
}

/* Without surfaces, whose reflections take most of the time of a scene this small. */
static ty_scene* plain_scene(ty_context* context) {
    const ty_medium_def block = colored_block();
    const ty_light_def sun = sun_light(1, 2, 3);
    ty_light_def sky = sky_light(1, 1, 1);
    ty_scene* scene = make_scene(context);
    add_medium(scene, &block);
    add_light(scene, &sun);
    add_light(scene, &sky);
    commit(scene);
    return scene;
}

/* Light on cells of a box a little larger than the fog's. */
typedef struct cells {
    double fluence[3 * CELLS], uncollided[3 * CELLS];
} cells;

static void look_at(const ty_dom* light, cells* out) {
    static const double lower[3] = {-1.1, -1, -1.2}, upper[3] = {1.1, 1.1, 0.9};
    static const int32_t size[3] = {SIDE, SIDE, SIDE};
    assert_int_equal(ty_dom_fluence(light, lower, upper, size, out->fluence, out->uncollided), TY_OK);
}

/* ---- calls ---- */

VOLUME_CALLS(dom)
VOLUME_FLUENCE(dom)

static void make_def(volume_def* def, int variant) {
    (void)variant;
    def->dom = small_dom();
}

static const volume_calls calls = {VOLUME_CALLS_OF(dom), VOLUME_FLUENCE_OF, .variants = 1, .told = 0.4,
                                   .make_scene = plain_scene};

/* ---- arguments ---- */

static const bad_field bad_fields[] = {VOLUME_BAD_FIELDS(dom)};
static const volume_suite suite = {&calls, bad_fields, sizeof bad_fields / sizeof *bad_fields};

static void points_are_checked(void** state) {
    static const double rays[3][6] = {{0, NAN, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 0}, {9, 9, 9, 0, 0, 2}};
    ty_scene* scene = foggy_scene(*state);
    const ty_dom_def def = small_dom();
    ty_dom* light = solve_dom(scene, &def, NULL);
    double radiance[3] = {-1, -1, -1};
    assert_int_equal(ty_dom_radiance(light, rays[0], 1, radiance), TY_ERROR_ARGUMENT);
    assert_error(*state, "rays: point");
    assert_int_equal(ty_dom_radiance(light, rays[1], 1, radiance), TY_ERROR_ARGUMENT);
    assert_error(*state, "rays: direction");
    assert_int_equal(ty_dom_radiance(light, rays[2], 0, radiance), TY_ERROR_ARGUMENT);
    assert_error(*state, "a count of 0 rays");
    assert_int_equal(ty_dom_radiance(light, rays[2], 1, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "rays or radiance is NULL");
    assert_int_equal(ty_dom_radiance(light, rays[2], 1, radiance), TY_OK);
    for (int c = 0; c < 3; ++c) assert_true(radiance[c] == 0); /* outside of the box */
    ty_dom_destroy(light);
    ty_scene_destroy(scene);
}

/* ---- what is told ---- */

static void statistics_tell_what_was_done(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_dom_def def = small_dom();
    ty_dom_stats stats = ty_default_dom_stats();
    ty_dom* light = solve_dom(scene, &def, &stats);
    for (int a = 0; a < 3; ++a) {
        assert_int_equal(stats.direct_size[a], 16);
        assert_int_equal(stats.size[a], 8);
    }
    assert_int_equal(stats.planes, 3);
    assert_int_equal(stats.directions, 24);
    assert_true(stats.bands >= 2 && stats.converged && stats.memory_bytes > 0);
    for (int c = 0; c < 3; ++c) {
        assert_true(stats.sweeps[c] > 0 && stats.change[c] <= def.tolerance);
        assert_true(stats.emitted[c] > 0);
        assert_close((stats.absorbed[c] + stats.absorbed_by_surfaces[c] + stats.leaving[c]) / stats.emitted[c], 1,
                     1e-3);
    }
    ty_dom_destroy(light);
    def.acceleration = TY_DOM_ACCELERATION_NONE;
    def.iterations = 1;
    light = solve_dom(scene, &def, &stats);
    assert_false(stats.converged);
    ty_dom_destroy(light);
    ty_scene_destroy(scene);
}

/* ---- results ---- */

static double mean_of(const double* values) {
    double sum = 0;
    for (int i = 0; i < 3 * CELLS; ++i) sum += values[i] / (3 * CELLS);
    return sum;
}

/* All directions' radiance together is the fluence of what has scattered. */
static void radiance_adds_up_to_fluence(void** state) {
    enum { WAYS = 2000 };
    static const double point[3] = {0.375, 0.625, -0.625}; /* the middle of a cell */
    static const int32_t one[3] = {1, 1, 1};
    static double rays[6 * WAYS], radiance[3 * WAYS];
    ty_scene* scene = foggy_scene(*state);
    const ty_dom_def def = small_dom();
    ty_dom* light = solve_dom(scene, &def, NULL);
    double fluence[3], uncollided[3];
    for (int i = 0; i < WAYS; ++i) {
        const double z = 1 - (2 * i + 1.0) / WAYS, angle = 2.399963229728653 * i, radius = sqrt(1 - z * z);
        memcpy(rays + 6 * i, point, sizeof point);
        set3(rays + 6 * i + 3, radius * cos(angle), radius * sin(angle), z);
    }
    check_result(*state, ty_dom_radiance(light, rays, WAYS, radiance));
    check_result(*state, ty_dom_fluence(light, point, point, one, fluence, uncollided));
    for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int i = 0; i < WAYS; ++i) sum += radiance[3 * i + c] * 4 * 3.141592653589793 / WAYS;
        assert_close(sum / (fluence[c] - uncollided[c]), 1, 0.01);
    }
    ty_dom_destroy(light);
    ty_scene_destroy(scene);
}

/* Starting where a solve ended takes less work and changes the result within the tolerance. */
static void starts_save_sweeps(void** state) {
    static cells light[2];
    ty_scene* scene = foggy_scene(*state);
    ty_dom_def def = small_dom();
    ty_dom_stats stats[2] = {ty_default_dom_stats(), ty_default_dom_stats()};
    def.acceleration = TY_DOM_ACCELERATION_NONE;
    ty_dom* first = solve_dom(scene, &def, &stats[0]);
    look_at(first, &light[0]);
    def.start = first;
    ty_dom* second = solve_dom(scene, &def, &stats[1]);
    look_at(second, &light[1]);
    for (int c = 0; c < 3; ++c) assert_true(stats[1].sweeps[c] < stats[0].sweeps[c]);
    assert_close(mean_of(light[1].fluence) / mean_of(light[0].fluence), 1, def.tolerance);
    def.resolution = 9;
    ty_dom* third = NULL;
    assert_int_equal(ty_dom_solve(scene, &def, &third, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "dom.start: of 8 x 8 x 8 cells, and these are 9 x 9 x 9");
    assert_null(third);
    ty_dom_destroy(first);
    ty_dom_destroy(second);
    ty_scene_destroy(scene);
}

/* A scene whose channels are alike is solved once; a little color makes it three times the same. */
static void gray_scenes_are_solved_once(void** state) {
    static cells light[2];
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_image* images[2] = {NULL};
    for (int i = 0; i < 2; ++i) {
        ty_scene* scene = make_scene(*state);
        ty_medium_def fog = box_medium(lower, upper, 2, 0.1f);
        const ty_light_def sun = sun_light(2, 1, 0.5f), lamp = point_light(0.3, 0.2, 1.5, 4, i == 0 ? 2 : 2.00002f, 1);
        ty_dom_def def = small_dom();
        ty_dom_stats stats = ty_default_dom_stats();
        set3f(fog.g, 0.6f, 0.6f, 0.6f);
        add_medium(scene, &fog);
        add_light(scene, &sun);
        add_light(scene, &lamp);
        commit(scene);
        ty_dom* solved = solve_dom(scene, &def, &stats);
        assert_int_equal(stats.planes, i == 0 ? 1 : 3);
        look_at(solved, &light[i]);
        check_result(*state, ty_dom_view(solved, scene, &def, &images[i], NULL));
        ty_dom_destroy(solved);
        ty_scene_destroy(scene);
    }
    for (int i = 0; i < 3 * CELLS; ++i)
        assert_true(fabs(light[1].fluence[i] - light[0].fluence[i]) <= 2e-3 * light[0].fluence[i]);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < PIXELS; ++i) {
            const double a = (double)ty_image_plane_const(images[0], c)[i],
                         b = (double)ty_image_plane_const(images[1], c)[i];
            assert_true(fabs(a - b) <= 5e-3 * a + 1e-6);
        }
    ty_image_destroy(images[0]);
    ty_image_destroy(images[1]);
}

/* Twelve lamps, of which eight have fields of their own, are as bright as the same ones one by one. */
static void many_lamps_add_up(void** state) {
    static cells all, one;
    static double sum[3 * CELLS];
    const ty_medium_def block = colored_block();
    ty_dom_def def = small_dom();
    def.tolerance = 1e-5;
    for (int lamp = -1; lamp < 12; ++lamp) {
        ty_scene* scene = make_scene(*state);
        add_medium(scene, &block);
        for (int i = 0; i < 12; ++i) {
            const ty_light_def light = point_light(0.17 * (i % 4) - 1.3, 0.4 * (i / 4), 0.9, 1, (float)i, 2);
            if (lamp < 0 || lamp == i) add_light(scene, &light);
        }
        commit(scene);
        ty_dom* light = solve_dom(scene, &def, NULL);
        look_at(light, lamp < 0 ? &all : &one);
        for (int i = 0; i < 3 * CELLS && lamp >= 0; ++i) sum[i] += one.fluence[i];
        ty_dom_destroy(light);
        ty_scene_destroy(scene);
    }
    const double mean = mean_of(sum);
    /* Cell by cell sweeps that hold radiance above 0 are not linear. */
    assert_close(mean_of(all.fluence) / mean, 1, 1e-3);
    for (int i = 0; i < 3 * CELLS; ++i) assert_true(fabs(all.fluence[i] - sum[i]) <= 0.02 * mean);
}

/* Absent things send nothing: no light, no colour, no scattering. */
static void nothing_comes_from_nothing(void** state) {
    static cells cell;
    for (int lights = 0; lights < 3; ++lights) {
        ty_medium_def block = colored_block();
        const ty_light_def sun = sun_light(lights == 2 ? 1 : 0, 0, 0);
        ty_scene* scene = make_scene(*state);
        const ty_dom_def def = small_dom();
        ty_dom_stats stats = ty_default_dom_stats();
        if (lights == 2) set3f(block.sigma_s, 0, 0, 0);
        add_medium(scene, &block);
        if (lights > 0) add_light(scene, &sun);
        commit(scene);
        ty_dom* light = solve_dom(scene, &def, &stats);
        assert_true(stats.converged);
        look_at(light, &cell);
        for (int i = 0; i < 3 * CELLS; ++i) assert_true(cell.fluence[i] == cell.uncollided[i]);
        ty_image* image = NULL;
        check_result(*state, ty_dom_view(light, scene, &def, &image, NULL));
        for (int i = 0; i < PIXELS; ++i) assert_true(ty_image_plane_const(image, 0)[i] == 0);
        ty_image_destroy(image);
        ty_dom_destroy(light);
        ty_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        VOLUME_TESTS,
        cmocka_unit_test(cameras_move_without_solving_again),
        cmocka_unit_test(points_are_checked),
        cmocka_unit_test(statistics_tell_what_was_done),
        cmocka_unit_test(radiance_adds_up_to_fluence),
        cmocka_unit_test(starts_save_sweeps),
        cmocka_unit_test(gray_scenes_are_solved_once),
        cmocka_unit_test(many_lamps_add_up),
        cmocka_unit_test(nothing_comes_from_nothing),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
