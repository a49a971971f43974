/* Gradients by adjoint solves against central differences of the solves themselves. */
#include "fog.h"

enum { SIDE = 5, CELLS = SIDE * SIDE * SIDE, VOXELS_SIDE = 14, VOXELS = VOXELS_SIDE * VOXELS_SIDE * VOXELS_SIDE };

/* Relative error of a derivative; at most 4.1e-5 is measured, by the single precision of the fluences that are
 * subtracted. */
static const double TOLERANCE = 1e-4;

/* A scene by its parameters, so that each of them can be moved. */
typedef struct parameters {
    double sigma_s[3], sigma_a[3], g[3], sun, sky; /* sun, sky: factors of the lights */
    float* voxels;                                 /* NULL: a box without */
    ty_fld_def def;
} parameters;

static parameters gray(void) {
    parameters p = {.sigma_s = {3, 3, 3}, .sigma_a = {0.3, 0.3, 0.3}, .g = {0.4, 0.4, 0.4}, .sun = 1, .sky = 1};
    p.def = ty_default_fld_def();
    p.def.resolution = 16;
    p.def.environment_beams = 12;
    p.def.tolerance = 1e-7;
    return p;
}

static parameters colored(void) {
    parameters p = gray();
    set3(p.sigma_s, 1, 3, 6);
    set3(p.sigma_a, 0.5, 0.2, 0.1);
    set3(p.g, 0, 0.3, 0.7);
    return p;
}

static ty_scene* make(ty_context* context, const parameters* p) {
    static const double lower[3] = {-1, -0.75, -0.5}, upper[3] = {1, 0.75, 0.5};
    ty_scene* scene = make_scene(context);
    ty_medium_def medium = box_medium(lower, upper, 0, 0);
    ty_light_def sun = ty_default_light_def(), sky = sky_light(0.25f, 0.5f, 0.75f);
    ty_grid* grid = NULL;
    set3(sun.direction, -1, -2, -0.5);
    for (int c = 0; c < 3; ++c) {
        medium.sigma_s[c] = (float)p->sigma_s[c];
        medium.sigma_a[c] = (float)p->sigma_a[c];
        medium.g[c] = (float)p->g[c];
        sun.color[c] = (float)(p->sun * (1 + 0.3 * c));
        sky.color[c] *= (float)p->sky;
    }
    if (p->voxels != NULL) {
        ty_grid_def def = ty_default_grid_def();
        for (int a = 0; a < 3; ++a) def.size[a] = VOXELS_SIDE;
        def.values = p->voxels;
        assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
        medium.density_grid = grid;
    }
    assert_int_equal(ty_scene_add_medium(scene, &medium), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sun), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_grid_release(grid);
    return scene;
}

/* Weights of both signs. */
static void make_weights(double weights[3 * CELLS], bool same_in_channels) {
    uint64_t state = 7;
    for (int i = 0; i < CELLS; ++i)
        for (int c = 0; c < 3; ++c)
            weights[3 * i + c] = same_in_channels && c > 0 ? weights[3 * i] : uniform_in(&state, -0.5, 1);
}

static const double from[3] = {-0.9, -0.8, -0.45}, to[3] = {1.05, 0.7, 0.4};
static const int32_t cells_size[3] = {SIDE, SIDE, SIDE};

static ty_fld* solve(const ty_scene* scene, const parameters* p) {
    ty_fld* light = NULL;
    ty_fld_stats stats = ty_default_fld_stats();
    assert_int_equal(ty_fld_solve(scene, &p->def, &light, &stats), TY_OK);
    return light;
}

static double loss_of(ty_context* context, const parameters* p, const double* weights) {
    double fluence[3 * CELLS], sum = 0;
    ty_scene* scene = make(context, p);
    ty_fld* light = solve(scene, p);
    assert_int_equal(ty_fld_fluence(light, from, to, cells_size, fluence, NULL, NULL), TY_OK);
    for (int i = 0; i < 3 * CELLS; ++i) sum += weights[i] * fluence[i];
    ty_fld_destroy(light);
    ty_scene_destroy(scene);
    return sum;
}

