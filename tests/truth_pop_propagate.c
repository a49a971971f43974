/* The paper's propagation from cell to cell against path tracing, by which it is too bright, and against a closed form.
 */
#include "pop_grid_maker.h"

#include <stdio.h>

enum { SIDE = 16, CELLS = SIDE * SIDE * SIDE };

static const double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
static const int32_t size[3] = {SIDE, SIDE, SIDE};

/* sigma_s = 4/m and no absorption; light of 1 W m^-2 comes down. */
static ty_scene* cube_in_light(ty_context* context, double g) {
    ty_scene* scene = make_scene(context);
    const ty_medium_def medium = pop_cube(4, 0, g);
    check_result(context, ty_scene_add_medium(scene, &medium));
    direct_add_sun(scene, 0, -1, 0, 1);
    return scene;
}

/* The mean over the cube of the fluence of light that has scattered. */
static double traced(ty_context* context, double g) {
    ty_scene* scene = cube_in_light(context, g);
    double* fluence = malloc(3 * CELLS * sizeof *fluence);
    assert_non_null(fluence);
    double sum = 0;
    ty_path_def def = ty_default_path_def();
    def.spp = 256;
    check_result(context, ty_scene_commit(scene));
    check_result(context, ty_path_fluence(scene, &def, low, high, size, fluence, NULL, NULL));
    for (int i = 0; i < CELLS; ++i) sum += fluence[3 * i];
    free(fluence);
    ty_scene_destroy(scene);
    return sum / CELLS - (1 - exp(-4)) / 4;
}

static double propagated(ty_context* context, double g, ty_pop_mode mode, int32_t iterations) {
    const ty_discrete_light light = parallel_light(0, -1, 0);
    pop_case made = pop_begin(cube_in_light(context, g), &light, mode, SIDE, iterations);
    pop_run(&made);
    double sum = 0;
    for (int32_t k = 0; k < SIDE; ++k)
        for (int32_t i = 0; i < SIDE * SIDE; ++i) sum += (double)pop_accumulated(&made.light, i % SIDE, i / SIDE, k)[3];
    pop_end(&made);
    return sum / CELLS - (1 - exp(-4)) / 4;
}

/* The published mode counts light once for each cell that it came from, after as many iterations as there are cells
 * along the light; the collided mode ends when all light has left, which takes so long because cells trap it.
 * Propagation written apart from this library gave 4.6, 4.8, 4.2 and 3.6, 4.6, 1.19, to its noise of some per cent. The
 * ratios below were measured here; they are held to 1.5 %, a margin for path tracing's noise at g = 0.96. */
static void published_propagation_is_too_bright_as_measured(void** state) {
    static const double anisotropies[3] = {0, 0.7, 0.96};
    static const double published[3] = {4.83, 5.03, 4.28}, collided[3] = {3.57, 4.46, 1.20};
    for (int i = 0; i < 3; ++i) {
        const double g = anisotropies[i], truth = traced(*state, g);
        const double first = propagated(*state, g, TY_POP_MODE_PUBLISHED, SIDE) / truth;
        const double second = propagated(*state, g, TY_POP_MODE_COLLIDED, 1024) / truth;
        printf("g %.2f: published %.3f, collided %.3f times the fluence of path tracing\n", g, first, second);
        assert_close(first, published[i], 0.015 * published[i]);
        assert_close(second, collided[i], 0.015 * collided[i]);
    }
}

/* With g so near to 1 that nothing leaves its column, and no absorption, every cell of the published mode hands all of
 * its light on: after SIDE iterations cell k holds the sum over i <= k of the uncollided light of cell i, the mean of
 * exp(-sigma_s y) over it. */
static void straight_light_adds_up(void** state) {
    const double depth = 4.0 / SIDE;
    double sum = 0, column = 0;
    for (int k = 0; k < SIDE; ++k) {
        column += exp(-depth * k) * (1 - exp(-depth)) / depth;
        sum += column / SIDE;
    }
    const double expected = sum - (1 - exp(-4)) / 4;
    const double found = propagated(*state, 1 - 1e-7, TY_POP_MODE_PUBLISHED, SIDE);
    printf("straight light: %.5f of %.5f\n", found, expected);
    assert_close(found, expected, 1e-3 * expected);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(straight_light_adds_up),
                                       cmocka_unit_test(published_propagation_is_too_bright_as_measured)};
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
