/* Flux limiters against their definitions in double precision, and their limits. */
#include "solve/diffusion/diffusion.h"
#include "solve/diffusion/limiter.k.h"

#include "checks.h"

static double defined(int limiter, double n, double r) {
    switch (limiter) {
    case TY_LIMITER_SUM: return 1 / (3 + r);
    case TY_LIMITER_MAX: return 1 / fmax(3, r);
    case TY_LIMITER_KERSHAW: return 2 / (3 + sqrt(9 + 4 * r * r));
    case TY_LIMITER_LARSEN: return pow(pow(3, n) + pow(r, n), -1 / n);
    case TY_LIMITER_LEVERMORE_POMRANING: return r < 1e-3 ? 1.0 / 3 - r * r / 45 : (1 / tanh(r) - 1 / r) / r;
    default: return 1.0 / 3;
    }
}

static void limiters_are_as_defined(void** state) {
    (void)state;
    static const double powers[] = {1, 1.5, 2, 3.7, 20};
    for (int limiter = 0; limiter < TY_LIMITER_COUNT; ++limiter)
        for (int p = 0; p < 5; ++p)
            for (double r = 1e-6; r < 1e6; r *= 1.07) {
                const double expected = defined(limiter, powers[p], r);
                const float value = ty_limiter_value(limiter, (float)powers[p], (float)r);
                assert_close((double)value, expected, 2e-6 * expected);
            }
}

static void limits_are_right(void** state) {
    (void)state;
    for (int limiter = TY_LIMITER_SUM; limiter < TY_LIMITER_COUNT; ++limiter) {
        assert_close((double)ty_limiter_value(limiter, 2, 0), 1.0 / 3, 1e-7);
        assert_close(1e7 * (double)ty_limiter_value(limiter, 2, 1e7f), 1, 2e-6);
        /* Ratios that square to infinity still give 1 / R, or as good as that. */
        const float far = ty_limiter_value(limiter, 2, 1e30f);
        assert_true(far > 0 && far < 1e-17f);
    }
}

/* |E| = R F(R) phi. */
static void flux_never_exceeds_fluence(void** state) {
    (void)state;
    for (int limiter = TY_LIMITER_SUM; limiter < TY_LIMITER_COUNT; ++limiter)
        for (float r = 1e-4f; r < 1e8f; r *= 1.01f)
            if (r * ty_limiter_value(limiter, 5, r) > 1 + 1e-6f) fail_msg("limiter %d at %g", limiter, (double)r);
}

static void limiters_fall(void** state) {
    (void)state;
    for (int limiter = TY_LIMITER_SUM; limiter < TY_LIMITER_COUNT; ++limiter) {
        float last = 1;
        for (float r = 1e-2f; r < 1e6f; r *= 1.01f) {
            const float value = ty_limiter_value(limiter, 2, r);
            assert_true(value <= last * (1 + 1e-6f));
            last = value;
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(limiters_are_as_defined),
        cmocka_unit_test(limits_are_right),
        cmocka_unit_test(flux_never_exceeds_fluence),
        cmocka_unit_test(limiters_fall),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
