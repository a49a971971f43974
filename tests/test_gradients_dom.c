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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gray_media_and_lights),  cmocka_unit_test(coloured_media_and_lights),
        cmocka_unit_test(narrow_phase_functions), cmocka_unit_test(thick_media),
        cmocka_unit_test(voxels_of_density),
    };
    return cmocka_run_group_tests_name("gradients of dom", tests, start_context, stop_context);
}
