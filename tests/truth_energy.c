/* Light in equals light out: a slab against published numbers, a cube against its own beam. */
#include "truth_cases.h"

/* g 0.75, sigma_a 10/cm, sigma_s 90/cm, 0.02 cm, normal incidence (van de Hulst 1980, Multiple Light Scattering). */
static void a_slab_agrees_with_van_de_hulst(void** state) {
    const slab_result slab = in_full() ? measure_slab(*state, 1 << 21, 16) : measure_slab(*state, 1 << 17, 8);
    const double tolerance = in_full() ? 0.001 : 0.005;
    assert_close("slab, diffuse reflectance", slab.reflectance, 0.09739, tolerance);
    assert_close("slab, total transmittance", slab.transmittance, 0.66096, tolerance);
}

static void check_cube(ty_context* context, double g, int64_t rays) {
    char name[64];
    snprintf(name, sizeof name, "power out of a cube, g %g", g);
    const estimate power =
        in_full() ? measure_cube_energy(context, g, 1 << 19, 16) : measure_cube_energy(context, g, rays, 4);
    assert_close(name, power, 1, 0.005);
}

static void a_cube_loses_no_energy(void** state) {
    static const double others[] = {-0.9, -0.3, 0.5, 0.9, 0.99};
    check_cube(*state, 0, 1 << 15);
    if (in_full()) check_cube(*state, 0.7, 0); /* 0 and 0.96 enclose it */
    check_cube(*state, 0.96, 1 << 17);
    for (int i = 0; i < (in_full() ? 5 : 0); ++i) check_cube(*state, others[i], 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_slab_agrees_with_van_de_hulst),
        cmocka_unit_test(a_cube_loses_no_energy),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
