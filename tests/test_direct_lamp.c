/* Light from points on a grid: the inverse square law averaged over cells, even and uneven media, shadows, threads. */
#include "direct_maker.h"

#include <stdio.h>

static ty_scene* cube_scene(ty_context* context, float sigma_t, const double lamp[3]) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(context);
    const ty_medium_def medium = box_medium(lower, upper, 0.5f * sigma_t, 0.5f * sigma_t);
    check_result(context, ty_scene_add_medium(scene, &medium));
    ty_light_def light = ty_default_light_def();
    light.kind = TY_LIGHT_POINT;
    memcpy(light.position, lamp, sizeof light.position);
    set3f(light.color, 1, 2, 3);
    check_result(context, ty_scene_add_light(scene, &light));
    return scene;
}

/* Length within the cube of the segment from the point light to a point. */
static double way_inside(const double lamp[3], const double point[3]) {
    double enter = 0, leave = 1, square = 0;
    for (int a = 0; a < 3; ++a) {
        const double d = point[a] - lamp[a];
        square += d * d;
        if (d == 0) continue;
        enter = fmax(enter, fmin((-1 - lamp[a]) / d, (1 - lamp[a]) / d));
        leave = fmin(leave, fmax((-1 - lamp[a]) / d, (1 - lamp[a]) / d));
    }
    return fmax(0, leave - enter) * sqrt(square);
}

/* The mean over a cell of intensity 1 at n^3 points. */
static double exact_cell(const ty_grid_medium* medium, const int32_t cell[3], const double lamp[3], double sigma,
                         int n) {
    double sum = 0;
    for (int i = 0; i < n * n * n; ++i) {
        const int at[3] = {i % n, i / n % n, i / n / n};
        double point[3], square = 0;
        for (int a = 0; a < 3; ++a) {
            point[a] = medium->box.lower[a] + medium->cell[a] * (cell[a] + (at[a] + 0.5) / n);
            square += (point[a] - lamp[a]) * (point[a] - lamp[a]);
        }
        sum += exp(-sigma * way_inside(lamp, point)) / square;
    }
    return sum / ((double)n * n * n);
}

typedef struct lamp_errors {
    double worst, rms, mean; /* relative: of single cells, of all in proportion to their light */
} lamp_errors;

static lamp_errors compare_cube(ty_context* context, double sigma, const double lamp[3], int32_t cells) {
    ty_scene* scene = cube_scene(context, (float)sigma, lamp);
    direct_case made = direct_begin(scene, cells, 1, 1);
    ty_light_field* field = direct_light(&made, true);
    const int32_t* size = made.medium->box.size;
    lamp_errors errors = {0, 0, 0};
    double sum = 0, found = 0;
    for (size_t i = 0; i < made.medium->cells; ++i) {
        const int32_t cell[3] = {(int32_t)i % size[0], (int32_t)i / size[0] % size[1], (int32_t)i / size[0] / size[1]};
        double near = 0;
        for (int a = 0; a < 3; ++a)
            near = fmax(near, fabs(made.medium->box.lower[a] + made.medium->cell[a] * (cell[a] + 0.5) - lamp[a]) /
                                  made.medium->cell[a]);
        const double expected = exact_cell(made.medium, cell, lamp, sigma, near < 1.6 ? 32 : near < 4 ? 12 : 5);
        const double off = (double)field->fluence[1][i] / (2 * expected) - 1;
        double flux = 0;
        for (int a = 0; a < 3; ++a) flux += pow((double)field->flux[1][a][i], 2);
        assert_true(sqrt(flux) <= (double)field->fluence[1][i] * (1 + 1e-5));
        errors.worst = fmax(errors.worst, fabs(off));
        errors.rms += off * off;
        sum += expected;
        found += (double)field->fluence[1][i] / 2;
    }
    errors.rms = sqrt(errors.rms / (double)made.medium->cells);
    errors.mean = found / sum - 1;
    ty_light_field_destroy(field);
    direct_end(&made);
    return errors;
}

