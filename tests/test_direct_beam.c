/* Parallel light on a grid: closed forms, energy, shadows, threads. */
#include "direct_maker.h"

#include <stdio.h>

static const double ways[][3] = {{0, 0, 1},       {0, 0, -1}, {1, 0, 0},   {0, -1, 0},   {1, 2, 3},      {-3, 1, 0.5},
                                 {0.2, -1, -0.7}, {1, 1, 1},  {-1, -1, 1}, {1, 1e-9, 1}, {0.6, -0.8, 0}, {-2, -3, -4}};
enum { WAYS = sizeof ways / sizeof *ways };

static ty_scene* box_scene(ty_context* context, float sigma_s, float sigma_a) {
    const double lower[3] = {-1, 0.5, -2}, upper[3] = {1, 2.5, 1};
    ty_scene* scene = make_scene(context);
    const ty_medium_def medium = box_medium(lower, upper, sigma_s, sigma_a);
    check_result(context, ty_scene_add_medium(scene, &medium));
    return scene;
}

static ty_scene* cloud_scene(ty_context* context, bool gray) {
    const double lower[3] = {-1, 0.5, -2}, upper[3] = {1, 2.5, 1};
    ty_scene* scene = make_scene(context);
    ty_medium_def medium = box_medium(lower, upper, 2, 0.5f);
    if (!gray) set3f(medium.sigma_s, 1, 2, 9);
    medium.density_grid = direct_noise(context, 8, 8, 12, 7);
    check_result(context, ty_scene_add_medium(scene, &medium));
    ty_grid_release(medium.density_grid);
    return scene;
}

/* Along an axis tubes are rows of cells, and the mean over a cell is known. */
static void even_media_are_exact_along_axes(void** state) {
    for (int w = 0; w < 4; ++w) {
        ty_scene* scene = box_scene(*state, 1, 0.5f);
        direct_add_sun(scene, ways[w][0], ways[w][1], ways[w][2], 2);
        direct_case made = direct_begin(scene, 12, 1, 1);
        ty_light_field* field = direct_light(&made, true);
        const int32_t* size = made.medium->box.size;
        assert_int_equal(made.medium->planes, 1);
        for (size_t i = 0; i < made.medium->cells; ++i) {
            const int32_t cell[3] = {(int32_t)i % size[0], (int32_t)i / size[0] % size[1],
                                     (int32_t)i / size[0] / size[1]};
            int a = 0;
            while (ways[w][a] == 0) ++a;
            const int32_t slab = ways[w][a] > 0 ? cell[a] : size[a] - 1 - cell[a];
            const double depth = 1.5 * made.medium->cell[a];
            const double expected = 2 * exp(-depth * slab) * -expm1(-depth) / depth;
            assert_close(field->fluence[1][i], expected, 2e-6);
            assert_close(field->flux[1][a][i], expected * (ways[w][a] > 0 ? 1 : -1), 2e-6);
            assert_close(field->flux[1][(a + 1) % 3][i], 0, 0);
        }
        ty_light_field_destroy(field);
        direct_end(&made);
    }
}

static void nothing_dims_nothing(void** state) {
    for (int w = 0; w < WAYS; ++w) {
        ty_scene* scene = box_scene(*state, 0, 0);
        direct_add_sun(scene, ways[w][0], ways[w][1], ways[w][2], 3);
        direct_case made = direct_begin(scene, 13, 1, 1);
        ty_light_field* field = direct_light(&made, false);
        for (size_t i = 0; i < made.medium->cells; ++i) assert_close(field->fluence[0][i], 3, 2e-6);
        ty_light_field_destroy(field);
        direct_end(&made);
    }
}

static double absorbed(const ty_grid_medium* medium, const float* lit, int channel) {
    double sum = 0;
    for (size_t i = 0; i < medium->cells; ++i) sum += (double)medium->extinction[channel][i] * (double)lit[i];
    return sum * medium->cell[0] * medium->cell[1] * medium->cell[2];
}

/* The light that cells absorb and the light that leaves add up to the light that entered. */
static void no_light_is_lost(void** state) {
    for (int w = 0; w < WAYS; ++w)
        for (int gray = 0; gray < 2; ++gray) {
            ty_scene* scene = cloud_scene(*state, gray);
            direct_add_sun(scene, ways[w][0], ways[w][1], ways[w][2], 1);
            direct_case made = direct_begin(scene, 17, 1, 1);
            float* planes[3];
            for (int c = 0; c < 3; ++c) planes[c] = calloc(made.medium->cells, sizeof(float));
            ty_collimated_power power;
            assert_int_equal(made.medium->planes, gray ? 1 : 3);
            check_result(*state,
                         ty_uncollided_transmittance(scene, made.medium, NULL, made.sources.items, planes, &power));
            for (int c = 0; c < made.medium->planes; ++c) {
                const double taken = absorbed(made.medium, planes[c], c);
                assert_true(taken > 0.3 * power.entering[c] && power.leaving[c] > 1e-3 * power.entering[c]);
                assert_close((taken + power.leaving[c]) / power.entering[c], 1, 2e-6);
            }
            for (int c = 0; c < 3; ++c) free(planes[c]);
            direct_end(&made);
        }
}

