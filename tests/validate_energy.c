/* The long form of truth_energy.c: to a tenth of what is allowed there, and for more g. */
#include "truth_cases.h"

static void test_slab(void** state) {
    const slab_result slab = measure_slab(*state, 1 << 21, 16);
    assert_close("slab, diffuse reflectance", slab.reflectance, 0.09739, 0.001);
    assert_close("slab, total transmittance", slab.transmittance, 0.66096, 0.001);
}

static void test_cube(void** state) {
    static const double anisotropies[] = {-0.9, -0.3, 0, 0.5, 0.7, 0.9, 0.96, 0.99};
    for (int i = 0; i < 8; ++i) {
        char name[64];
        snprintf(name, sizeof name, "power out of a cube, g %g", anisotropies[i]);
        assert_close(name, measure_cube_energy(*state, anisotropies[i], 1 << 19, 16), 1, 0.005);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_slab),
        cmocka_unit_test(test_cube),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
