/* The mean fluence in a cube by fld, pop and dom, with the energy balance of those that state one. */
#ifndef TY_TESTS_MEAN_FLUENCE_H
#define TY_TESTS_MEAN_FLUENCE_H

#include "truth.h"

enum { FLUENCE_ACROSS = 4, FLUENCE_CELLS = FLUENCE_ACROSS * FLUENCE_ACROSS * FLUENCE_ACROSS };

/* The cells of the cube [-half, half]^3, and the fluence in each. */
typedef struct fluence_cube {
    double lower[3], upper[3], fluence[3 * FLUENCE_CELLS];
    int32_t size[3];
} fluence_cube;

static inline fluence_cube fluence_cube_of(double half) {
    fluence_cube cube = {.size = {FLUENCE_ACROSS, FLUENCE_ACROSS, FLUENCE_ACROSS}};
    set3(cube.lower, -half, -half, -half);
    set3(cube.upper, half, half, half);
    return cube;
}

/* Mean of the first channel, W m^-2. */
static inline double mean_of_cube(const fluence_cube* cube) {
    double sum = 0;
    for (int i = 0; i < FLUENCE_CELLS; ++i) sum += cube->fluence[3 * i] / FLUENCE_CELLS;
    return sum;
}

/* The power that media and surfaces absorb and that leaves is the power emitted, within 3e-3. */
static inline void assert_balance(const double absorbed[3], const double absorbed_by_surfaces[3],
                                  const double leaving[3], const double emitted[3]) {
    const double out = absorbed[0] + absorbed_by_surfaces[0] + leaving[0];
    if (!(fabs(out - emitted[0]) <= 3e-3 * emitted[0])) fail_msg("%g of %g", out, emitted[0]);
}

static inline double fld_mean_fluence(const ty_scene* scene, const ty_fld_def* def, double half) {
    ty_context* context = ty_scene_context(scene);
    fluence_cube cube = fluence_cube_of(half);
    ty_fld_stats stats = ty_default_fld_stats();
    ty_fld* light = NULL;
    must(context, ty_fld_solve(scene, def, &light, &stats));
    assert_true(stats.converged);
    assert_balance(stats.absorbed, stats.absorbed_by_surfaces, stats.leaving, stats.emitted);
    must(context, ty_fld_fluence(light, cube.lower, cube.upper, cube.size, cube.fluence, NULL, NULL));
    ty_fld_destroy(light);
    return mean_of_cube(&cube);
}

static inline double pop_mean_fluence(const ty_scene* scene, const ty_pop_def* def, double half) {
    ty_context* context = ty_scene_context(scene);
    fluence_cube cube = fluence_cube_of(half);
    ty_pop* light = NULL;
    must(context, ty_pop_solve(scene, def, &light, NULL));
    must(context, ty_pop_fluence(light, cube.lower, cube.upper, cube.size, cube.fluence, NULL));
    ty_pop_destroy(light);
    return mean_of_cube(&cube);
}

static inline double dom_mean_fluence(const ty_scene* scene, const ty_dom_def* def, double half) {
    ty_context* context = ty_scene_context(scene);
    fluence_cube cube = fluence_cube_of(half);
    ty_dom_stats stats = ty_default_dom_stats();
    ty_dom* light = NULL;
    must(context, ty_dom_solve(scene, def, &light, &stats));
    assert_balance(stats.absorbed, stats.absorbed_by_surfaces, stats.leaving, stats.emitted);
    must(context, ty_dom_fluence(light, cube.lower, cube.upper, cube.size, cube.fluence, NULL));
    ty_dom_destroy(light);
    return mean_of_cube(&cube);
}

#endif