/* The derivative by central differences of fourth order with a step of `step` in the numbers at `at`. */
static double difference(ty_context* context, parameters* p, double* at[], int count, double step,
                         const double* weights) {
    static const double move[4] = {-2, -1, 1, 2}, weight[4] = {1, -8, 8, -1};
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
        for (int n = 0; n < count; ++n) *at[n] += move[i] * step;
        sum += weight[i] * loss_of(context, p, weights);
        for (int n = 0; n < count; ++n) *at[n] -= move[i] * step;
    }
    return sum / (12 * step);
}

static void compare(const char* what, double found, double expected, double scale) {
    if (getenv("TYNDALL_SHOW") != NULL)
        print_message("%-12s %12.6g %12.6g  relative %.2g\n", what, found, expected, (found - expected) / scale);
    if (!(fabs(found - expected) <= TOLERANCE * scale))
        fail_msg("%s: %.9g, by differences %.9g", what, found, expected);
}

static ty_gradient* find(const ty_scene* scene, const parameters* p, const double* weights, ty_gradient_stats* stats) {
    ty_fld* light = solve(scene, p);
    ty_gradient* gradient = NULL;
    const ty_result result = ty_fld_gradient(light, scene, &p->def, from, to, cells_size, weights, &gradient, stats);
    if (result != TY_OK) fail_msg("%s", ty_take_error(ty_scene_context(scene)));
    ty_fld_destroy(light);
    assert_true(stats->converged);
    return gradient;
}

/* All coefficients of the medium and both lights. */
static void check_all(ty_context* context, parameters* p, bool same_in_channels) {
    double weights[3 * CELLS], sigma_s[3], sigma_a[3], g[3], factor[3];
    ty_gradient_stats stats = ty_default_gradient_stats();
    make_weights(weights, same_in_channels);
    ty_scene* scene = make(context, p);
    ty_gradient* gradient = find(scene, p, weights, &stats);
    if (getenv("TYNDALL_SHOW") != NULL)
        print_message("%d solves, residual %.1e, imbalance %.1e\n", stats.iterations, stats.residual, stats.imbalance);
    assert_int_equal(ty_gradient_medium(gradient, scene, 0, sigma_s, sigma_a, g), TY_OK);
    const int planes = ty_gradient_planes(gradient);
    for (int c = 0; c < planes; ++c) {
        const int count = planes == 1 ? 3 : 1;
        double *at_s[3] = {&p->sigma_s[c], &p->sigma_s[1], &p->sigma_s[2]},
               *at_a[3] = {&p->sigma_a[c], &p->sigma_a[1], &p->sigma_a[2]}, *at_g[3] = {&p->g[c], &p->g[1], &p->g[2]};
        const double by_s = difference(context, p, at_s, count, 0.04 * p->sigma_s[c], weights);
        const double by_a = difference(context, p, at_a, count, 0.005, weights);
        const double by_g = difference(context, p, at_g, count, 0.02, weights);
        compare("sigma_s", sigma_s[c], by_s, fabs(by_s) + 0.1 * fabs(by_a));
        compare("sigma_a", sigma_a[c], by_a, fabs(by_a));
        if (p->g[c] > 0) compare("g", g[c], by_g, fabs(by_g));
    }
    double* at[1] = {&p->sun};
    for (int i = 0; i < 2; ++i) {
        if (i == 1) at[0] = &p->sky;
        const double by_light = difference(context, p, at, 1, 0.02, weights);
        assert_int_equal(ty_gradient_light(gradient, i, factor), TY_OK);
        compare(i == 0 ? "sun" : "sky", factor[0] + factor[1] + factor[2], by_light, fabs(by_light));
    }
    ty_gradient_destroy(gradient);
    ty_scene_destroy(scene);
}

static void gray_media_and_lights(void** state) {
    parameters p = gray();
    check_all(*state, &p, true);
}

static void coloured_media_and_lights(void** state) {
    parameters p = colored();
    check_all(*state, &p, false);
}

static void every_limiter(void** state) {
    for (int limiter = TY_FLD_LIMITER_NONE; limiter < TY_FLD_LIMITER_LEVERMORE_POMRANING; ++limiter) {
        parameters p = gray();
        p.def.limiter = (ty_fld_limiter)limiter;
        check_all(*state, &p, true);
    }
}

