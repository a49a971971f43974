/* Identities that flux-limited diffusion's light must meet: fluence, flux, energy, channels, lights, solvers. */
#include "fld_maker.h"

#include <stdio.h>

/* ---- scenes ---- */

static ty_scene* lit(ty_context* context, const ty_medium_def* medium, const ty_light_def* lights, int count) {
    ty_scene* scene = make_scene(context);
    add_medium(scene, medium);
    for (int i = 0; i < count; ++i) add_light(scene, &lights[i]);
    commit(scene);
    return scene;
}

/* Every kind of light, inside the fog and outside; area lights and spots, too. */
enum { LIGHT_KINDS = 6 };

static ty_light_def light_of_kind(int kind) {
    ty_light_def light = ty_default_light_def();
    switch (kind) {
    case 0: return sun_light(1, 2, 3);
    case 1: return point_light(0.1, 0.2, 0.05, 3, 2, 1);
    case 2: return point_light(2, 0, 1, 5, 5, 5);
    case 3:
        light.kind = TY_LIGHT_SPOT;
        set3(light.position, 0, 2, 0);
        light.cone = 50;
        return light;
    case 4:
        light.kind = TY_LIGHT_AREA;
        set3(light.position, -0.5, 0.8, -0.5);
        set3(light.u, 1, 0, 0);
        set3(light.v, 0, 0, 1);
        return light;
    default:
        light.kind = TY_LIGHT_ENVIRONMENT;
        set3f(light.color, 0.2f, 0.3f, 0.4f);
        return light;
    }
}

/* Voxels with holes. */
static ty_medium_def cloud_block(ty_context* context) {
    ty_medium_def medium = colored_block();
    ty_noise_def noise = ty_default_noise_def();
    noise.kind = TY_NOISE_CLOUD;
    noise.size[0] = 24;
    noise.size[1] = 18;
    noise.size[2] = 12;
    noise.frequency = 3;
    check_result(context, ty_grid_create_noise(context, &noise, &medium.density_grid));
    return medium;
}

