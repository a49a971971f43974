/* Media on cells and lights as beams and lamps: what is sampled, what is kept when cells change, what is refused. */
#include "direct_maker.h"

static double total(const ty_grid_medium* medium, const float* plane) {
    double sum = 0;
    for (size_t i = 0; i < medium->cells; ++i) sum += (double)plane[i];
    return sum * medium->cell[0] * medium->cell[1] * medium->cell[2];
}

static ty_grid_medium* sample(const ty_scene* scene, int32_t longest) {
    ty_grid_box box;
    ty_grid_medium* medium = NULL;
    check_result(ty_scene_context(scene), ty_grid_box_fit(scene, longest, &box));
    check_result(ty_scene_context(scene), ty_grid_medium_create(scene, &box, &medium));
    return medium;
}

static ty_scene* voxel_scene(ty_context* context, ty_grid** grid) {
    const double lower[3] = {0, 0, 0}, upper[3] = {4, 2, 3};
    ty_scene* scene = make_scene(context);
    ty_medium_def medium = box_medium(lower, upper, 2, 1);
    *grid = direct_noise(context, 8, 4, 6, 3);
    medium.density_grid = *grid;
    set3f(medium.g, 0.5f, 0.5f, 0.5f);
    check_result(context, ty_scene_add_medium(scene, &medium));
    check_result(context, ty_scene_commit(scene));
    return scene;
}

/* Cells that are voxels hold the trilinear function's mean: 27 voxels by 1/8, 3/4, 1/8 along each axis. */
static void voxels_are_met_exactly(void** state) {
    ty_grid* grid;
    ty_scene* scene = voxel_scene(*state, &grid);
    ty_grid_medium* medium = sample(scene, 100);
    assert_int_equal(medium->box.size[0], 8);
    assert_int_equal(medium->box.size[1], 4);
    assert_int_equal(medium->box.size[2], 6);
    assert_int_equal(medium->planes, 1);
    assert_ptr_equal(medium->extinction[0], medium->extinction[2]);
    for (int k = 0; k < 6; ++k)
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 8; ++i) {
                double mean = 0;
                for (int n = 0; n < 27; ++n) {
                    const int at[3] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
                    const double index[3] = {i + at[0], j + at[1], k + at[2]};
                    double weight = 1;
                    for (int a = 0; a < 3; ++a) weight *= at[a] == 0 ? 0.75 : 0.125;
                    mean += weight * (double)ty_grid_sample(grid, index);
                }
                const size_t cell = (size_t)(i + 8 * (j + 4 * k));
                assert_close(medium->extinction[1][cell], 3 * mean, 2e-5);
                assert_close(medium->scattering[1][cell], 2 * mean, 2e-5);
                assert_close(medium->g[1][cell], mean > 0 ? 0.5 : 0, 1e-6);
            }
    ty_grid_medium_destroy(medium);
    ty_scene_destroy(scene);
    ty_grid_release(grid);
}

/* Coarser cells, of whatever size, hold as much matter. */
static void nothing_is_lost_in_other_cells(void** state) {
    static const int32_t sizes[][3] = {{4, 2, 3}, {3, 1, 5}, {7, 4, 1}, {16, 9, 6}};
    ty_grid* grid;
    ty_scene* scene = voxel_scene(*state, &grid);
    ty_grid_medium* medium = sample(scene, 100);
    for (int i = 0; i < 4; ++i) {
        ty_grid_medium* other = NULL;
        check_result(*state, ty_grid_medium_resize(medium, sizes[i], &other));
        assert_close(total(other, other->extinction[0]) / total(medium, medium->extinction[0]), 1, 1e-6);
        assert_close(total(other, other->scattering[0]) / total(medium, medium->scattering[0]), 1, 1e-6);
        for (size_t cell = 0; cell < other->cells; ++cell)
            if (other->scattering[0][cell] > 0) assert_close(other->g[0][cell], 0.5, 1e-6);
        ty_grid_medium_destroy(other);
    }
    ty_grid_medium_destroy(medium);
    ty_scene_destroy(scene);
    ty_grid_release(grid);
}

