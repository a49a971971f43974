/* A point source in a medium: the path tracer's fluence against the exact solution of the transport equation. */
#include "transport.h"

static const double taus[] = {0.5, 1, 2, 4, 6};

/* The quadrature has the limits it must have: no scattering, little scattering, diffusion far out, Grosjean between. */
static void quadrature_is_exact(void** state) {
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

static void quadrature_conserves_energy(void** state) {
    (void)state;
    for (double albedo = 0.1; albedo < 0.95; albedo += 0.2)
        assert_true(fabs(ty_integrate(shell, &albedo, 1e-9, 120, 400) * (1 - albedo) - 1) < 1e-4);
}

typedef struct source_case {
    double albedo, tau;
    int32_t spp; /* of 256 items, for an error of a third of a per cent; quick runs take half of them, full ones twice
                    as many */
} source_case;

static const source_case source_cases[] = {
    {0.5, 0.5, 128}, {0.5, 1, 256}, {0.5, 2, 1024}, {0.5, 4, 12288}, {0.5, 6, 98304},
    {0.9, 0.5, 192}, {0.9, 1, 512}, {0.9, 2, 1536}, {0.9, 4, 12288}, {0.9, 6, 16384},
    {1, 0.5, 256},   {1, 1, 512},   {1, 2, 2048},   {1, 4, 4096},    {1, 6, 6144},
};

/* To within 2%; far from the source that takes minutes. */
static void fluence_is_that_of_transport(void** state) {
    const double farthest = in_full() ? 6 : 2;
    for (size_t i = 0; i < sizeof source_cases / sizeof *source_cases; ++i) {
        const source_case* c = &source_cases[i];
        if (c->tau > farthest || (!in_full() && i % 2 == 1)) continue;
        char name[64];
        snprintf(name, sizeof name, "point source, albedo %g, tau %g", c->albedo, c->tau);
        assert_close(name, measure_source(*state, c->albedo, c->tau, 256, in_full() ? 2 * c->spp : c->spp / 2),
                     transport_in_ball(c->albedo, c->tau), 0.02);
    }
}

/* From a tenth of a mean free path on, for more albedos. */
static void the_table_holds_for_more_albedos(void** state) {
    static const double more_albedos[] = {0.3, 0.7, 0.8, 0.95, 0.99}, more_taus[] = {0.1, 0.2, 0.3, 0.7, 1.5, 3};
    leave_to_full_runs();
    for (int a = 0; a < 5; ++a)
        for (int i = 0; i < 6; ++i) {
            const double albedo = more_albedos[a], tau = more_taus[i];
            char name[64];
            snprintf(name, sizeof name, "point source, albedo %g, tau %g", albedo, tau);
            const int32_t spp = (int32_t)(4096 * (1 + tau * tau));
            assert_close(name, measure_source(*state, albedo, tau, 256, spp), transport_in_ball(albedo, tau), 0.02);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quadrature_is_exact),
        cmocka_unit_test(quadrature_conserves_energy),
        cmocka_unit_test(fluence_is_that_of_transport),
        cmocka_unit_test(the_table_holds_for_more_albedos),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