static const double lamps[][3] = {{0.03, -0.04, 0.01}, {0, 0, 0},   {0.95, 0.9, -0.97},  {3, 0.5, 0.2},
                                  {1.01, 0.2, 0.3},    {-4, 5, -6}, {0.31, 0.52, -0.73}, {40, 0, 0}};
enum { LAMPS = sizeof lamps / sizeof *lamps };
/* Relative, in an even medium. A lamp just off a side lights cells there at grazing angles, and one beyond a corner
 * lights cells through two sides: their depths are not even nearly linear. */
static const double allowed[LAMPS] = {0.003, 0.003, 0.003, 0.003, 0.06, 0.02, 0.003, 0.003};

static void inverse_squares_are_met(void** state) {
    for (int i = 0; i < LAMPS; ++i) {
        const lamp_errors errors = compare_cube(*state, 0, lamps[i], 16);
        printf("lamp %d, nothing there: worst %.4f, rms %.5f, mean %+.5f\n", i, errors.worst, errors.rms, errors.mean);
        assert_true(errors.worst < 0.04 && errors.rms < 0.005 && fabs(errors.mean) < 0.005);
    }
}

static void even_media_dim_lamps(void** state) {
    for (int i = 0; i < LAMPS; ++i) {
        const lamp_errors errors = compare_cube(*state, 3, lamps[i], 16);
        printf("lamp %d, even medium: worst %.4f, rms %.5f, mean %+.5f\n", i, errors.worst, errors.rms, errors.mean);
        assert_true(errors.worst < 12 * allowed[i] && errors.rms < allowed[i] && fabs(errors.mean) < 0.02);
    }
}

static void finer_cells_are_nearer(void** state) {
    const double lamp[3] = {-1.7, 1.9, 1.2};
    const lamp_errors coarse = compare_cube(*state, 3, lamp, 8), fine = compare_cube(*state, 3, lamp, 32);
    printf("rms %.5f on 8^3, %.5f on 32^3\n", coarse.rms, fine.rms);
    assert_true(fine.rms < 0.3 * coarse.rms);
}

/* Long boxes are cut into lengths whose lattices widen. */
static void long_boxes_are_met(void** state) {
    const double lower[3] = {-0.1, -20, -0.1}, upper[3] = {0.1, 20, 0.1};
    ty_scene* scene = make_scene(*state);
    const ty_medium_def medium = box_medium(lower, upper, 0.1f, 0);
    ty_light_def light = ty_default_light_def();
    light.kind = TY_LIGHT_POINT;
    set3(light.position, 0.01, 1, 0);
    check_result(*state, ty_scene_add_medium(scene, &medium));
    check_result(*state, ty_scene_add_light(scene, &light));
    direct_case made = direct_begin(scene, 800, 1, 1);
    ty_light_field* field = direct_light(&made, false);
    const int32_t* size = made.medium->box.size;
    assert_int_equal(size[0], 4);
    for (int32_t j = 0; j < size[1]; ++j) {
        const double y = -20 + 40 * (j + 0.5) / size[1];
        if (fabs(y - 1) < 0.5) continue;
        for (int32_t i = 0; i < 4; ++i) {
            const double x = 0.05 * (i - 1.5) - 0.01, square = x * x + (y - 1) * (y - 1) + 0.025 * 0.025;
            const double value = (double)field->fluence[0][i + size[0] * (j + size[1] * 1)];
            assert_close(value * square / exp(-0.1 * sqrt(square)), 1, 0.01);
        }
    }
    ty_light_field_destroy(field);
    direct_end(&made);
}

/* A board between the lamp and half of the cube. */
static void boards_shade_lamps(void** state) {
    const double lamp[3] = {0, 3, 0};
    ty_scene* scene = cube_scene(*state, 0, lamp);
    ty_shape_def board = quad_shape((const double[3][3]){{0, 2, -5}, {0, 0, 10}, {5, 0, 0}});
    check_result(*state, ty_scene_add_shape(scene, &board));
    direct_case made = direct_begin(scene, 24, 1, 1);
    ty_light_field* field = direct_light(&made, false);
    for (size_t i = 0; i < made.medium->cells; ++i) {
        const double x = -1 + (i % 24 + 0.5) / 12.0, y = -1 + (i / 24 % 24 + 0.5) / 12.0,
                     z = -1 + (i / 576 + 0.5) / 12.0;
        const double square = x * x + (y - 3) * (y - 3) + z * z;
        if (fabs(x) < 0.1) continue;
        assert_close((double)field->fluence[0][i] * square, x > 0 ? 0 : 1, 0.003);
    }
    ty_light_field_destroy(field);
    direct_end(&made);
}

