/* The marcher against closed forms and fine quadrature. */
#include "march_maker.h"

#include "image/march/deconvolve.h"
#include "scene/media/phase.k.h"

static const double low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};

static ty_scene* seen_from_front(ty_context* context) {
    ty_scene* scene = make_scene(context);
    march_look(scene, 0, 0, 50, 0, 0, 0);
    return scene;
}

static void add_medium(ty_scene* scene, const ty_medium_def* def) {
    check_result(ty_scene_context(scene), ty_scene_add_medium(scene, def));
}

static void commit(ty_scene* scene) {
    check_result(ty_scene_context(scene), ty_scene_commit(scene));
}

/* Light that is alike everywhere: (1 - e^-tau) albedo S, whatever the steps. */
static void even_boxes(void** state) {
    const float depths[] = {1e-4f, 0.3f, 4, 60};
    const double steps[] = {0.05, 0.7, 8};
    for (int d = 0; d < 4; ++d) {
        ty_scene* scene = seen_from_front(*state);
        const ty_medium_def medium = box_medium(low, high, 0.4f * depths[d], 0.1f * depths[d]);
        add_medium(scene, &medium);
        commit(scene);
        even_field even;
        even_begin(&even, low, high, 3);
        for (int s = 0; s < 3; ++s) {
            ty_march_def def = march_def(1, 1);
            def.step = steps[s];
            def.field = &even.field;
            const double expected = 0.8 * 3 * -expm1(-(double)depths[d]);
            assert_close(march_once(scene, &def, "R") / expected, 1, 1e-5);
        }
        ty_scene_destroy(scene);
    }
}

