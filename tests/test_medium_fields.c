/* Media with transfer functions and fields: what is refused, values against closed forms, extremes against brute force.
 */
#include "checks.h"
#include "triangle_maker.h"

#include "scene/scene.h"

#include <stddef.h>

static const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};

/* A grid whose values are random in [low, high]. */
static ty_grid* random_grid(ty_context* context, int32_t size, double low, double high, bool placed) {
    ty_grid_def def = ty_default_grid_def();
    const int32_t count = size * size * size;
    float* values = malloc((size_t)count * sizeof *values);
    uint64_t random = 31;
    assert_non_null(values);
    for (int32_t i = 0; i < count; ++i) values[i] = (float)uniform_in(&random, low, high);
    for (int a = 0; a < 3; ++a) {
        def.size[a] = size;
        def.index_to_local.m[5 * a] = 2.0 / size;
        def.index_to_local.m[4 * a + 3] = -1 + 1.0 / size;
    }
    def.values = values;
    def.placed = placed;
    def.background = 0.25f;
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    free(values);
    return grid;
}

static ty_scene* medium_scene(ty_context* context, const ty_medium_def* def) {
    ty_scene* scene = make_scene(context);
    if (ty_scene_add_medium(scene, def) != TY_OK) fail_msg("%s", ty_take_error(context));
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

static const ty_medium_view* view_of(const ty_scene* scene) {
    return &ty_scene_get_view(scene)->media[0];
}

/* ---- what is refused ---- */

static void refuse(ty_context* context, const ty_medium_def* def, const char* words) {
    ty_scene* scene = make_scene(context);
    assert_int_equal(ty_scene_add_medium(scene, def), TY_ERROR_ARGUMENT);
    assert_error(context, words);
    assert_int_equal(ty_scene_get_info(scene).media, 0);
    ty_scene_destroy(scene);
}

#define MEDIUM(field, type, value, words)                                                                              \
    { offsetof(ty_medium_def, field), type, value, words }

static void wrong_numbers_are_refused(void** state) {
    static const bad_field bad[] = {
        MEDIUM(emission[1], FIELD_FLOAT, -1, "medium.emission[1]: -1 is outside [0, 1e+15]"),
        MEDIUM(emission[2], FIELD_FLOAT, NAN, "medium.emission[2]"),
        MEDIUM(emission_scale, FIELD_FLOAT, -0.5, "medium.emission_scale: -0.5"),
        MEDIUM(emission_scale, FIELD_FLOAT, INFINITY, "medium.emission_scale"),
        MEDIUM(kelvin[0], FIELD_DOUBLE, NAN, "medium.kelvin"),
        MEDIUM(kelvin[1], FIELD_DOUBLE, 1e10, "medium.kelvin: 1e+10"),
        MEDIUM(transfer_count, FIELD_INT, 1, "medium.transfer: 1 points are not 2..256"),
        MEDIUM(transfer_count, FIELD_INT, -3, "medium.transfer: -3 points"),
        MEDIUM(transfer_count, FIELD_INT, 257, "medium.transfer: 257 points"),
        MEDIUM(bounds, FIELD_INT, TY_BOUNDS_SHELL, "medium.shell: it is NULL"),
        MEDIUM(bounds, FIELD_INT, 4, "medium.bounds: 4 is not a ty_bounds_kind"),
    };
    static const ty_transfer_point points[2] = {{0, 0, {1, 1, 1}}, {1, 1, {1, 1, 1}}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        ty_medium_def def = box_medium(lower, upper, 1, 1);
        def.transfer = points;
        set_field(&def, &bad[i]);
        refuse(*state, &def, bad[i].words);
    }
    ty_medium_def def = box_medium(lower, upper, 1, 1);
    def.transfer_count = 2;
    refuse(*state, &def, "medium.transfer: 2 points are not");
    def.transfer = points;
    refuse(*state, &def, "medium.transfer: there is no density grid");
    def.transfer_count = 0;
    def.transfer_albedo = true;
    refuse(*state, &def, "medium.transfer_albedo: there is no transfer function");
}

static void wrong_points_are_refused(void** state) {
    static const struct {
        ty_transfer_point point;
        const char* words;
    } bad[] = {
        {{0.5f, 1, {1, 1, 1}}, "medium.transfer[1].value: 0.5 is not above the one before"},
        {{NAN, 1, {1, 1, 1}}, "medium.transfer[1].value"},
        {{1, -1, {1, 1, 1}}, "medium.transfer[1].density: -1 is outside [0, 1e+15]"},
        {{1, INFINITY, {1, 1, 1}}, "medium.transfer[1].density"},
        {{1, 1, {1, 2, 1}}, "medium.transfer.albedo[1]: 2 is outside [0, 1]"},
    };
    ty_medium_def def = box_medium(lower, upper, 1, 1);
    def.density_grid = random_grid(*state, 4, 0, 1, false);
    def.transfer_count = 2;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        const ty_transfer_point points[2] = {{0.5f, 0, {0, 0, 0}}, bad[i].point};
        def.transfer = points;
        refuse(*state, &def, bad[i].words);
    }
    ty_grid_release(def.density_grid);
}

