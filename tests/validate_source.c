/* The long form of truth_source.c: larger distances, more samples, and a finer table. */
#include "transport.h"

static void test_fluence(void** state) {
    check_sources(*state, 6, 8);
}

/* From a tenth of a mean free path on, for more albedos; printed to be looked at, held to the same 2%. */
static void test_table(void** state) {
    static const double albedos[] = {0.3, 0.7, 0.8, 0.95, 0.99}, taus[] = {0.1, 0.2, 0.3, 0.7, 1.5, 3};
    for (int a = 0; a < 5; ++a)
        for (int i = 0; i < 6; ++i) {
            char name[64];
            snprintf(name, sizeof name, "point source, albedo %g, tau %g", albedos[a], taus[i]);
            const int32_t spp = (int32_t)(4096 * (1 + taus[i] * taus[i]));
            assert_close(name, measure_source(*state, albedos[a], taus[i], 256, spp),
                         transport_in_ball(albedos[a], taus[i]), 0.02);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_fluence),
        cmocka_unit_test(test_table),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