/* Walls in the cube's own faces, and a lamp before the one that is open, beside it, or in the plane of a wall. */
static void walls_in_the_faces_keep_lamps_out(void** state) {
    static const double places[][3] = {{-2.5, 0.3, 2.5}, {0.2, 3, 1.7}, {4, -5, 3}, {-1, 0.1, 2}, {0, 0, 9}};
    static const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    for (int n = 0; n < 5; ++n) {
        ty_scene* scene = cube_scene(*state, 0, places[n]);
        direct_add_walls(scene, lower, upper);
        direct_case made = direct_begin(scene, 30, 1, 1);
        ty_light_field* field = direct_light(&made, false);
        int edges = 0;
        for (size_t i = 0; i < made.medium->cells; ++i) {
            const double at[3] = {-1 + (i % 30 + 0.5) / 15.0, -1 + (i / 30 % 30 + 0.5) / 15.0,
                                  -1 + (i / 900 + 0.5) / 15.0};
            const double toward[3] = {places[n][0] - at[0], places[n][1] - at[1], places[n][2] - at[2]};
            const double square = toward[0] * toward[0] + toward[1] * toward[1] + toward[2] * toward[2];
            const double within = direct_through_opening(lower, upper, at, toward);
            const double shallow = 1 + fmax(fabs(toward[0]), fabs(toward[1])) / toward[2];
            if (fabs(within) < 2.0 / 15 * shallow) continue;
            assert_close((double)field->fluence[0][i] * square, within > 0 ? 1 : 0, 0.005);
            edges += fmax(fabs(at[0]), fabs(at[1])) > 14.0 / 15;
        }
        assert_true(edges > 500);
        ty_light_field_destroy(field);
        direct_end(&made);
    }
}

static void transmittance_has_no_distance_in_it(void** state) {
    ty_scene* scene = cube_scene(*state, 2, lamps[3]);
    direct_case made = direct_begin(scene, 16, 1, 1);
    ty_light_field* field = direct_light(&made, false);
    float* planes[3] = {calloc(made.medium->cells, sizeof(float)), NULL, NULL};
    check_result(*state, ty_uncollided_transmittance(scene, made.medium, NULL, made.sources.items, planes, NULL));
    for (size_t i = 0; i < made.medium->cells; ++i) {
        const double x = -1 + (i % 16 + 0.5) / 8.0, y = -1 + (i / 16 % 16 + 0.5) / 8.0, z = -1 + (i / 256 + 0.5) / 8.0;
        const double square = pow(x - lamps[3][0], 2) + pow(y - lamps[3][1], 2) + pow(z - lamps[3][2], 2);
        assert_close((double)field->fluence[2][i] * square / 3 / (double)planes[0][i], 1, 0.01);
    }
    free(planes[0]);
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
        made[i] = direct_begin(cube_scene(contexts[i], 2, lamps[6]), 20, 1, 1);
        fields[i] = direct_light(&made[i], true);
    }
    for (int c = 0; c < 3; ++c)
        assert_memory_equal(fields[0]->fluence[c], fields[1]->fluence[c], made[0].medium->cells * sizeof(float));
    for (int i = 0; i < 2; ++i) {
        ty_light_field_destroy(fields[i]);
        direct_end(&made[i]);
        ty_context_destroy(contexts[i]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inverse_squares_are_met),
        cmocka_unit_test(even_media_dim_lamps),
        cmocka_unit_test(finer_cells_are_nearer),
        cmocka_unit_test(long_boxes_are_met),
        cmocka_unit_test(boards_shade_lamps),
        cmocka_unit_test(walls_in_the_faces_keep_lamps_out),
        cmocka_unit_test(transmittance_has_no_distance_in_it),
        cmocka_unit_test(threads_change_no_bit),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
