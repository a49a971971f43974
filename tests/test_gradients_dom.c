/* Gradients of dom by adjoint solves against central differences of the solves themselves. */
#include "gradient_maker.h"

/* bands: fixed, as a change of their number is no derivative; TY_AUTO. */
static parameters by_dom(parameters p, int32_t bands) {
    p.by_dom = true;
    p.dom.bands = bands;
    return p;
}

static void gray_media_and_lights(void** state) {
    parameters p = by_dom(gray(), 4);
    check_all(*state, &p, true);
}

static void coloured_media_and_lights(void** state) {
    parameters p = by_dom(colored(), 4);
    check_all(*state, &p, false);
}

/* g above what the directions resolve: fitted moments. */
static void narrow_phase_functions(void** state) {
    parameters p = by_dom(gray(), TY_AUTO);
    p.dom.directions = 48;
    for (int c = 0; c < 3; ++c) p.g[c] = 0.85;
    check_all(*state, &p, true);
}

static void thick_media(void** state) {
    parameters p = by_dom(gray(), 4);
    for (int c = 0; c < 3; ++c) {
        p.sigma_s[c] = 29.97;
        p.sigma_a[c] = 0.03;
    }
    check_all(*state, &p, true);
}

static void voxels_of_density(void** state) {
    parameters p = by_dom(gray(), 4);
    p.dom.direct = TY_AUTO;
    check_voxels(*state, p);
}

/* The loss after steps in all voxels. */
static double loss_after(ty_context* context, parameters p, const double* weights, const float* voxels,
                         const float* step, float factor) {
    float moved[VOXELS];
    for (int i = 0; i < VOXELS; ++i) moved[i] = voxels[i] + factor * step[i];
    p.voxels = moved;
    return loss_of(context, &p, weights);
}

/* A narrow phase function in a cloud with empty space around. Where nothing is, density can only grow, and the loss has
 * so many kinks at 0 (faces that fix-ups close) that steps as small as single precision allows see only about the
 * derivative: 9 % off are measured, and more with longer steps. */
static void clouds_in_empty_space(void** state) {
    static const float step_of[2] = {0.01f, 1e-4f};
    static const double tolerance[2] = {1e-4, 0.12};
    float voxels[VOXELS], step[2][VOXELS] = {{0}};
    double weights[3 * CELLS], gradient_of_voxels[VOXELS];
    parameters p = by_dom(gray(), TY_AUTO);
    p.dom.direct = TY_AUTO;
    p.dom.directions = 48;
    p.voxels = voxels;
    for (int c = 0; c < 3; ++c) p.g[c] = 0.85;
    for (int i = 0; i < VOXELS; ++i) {
        const double x = i % VOXELS_SIDE - 6.5, y = i / VOXELS_SIDE % VOXELS_SIDE - 6.5,
                     z = i / (VOXELS_SIDE * VOXELS_SIDE) - 6.5;
        const int empty = x * x + y * y + z * z < 16 ? 0 : 1;
        voxels[i] = empty != 0 ? 0 : 1;
        step[empty][i] = step_of[empty] * (float)(1 + i % 3);
    }
    make_weights(weights, true);
    ty_scene* scene = make(*state, &p);
    ty_gradient_stats stats = ty_default_gradient_stats();
    ty_gradient* gradient = find(scene, &p, weights, &stats);
    assert_int_equal(ty_gradient_density(gradient, scene, 0, gradient_of_voxels), TY_OK);
    for (int empty = 0; empty < 2; ++empty) {
        const float* steps = step[empty];
        double sum = 0;
        for (int i = 0; i < VOXELS; ++i) sum += gradient_of_voxels[i] * (double)steps[i];
        const double above = loss_after(*state, p, weights, voxels, steps, 1),
                     below = loss_after(*state, p, weights, voxels, steps, empty != 0 ? 0 : -1);
        const double expected = (above - below) / (empty != 0 ? 1 : 2);
        compare(empty != 0 ? "empty voxels" : "full voxels", sum, expected,
                fabs(expected) * tolerance[empty] / TOLERANCE);
    }
    ty_gradient_destroy(gradient);
    ty_scene_destroy(scene);
}

static void threads_do_not_matter(void** state) {
    (void)state;
    parameters p = by_dom(colored(), 4);
    p.dom.direct = 48; /* so that cells and slabs are divided among threads */
    p.dom.resolution = 24;
    p.dom.directions = 8;
    p.dom.environment_beams = 3;
    p.dom.tolerance = 1e-4;
    check_threads(&p);
}

static void what_has_no_gradient_is_refused(void** state) {
    double weights[3 * CELLS] = {0};
    parameters p = by_dom(gray(), 4), other = p;
    ty_gradient* gradient = NULL;
    ty_scene* scene = make(*state, &p);
    const solved_light light = solve(scene, &p);
    other.dom.differentiable = false;
    assert_int_equal(gradient_of(scene, &other, light, weights, &gradient, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "dom.differentiable");
    other = p;
    other.dom.last_directions = 80;
    assert_int_equal(gradient_of(scene, &other, light, weights, &gradient, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "last_directions");
    other = p;
    other.dom.resolution = 9;
    assert_int_equal(gradient_of(scene, &other, light, weights, &gradient, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "other options");
    for (int c = 0; c < 3; ++c) other.sigma_a[c] = 20;
    ty_scene* moved = make(*state, &other);
    assert_int_equal(gradient_of(moved, &p, light, weights, &gradient, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "no solution");
    other = p;
    other.lamps = 1;
    ty_scene* lit = make(*state, &other);
    assert_int_equal(gradient_of(lit, &p, light, weights, &gradient, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "lights[2]");
    ty_scene_destroy(lit);
    assert_null(gradient);
    ty_scene_destroy(moved);
    destroy_light(light);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gray_media_and_lights),  cmocka_unit_test(coloured_media_and_lights),
        cmocka_unit_test(narrow_phase_functions), cmocka_unit_test(thick_media),
        cmocka_unit_test(voxels_of_density),      cmocka_unit_test(clouds_in_empty_space),
        cmocka_unit_test(threads_do_not_matter),  cmocka_unit_test(what_has_no_gradient_is_refused),
    };
    return cmocka_run_group_tests_name("gradients of dom", tests, start_context, stop_context);
}