/* A ball of fog, a thinner box around it, of other colour and g, which glows: volumes, g by scattering, emission. */
static void media_add_up(void** state) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(*state);
    ty_medium_def box = box_medium(lower, upper, 1, 0.5f), ball = ty_default_medium_def();
    ball.bounds = TY_BOUNDS_SPHERE;
    ball.sphere_radius = 0.5;
    set3f(ball.sigma_s, 3, 0, 6);
    set3f(ball.g, 0.8f, 0.8f, 0.8f);
    set3f(box.emission, 0.25f, 0.5f, 1);
    check_result(*state, ty_scene_add_medium(scene, &box));
    check_result(*state, ty_scene_add_medium(scene, &ball));
    check_result(*state, ty_scene_commit(scene));
    ty_grid_medium* medium = sample(scene, 32);
    const double volume = 4.18879020478639 / 8;
    assert_int_equal(medium->planes, 3);
    assert_close(total(medium, medium->extinction[0]), 12 + 3 * volume, 0.01);
    assert_close(total(medium, medium->scattering[2]), 8 + 6 * volume, 0.02);
    assert_close(total(medium, medium->extinction[1]), 12, 1e-4);
    assert_close(total(medium, medium->emission[2]), 8 * 0.5 * 12.566370614359172, 1e-3);
    assert_close(total(medium, medium->emission[0]), 8 * 0.125 * 12.566370614359172, 1e-3);
    const size_t middle = 16 + 32 * (16 + 32 * 16);
    assert_close(medium->g[0][middle], 0.8 * 3 / 4, 1e-6);
    assert_close(medium->g[1][middle], 0, 1e-6);
    assert_close(medium->g[2][middle], 0.8 * 6 / 7, 1e-6);
    ty_grid_medium_destroy(medium);
    ty_scene_destroy(scene);
}

/* A grid of 8 x 4 x 6 voxels that is low + slope x in their middles, over 4 m along x. */
static ty_grid* ramp_grid(ty_context* context, double low, double slope) {
    float values[8 * 4 * 6];
    for (int i = 0; i < 8 * 4 * 6; ++i) values[i] = (float)(low + slope * 0.5 * (i % 8 + 0.5));
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = 8;
    def.size[1] = 4;
    def.size[2] = 6;
    def.values = values;
    ty_grid* grid = NULL;
    check_result(context, ty_grid_create(context, &def, &grid));
    return grid;
}

/* Albedo, g and temperature that vary along x: means of what scatters and glows, g by what scatters. */
static void fields_are_sampled(void** state) {
    const double lower[3] = {0, 0, 0}, upper[3] = {4, 2, 3};
    ty_grid *albedo = ramp_grid(*state, 0.2, 0.1), *g = ramp_grid(*state, -0.3, 0.2);
    ty_grid* temperature = ramp_grid(*state, 0.5, 0);
    ty_scene* scene = make_scene(*state);
    ty_medium_def medium = box_medium(lower, upper, 2, 1);
    for (int c = 0; c < 3; ++c) medium.albedo_grid[c] = albedo;
    medium.g_grid = g;
    medium.temperature_grid = temperature;
    medium.kelvin[0] = 1000;
    medium.kelvin[1] = 3000;
    check_result(*state, ty_scene_add_medium(scene, &medium));
    check_result(*state, ty_scene_commit(scene));
    ty_grid_medium* sampled = sample(scene, 100);
    float glow[3];
    ty_blackbody(2000, glow);
    assert_int_equal(sampled->box.size[0], 8);
    assert_int_equal(sampled->planes, 1);
    for (size_t cell = 0; cell < sampled->cells; ++cell) {
        const double x = 0.5 * ((double)(cell % 8) + 0.5), a = 0.2 + 0.1 * x, mean_g = -0.3 + 0.2 * x;
        assert_close(sampled->extinction[0][cell], 3, 1e-5);
        if (cell % 8 == 0 || cell % 8 == 7) continue; /* beyond voxels' middles the ramps end */
        assert_close(sampled->scattering[0][cell], 3 * a, 1e-5);
        assert_close(sampled->g[0][cell], mean_g + 0.1 * 0.2 * 0.25 / 12 / a, 4e-4);
        for (int c = 0; c < 3; ++c)
            assert_close(sampled->emission[c][cell], 12.566370614359172 * 3 * (1 - a) * (double)glow[c],
                         1e-4 * (double)glow[0]);
    }
    ty_grid_medium_destroy(sampled);
    ty_scene_destroy(scene);
    ty_grid_release(albedo);
    ty_grid_release(g);
    ty_grid_release(temperature);
}

