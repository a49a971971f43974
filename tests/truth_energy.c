/* Light in equals light out: a slab against published numbers, a cube against its own beam. */
#include "truth_cases.h"

/* g 0.75, sigma_a 10/cm, sigma_s 90/cm, 0.02 cm, normal incidence (van de Hulst 1980, Multiple Light Scattering). */
static void test_slab(void** state) {
    const slab_result slab = measure_slab(*state, 1 << 17, 8);
    assert_close("slab, diffuse reflectance", slab.reflectance, 0.09739, 0.005);
    assert_close("slab, total transmittance", slab.transmittance, 0.66096, 0.005);
}

static void check_cube(ty_context* context, double g, int64_t rays, int32_t spp) {
    char name[64];
    snprintf(name, sizeof name, "power out of a cube, g %g", g);
    assert_close(name, measure_cube_energy(context, g, rays, spp), 1, 0.005);
}

static void test_cube(void** state) {
    check_cube(*state, 0, 1 << 15, 4);
    check_cube(*state, 0.7, 1 << 16, 4);
    check_cube(*state, 0.96, 1 << 16, 4);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_slab),
        cmocka_unit_test(test_cube),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