/* The exact mean over cells of an even box, by the distance to where light enters, at 6^3 points. */
static double exact_box(const ty_grid_medium* medium, const int32_t cell[3], const double way[3], double sigma) {
    enum { POINTS = 6 };
    double sum = 0;
    for (int i = 0; i < POINTS * POINTS * POINTS; ++i) {
        const int at[3] = {i % POINTS, i / POINTS % POINTS, i / POINTS / POINTS};
        double distance = INFINITY;
        for (int a = 0; a < 3; ++a) {
            const double x = medium->cell[a] * (cell[a] + (at[a] + 0.5) / POINTS);
            const double depth = way[a] > 0 ? x : medium->box.upper[a] - medium->box.lower[a] - x;
            if (way[a] != 0) distance = fmin(distance, depth / fabs(way[a]));
        }
        sum += exp(-sigma * distance);
    }
    return sum / (POINTS * POINTS * POINTS);
}

/* Relative root mean square error of an even box under slanting light. */
static double box_error(ty_context* context, const double way[3], int32_t longest) {
    const double length = sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
    const double unit[3] = {way[0] / length, way[1] / length, way[2] / length};
    ty_scene* scene = box_scene(context, 1, 0.5f);
    direct_add_sun(scene, way[0], way[1], way[2], 1);
    direct_case made = direct_begin(scene, longest, 1, 1);
    ty_light_field* field = direct_light(&made, false);
    const int32_t* size = made.medium->box.size;
    double square = 0, sum = 0;
    for (size_t i = 0; i < made.medium->cells; ++i) {
        const int32_t cell[3] = {(int32_t)i % size[0], (int32_t)i / size[0] % size[1], (int32_t)i / size[0] / size[1]};
        const double expected = exact_box(made.medium, cell, unit, 1.5);
        square += pow((double)field->fluence[0][i] - expected, 2);
        sum += expected;
    }
    const double cells = (double)made.medium->cells;
    ty_light_field_destroy(field);
    direct_end(&made);
    return sqrt(square / cells) / (sum / cells);
}

static void slanting_light_converges(void** state) {
    for (int w = 4; w < WAYS; ++w) {
        const double coarse = box_error(*state, ways[w], 12), fine = box_error(*state, ways[w], 48);
        printf("way %2d: relative RMSE %.4f on 12 cells, %.4f on 48: order %.2f\n", w, coarse, fine,
               log(coarse / fine) / log(4));
        assert_true(coarse < 0.07 && fine < 0.25 * coarse);
    }
}

static void middle_of(const ty_grid_medium* medium, size_t cell, double at[3]) {
    for (int a = 0; a < 3; ++a) {
        const size_t size = (size_t)medium->box.size[a];
        at[a] = medium->box.lower[a] + medium->cell[a] * ((double)(cell % size) + 0.5);
        cell /= size;
    }
}

/* Behind a board across the light there is none of it, beside it there is all, however far. */
static void boards_throw_sharp_shadows(void** state) {
    ty_scene* scene = box_scene(*state, 0, 0);
    ty_shape_def board = quad_shape((const double[3][3]){{0, 1.5, -3}, {5, 0, 0}, {0, 5, 0}});
    check_result(*state, ty_scene_add_shape(scene, &board));
    direct_add_sun(scene, 0.25, 0, 1, 1);
    direct_case made = direct_begin(scene, 60, 1, 1);
    ty_light_field* field = direct_light(&made, false);
    const ty_grid_medium* medium = made.medium;
    int dark = 0;
    for (size_t i = 0; i < medium->cells; ++i) {
        double at[3];
        middle_of(medium, i, at);
        const double inside = fmin(at[0] - 0.25 * (at[2] + 3), at[1] - 1.5);
        if (fabs(inside) < 1.5 * medium->cell[0]) continue;
        assert_close(field->fluence[0][i], inside > 0 ? 0 : 1, 2e-6);
        dark += inside > 0;
    }
    assert_true(dark > 1000);
    ty_light_field_destroy(field);
    direct_end(&made);
}

/* Walls in the box's own faces keep out what slants at them from outside, and lose nothing of what slants at them from
 * within: the cells next to them are as dark, or as bright, as those before them. */