/* Moves all voxels by random amounts at once, which differences resolve better than one voxel. */
static void voxels_of_density(void** state) {
    float voxels[VOXELS], direction[VOXELS];
    double weights[3 * CELLS], gradient_of[VOXELS], sum = 0, losses[2];
    uint64_t random = 3;
    parameters p = gray();
    p.def.resolution = TY_AUTO;
    p.voxels = voxels;
    for (int i = 0; i < VOXELS; ++i) {
        voxels[i] = (float)fmax(0.05, uniform_in(&random, -0.3, 1.5));
        direction[i] = (float)uniform_in(&random, -0.2, 1);
    }
    make_weights(weights, true);
    ty_scene* scene = make(*state, &p);
    ty_gradient_stats stats = ty_default_gradient_stats();
    ty_gradient* gradient = find(scene, &p, weights, &stats);
    if (ty_gradient_density(gradient, scene, 0, gradient_of) != TY_OK) fail_msg("%s", ty_take_error(*state));
    for (int i = 0; i < VOXELS; ++i) sum += gradient_of[i] * (double)direction[i];
    const float step = 0.01f;
    for (int s = 0; s < 2; ++s) {
        float moved[VOXELS];
        for (int i = 0; i < VOXELS; ++i) moved[i] = voxels[i] + (s == 0 ? -step : step) * direction[i];
        p.voxels = moved;
        losses[s] = loss_of(*state, &p, weights);
    }
    const double expected = (losses[1] - losses[0]) / (2 * (double)step);
    compare("voxels", sum, expected, fabs(expected));
    ty_gradient_destroy(gradient);
    ty_scene_destroy(scene);
}

/* ---- threads and progress ---- */

static void threads_do_not_matter(void** state) {
    (void)state;
    double weights[3 * CELLS], numbers[2][16];
    make_weights(weights, false);
    for (int i = 0; i < 2; ++i) {
        ty_context* context = make_context(1 + 2 * i);
        parameters p = colored();
        p.def.resolution = 96; /* so that slabs and boxes are divided among threads */
        p.def.environment_beams = 3;
        p.def.tolerance = 1e-4;
        ty_scene* scene = make(context, &p);
        ty_gradient_stats stats = ty_default_gradient_stats();
        ty_gradient* gradient = find(scene, &p, weights, &stats);
        assert_int_equal(ty_gradient_medium(gradient, scene, 0, numbers[i], numbers[i] + 3, numbers[i] + 6), TY_OK);
        assert_int_equal(ty_gradient_light(gradient, 0, numbers[i] + 9), TY_OK);
        assert_int_equal(ty_gradient_light(gradient, 1, numbers[i] + 12), TY_OK);
        numbers[i][15] = stats.residual;
        ty_gradient_destroy(gradient);
        ty_scene_destroy(scene);
        ty_context_destroy(context);
    }
    assert_memory_equal(numbers[0], numbers[1], sizeof numbers[0]);
}

static bool stop(void* user, const ty_progress* progress) {
    ++*(int*)user;
    return strcmp(progress->stage, "adjoint") != 0;
}

static void a_gradient_is_cancelled(void** state) {
    double weights[3 * CELLS];
    int calls = 0;
    parameters p = gray();
    ty_gradient* gradient = NULL;
    make_weights(weights, true);
    ty_scene* scene = make(*state, &p);
    ty_fld* light = solve(scene, &p);
    ty_fld_def def = p.def;
    def.progress = stop;
    def.progress_user = &calls;
    assert_int_equal(ty_fld_gradient(light, scene, &def, from, to, cells_size, weights, &gradient, NULL), TY_CANCELLED);
    assert_null(gradient);
    assert_true(calls > 0);
    ty_fld_destroy(light);
    ty_scene_destroy(scene);
}

/* ---- refusals ---- */

static void refuse(const ty_scene* scene, const ty_fld* light, const ty_fld_def* def, const char* words) {
    double weights[3 * CELLS] = {0};
    ty_gradient* gradient = NULL;
    assert_int_equal(ty_fld_gradient(light, scene, def, from, to, cells_size, weights, &gradient, NULL),
                     TY_ERROR_ARGUMENT);
    assert_null(gradient);
    assert_error(ty_scene_context(scene), words);
}

