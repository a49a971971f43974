/* A point source in a medium: the path tracer's fluence against the exact solution of the transport equation. */
#include "transport.h"

static const double taus[] = {0.5, 1, 2, 4, 6};

/* The quadrature has the limits it must have: no scattering, little scattering, diffusion far out, Grosjean between. */
static void test_quadrature(void** state) {
    (void)state;
    for (int i = 0; i < 5; ++i) {
        const double tau = taus[i];
        assert_true(fabs(transport_fluence(1e-9, tau) / (exp(-tau) / (tau * tau)) - 1) < 1e-6);
        /* A little scattering: twice as much gives twice as much. */
        const double once = transport_fluence(1e-3, tau) - transport_fluence(1e-9, tau);
        const double twice = transport_fluence(2e-3, tau) - transport_fluence(1e-9, tau);
        assert_true(fabs(twice / once - 2) < 0.02);
        for (int tenth = 1; tenth <= 10; ++tenth) {
            const double albedo = 0.1 * tenth, ratio = transport_grosjean(albedo, tau) / transport_fluence(albedo, tau);
            if (!(fabs(ratio - 1) < 0.1)) fail_msg("albedo %g, tau %g: Grosjean's is %g of it", albedo, tau, ratio);
        }
    }
    assert_true(fabs(transport_fluence(1, 40) * 40 / 3 - 1) < 1e-6);
    assert_true(fabs(1 / transport_decay(0.9) - 1.903205) < 1e-5); /* Case, de Hoffmann and Placzek, table 26 */
    /* Albedo 1 is a limit that is reached evenly. */
    assert_true(fabs(transport_fluence(1 - 1e-8, 1) / transport_fluence(1, 1) - 1) < 1e-3);
}

/* All light is absorbed somewhere: albedo < 1 makes the fluence add up to power / sigma_a. */
static double shell(const void* user, double tau) {
    return tau * tau * transport_fluence(*(const double*)user, tau);
}

static void test_quadrature_conserves_energy(void** state) {
    (void)state;
    for (double albedo = 0.1; albedo < 0.95; albedo += 0.2)
        assert_true(fabs(ty_integrate(shell, &albedo, 1e-9, 120, 400) * (1 - albedo) - 1) < 1e-4);
}

static void test_fluence(void** state) {
    check_sources(*state, 2, 1); /* farther ones take minutes: validate_source.c */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quadrature),
        cmocka_unit_test(test_quadrature_conserves_energy),
        cmocka_unit_test(test_fluence),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