static void walls_in_the_faces_keep_light_apart(void** state) {
    static const double lower[3] = {-1, 0.5, -2}, upper[3] = {1, 2.5, 1};
    for (int w = 0; w < WAYS; ++w) {
        if (!(ways[w][2] < 0)) continue;
        ty_scene* scene = box_scene(*state, 0, 0);
        direct_add_walls(scene, lower, upper);
        direct_add_sun(scene, ways[w][0], ways[w][1], ways[w][2], 1);
        direct_case made = direct_begin(scene, 45, 1, 1);
        ty_light_field* field = direct_light(&made, false);
        const ty_grid_medium* medium = made.medium;
        const double toward[3] = {-ways[w][0], -ways[w][1], -ways[w][2]};
        const double shallow = 1 + fmax(fabs(ways[w][0]), fabs(ways[w][1])) / -ways[w][2];
        int edges = 0;
        for (size_t i = 0; i < medium->cells; ++i) {
            double at[3];
            middle_of(medium, i, at);
            const double within = direct_through_opening(lower, upper, at, toward);
            const bool sure = ways[w][0] == 0 && ways[w][1] == 0;
            if (!sure && fabs(within) < 2.5 * medium->cell[0] * shallow) continue;
            assert_close(field->fluence[0][i], within > 0 ? 1 : 0, 2e-6);
            for (int a = 0; a < 2; ++a) edges += fmin(at[a] - lower[a], upper[a] - at[a]) < 0.75 * medium->cell[a];
        }
        assert_true(edges > 1000);
        ty_light_field_destroy(field);
        direct_end(&made);
    }
}

/* A floor in the middle of the box: light ends there. */
static void floors_end_light(void** state) {
    ty_scene* scene = box_scene(*state, 1, 0);
    ty_shape_def floor = quad_shape((const double[3][3]){{-5, 1.5, -5}, {0, 0, 10}, {10, 0, 0}});
    check_result(*state, ty_scene_add_shape(scene, &floor));
    direct_add_sun(scene, 0, -1, 0, 1);
    direct_case made = direct_begin(scene, 30, 1, 1);
    ty_light_field* field = direct_light(&made, false);
    const ty_grid_medium* medium = made.medium;
    const size_t column = (size_t)medium->box.size[0] / 2;
    for (int32_t j = 0; j < medium->box.size[1]; ++j) {
        const double below = medium->box.upper[1] - medium->box.lower[1] - medium->cell[1] * (j + 1);
        const double expected = exp(-below) * -expm1(-medium->cell[1]) / medium->cell[1];
        const double value = (double)field->fluence[2][column + (size_t)medium->box.size[0] * (size_t)j];
        assert_close(value, 2 * j < medium->box.size[1] ? 0 : expected, 3e-6);
    }
    ty_light_field_destroy(field);
    direct_end(&made);
}

static void threads_change_no_bit(void** state) {
    (void)state;
    ty_light_field* fields[2];
    direct_case made[2];
    ty_context* contexts[2];
    for (int i = 0; i < 2; ++i) {
        contexts[i] = make_context(i == 0 ? 1 : 5);
        ty_scene* scene = cloud_scene(contexts[i], false);
        ty_light_def sky = sky_light(1, 1, 1);
        check_result(contexts[i], ty_scene_add_light(scene, &sky));
        direct_add_sun(scene, 1, -2, 3, 1);
        made[i] = direct_begin(scene, 29, 6, 1);
        fields[i] = direct_light(&made[i], true);
    }
    const size_t bytes = made[0].medium->cells * sizeof(float);
    for (int c = 0; c < 3; ++c) {
        assert_memory_equal(made[0].medium->extinction[c], made[1].medium->extinction[c], bytes);
        assert_memory_equal(fields[0]->fluence[c], fields[1]->fluence[c], bytes);
        for (int a = 0; a < 3; ++a) assert_memory_equal(fields[0]->flux[c][a], fields[1]->flux[c][a], bytes);
    }
    for (int i = 0; i < 2; ++i) {
        ty_light_field_destroy(fields[i]);
        direct_end(&made[i]);
        ty_context_destroy(contexts[i]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(even_media_are_exact_along_axes),
        cmocka_unit_test(nothing_dims_nothing),
        cmocka_unit_test(no_light_is_lost),
        cmocka_unit_test(slanting_light_converges),
        cmocka_unit_test(boards_throw_sharp_shadows),
        cmocka_unit_test(walls_in_the_faces_keep_light_apart),
        cmocka_unit_test(floors_end_light),
        cmocka_unit_test(threads_change_no_bit),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