static void wrong_fields_are_refused(void** state) {
    static const ty_transfer_point points[2] = {{0, 0, {1, 1, 1}}, {1, 1, {1, 1, 1}}};
    ty_grid* grid = random_grid(*state, 4, 0, 1, false);
    ty_medium_def def = box_medium(lower, upper, 1, 1);
    def.albedo_grid[1] = grid;
    refuse(*state, &def, "medium.albedo_grid: give three grids or none");
    def.albedo_grid[0] = def.albedo_grid[2] = grid;
    def.density_grid = grid;
    def.transfer = points;
    def.transfer_count = 2;
    def.transfer_albedo = true;
    refuse(*state, &def, "medium.albedo_grid: the transfer function gives the albedo already");
    for (int field = 0; field < 3; ++field) {
        def = ty_default_medium_def();
        def.bounds = TY_BOUNDS_SPHERE;
        def.sphere_radius = 1;
        if (field == 0) def.g_grid = grid;
        if (field == 1) def.temperature_grid = grid;
        if (field == 2) def.albedo_grid[0] = def.albedo_grid[1] = def.albedo_grid[2] = grid;
        refuse(*state, &def, "medium: a field without a transform needs a box to fill");
    }
    made_mesh mesh = made_nothing();
    made_add_box(&mesh, lower, upper);
    def = ty_default_medium_def();
    def.bounds = TY_BOUNDS_SHELL;
    def.density_grid = grid;
    assert_int_equal(made_shell(*state, &mesh, &def.shell), TY_OK);
    refuse(*state, &def, "medium.bounds: a grid without a transform fills a box, not a closed mesh");
    ty_closed_mesh_release(def.shell);
    made_free(&mesh);
    ty_grid_release(grid);
}

/* Objects of a scene stay when the caller releases them. */
static void media_keep_what_they_use(void** state) {
    ty_transfer_point points[2] = {{0, 0, {1, 1, 1}}, {1, 2, {1, 1, 1}}};
    ty_medium_def def = box_medium(lower, upper, 1, 1);
    def.density_grid = random_grid(*state, 4, 0, 1, false);
    def.g_grid = random_grid(*state, 3, -0.5, 0.5, false);
    def.temperature_grid = random_grid(*state, 5, 500, 900, true);
    def.transfer = points;
    def.transfer_count = 2;
    ty_scene* scene = make_scene(*state);
    const size_t before = ty_scene_get_info(scene).bytes;
    assert_int_equal(ty_scene_add_medium(scene, &def), TY_OK);
    const size_t bytes = ty_grid_get_info(def.density_grid).bytes + ty_grid_get_info(def.g_grid).bytes +
                         ty_grid_get_info(def.temperature_grid).bytes;
    assert_true(ty_scene_get_info(scene).bytes >= before + bytes);
    ty_grid_release(def.density_grid);
    ty_grid_release(def.g_grid);
    ty_grid_release(def.temperature_grid);
    points[1].density = -7;
    ty_medium_def kept;
    assert_int_equal(ty_scene_get_medium(scene, 0, &kept), TY_OK);
    assert_close(kept.transfer[1].density, 2, 0);
    assert_int_equal(ty_grid_get_info(kept.temperature_grid).size[0], 5);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_scene_destroy(scene);
}