/* A box whose bounds hold all cells needs no coverage; what it holds is the same where they do not. */
static void bounds_cut_cells(void** state) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_grid_medium* media[2];
    ty_grid* grid = direct_noise(*state, 8, 8, 8, 5);
    for (int i = 0; i < 2; ++i) {
        ty_scene* scene = make_scene(*state);
        ty_medium_def medium = box_medium(lower, upper, 2, 1);
        medium.density_grid = grid;
        check_result(*state, ty_scene_add_medium(scene, &medium));
        check_result(*state, ty_scene_commit(scene));
        const double half = i == 0 ? 1 : 1.25;
        const ty_grid_box box = {
            .lower = {-half, -half, -half}, .upper = {half, half, half}, .size = {16 + 4 * i, 16 + 4 * i, 16 + 4 * i}};
        check_result(*state, ty_grid_medium_create(scene, &box, &media[i]));
        ty_scene_destroy(scene);
    }
    for (size_t cell = 0; cell < media[1]->cells; ++cell) {
        const size_t at[3] = {cell % 20 - 2, cell / 20 % 20 - 2, cell / 400 - 2};
        const bool inside = at[0] < 16 && at[1] < 16 && at[2] < 16;
        const double expected = inside ? (double)media[0]->extinction[0][at[0] + 16 * (at[1] + 16 * at[2])] : 0;
        assert_close(media[1]->extinction[0][cell], expected, 2e-5);
    }
    for (int i = 0; i < 2; ++i) ty_grid_medium_destroy(media[i]);
    ty_grid_release(grid);
}

/* A grid turned over is sampled point by point, and its cells are those of the other, turned over. */
static void turned_grids_are_the_same(void** state) {
    const double lower[3] = {-2, -2, -2}, upper[3] = {2, 2, 2}, none[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    const double turn[3] = {0, 0, 90};
    ty_grid_medium* media[2];
    ty_grid* grid = direct_noise(*state, 8, 8, 8, 5);
    for (int i = 0; i < 2; ++i) {
        ty_scene* scene = make_scene(*state);
        ty_medium_def medium = box_medium(lower, upper, 2, 1);
        medium.density_grid = grid;
        if (i == 1) medium.transform = ty_affine_compose(none, turn, one);
        check_result(*state, ty_scene_add_medium(scene, &medium));
        check_result(*state, ty_scene_commit(scene));
        const ty_grid_box box = {.lower = {-2, -2, -2}, .upper = {2, 2, 2}, .size = {4, 4, 3}};
        check_result(*state, ty_grid_medium_create(scene, &box, &media[i]));
        ty_scene_destroy(scene);
    }
    for (int k = 0; k < 3; ++k)
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 4; ++i) /* x to y, y to -x */
                assert_close(media[0]->extinction[0][i + 4 * (j + 4 * k)],
                             media[1]->extinction[0][3 - j + 4 * (i + 4 * k)], 2e-4);
    for (int i = 0; i < 2; ++i) ty_grid_medium_destroy(media[i]);
    ty_grid_release(grid);
}

static void reduced_extinction(void** state) {
    ty_grid* grid;
    ty_scene* scene = voxel_scene(*state, &grid);
    ty_grid_medium* medium = sample(scene, 100);
    float* planes[3] = {calloc(medium->cells, sizeof(float)), NULL, NULL};
    for (int order = 1; order < 4; ++order) {
        ty_grid_medium_reduce(medium, order, planes);
        for (size_t i = 0; i < medium->cells; ++i)
            assert_close(planes[0][i], (double)medium->extinction[0][i] * (1 - pow(0.5, order) * 2 / 3), 1e-5);
    }
    free(planes[0]);
    ty_grid_medium_destroy(medium);
    ty_scene_destroy(scene);
    ty_grid_release(grid);
}

/* Beams of an environment carry 4 pi radiance, points of surfaces pi radiance area, and those of a spot with a radius
 * its intensity, from a disc that it does not hide. */