static void what_has_no_gradient_is_refused(void** state) {
    parameters p = gray();
    p.def.resolution = 8;
    ty_scene* scene = make(*state, &p);
    ty_fld* light = solve(scene, &p);
    ty_scene* surfaces = foggy_scene(*state);
    ty_fld* between = solve(surfaces, &p);
    refuse(surfaces, between, &p.def, "scenes with surfaces");
    ty_fld_destroy(between);
    ty_scene_destroy(surfaces);

    ty_fld_def other = p.def;
    other.resolution = 12;
    refuse(scene, light, &other, "other options");
    other = p.def;
    other.ratio = 4;
    refuse(scene, light, &other, "above 3");
    for (int c = 0; c < 3; ++c) p.sigma_s[c] = 20;
    ty_scene* moved = make(*state, &p);
    refuse(moved, light, &p.def, "no solution");
    ty_scene_destroy(moved);

    ty_scene* lit = make_scene(*state);
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    const ty_medium_def fog = box_medium(lower, upper, 1, 0);
    ty_light_def lamp = ty_default_light_def();
    lamp.kind = TY_LIGHT_POINT;
    set3(lamp.position, 0, 3, 0);
    assert_int_equal(ty_scene_add_medium(lit, &fog), TY_OK);
    assert_int_equal(ty_scene_add_light(lit, &lamp), TY_OK);
    assert_int_equal(ty_scene_commit(lit), TY_OK);
    refuse(lit, light, &p.def, "lights[0]");
    ty_scene_destroy(lit);

    /* A medium without voxels has no derivatives by them. */
    double weights[3 * CELLS] = {1}, voxels[1], sigma_s[3], sigma_a[3], g[3];
    ty_gradient_stats stats = ty_default_gradient_stats();
    for (int c = 0; c < 3; ++c) p.sigma_s[c] = 3;
    ty_gradient* gradient = find(scene, &p, weights, &stats);
    assert_int_equal(ty_gradient_density(gradient, scene, 0, voxels), TY_ERROR_ARGUMENT);
    assert_error(*state, "no voxels");
    assert_int_equal(ty_gradient_medium(gradient, scene, 1, sigma_s, sigma_a, g), TY_ERROR_ARGUMENT);
    assert_error(*state, "media[1]");
    assert_int_equal(ty_gradient_cells(gradient, TY_GRADIENT_G, 1, voxels), TY_ERROR_ARGUMENT);
    assert_error(*state, "plane 1");
    assert_int_equal(ty_gradient_light(gradient, 2, g), TY_ERROR_ARGUMENT);
    assert_error(*state, "lights[2]");
    ty_gradient_destroy(gradient);
    ty_fld_destroy(light);
    ty_scene_destroy(scene);
}

/* The sum over cells of the derivatives by albedo and g is that by the medium's; so is that by extinction at a constant
 * albedo. */
static void cells_add_up_to_media(void** state) {
    double weights[3 * CELLS], sigma_s[3], sigma_a[3], g[3], values[16 * 16 * 16], sums[3] = {0};
    ty_gradient_stats stats = ty_default_gradient_stats();
    parameters p = gray();
    make_weights(weights, true);
    ty_scene* scene = make(*state, &p);
    ty_gradient* gradient = find(scene, &p, weights, &stats);
    double lower[3], upper[3];
    int32_t size[3];
    ty_gradient_box(gradient, lower, upper, size);
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(ty_gradient_cells(gradient, (ty_gradient_coefficient)i, 0, values), TY_OK);
        for (int n = 0; n < size[0] * size[1] * size[2]; ++n) sums[i] += values[n];
    }
    assert_int_equal(ty_gradient_medium(gradient, scene, 0, sigma_s, sigma_a, g), TY_OK);
    const double sigma_t = p.sigma_s[0] + p.sigma_a[0], albedo = p.sigma_s[0] / sigma_t;
    assert_close(sums[0], albedo * sigma_s[0] + (1 - albedo) * sigma_a[0], 1e-5 * fabs(sigma_a[0]));
    assert_close(sums[1], sigma_t * (sigma_s[0] - sigma_a[0]), 1e-5 * fabs(sigma_t * sigma_a[0]));
    assert_close(sums[2], g[0], 1e-4 * fabs(g[0]));
    ty_gradient_destroy(gradient);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gray_media_and_lights),   cmocka_unit_test(coloured_media_and_lights),
        cmocka_unit_test(every_limiter),           cmocka_unit_test(voxels_of_density),
        cmocka_unit_test(cells_add_up_to_media),   cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(a_gradient_is_cancelled), cmocka_unit_test(what_has_no_gradient_is_refused),
    };
    return cmocka_run_group_tests_name("gradients", tests, start_context, stop_context);
}