/* ---- transfer functions ---- */

enum { POINTS = 7 };

/* Steep, flat and hidden peaks. */
static const ty_transfer_point curve[POINTS] = {{-0.5f, 0.3f, {0, 1, 0.5f}},    {0.1f, 0, {0.2f, 0.8f, 0.5f}},
                                                {0.3f, 2, {0.4f, 0.6f, 0.5f}},  {0.3001f, 9, {0.5f, 0.5f, 0.5f}},
                                                {0.31f, 0, {0.6f, 0.4f, 0.5f}}, {0.7f, 0.5f, {0.8f, 0.2f, 0.5f}},
                                                {1.2f, 4, {1, 0, 0.5f}}};

/* One value of the curve's points by straight search: 0 density, 1..3 albedo. */
static double curve_at(double value, int what) {
    double y[POINTS];
    for (int i = 0; i < POINTS; ++i) y[i] = (double)(what == 0 ? curve[i].density : curve[i].albedo[what - 1]);
    if (value <= (double)curve[0].value) return y[0];
    for (int i = 1; i < POINTS; ++i) {
        const double a = (double)curve[i - 1].value, b = (double)curve[i].value;
        if (value <= b) return y[i - 1] + (y[i] - y[i - 1]) * (value - a) / (b - a);
    }
    return y[POINTS - 1];
}

static void transfer_functions_are_linear_between_points(void** state) {
    (void)state;
    for (int i = -2000; i <= 3000; ++i) {
        const float value = (float)(i * 7e-4);
        assert_close(ty_transfer_density(curve, POINTS, value), curve_at((double)value, 0), 0.02);
        int32_t at;
        const float weight = ty_transfer_locate(curve, POINTS, value, &at);
        assert_true(at >= 0 && at + 1 < POINTS && weight >= 0 && weight <= 1);
    }
    for (int i = 0; i < POINTS; ++i)
        assert_close(ty_transfer_density(curve, POINTS, curve[i].value), curve[i].density, 1e-6);
    assert_close(ty_transfer_density(curve, POINTS, -1e30f), 0.3, 1e-6);
    assert_close(ty_transfer_density(curve, POINTS, 1e30f), 4, 1e-6);
    assert_close(ty_transfer_density(curve, POINTS, INFINITY), 4, 1e-6);
}