static void glow(void** state) {
    ty_scene* scene = seen_from_front(*state);
    ty_medium_def medium = box_medium(low, high, 0.5f, 0.25f);
    set3f(medium.sigma_a, 0.25f, 1, 4);
    set3f(medium.sigma_s, 0.5f, 2, 0);
    set3f(medium.emission, 1, 2, 3);
    add_medium(scene, &medium);
    commit(scene);
    ty_march_def def = march_def(1, 1);
    def.aovs = TY_AOV_TRANSMITTANCE;
    ty_image* image = march_image(scene, &def, NULL);
    assert_close(march_value(image, "R", 0), 1 * (0.25 / 0.75) * -expm1(-1.5), 1e-5);
    assert_close(march_value(image, "G", 0), 2 * (1.0 / 3) * -expm1(-6), 1e-5);
    assert_close(march_value(image, "B", 0), 3 * -expm1(-8), 1e-5);
    assert_close(march_value(image, "transmittance.R", 0), exp(-1.5), 1e-6);
    assert_close(march_value(image, "transmittance.G", 0), exp(-6), 1e-6);
    assert_close(march_value(image, "transmittance.B", 0), exp(-8), 1e-6);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* A second box over half of the first, another alone behind a gap: coefficients add where both are. */
static void media_together(void** state) {
    const double half[3] = {1, 1, 0}, behind[2][3] = {{-1, -1, -4}, {1, 1, -3}};
    ty_scene* scene = seen_from_front(*state);
    ty_medium_def first = box_medium(low, high, 0.3f, 0.1f), second = box_medium(low, half, 0, 0.5f);
    ty_medium_def third = box_medium(behind[0], behind[1], 0, 0.25f);
    for (int c = 0; c < 3; ++c) {
        first.emission[c] = 1;
        second.emission[c] = 2;
        third.emission[c] = 4;
    }
    add_medium(scene, &first);
    add_medium(scene, &second);
    add_medium(scene, &third);
    commit(scene);
    ty_march_def def = march_def(1, 1);
    def.aovs = TY_AOV_TRANSMITTANCE;
    ty_image* image = march_image(scene, &def, NULL);
    const double near = 0.1 / 0.4 * -expm1(-0.4), both = (0.1 * 1 + 0.5 * 2) / 0.9 * -expm1(-0.9);
    const double expected = near + exp(-0.4) * both + exp(-1.3) * 4 * -expm1(-0.25);
    assert_close(march_value(image, "R", 0), expected, 1e-5);
    assert_close(march_value(image, "transmittance.G", 0), exp(-1.55), 1e-6);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

static void spheres(void** state) {
    ty_scene* scene = make_scene(*state);
    march_look(scene, 0.6, 0, 50, 0.6, 0, 0);
    ty_medium_def ball = ty_default_medium_def();
    ball.bounds = TY_BOUNDS_SPHERE;
    ball.sphere_radius = 1;
    set3f(ball.sigma_a, 1, 1, 1);
    add_medium(scene, &ball);
    commit(scene);
    ty_march_def def = march_def(1, 1);
    def.aovs = TY_AOV_TRANSMITTANCE;
    assert_close(march_once(scene, &def, "transmittance.B"), exp(-1.6), 1e-5);
    ty_scene_destroy(scene);
}

/* ---- grids ---- */

static double trilinear(const float* values, const int32_t size[3], const double at[3]) {
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1;
        size_t index = 0, stride = 1;
        for (int a = 0; a < 3; ++a) {
            const double floor_at = floor(at[a]), share = at[a] - floor_at;
            int32_t cell = (int32_t)floor_at + (corner >> a & 1);
            weight *= (corner >> a & 1) != 0 ? share : 1 - share;
            cell = cell < 0 ? 0 : cell >= size[a] ? size[a] - 1 : cell;
            index += stride * (size_t)cell;
            stride *= (size_t)size[a];
        }
        sum += weight * (double)values[index];
    }
    return sum;
}

/* Fog of random voxels in the cube, and a copy of them. */
static ty_grid* random_voxels(ty_context* context, const int32_t size[3], float* values) {
    ty_grid* grid = direct_noise(context, size[0], size[1], size[2], 7);
    uint64_t seed = 7;
    for (int32_t i = 0; i < size[0] * size[1] * size[2]; ++i) values[i] = (float)fmax(0, uniform_in(&seed, -0.5, 1.5));
    return grid;
}

/* e^-depth is that of the trilinear density to rounding, whatever the steps; density_of: of the grid's values. */
static void check_depths(ty_context* context, bool transfer, double tolerance) {
    enum { NX = 19, NY = 13, NZ = 25, RAYS = 40 };
    static const ty_transfer_point points[3] = {{0.2f, 0, {0}}, {0.7f, 1.2f, {0}}, {1.1f, 0.4f, {0}}};
    const int32_t size[3] = {NX, NY, NZ};
    static float values[NX * NY * NZ];
    ty_grid* grid = random_voxels(context, size, values);
    uint64_t seed = 11;
    for (int ray = 0; ray < RAYS; ++ray) {
        ty_scene* scene = make_scene(context);
        const ty_vec d = random_unit(&seed);
        const double target[3] = {uniform_in(&seed, -0.6, 0.6), uniform_in(&seed, -0.6, 0.6),
                                  uniform_in(&seed, -0.6, 0.6)};
        const double way[3] = {(double)d.x, (double)d.y, (double)d.z};
        march_look(scene, target[0] - 5 * way[0], target[1] - 5 * way[1], target[2] - 5 * way[2], target[0], target[1],
                   target[2]);
        ty_medium_def medium = box_medium(low, high, 0.5f, 1);
        medium.density_grid = grid;
        if (transfer) {
            medium.transfer = points;
            medium.transfer_count = 3;
        }
        add_medium(scene, &medium);
        commit(scene);
        double depth = 0;
        enum { PARTS = 200000 };
        for (int i = 0; i < PARTS; ++i) {
            const double t = 2 + 6 * (i + 0.5) / PARTS;
            double at[3];
            bool inside = true;
            for (int a = 0; a < 3; ++a) {
                const double x = target[a] + (t - 5) * way[a];
                inside = inside && fabs(x) < 1;
                at[a] = (x + 1) * size[a] / 2 - 0.5;
            }
            if (!inside) continue;
            const double value = trilinear(values, size, at);
            depth += 1.5 * (transfer ? (double)ty_transfer_density(points, 3, (float)value) : value) * 6 / PARTS;
        }
        ty_march_def def = march_def(1, 1);
        def.aovs = TY_AOV_TRANSMITTANCE;
        assert_close(march_once(scene, &def, "transmittance.G"), exp(-depth), tolerance);
        ty_scene_destroy(scene);
    }
    ty_grid_release(grid);
}

static void depths_are_exact(void** state) {
    check_depths(*state, false, 1e-5);
}

static void depths_of_transfer_functions(void** state) {
    check_depths(*state, true, 5e-4);
}

/* Random voxels with a field of random cells: what steps cost falls with their square. */
static double lit_noise(ty_context* context, double step, uint64_t seed) {
    enum { CELLS = 8 };
    static float cells[CELLS * CELLS * CELLS];
    const int32_t size[3] = {48, 48, 48};
    static float values[48 * 48 * 48];
    ty_scene* scene = make_scene(context);
    march_look(scene, 3, 4, 5, 0.1, 0.2, -0.1);
    ty_grid* grid = random_voxels(context, size, values);
    ty_medium_def medium = box_medium(low, high, 2, 0.1f);
    medium.density_grid = grid;
    add_medium(scene, &medium);
    commit(scene);
    uint64_t of_cells = 3;
    for (int i = 0; i < CELLS * CELLS * CELLS; ++i) cells[i] = (float)uniform(&of_cells);
    even_field even;
    even_begin(&even, low, high, 0);
    for (int c = 0; c < 3; ++c) {
        even.field.terms[c][0] = cells;
        even.field.box.size[c] = CELLS;
    }
    ty_march_def def = march_def(1, 1);
    def.field = &even.field;
    def.step = step;
    def.seed = seed;
    const double value = march_once(scene, &def, "R");
    ty_grid_release(grid);
    ty_scene_destroy(scene);
    return value;
}

static void steps_converge(void** state) {
    const double truth = lit_noise(*state, 0.05, 0);
    double error[2] = {0, 0};
    for (uint64_t seed = 1; seed <= 16; ++seed) {
        error[0] += pow(lit_noise(*state, 1, seed) / truth - 1, 2) / 16;
        error[1] += pow(lit_noise(*state, 0.25, seed) / truth - 1, 2) / 16;
    }
    assert_true(sqrt(error[0]) < 0.02);
    assert_true(sqrt(error[1]) < sqrt(error[0]) / 4);
}

/* ---- lights ---- */

/* A beam on a cube, its fluence given on cells that are fine enough: the closed form with the true phase function. */
static void beams_scatter_once(void** state) {
    const float g = 0.7f;
    enum { CELLS = 128 };
    static float fluence[CELLS];
    ty_scene* scene = seen_from_front(*state);
    ty_medium_def medium = box_medium(low, high, 1, 0.5f);
    set3f(medium.g, g, g, g);
    add_medium(scene, &medium);
    commit(scene);
    ty_march_def def = march_def(1, 1);
    ty_light_fluence light = {.kind = TY_FLUENCE_DIRECTIONAL, .anchor = ty_vec_make(0, 0.6f, -0.8f)};
    for (int z = 0; z < CELLS; ++z) fluence[z] = (float)(5 * exp(-1.5 * (2.0 - (z + 0.5) * 2 / CELLS)));
    for (int c = 0; c < 3; ++c) {
        light.fluence[c] = fluence;
        def.light_box.lower[c] = -1;
        def.light_box.upper[c] = 1;
        def.light_box.size[c] = c == 2 ? CELLS : 1;
    }
    def.lights = &light;
    def.light_count = 1;
    def.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE;
    ty_image* image = march_image(scene, &def, NULL);
    const double expected = 5 * (double)ty_hg(-0.8f, g) * -expm1(-6) / 3;
    assert_close(march_value(image, "single.R", 0) / expected, 1, 5e-4);
    assert_true(march_value(image, "R", 0) == march_value(image, "single.R", 0));
    assert_true(march_value(image, "multiple.R", 0) == 0);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* Light from above in a cube of cells 5 mean free paths thick, seen at its front below the upper side: the first cell's
 * mean is 0.2 of the light, of which a constant would show as much everywhere. */
static void beams_enter_thick_cells(void** state) {
    enum { CELLS = 8 };
    static float fluence[CELLS * CELLS * CELLS];
    const double cell = 2.0 / CELLS, extinction = 5 / cell, below[] = {0.01, 0.05, 0.1, 0.2};
    for (int i = 0; i < CELLS * CELLS * CELLS; ++i) {
        const double top = extinction * cell * (CELLS - 1 - i / CELLS % CELLS);
        fluence[i] = (float)(5 * exp(-top) * -expm1(-extinction * cell) / (extinction * cell));
    }
    for (int i = 0; i < 4; ++i) {
        ty_scene* scene = make_scene(*state);
        march_look(scene, 0, 1 - below[i], 50, 0, 1 - below[i], 0);
        ty_medium_def medium = box_medium(low, high, (float)(0.5 * extinction), (float)(0.5 * extinction));
        add_medium(scene, &medium);
        ty_light_def sun = ty_default_light_def();
        set3f(sun.color, 5, 5, 5);
        sun.direction[0] = sun.direction[2] = 0;
        sun.direction[1] = -1;
        check_result(*state, ty_scene_add_light(scene, &sun));
        commit(scene);
        ty_march_def def = march_def(1, 1);
        ty_light_fluence light = {.kind = TY_FLUENCE_DIRECTIONAL, .anchor = ty_vec_make(0, -1, 0)};
        for (int c = 0; c < 3; ++c) {
            light.fluence[c] = fluence;
            def.light_box.lower[c] = -1;
            def.light_box.upper[c] = 1;
            def.light_box.size[c] = CELLS;
        }
        def.lights = &light;
        def.light_count = 1;
        def.traces_faces = true;
        const double expected = 0.5 * 5 / (4 * 3.14159265358979) * exp(-extinction * below[i]);
        assert_close(march_once(scene, &def, "R") / expected, 1, 1e-3);
        ty_scene_destroy(scene);
    }
}

/* ---- fields ---- */

static void fields_have_directions_and_ends(void** state) {
    const double half[3] = {1, 1, 0};
    ty_scene* scene = seen_from_front(*state);
    ty_medium_def medium = box_medium(low, high, 0.5f, 0);
    set3f(medium.g, 0.5f, 0.5f, 0.5f);
    add_medium(scene, &medium);
    commit(scene);
    even_field even;
    even_begin(&even, low, high, 2);
    even.field.term_count = 4;
    even.values[3] = 1.5f; /* more towards +z, where the camera is */
    ty_march_def def = march_def(1, 1);
    def.field = &even.field;
    /* Twice 1.5 / 3 over 2 is a half, and P3(1) is 1. */
    const double third = -7.0 / 8 * 2 * pow(0.5, 3);
    assert_close(march_once(scene, &def, "R"), (2 + 0.5 * 1.5 + pow(0.5, 3) * third) * -expm1(-1), 1e-5);
    even.values[3] = -4.5f;
    assert_close(march_once(scene, &def, "R"), 0, 0);
    /* Steps do not end where the field does: many rays, that differ. */
    even_begin(&even, low, half, 2);
    def.step = 0.05;
    def.spp = 64;
    assert_close(march_once(scene, &def, "R"), 2 * exp(-0.5) * -expm1(-0.5), 2e-3);
    ty_scene_destroy(scene);
}

/* Channels that are multiples of one, said to be so and not, are the same light. */
static void shared_fields_are_the_same(void** state) {
    static const float color[3] = {1, 0.5f, 3};
    float terms[3][TY_FIELD_TERMS];
    ty_scene* scene = seen_from_front(*state);
    ty_medium_def medium = box_medium(low, high, 0.5f, 0);
    set3f(medium.g, 0.5f, 0.5f, 0.5f);
    add_medium(scene, &medium);
    commit(scene);
    ty_march_def def = march_def(1, 1);
    for (int count = 1; count <= TY_FIELD_TERMS; count += 3) {
        even_field even;
        even_begin(&even, low, high, 0);
        even.field.term_count = count;
        for (int c = 0; c < 3; ++c)
            for (int t = 0; t < TY_FIELD_TERMS; ++t) {
                terms[c][t] = color[c] * (2 - 0.4f * (float)t);
                even.field.terms[c][t] = &terms[c][t];
            }
        def.field = &even.field;
        ty_image* apart = march_image(scene, &def, NULL);
        even.field.shared = true;
        for (int c = 0; c < 3; ++c) even.field.color[c] = color[c];
        for (int t = 0; t < TY_FIELD_TERMS; ++t) even.field.terms[1][t] = even.field.terms[2][t] = NULL;
        ty_image* shared = march_image(scene, &def, NULL);
        static const char* const names[3] = {"R", "G", "B"};
        for (int c = 0; c < 3; ++c) {
            const double expected = march_value(apart, names[c], 0);
            assert_true(expected > 0);
            assert_close(march_value(shared, names[c], 0) / expected, 1, 1e-6);
        }
        ty_image_destroy(apart);
        ty_image_destroy(shared);
    }
    ty_scene_destroy(scene);
}

/* Two cells side by side, one of them as dense as the medium. */
static void guides_choose_cells(void** state) {
    float light[2] = {1, 5}, guide[2] = {0.5f, 0.01f};
    ty_scene* scene = seen_from_front(*state);
    const ty_medium_def medium = box_medium(low, high, 0.5f, 0);
    add_medium(scene, &medium);
    commit(scene);
    even_field even;
    even_begin(&even, low, high, 0);
    even.field.box.size[0] = 2;
    for (int c = 0; c < 3; ++c) even.field.terms[c][0] = light;
    even.field.guide = guide;
    ty_march_def def = march_def(1, 1);
    def.field = &even.field;
    def.bilateral_sigma = 0;
    assert_close(march_once(scene, &def, "R"), 3 * -expm1(-1), 1e-4);
    def.bilateral_sigma = 0.25;
    assert_close(march_once(scene, &def, "R"), 1 * -expm1(-1), 0.05);
    guide[1] = 0.5f;
    assert_close(march_once(scene, &def, "R"), 3 * -expm1(-1), 1e-4);
    guide[0] = guide[1] = 0;
    assert_close(march_once(scene, &def, "R"), 3 * -expm1(-1), 1e-4);
    ty_scene_destroy(scene);
}

/* The interpolant's mean over a cell of one of a row. */
static double row_mean(const float* values, int at, int count) {
    const int before = at > 0 ? at - 1 : at, after = at + 1 < count ? at + 1 : at;
    return ((double)values[before] + 6 * (double)values[at] + (double)values[after]) / 8;
}

/* Waves come out with the means that they had, even fields as they were, and nothing below 0. */
static void sharp_cells_keep_their_means(void** state) {
    enum { CELLS = 16 };
    for (int axis = 0; axis < 3; ++axis) {
        int32_t size[3] = {1, 1, 1};
        float wave[CELLS], cells[CELLS][4];
        size[axis] = CELLS;
        for (int i = 0; i < CELLS; ++i) {
            wave[i] = 2 + cosf(1.5707963f * ((float)i + 0.5f));
            cells[i][0] = wave[i];
            cells[i][1] = 3;
            cells[i][2] = i < CELLS / 2 ? 0.0f : 1.0f;
            cells[i][3] = 7;
        }
        check_result(*state, ty_deconvolve_means(*state, size, 4, 1, 3, NULL, NULL, cells[0]));
        float sharp[CELLS];
        for (int i = 0; i < CELLS; ++i) sharp[i] = cells[i][0];
        for (int i = 0; i < CELLS; ++i) {
            assert_true(fabs(row_mean(wave, i, CELLS) - (double)wave[i]) > 0.05);
            assert_close(row_mean(sharp, i, CELLS), (double)wave[i], 0.005);
            assert_close((double)cells[i][1], 3, 1e-5);
            assert_true(cells[i][2] >= 0 && cells[i][3] == 7);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(even_boxes),
        cmocka_unit_test(glow),
        cmocka_unit_test(media_together),
        cmocka_unit_test(spheres),
        cmocka_unit_test(depths_are_exact),
        cmocka_unit_test(depths_of_transfer_functions),
        cmocka_unit_test(steps_converge),
        cmocka_unit_test(beams_scatter_once),
        cmocka_unit_test(beams_enter_thick_cells),
        cmocka_unit_test(fields_have_directions_and_ends),
        cmocka_unit_test(shared_fields_are_the_same),
        cmocka_unit_test(guides_choose_cells),
        cmocka_unit_test(sharp_cells_keep_their_means),
    };
    return cmocka_run_group_tests_name("march", tests, start_context, stop_context);
}