static double length_of(const double v[3]) {
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* ---- fluence and flux ---- */

static void assert_sound(const cell_light* light, const char* what) {
    for (int i = 0; i < 3 * CELLS; ++i) {
        if (!(isfinite(light->fluence[i]) && light->beam[i] >= 0 && light->fluence[i] >= light->beam[i]))
            fail_msg("%s: fluence %g with beam %g", what, light->fluence[i], light->beam[i]);
        if (!(length_of(&light->flux[3 * i]) <= light->fluence[i] * (1 + 1e-5) + 1e-30))
            fail_msg("%s: flux %g of fluence %g", what, length_of(&light->flux[3 * i]), light->fluence[i]);
    }
}

static void flux_never_exceeds_fluence(void** state) {
    static cell_light light;
    for (int kind = 0; kind < LIGHT_KINDS; ++kind)
        for (int cloudy = 0; cloudy < 2; ++cloudy)
            for (int limiter = 0; limiter < 6; ++limiter) {
                ty_medium_def medium = cloudy ? cloud_block(*state) : colored_block();
                const ty_light_def source = light_of_kind(kind);
                ty_scene* scene = lit(*state, &medium, &source, 1);
                ty_fld_def def = small_fld();
                char what[64];
                snprintf(what, sizeof what, "light %d, limiter %d", kind, limiter);
                def.limiter = (ty_fld_limiter)limiter;
                def.max_flux_fraction = 1;
                solve_cells(scene, &def, &light, NULL);
                assert_sound(&light, what);
                ty_grid_release(medium.density_grid);
                ty_scene_destroy(scene);
            }
}

static void outside_there_is_nothing(void** state) {
    static const double far[2][3] = {{5, 5, 5}, {6, 6, 6}};
    static const int32_t size[3] = {2, 2, 2};
    const ty_medium_def medium = colored_block();
    const ty_light_def sun = sun_light(1, 1, 1);
    ty_scene* scene = lit(*state, &medium, &sun, 1);
    const ty_fld_def def = small_fld();
    ty_fld* light = solve(scene, &def, NULL);
    double fluence[24], beam[24], flux[72];
    for (int i = 0; i < 24; ++i) fluence[i] = beam[i] = flux[i] = flux[24 + i] = flux[48 + i] = -1;
    check_result(*state, ty_fld_fluence(light, far[0], far[1], size, fluence, beam, flux));
    for (int i = 0; i < 24; ++i) assert_true(fluence[i] == 0 && beam[i] == 0);
    for (int i = 0; i < 72; ++i) assert_true(flux[i] == 0);
    ty_fld_destroy(light);
    ty_scene_destroy(scene);
}

/* The mean over 2 x 3 x 4 parts of a box is that of the box, which reaches beyond the fog. */
static void finer_cuts_keep_the_mean(void** state) {
    static const double lower[3] = {-0.9, -0.83, -0.6}, upper[3] = {0.77, 0.3, 0.21};
    static const int32_t one[3] = {1, 1, 1}, many[3] = {2, 3, 4};
    const ty_medium_def medium = colored_block();
    const ty_light_def lights[2] = {sun_light(1, 2, 3), light_of_kind(5)};
    ty_scene* scene = lit(*state, &medium, lights, 2);
    const ty_fld_def def = small_fld();
    ty_fld* light = solve(scene, &def, NULL);
    double whole[3], whole_beam[3], whole_flux[9], parts[72], beams[72], flux[216];
    check_result(*state, ty_fld_fluence(light, lower, upper, one, whole, whole_beam, whole_flux));
    check_result(*state, ty_fld_fluence(light, lower, upper, many, parts, beams, flux));
    for (int c = 0; c < 3; ++c) {
        double sum = 0, beam = 0, vector[3] = {0, 0, 0};
        for (int i = 0; i < 24; ++i) {
            sum += parts[3 * i + c] / 24;
            beam += beams[3 * i + c] / 24;
            for (int a = 0; a < 3; ++a) vector[a] += flux[9 * i + 3 * c + a] / 24;
        }
        assert_true(sum > 0 && beam > 0);
        assert_close(whole[c], sum, 1e-12 * sum);
        assert_close(whole_beam[c], beam, 1e-12 * beam);
        for (int a = 0; a < 3; ++a) assert_close(whole_flux[3 * c + a], vector[a], 1e-12 * sum);
    }
    ty_fld_destroy(light);
    ty_scene_destroy(scene);
}

/* Points, lines and planes are what thin boxes come to; all faces of the fog's box are part of it. */
static void boxes_without_extent(void** state) {
    static const double corners[7][2][3] = {
        {{0.03, 0.1, -0.2}, {0.03, 0.1, -0.2}}, {{-1, 0.1, -0.2}, {1, 0.1, -0.2}},
        {{-1, -0.75, -0.2}, {1, 0.75, -0.2}},   {{-1, -0.75, -0.5}, {1, -0.75, 0.5}},
        {{-1, 0.75, -0.5}, {1, 0.75, 0.5}},     {{1, 0.75, 0.5}, {1, 0.75, 0.5}},
        {{-1, -0.75, -0.5}, {-1, -0.75, -0.5}},
    };
    static const int32_t size[3] = {1, 1, 1};
    const ty_medium_def medium = colored_block();
    const ty_light_def sun = sun_light(1, 2, 3);
    ty_scene* scene = lit(*state, &medium, &sun, 1);
    const ty_fld_def def = small_fld();
    ty_fld* light = solve(scene, &def, NULL);
    for (int i = 0; i < 7; ++i) {
        double thin[3], thick[3], lower[3], upper[3];
        for (int a = 0; a < 3; ++a) {
            lower[a] = corners[i][0][a];
            upper[a] = corners[i][1][a];
            if (upper[a] > lower[a]) continue;
            lower[a] = fmax(lower[a] - 1e-6, -1 + 0.25 * a);
            upper[a] = fmin(upper[a] + 1e-6, 1 - 0.25 * a);
        }
        check_result(*state, ty_fld_fluence(light, corners[i][0], corners[i][1], size, thin, NULL, NULL));
        check_result(*state, ty_fld_fluence(light, lower, upper, size, thick, NULL, NULL));
        for (int c = 0; c < 3; ++c) {
            if (!(thin[c] > 0)) fail_msg("box %d: %g", i, thin[c]);
            assert_close(thin[c], thick[c], 1e-5 * thick[c]);
        }
    }
    ty_fld_destroy(light);
    ty_scene_destroy(scene);
}

/* ---- energy ---- */

static void energy_is_kept(void** state) {
    for (int kind = 0; kind < LIGHT_KINDS; ++kind)
        for (int form = 0; form < 8; ++form) {
            ty_medium_def medium = form & 1 ? cloud_block(*state) : colored_block();
            if (form & 2) set3f(medium.sigma_a, 0, 0, 0);
            if (form & 4) set3f(medium.emission, 0.3f, 0.2f, 0.1f);
            const ty_light_def source = light_of_kind(kind);
            ty_scene* scene = lit(*state, &medium, &source, 1);
            const ty_fld_def def = small_fld();
            ty_fld_stats stats = ty_default_fld_stats();
            ty_fld_destroy(solve(scene, &def, &stats));
            assert_true(stats.converged);
            for (int c = 0; c < 3; ++c) {
                assert_true(stats.emitted[c] > 0 && stats.leaving[c] > 0);
                assert_true((stats.absorbed[c] > 0) == ((form & 2) == 0));
                const double off = (stats.absorbed[c] + stats.leaving[c]) / stats.emitted[c] - 1;
                if (!(fabs(off) <= 1e-3))
                    fail_msg("light %d, form %d, channel %d: energy is off by %g", kind, form, c, off);
            }
            ty_grid_release(medium.density_grid);
            ty_scene_destroy(scene);
        }
}

/* Fog without lights glows by itself: 4 pi sigma_a emission a cubic metre. */
static void glowing_fog_needs_no_lights(void** state) {
    static cell_light light;
    ty_medium_def medium = colored_block();
    set3f(medium.emission, 1, 0.5f, 0);
    ty_scene* scene = lit(*state, &medium, NULL, 0);
    const ty_fld_def def = small_fld();
    ty_fld_stats stats = ty_default_fld_stats();
    solve_cells(scene, &def, &light, &stats);
    assert_sound(&light, "emission");
    assert_close(stats.emitted[0], 12.566370614 * 0.1 * 3, 1e-4);
    assert_close(stats.emitted[1], 12.566370614 * 0.5 * 0.5 * 3, 1e-4);
    assert_true(stats.emitted[2] == 0 && stats.leaving[2] == 0 && stats.absorbed[2] == 0);
    assert_true(stats.converged && light.fluence[3 * (CELLS / 2)] > 0);
    for (int i = 0; i < CELLS; ++i) assert_true(light.fluence[3 * i + 2] == 0 && light.beam[3 * i] == 0);
    ty_image* image = NULL;
    check_result(*state, ty_fld_render(scene, &def, &image, NULL));
    assert_true(total(image, 0) > 0 && total(image, 2) == 0);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* Neither lights nor emission: nothing, without a warning's worth of trouble. */
static void dark_fog_is_dark(void** state) {
    static cell_light light;
    const ty_medium_def medium = colored_block();
    ty_scene* scene = lit(*state, &medium, NULL, 0);
    for (int solver = 0; solver < 3; ++solver) {
        ty_fld_def def = small_fld();
        ty_fld_stats stats = ty_default_fld_stats();
        def.solver = (ty_fld_solver)solver;
        solve_cells(scene, &def, &light, &stats);
        assert_true(stats.converged);
        for (int i = 0; i < 3 * CELLS; ++i) assert_true(light.fluence[i] == 0);
    }
    ty_scene_destroy(scene);
}

/* ---- channels and lights ---- */

/* Coefficients that differ between channels give what three gray media would, each in its channel. */
static void channels_do_not_mix(void** state) {
    static cell_light all, one;
    const ty_light_def sun = sun_light(1, 2, 3);
    const ty_medium_def medium = colored_block();
    ty_scene* scene = lit(*state, &medium, &sun, 1);
    const ty_fld_def def = small_fld();
    ty_fld_stats stats = ty_default_fld_stats();
    solve_cells(scene, &def, &all, &stats);
    assert_int_equal(stats.planes, 3);
    ty_scene_destroy(scene);
    for (int c = 0; c < 3; ++c) {
        ty_medium_def gray = medium;
        for (int d = 0; d < 3; ++d) {
            gray.sigma_s[d] = medium.sigma_s[c];
            gray.sigma_a[d] = medium.sigma_a[c];
            gray.g[d] = medium.g[c];
        }
        scene = lit(*state, &gray, &sun, 1);
        solve_cells(scene, &def, &one, &stats);
        assert_int_equal(stats.planes, 1);
        ty_scene_destroy(scene);
        for (int i = c; i < 3 * CELLS; i += 3) {
            assert_close(all.fluence[i], one.fluence[i], 1e-4 * one.fluence[i]);
            assert_close(all.beam[i], one.beam[i], 1e-5 * one.beam[i]);
        }
    }
}

/* In gray fog one solve does for light of any color, also with black channels. */
static void colors_of_light_scale(void** state) {
    static const float colors[3][3] = {{1, 2, 3}, {0, 1, 0.5f}, {0.25f, 0, 0}};
    static cell_light light;
    ty_medium_def gray = colored_block();
    set3f(gray.sigma_s, 4, 4, 4);
    set3f(gray.sigma_a, 0.2f, 0.2f, 0.2f);
    set3f(gray.g, 0.5f, 0.5f, 0.5f);
    for (int k = 0; k < 3; ++k) {
        const ty_light_def lights[2] = {sun_light(colors[k][0], colors[k][1], colors[k][2]),
                                        point_light(0, 0, 2, 2 * colors[k][0], 2 * colors[k][1], 2 * colors[k][2])};
        ty_scene* scene = lit(*state, &gray, lights, 2);
        const ty_fld_def def = small_fld();
        ty_fld_stats stats = ty_default_fld_stats();
        solve_cells(scene, &def, &light, &stats);
        int solves = 0;
        const int bright = k == 0 ? 2 : k == 1 ? 1 : 0;
        for (int c = 0; c < 3; ++c) solves += stats.iterations[c] > 0;
        assert_true(solves <= 2 && stats.converged);
        for (int i = 0; i < 3 * CELLS; i += 3)
            for (int c = 0; c < 3; ++c) {
                const double expected = light.fluence[i + bright] * (double)(colors[k][c] / colors[k][bright]);
                assert_close(light.fluence[i + c], expected, 1e-5 * expected);
            }
        ty_scene_destroy(scene);
    }
}

/* Classical diffusion is linear: light of several lights together is the sum of what each brings.
 * (Points on area lights and beams of a sky depend on the light's place in the list.) */
static void lights_add_up(void** state) {
    static cell_light all, one, sum;
    const ty_medium_def medium = colored_block();
    enum { COUNT = 4 };
    ty_light_def lights[COUNT];
    ty_fld_def def = small_fld();
    def.limiter = TY_FLD_LIMITER_NONE;
    def.tolerance = 1e-6;
    memset(&sum, 0, sizeof sum);
    for (int k = 0; k < COUNT; ++k) {
        lights[k] = light_of_kind(k);
        ty_scene* scene = lit(*state, &medium, &lights[k], 1);
        solve_cells(scene, &def, &one, NULL);
        ty_scene_destroy(scene);
        for (int i = 0; i < 3 * CELLS; ++i) sum.fluence[i] += one.fluence[i];
        for (int i = 0; i < 3 * CELLS; ++i) sum.beam[i] += one.beam[i];
    }
    ty_scene* scene = lit(*state, &medium, lights, COUNT);
    solve_cells(scene, &def, &all, NULL);
    ty_scene_destroy(scene);
    for (int i = 0; i < 3 * CELLS; ++i) {
        assert_close(all.fluence[i], sum.fluence[i], 1e-5 * sum.fluence[i]);
        assert_close(all.beam[i], sum.beam[i], 1e-6 * sum.beam[i]);
    }
}

/* More lights than have fields of their own: the light of all is the same, in fluence. */
static void many_lights_share_fields(void** state) {
    static cell_light all, one, sum;
    enum { COUNT = 12 };
    const ty_medium_def medium = colored_block();
    ty_light_def lights[COUNT];
    ty_fld_def def = small_fld();
    def.limiter = TY_FLD_LIMITER_NONE;
    def.tolerance = 1e-6;
    memset(&sum, 0, sizeof sum);
    for (int k = 0; k < COUNT; ++k) {
        lights[k] = point_light(cos(k) * 2, sin(k) * 2, 0.1 * k, (float)(1 + k % 3), 1, 2);
        ty_scene* scene = lit(*state, &medium, &lights[k], 1);
        solve_cells(scene, &def, &one, NULL);
        ty_scene_destroy(scene);
        for (int i = 0; i < 3 * CELLS; ++i) sum.fluence[i] += one.fluence[i];
    }
    ty_scene* scene = lit(*state, &medium, lights, COUNT);
    solve_cells(scene, &def, &all, NULL);
    assert_sound(&all, "many lights");
    ty_scene_destroy(scene);
    for (int i = 0; i < 3 * CELLS; ++i) assert_close(all.fluence[i], sum.fluence[i], 1e-3 * sum.fluence[i]);
}

/* ---- options ---- */

/* Faces without fluence take more light away than vacuum does. */
static void dirichlet_is_darker(void** state) {
    static cell_light light[2];
    const ty_medium_def medium = colored_block();
    const ty_light_def sun = sun_light(1, 1, 1);
    ty_scene* scene = lit(*state, &medium, &sun, 1);
    ty_fld_def def = small_fld();
    solve_cells(scene, &def, &light[0], NULL);
    def.boundary = TY_FLD_BOUNDARY_DIRICHLET;
    solve_cells(scene, &def, &light[1], NULL);
    for (int i = 0; i < 3 * CELLS; ++i) {
        assert_true(light[1].beam[i] == light[0].beam[i]);
        if (light[0].fluence[i] > 0) assert_true(light[1].fluence[i] < light[0].fluence[i]);
    }
    ty_scene_destroy(scene);
}

/* All solvers find the same light. */
static void solvers_agree(void** state) {
    static const double tolerances[3] = {1e-6, 1e-6, 1e-4}, close[3] = {0, 1e-4, 1e-3};
    static cell_light light[3];
    ty_medium_def medium = cloud_block(*state);
    const ty_light_def lights[2] = {sun_light(1, 1, 1), light_of_kind(1)};
    for (int limiter = 0; limiter < 6; limiter += 5) {
        ty_scene* scene = lit(*state, &medium, lights, 2);
        for (int solver = 0; solver < 3; ++solver) {
            ty_fld_def def = small_fld();
            ty_fld_stats stats = ty_default_fld_stats();
            def.limiter = (ty_fld_limiter)limiter;
            def.solver = (ty_fld_solver)solver;
            def.tolerance = tolerances[solver];
            def.relaxation = 1.2; /* 1.85 is too much for so few cells with holes */
            solve_cells(scene, &def, &light[solver], &stats);
            if (!stats.converged) fail_msg("solver %d, limiter %d: residual %g", solver, limiter, stats.residual[0]);
            for (int i = 0; i < 3 * CELLS; ++i)
                if (!(fabs(light[solver].fluence[i] - light[0].fluence[i]) <= close[solver] * light[0].fluence[i]))
                    fail_msg("solver %d, limiter %d: %g, not %g", solver, limiter, light[solver].fluence[i],
                             light[0].fluence[i]);
        }
        ty_scene_destroy(scene);
    }
    ty_grid_release(medium.density_grid);
}

/* The paper's beam differs from the reduced one where media scatter forwards, and nowhere else. */
static void beams_differ_by_anisotropy(void** state) {
    static cell_light light[2];
    for (int even = 0; even < 2; ++even) {
        ty_medium_def medium = colored_block();
        if (even) set3f(medium.g, 0, 0, 0);
        const ty_light_def sun = sun_light(1, 1, 1);
        ty_scene* scene = lit(*state, &medium, &sun, 1);
        ty_image* images[2] = {NULL};
        for (int beam = 0; beam < 2; ++beam) {
            ty_fld_def def = small_fld();
            def.beam = (ty_fld_beam)beam;
            solve_cells(scene, &def, &light[beam], NULL);
            check_result(*state, ty_fld_render(scene, &def, &images[beam], NULL));
        }
        assert_true(same_images(images[0], images[1]) == (even == 1));
        assert_true((memcmp(&light[0], &light[1], sizeof light[0]) == 0) == (even == 1));
        for (int beam = 0; beam < 2; ++beam) ty_image_destroy(images[beam]);
        ty_scene_destroy(scene);
    }
}

/* Larsen's limiter of a large power is the maximum's; of power 1 it is the sum's. */
static void limiters_meet(void** state) {
    static const ty_fld_limiter others[2] = {TY_FLD_LIMITER_SUM, TY_FLD_LIMITER_MAX};
    static const double powers[2] = {1, 100}, close[2] = {1e-4, 2e-2};
    static cell_light light[2];
    const ty_medium_def medium = colored_block();
    const ty_light_def sun = sun_light(1, 1, 1);
    ty_scene* scene = lit(*state, &medium, &sun, 1);
    for (int k = 0; k < 2; ++k) {
        ty_fld_def def = small_fld();
        def.tolerance = 1e-6;
        def.limiter = others[k];
        solve_cells(scene, &def, &light[0], NULL);
        def.limiter = TY_FLD_LIMITER_LARSEN;
        def.larsen_power = powers[k];
        solve_cells(scene, &def, &light[1], NULL);
        for (int i = 0; i < 3 * CELLS; ++i)
            assert_close(light[1].fluence[i], light[0].fluence[i], close[k] * light[0].fluence[i]);
    }
    ty_scene_destroy(scene);
}

enum { FEW = 12 };

/* Relative rms error of fluence on FEW^3 cells of the box of colored_block. */
static double fluence_error(const ty_scene* scene, const ty_fld_def* def, const double* truth, double* fluence) {
    static const int32_t size[3] = {FEW, FEW, FEW};
    static const double lower[3] = {-1, -0.75, -0.5}, upper[3] = {1, 0.75, 0.5};
    double squares[2] = {0, 0};
    ty_fld* light = solve(scene, def, NULL);
    check_result(ty_scene_context(scene), ty_fld_fluence(light, lower, upper, size, fluence, NULL, NULL));
    for (int i = 0; i < 3 * FEW * FEW * FEW && truth != NULL; ++i) {
        squares[0] += pow(fluence[i] - truth[i], 2);
        squares[1] += pow(truth[i], 2);
    }
    ty_fld_destroy(light);
    return truth != NULL ? sqrt(squares[0] / squares[1]) : 0;
}

/* On a quarter of the cells and a few sweeps on a half: nearer than a third without them. */
static void coarse_diffusion_is_refined(void** state) {
    static double truth[3 * FEW * FEW * FEW], fluence[3 * FEW * FEW * FEW];
    const ty_medium_def medium = cloud_block(*state);
    const ty_light_def sun = sun_light(1, 1, 1);
    ty_scene* scene = lit(*state, &medium, &sun, 1);
    ty_fld_def def = small_fld();
    def.resolution = 24;
    def.ratio = 1;
    fluence_error(scene, &def, NULL, truth);
    def.ratio = 3;
    const double third = fluence_error(scene, &def, truth, fluence);
    def.ratio = 4;
    const double quarter = fluence_error(scene, &def, truth, fluence);
    if (!(quarter < third)) fail_msg("off by %g on a quarter, %g on a third", quarter, third);
    ty_grid_release(medium.density_grid);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flux_never_exceeds_fluence),
        cmocka_unit_test(outside_there_is_nothing),
        cmocka_unit_test(finer_cuts_keep_the_mean),
        cmocka_unit_test(boxes_without_extent),
        cmocka_unit_test(energy_is_kept),
        cmocka_unit_test(glowing_fog_needs_no_lights),
        cmocka_unit_test(dark_fog_is_dark),
        cmocka_unit_test(channels_do_not_mix),
        cmocka_unit_test(colors_of_light_scale),
        cmocka_unit_test(lights_add_up),
        cmocka_unit_test(many_lights_share_fields),
        cmocka_unit_test(dirichlet_is_darker),
        cmocka_unit_test(solvers_agree),
        cmocka_unit_test(beams_differ_by_anisotropy),
        cmocka_unit_test(limiters_meet),
        cmocka_unit_test(coarse_diffusion_is_refined),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