/* Densities along random rays stay within what bricks promise, and nothing is skipped: brute force over fine steps. */
static void bricks_bound_the_transferred_density(void** state) {
    for (int placed = 0; placed < 2; ++placed) {
        ty_medium_def def = box_medium(lower, upper, 1, 1);
        def.density_grid = random_grid(*state, 21, -0.2, 1.3, placed != 0);
        def.transfer = curve;
        def.transfer_count = POINTS;
        def.transfer_albedo = true;
        ty_scene* scene = medium_scene(*state, &def);
        const ty_medium_view* medium = view_of(scene);
        uint64_t number = 41;
        ty_sampler random = {0};
        for (int ray = 0; ray < 60; ++ray) {
            const ty_vec origin = ty_scale(random_unit(&number), 2.5f);
            const ty_vec way = ty_normalize(ty_sub(ty_scale(random_unit(&number), 0.7f), origin));
            float enter = 0, leave = 100;
            if (!ty_medium_interval(medium, origin, way, &enter, &leave)) continue;
            ty_majorant_dda bricks;
            float reached = enter;
            ty_majorant_dda_begin(&bricks, medium, origin, way, enter, leave);
            while (ty_majorant_dda_next(&bricks)) {
                for (int pass = 0; pass < 2; ++pass) { /* skipped bricks are empty */
                    const float from = pass == 0 ? reached : bricks.enter, to = pass == 0 ? bricks.enter : bricks.leave;
                    for (int i = 0; i < 40; ++i) {
                        const float t = from + (to - from) * ((float)i + 0.5f) / 40;
                        const ty_vec at = ty_mad(origin, way, t);
                        const double index[3] = {(double)(at.x + 1) * 10.5 - 0.5, (double)(at.y + 1) * 10.5 - 0.5,
                                                 (double)(at.z + 1) * 10.5 - 0.5};
                        const double value = (double)ty_grid_sample(def.density_grid, index);
                        const double density = curve_at(value, 0),
                                     found = (double)ty_medium_density(medium, at, &random);
                        if (fabs(value - 0.305) > 0.006) assert_close(found, density, 2e-3);
                        if (pass == 0) assert_true(found < 1e-2 || to - from < 1e-4f);
                        if (pass == 1)
                            assert_true(found >= (double)bricks.minorant - 1e-2 &&
                                        found <= (double)bricks.majorant + 1e-2);
                    }
                }
                reached = bricks.leave;
            }
        }
        float albedo[3];
        const double middle[3] = {10, 10, 10};
        ty_medium_albedo(medium, ty_vec_make((float)(10.5 / 10.5 - 1), 0, 0), albedo);
        const double value = (double)ty_grid_sample(def.density_grid, middle);
        for (int c = 0; c < 3; ++c) assert_close(albedo[c], curve_at(value, 1 + c), 2e-3);
        ty_scene_destroy(scene);
        ty_grid_release(def.density_grid);
    }
}

/* Each brick's pair is the least and largest density over the values that it spans. */
static void extremes_are_exact(void** state) {
    ty_medium_def def = box_medium(lower, upper, 1, 1);
    def.density_grid = random_grid(*state, 13, 0.2, 0.5, false);
    def.transfer = curve;
    def.transfer_count = POINTS;
    ty_scene* scene = medium_scene(*state, &def);
    const ty_medium_view* medium = view_of(scene);
    const int32_t* bricks = medium->grid.bricks;
    for (int32_t i = 0; i < bricks[0] * bricks[1] * bricks[2]; ++i) {
        const double from = (double)medium->grid.extremes[2 * i], to = (double)medium->grid.extremes[2 * i + 1];
        double least = INFINITY, most = 0;
        for (int s = 0; s <= 100000; ++s) {
            const double density = curve_at(from + (to - from) * s / 100000, 0);
            least = fmin(least, density);
            most = fmax(most, density);
        }
        assert_close(medium->extremes[2 * i], least, 1e-3);
        assert_close(medium->extremes[2 * i + 1], most, 0.3); /* the peak is as narrow as the steps */
        assert_true((double)medium->extremes[2 * i + 1] >= most - 1e-5);
    }
    ty_scene_destroy(scene);
    ty_grid_release(def.density_grid);
}

/* ---- fields ---- */

/* The value of a field at a point of the world, by the public lookup. */
static double field_at(const ty_grid* grid, ty_vec point) {
    const ty_grid_info info = ty_grid_get_info(grid);
    const double half = info.size[0] / 2.0;
    const double index[3] = {((double)point.x + 1) * half - 0.5, ((double)point.y + 1) * half - 0.5,
                             ((double)point.z + 1) * half - 0.5};
    return (double)ty_grid_sample(grid, index);
}

static double clamped(double value, double low, double high) {
    return fmin(fmax(value, low), high);
}