static void sources_carry_all_the_light(void** state) {
    ty_scene* scene = make_scene(*state);
    ty_light_def sky = ty_default_light_def(), area = sky;
    sky.kind = TY_LIGHT_ENVIRONMENT;
    set3f(sky.color, 0.5f, 1, 2);
    area.kind = TY_LIGHT_AREA;
    set3(area.u, 2, 0, 0);
    set3(area.v, 0, 3, 0);
    ty_shape_def ball = ty_default_shape_def();
    ball.kind = TY_SHAPE_SPHERE;
    ball.radius = 0.5;
    set3(ball.origin, 5, 0, 0);
    set3f(ball.emission, 1, 1, 1);
    check_result(*state, ty_scene_add_light(scene, &sky));
    ty_light_def spot = sky;
    spot.kind = TY_LIGHT_SPOT;
    spot.radius = 0.2;
    set3(spot.position, 0, 5, 0);
    check_result(*state, ty_scene_add_light(scene, &area));
    check_result(*state, ty_scene_add_light(scene, &spot));
    check_result(*state, ty_scene_add_shape(scene, &ball));
    check_result(*state, ty_scene_commit(scene));
    ty_discretize_def def = ty_default_discretize_def();
    ty_discrete_light_set sources;
    int32_t kinds[2] = {0, 0};
    check_result(*state, ty_discretize_lights(scene, &def, &sources));
    double sums[2] = {0, 0};
    for (int32_t i = 0; i < sources.count; ++i) {
        sums[sources.items[i].kind] += (double)sources.items[i].color[2];
        ++kinds[sources.items[i].kind];
        if (sources.items[i].profile == TY_PROFILE_SPOT)
            assert_true(sources.items[i].position.y < 4.8f && fabsf(sources.items[i].position.x) <= 0.2f);
        assert_close(ty_dot(sources.items[i].direction, sources.items[i].direction), 1, 1e-5);
    }
    assert_int_equal(kinds[TY_DISCRETE_DIRECTIONAL], def.environment);
    assert_int_equal(kinds[TY_DISCRETE_POINT], 3 * def.surface);
    assert_close(sums[TY_DISCRETE_DIRECTIONAL], 2 * 12.566370614359172, 1e-3);
    assert_close(sums[TY_DISCRETE_POINT], 6 + 3.14159265358979 + 2, 1e-3);
    ty_discrete_light_set_destroy(*state, &sources);
    ty_scene_destroy(scene);
}

static void wrong_arguments_are_refused(void** state) {
    const double lower[3] = {0, 0, 0}, upper[3] = {1, 1, 1};
    ty_grid_box box = {.upper = {1, 1, 1}, .size = {4, 4, 4}};
    ty_grid_medium* medium = NULL;
    ty_discretize_def def = ty_default_discretize_def();
    ty_discrete_light_set sources;
    ty_scene* scene = make_scene(*state);
    assert_int_equal(ty_grid_box_fit(scene, 8, &box), TY_ERROR_ARGUMENT);
    assert_error(*state, "not committed");
    check_result(*state, ty_scene_commit(scene));
    assert_int_equal(ty_grid_box_fit(scene, 8, &box), TY_ERROR_ARGUMENT);
    assert_error(*state, "media: there are none");
    const ty_medium_def fog = box_medium(lower, upper, 1, 0);
    check_result(*state, ty_scene_add_medium(scene, &fog));
    check_result(*state, ty_scene_commit(scene));
    assert_int_equal(ty_grid_box_fit(scene, 0, &box), TY_ERROR_ARGUMENT);
    assert_error(*state, "cells: longest");
    box.size[1] = 0;
    assert_int_equal(ty_grid_medium_create(scene, &box, &medium), TY_ERROR_ARGUMENT);
    assert_error(*state, "cells: 0 from 0 to 1 along y");
    box.size[1] = 4;
    box.upper[2] = NAN;
    assert_int_equal(ty_grid_medium_create(scene, &box, &medium), TY_ERROR_ARGUMENT);
    assert_error(*state, "cells: upper[2]");
    def.environment = 0;
    assert_int_equal(ty_discretize_lights(scene, &def, &sources), TY_ERROR_ARGUMENT);
    assert_error(*state, "sources: environment");
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(voxels_are_met_exactly),
        cmocka_unit_test(nothing_is_lost_in_other_cells),
        cmocka_unit_test(media_add_up),
        cmocka_unit_test(fields_are_sampled),
        cmocka_unit_test(bounds_cut_cells),
        cmocka_unit_test(turned_grids_are_the_same),
        cmocka_unit_test(reduced_extinction),
        cmocka_unit_test(sources_carry_all_the_light),
        cmocka_unit_test(wrong_arguments_are_refused),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
