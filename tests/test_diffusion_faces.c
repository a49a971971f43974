/* Diffusion between surfaces: closed forms of the solver's equations. */
#include "diffusion_maker.h"

#include <string.h>

static void fill(problem* p, float source, float absorption) {
    for (size_t i = 0; i < p->cells; ++i) {
        p->source[i] = source;
        p->absorption[i] = absorption;
    }
}

/* All that is emitted is absorbed: phi = q / sigma_a everywhere, whatever the limiter. */
static void white_walls_keep_all_light(void** state) {
    for (int limiter = 0; limiter < TY_LIMITER_COUNT; ++limiter) {
        problem p = make_problem(10, 7, 5, 2, 3);
        closed_box box = close_box(&p, 0, 4, 1, 0);
        fill(&p, 0.6f, 0.2f);
        p.def.limiter = (ty_limiter)limiter;
        p.def.faces = &box.faces;
        solve_problem(*state, &p);
        for (size_t i = 0; i < p.cells; ++i) assert_true(fabs((double)p.fluence[i] - 3) < 1e-4);
        free_box(&box);
        free_problem(&p);
    }
}

/* Walls of albedo a and radiosity M around media that neither absorb nor emit: phi = 4 M / (1 - a). */
static void glowing_walls_fill_their_room(void** state) {
    problem p = make_problem(8, 8, 8, 1, 2);
    closed_box box = close_box(&p, 0, 0, 0.4f, 1.5f);
    float* irradiance = make_floats((size_t)box.faces.count);
    p.def.faces = &box.faces;
    p.out.side_irradiance = irradiance;
    solve_problem(*state, &p);
    for (size_t i = 0; i < p.cells; ++i) assert_true(fabs((double)p.fluence[i] - 10) < 1e-3);
    for (int32_t i = 0; i < box.faces.count; ++i) assert_true(fabs((double)irradiance[i] - 2.5) < 1e-3);
    assert_true(fabs(p.stats.surfaces_emitted / p.stats.surfaces_absorbed - 1) < 1e-4);
    assert_true(fabs(p.stats.surfaces_emitted - 6 * 1.5) < 1e-4);
    free(irradiance);
    free_box(&box);
    free_problem(&p);
}

/* Between walls of albedo a, d apart, a uniform source has
 * phi = q x (d - x) / (2 D) + q d / (2 k), k = (1 - a) / (2 (1 + a)), without limiter; cells hold means. */
static void a_slab_between_walls_has_its_parabola(void** state) {
    enum { CELLS = 32 };
    const double albedo = 0.7, q = 1.3, sigma = 4, k = (1 - albedo) / (2 * (1 + albedo));
    problem p = make_problem(CELLS, 1, 1, 1, (float)sigma);
    closed_box box = close_box(&p, 0, 0, (float)albedo, 0);
    for (int32_t i = 0; i < box.faces.count; ++i)
        if (box.face[i] > 1) box.albedo[i] = 1;
    fill(&p, (float)q, 0);
    p.def.limiter = TY_LIMITER_NONE;
    p.def.faces = &box.faces;
    solve_problem(*state, &p);
    for (int i = 0; i < CELLS; ++i) {
        const double x = (i + 0.5) / CELLS, expected = q * x * (1 - x) * 1.5 * sigma + q / (2 * k);
        /* Measured: 2.8e-4, of second order in the cells. */
        assert_true(fabs((double)p.fluence[i] / expected - 1) < 1e-3);
    }
    assert_true(fabs(p.stats.surfaces_absorbed / p.stats.emitted - 1) < 1e-4);
    free_box(&box);
    free_problem(&p);
}

static void no_light_passes_a_wall(void** state) {
    problem p = make_problem(12, 6, 6, 1, 5);
    closed_box box = close_box(&p, 0, 5, 0.5f, 0);
    for (size_t i = 0; i < p.cells; ++i) p.source[i] = i % 12 < 5 ? 1 : 0;
    p.def.faces = &box.faces;
    p.def.tolerance = 1e-5;
    solve_problem(*state, &p);
    double lit = 0, dark = 0;
    for (size_t i = 0; i < p.cells; ++i) *(i % 12 < 5 ? &lit : &dark) += (double)p.fluence[i];
    assert_true(lit > 0);
    assert_true(dark < 1e-4 * lit);
    free_box(&box);
    free_problem(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(white_walls_keep_all_light), cmocka_unit_test(glowing_walls_fill_their_room),
        cmocka_unit_test(a_slab_between_walls_has_its_parabola), cmocka_unit_test(no_light_passes_a_wall)};
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