/* Inside, at the rim, outside and far outside, where a placed field has its background and others their edge. */
static void fields_are_looked_up(void** state) {
    for (int placed = 0; placed < 2; ++placed) {
        ty_medium_def def = box_medium(lower, upper, 3, 1);
        for (int c = 0; c < 3; ++c) def.albedo_grid[c] = random_grid(*state, 3 + c, -0.3, 1.3, placed != 0);
        def.g_grid = random_grid(*state, 7, -1.4, 1.4, placed != 0);
        def.temperature_grid = random_grid(*state, 6, 0, 1, placed != 0);
        def.kelvin[0] = 1500;
        def.kelvin[1] = 3500;
        def.emission[1] = 10;
        def.emission_scale = 0.5f;
        ty_scene* scene = medium_scene(*state, &def);
        const ty_medium_view* medium = view_of(scene);
        assert_true(medium->heterogeneous && medium->emits && !medium->has_grid);
        uint64_t number = 51;
        for (int i = 0; i < 3000; ++i) {
            const double reach = i % 3 == 0 ? 1 : i % 3 == 1 ? 2.5 : 1e12;
            const ty_vec at = ty_scale(random_unit(&number), (float)(reach * uniform(&number)));
            float albedo[3], sigma_s[3], g[3], emission[3], glow[3], black[3];
            ty_medium_albedo(medium, at, albedo);
            ty_medium_sigma_s(medium, at, sigma_s);
            ty_medium_g(medium, at, g);
            ty_medium_emission(medium, at, emission);
            ty_medium_emission_coefficient(medium, at, glow);
            ty_blackbody(1500 + 2000 * field_at(def.temperature_grid, at), black);
            for (int c = 0; c < 3; ++c) {
                assert_close(albedo[c], clamped(field_at(def.albedo_grid[c], at), 0, 1), 1e-4);
                assert_close(sigma_s[c], 4 * albedo[c], 1e-5);
                assert_close(g[c], clamped(field_at(def.g_grid, at), -0.9999, 0.9999), 2e-4);
                const double expected = (c == 1 ? 10 : 0) + 0.5 * (double)black[c];
                assert_close(emission[c], expected, 2e-3 * (double)black[0] + 1e-4);
                assert_close(glow[c], (double)emission[c] * (4 - (double)sigma_s[c]), 1e-3 * (1 + (double)emission[c]));
            }
        }
        ty_scene_destroy(scene);
        for (int c = 0; c < 3; ++c) ty_grid_release(def.albedo_grid[c]);
        ty_grid_release(def.g_grid);
        ty_grid_release(def.temperature_grid);
    }
}

/* One grid thrice is one field; a medium without fields is as its def says. */
static void fields_may_be_one_grid_or_none(void** state) {
    ty_medium_def def = box_medium(lower, upper, 3, 1);
    def.sigma_a[2] = 0;
    def.sigma_s[1] = 0;
    def.scale = 2;
    def.g[0] = 0.7f;
    ty_scene* scene = medium_scene(*state, &def);
    float albedo[3], g[3], glow[3];
    const ty_vec middle = ty_vec_make(0.1f, 0.2f, 0.3f);
    ty_medium_albedo(view_of(scene), middle, albedo);
    ty_medium_g(view_of(scene), middle, g);
    ty_medium_emission_coefficient(view_of(scene), middle, glow);
    assert_close(albedo[0], 0.75, 1e-6);
    assert_close(albedo[1], 0, 0);
    assert_close(albedo[2], 1, 0);
    assert_close(g[0], 0.7, 1e-6);
    assert_close(glow[0], 0, 0);
    assert_false(view_of(scene)->heterogeneous);
    ty_scene_destroy(scene);
    def.albedo_grid[0] = def.albedo_grid[1] = def.albedo_grid[2] = random_grid(*state, 4, 0, 1, true);
    scene = medium_scene(*state, &def);
    ty_medium_albedo(view_of(scene), middle, albedo);
    for (int c = 0; c < 3; ++c) assert_close(albedo[c], field_at(def.albedo_grid[0], middle), 1e-4);
    ty_scene_destroy(scene);
    ty_grid_release(def.albedo_grid[0]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_numbers_are_refused),
        cmocka_unit_test(wrong_points_are_refused),
        cmocka_unit_test(wrong_fields_are_refused),
        cmocka_unit_test(media_keep_what_they_use),
        cmocka_unit_test(transfer_functions_are_linear_between_points),
        cmocka_unit_test(bricks_bound_the_transferred_density),
        cmocka_unit_test(extremes_are_exact),
        cmocka_unit_test(fields_are_looked_up),
        cmocka_unit_test(fields_may_be_one_grid_or_none),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
