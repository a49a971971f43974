/* Flux-limited and classical diffusion about a point source, against what is known of both (Koerner et al. 2014,
 * Section 6.1). */
#include "checks.h"
#include "effort.h"

#include "figures/fld_point_solve.h"
#include "figures/point_transport.h"

#include <math.h>
#include <stdio.h>

enum { ALBEDOS = 7, CELLS = 127 };

static const double albedos[ALBEDOS] = {0, 0.2, 0.4, 0.6, 0.8, 0.9, 1};

static void solve(ty_context* context, double albedo, ty_limiter limiter, bool diffusive_faces, point_profile* out) {
    const point_case which = {CELLS, albedo, limiter, diffusive_faces};
    if (point_solve(context, &which, NULL, NULL, out) != TY_OK) fail_msg("%s", ty_take_error(context));
    if (!out->stats.converged) fail_msg("albedo %g: residual %g", albedo, out->stats.residual);
}

/* From the fourth cell on, where the source no longer has a shape, to the cube's corners. */
static void classical_diffusion_is_its_greens_function(void** state) {
    static point_profile profile;
    for (int i = 0; i < ALBEDOS; i += in_full() ? 1 : 3) {
        solve(*state, albedos[i], TY_LIMITER_NONE, true, &profile);
        const point_difference off =
            point_compare(&profile, transport_diffusion, albedos[i], 3.9 * POINT_EXTENT / CELLS, POINT_EXTENT);
        printf("albedo %g: CDA is within %.4f of Eq. 27, %.5f on average\n", albedos[i], off.largest, off.mean);
        assert_true(off.largest < 0.03);
        assert_true(off.mean < 0.003);
    }
}

/* Near the source light streams: its fluence falls with the square of distance. Classical diffusion's does not. */
static void limited_diffusion_is_nearer_to_transport(void** state) {
    static point_profile limited, classical;
    for (int i = 0; i < ALBEDOS; i += in_full() ? 1 : 6) {
        solve(*state, albedos[i], TY_LIMITER_LEVERMORE_POMRANING, false, &limited);
        solve(*state, albedos[i], TY_LIMITER_NONE, false, &classical);
        const double fld = point_compare(&limited, transport_fluence, albedos[i], 0.1, 1).mean;
        const double cda = point_compare(&classical, transport_fluence, albedos[i], 0.1, 1).mean;
        const double slope = point_slope(&limited, 0.1, 0.3);
        printf("albedo %g: off by %.3f (FLD), %.3f (CDA); slopes %.2f, %.2f\n", albedos[i], fld, cda, slope,
               point_slope(&classical, 0.1, 0.3));
        assert_true(fabs(slope + 2) < 0.2);
        assert_true(point_slope(&classical, 0.1, 0.3) > -1.4);
        assert_true(fld < 0.7 * cda);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(classical_diffusion_is_its_greens_function),
        cmocka_unit_test(limited_diffusion_is_nearer_to_transport),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
