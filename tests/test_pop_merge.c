/* Ordinates' light brought together in one grid, and what goes on there as isotropic light. */
#include "pop_merge_maker.h"

/* Cells of different sides; rows longer than one run of the kernel. */
static const ty_grid_box slab = {{-1, 0.5, 2}, {3, 1.5, 3.25}, {70, 13, 9}};
static const ty_grid_box cube = {{-1, -1, -1}, {1, 1, 1}, {15, 15, 15}};

enum { DIRECTIONS = 12 };

static ty_vec direction_of(int n) {
    static const ty_vec axes[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    uint64_t state = (uint64_t)n;
    return n < 6 ? axes[n] : random_unit(&state);
}

/* True if a point is between centers of cells, where nothing is held to the grid's edge. */
static bool is_inside(const ty_pop_grid* grid, ty_vec point) {
    const float step[3] = {grid->step.x, grid->step.y, grid->step.z};
    for (int a = 0; a < 3; ++a) {
        const float at = ty_dot(ty_sub(point, grid->origin), grid->axis[a]) / step[a];
        if (at < 0.5f || at > (float)grid->size[a] - 0.5f) return false;
    }
    return true;
}

static void merge(ty_context* context, const ty_pop_light* light, ty_pop_merged* merged) {
    ty_pop_merge(context, light, 1, merged);
}

/* ---- interpolation ---- */

static void fill_constant(const ty_pop_light* light, ty_vec center, float* cell) {
    (void)center;
    for (int n = 0; n < light->floats; ++n) cell[n] = (float)(n + 1);
}

/* Whatever the direction, everywhere in the box. */
static void constants_stay(void** state) {
    for (int d = 0; d < DIRECTIONS; ++d) {
        ty_pop_light light = parallel_light(&slab, direction_of(d), TY_POP_CELL_FLOATS_PROPAGATED);
        ty_pop_merged merged = make_merged(&slab, false);
        fill_light(&light, fill_constant);
        merge(*state, &light, &merged);
        for (size_t i = 0; i < box_cells(&slab); ++i)
            for (int c = 0; c < 3; ++c) {
                assert_close(merged.accumulated_radiance[c][i], c + 1, 1e-5);
                assert_close(merged.fluence[c][i], c + 4, 1e-5);
            }
        free_merged(&merged);
        free_light(&light);
    }
}

static float slope(int n, ty_vec p) {
    return 3 + (float)n + (1 - 0.2f * (float)n) * p.x + 2 * p.y - 0.7f * (float)n * p.z;
}

static void fill_slopes(const ty_pop_light* light, ty_vec center, float* cell) {
    for (int n = 0; n < light->floats; ++n) cell[n] = slope(n, center);
}

static void slopes_stay_between_middles(void** state) {
    for (int d = 0; d < DIRECTIONS; ++d)
        for (int32_t floats = TY_POP_CELL_FLOATS; floats <= TY_POP_CELL_FLOATS_PROPAGATED; floats += 4) {
            ty_pop_light light = parallel_light(&slab, direction_of(d), floats);
            ty_pop_merged merged = make_merged(&slab, false);
            int looked_at = 0;
            fill_light(&light, fill_slopes);
            merge(*state, &light, &merged);
            for (size_t i = 0; i < box_cells(&slab); ++i) {
                const ty_vec center = merged_center(&slab, i);
                if (!is_inside(&light.grid, center)) continue;
                ++looked_at;
                for (int c = 0; c < 3; ++c) {
                    assert_close(merged.accumulated_radiance[c][i], slope(c, center), 3e-5);
                    assert_close(merged.fluence[c][i], slope(3 + c, center), 3e-5);
                }
            }
            assert_true(looked_at > 1000);
            free_merged(&merged);
            free_light(&light);
        }
}

static void fill_noise(const ty_pop_light* light, ty_vec center, float* cell) {
    uint64_t state = ty_bits_from_float(center.x) ^ (uint64_t)ty_bits_from_float(center.y + center.z) << 20;
    for (int n = 0; n < light->floats; ++n) cell[n] = (float)uniform(&state);
}

static float blend(const ty_pop_light* light, const ty_pop_cell_position* place, int n) {
    float sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        size_t cell = place->base;
        float weight = place->inverse_square;
        for (int a = 0; a < 3; ++a) {
            const bool upper = (corner >> a & 1) != 0;
            cell += upper ? place->step[a] : 0;
            weight *= upper ? place->fraction[a] : 1 - place->fraction[a];
        }
        sum += weight * light->accumulated[(size_t)light->floats * cell + (size_t)n];
    }
    return sum;
}

static void check_places(ty_context* context, const ty_pop_light* light) {
    ty_pop_merged merged = make_merged(&slab, false);
    fill_light(light, fill_noise);
    merge(context, light, &merged);
    for (size_t i = 0; i < box_cells(&slab); ++i) {
        const ty_pop_cell_position place =
            ty_pop_locate(&light->grid, light->ordinate.min_distance, merged_center(&slab, i));
        const double tolerance = 1e-4 * (double)ty_maxf(1, place.inverse_square);
        for (int c = 0; c < 3; ++c) {
            assert_close(merged.accumulated_radiance[c][i], blend(light, &place, c), tolerance);
            assert_close(merged.fluence[c][i], blend(light, &place, 3 + c), tolerance);
        }
    }
    free_merged(&merged);
}

/* Cells, edges and rings included, are those that looking up a single point finds. */
static void cells_lie_where_points_are(void** state) {
    for (int d = 0; d < DIRECTIONS; ++d) {
        ty_pop_light light =
            parallel_light(&slab, direction_of(d), d % 2 == 0 ? TY_POP_CELL_FLOATS : TY_POP_CELL_FLOATS_PROPAGATED);
        check_places(*state, &light);
        free_light(&light);
    }
    static const ty_vec positions[] = {{0, 1, 2.5f}, {-3, 4, 1}, {0.9f, 0.7f, 8}};
    for (int n = 0; n < 6; ++n) {
        const bool single = n == 5;
        ty_pop_light light =
            radial_light(positions[n % 3], 8, single ? 1 : 10, 0.05f, 5, n < 3 ? TY_POP_CELL_FLOATS : 12);
        light.ordinate.min_distance = 0.5f;
        check_places(*state, &light);
        free_light(&light);
    }
}

/* Points outside of a grid have what is at its edge. */
static void points_outside_do_no_harm(void** state) {
    static const ty_grid_box far = {{1e6, -1e9, 4}, {2e6, 1e9, 5e7}, {5, 6, 7}};
    for (int d = 0; d < DIRECTIONS; ++d) {
        ty_pop_light lights[2] = {parallel_light(&slab, direction_of(d), TY_POP_CELL_FLOATS),
                                  radial_light(box_center(&slab), 6, 6, 0.1f, 2, TY_POP_CELL_FLOATS)};
        ty_pop_merged merged = make_merged(&far, false);
        for (int l = 0; l < 2; ++l) fill_light(&lights[l], fill_constant);
        ty_pop_merge(*state, lights, 2, &merged);
        for (size_t i = 0; i < box_cells(&far); ++i) assert_close(merged.fluence[2][i], 6, 1e-4);
        free_merged(&merged);
        for (int l = 0; l < 2; ++l) free_light(&lights[l]);
    }
}

/* ---- what lights add ---- */

/* Half of the cells are vacuum, from which those beside them take next to nothing. */
static void fill_weighted(const ty_pop_light* light, ty_vec center, float* cell) {
    const bool dense = center.x > 0;
    const float weight = dense ? 1 : 1e-4f;
    for (int n = 0; n < light->floats; ++n) cell[n] = weight * (dense ? 1.0f : 9.0f);
    cell[TY_POP_CELL_WEIGHT] = weight;
}

static void weights_decide(void** state) {
    ty_pop_light light = parallel_light(&cube, direction_of(0), TY_POP_CELL_FLOATS);
    ty_pop_merged merged = make_merged(&cube, false);
    const ty_pop_grid* grid = &light.grid;
    for (int32_t k = 0; k < grid->size[2]; ++k)
        for (int32_t j = 0; j < grid->size[1]; ++j)
            for (int32_t i = 0; i < grid->size[0]; ++i)
                fill_weighted(&light, ty_pop_cell_center(grid, i, j, k), cell_of(&light, i, j, k));
    merge(*state, &light, &merged);
    int dense = 0, empty = 0;
    for (size_t i = 0; i < box_cells(&cube); ++i) {
        const float value = merged.fluence[0][i];
        assert_true(value > 0.999f && value < 9.001f);
        if (merged_center(&cube, i).x > 0) assert_close(value, 1, 0.08);
        dense += value < 1.08f;
        empty += value > 8.9f;
    }
    assert_true(dense > 0 && empty > 0);
    free_merged(&merged);
    free_light(&light);
}

static void fill_intensity(const ty_pop_light* light, ty_vec center, float* cell) {
    (void)light;
    (void)center;
    for (int c = 0; c < 3; ++c) cell[3 + c] = (float)(c + 1);
}

/* 1 / r^2, held near the light, and away from it. */
static void lamps_spread(void** state) {
    static const ty_vec position = {0.3f, -0.2f, 0.1f};
    ty_pop_light light = radial_light(position, 8, 12, 0.05f, 3, TY_POP_CELL_FLOATS);
    ty_pop_merged merged = make_merged(&cube, false);
    light.ordinate.min_distance = 0.25f;
    fill_light(&light, fill_intensity);
    merge(*state, &light, &merged);
    for (size_t i = 0; i < box_cells(&cube); ++i) {
        const ty_vec off = ty_sub(merged_center(&cube, i), position);
        const float held = ty_maxf(sqrtf(ty_dot(off, off)), 0.25f);
        for (int c = 0; c < 3; ++c) {
            const float expected = (float)(c + 1) / (held * held);
            assert_close(merged.fluence[c][i], expected, 1e-5 * (double)expected);
        }
    }
    free_merged(&merged);
    free_light(&light);
}

enum { LIGHTS = 5 };

static void make_lights(ty_pop_light lights[LIGHTS]) {
    for (int l = 0; l < LIGHTS; ++l) {
        lights[l] = l % 2 == 0 ? parallel_light(&slab, direction_of(6 + l), TY_POP_CELL_FLOATS)
                               : radial_light(direction_of(6 + l), 6, 7, 0.1f, 5, TY_POP_CELL_FLOATS);
        fill_light(&lights[l], fill_noise);
    }
}

/* To the last bit, however many come at a time. */
static void lights_add_up(void** state) {
    ty_pop_light lights[LIGHTS];
    make_lights(lights);
    ty_pop_merged all = make_merged(&slab, false), one_by_one = make_merged(&slab, false);
    ty_pop_merge(*state, lights, LIGHTS, &all);
    for (int l = 0; l < LIGHTS; ++l) merge(*state, &lights[l], &one_by_one);
    for (int c = 0; c < 3; ++c) {
        assert_memory_equal(all.accumulated_radiance[c], one_by_one.accumulated_radiance[c],
                            box_cells(&slab) * sizeof(float));
        assert_memory_equal(all.fluence[c], one_by_one.fluence[c], box_cells(&slab) * sizeof(float));
    }
    free_merged(&all);
    free_merged(&one_by_one);
    for (int l = 0; l < LIGHTS; ++l) free_light(&lights[l]);
}

static void threads_make_no_difference(void** state) {
    ty_pop_light lights[LIGHTS];
    ty_pop_merged merged[2];
    make_lights(lights);
    for (int t = 0; t < 2; ++t) {
        ty_context* context = make_context(1 + 2 * t);
        merged[t] = make_merged(&slab, false);
        ty_pop_merge(context, lights, LIGHTS, &merged[t]);
        ty_context_destroy(context);
    }
    for (int c = 0; c < 3; ++c) {
        assert_memory_equal(merged[0].accumulated_radiance[c], merged[1].accumulated_radiance[c],
                            box_cells(&slab) * sizeof(float));
        assert_memory_equal(merged[0].fluence[c], merged[1].fluence[c], box_cells(&slab) * sizeof(float));
    }
    for (int t = 0; t < 2; ++t) free_merged(&merged[t]);
    for (int l = 0; l < LIGHTS; ++l) free_light(&lights[l]);
    (void)state;
}

/* ---- the residuum ---- */

/* A cube of 15 x 15 x 15 cells, lit at the center. */
typedef struct glow {
    ty_grid_medium medium;
    ty_pop_merged merged;
} glow;

static const size_t lit = (7 * 15 + 7) * 15 + 7;

static glow make_glow(const float absorption[3]) {
    glow g = {.medium = {.box = cube, .cells = box_cells(&cube), .planes = 3}, .merged = make_merged(&cube, true)};
    for (int c = 0; c < 3; ++c) {
        g.medium.cell[c] = 2.0 / 15;
        g.medium.extinction[c] = new_floats(g.medium.cells);
        g.medium.scattering[c] = new_floats(g.medium.cells);
        for (size_t i = 0; i < g.medium.cells; ++i) {
            g.medium.scattering[c][i] = 5;
            g.medium.extinction[c][i] = 5 + absorption[c];
        }
        g.merged.unpropagated[c][lit] = (float)(c + 1);
    }
    return g;
}

static void free_glow(glow* g) {
    for (int c = 0; c < 3; ++c) {
        free(g->medium.extinction[c]);
        free(g->medium.scattering[c]);
    }
    free_merged(&g->merged);
}

static double sum_of(const float* values) {
    double sum = 0;
    for (size_t i = 0; i < box_cells(&cube); ++i) sum += (double)values[i];
    return sum;
}

/* Until it reaches the faces, what is left is what was not absorbed, and fluence is the sum of it. */
static void residuum_is_absorbed_alone(void** state) {
    static const float absorption[3] = {0, 0.5f, 3};
    glow g = make_glow(absorption);
    double left, expected_left = 0;
    assert_int_equal(ty_pop_residuum(*state, &g.medium, 0, 7, &g.merged, &left), 7);
    for (int c = 0; c < 3; ++c) {
        const double pass = exp(-(double)absorption[c] * 2 / 15);
        double through = 0;
        for (int n = 1; n <= 7; ++n) through += (c + 1) * pow(pass, n);
        expected_left += (c + 1) * pow(pass, 7);
        assert_close(sum_of(g.merged.unpropagated[c]), (c + 1) * pow(pass, 7), 1e-5);
        assert_close(sum_of(g.merged.fluence[c]), through, 1e-4);
        assert_close(sum_of(g.merged.accumulated_radiance[c]), through / (4 * 3.14159265358979), 1e-5);
    }
    assert_close(left, expected_left / 6, 1e-6);
    free_glow(&g);
}

/* A pass takes away the light beside faces, a sixth for each. */
static void residuum_leaves_through_faces(void** state) {
    static const float absorption[3] = {0, 0, 0};
    glow g = make_glow(absorption);
    double left, sum = 3;
    for (int n = 0; n < 40; ++n) {
        double leaving = 0;
        for (int i = 0; i < 15 * 15 * 15; ++i) {
            const int at[3] = {i % 15, i / 15 % 15, i / 225};
            for (int a = 0; a < 3; ++a)
                if (at[a] == 0 || at[a] == 14) leaving += (double)g.merged.unpropagated[2][i] / 6;
        }
        assert_int_equal(ty_pop_residuum(*state, &g.medium, 0, 1, &g.merged, &left), 1);
        assert_close(sum_of(g.merged.unpropagated[2]), sum - leaving, 1e-5);
        sum -= leaving;
    }
    assert_true(sum < 2.9);
    free_glow(&g);
}

static void residuum_is_symmetric(void** state) {
    static const float absorption[3] = {0, 0.5f, 3};
    glow g = make_glow(absorption);
    double left;
    ty_pop_residuum(*state, &g.medium, 0, 30, &g.merged, &left);
    for (int c = 0; c < 3; ++c)
        for (int z = 0; z < 15; ++z)
            for (int y = 0; y < 15; ++y)
                for (int x = 0; x < 15; ++x) {
                    const double value = (double)g.merged.fluence[c][(z * 15 + y) * 15 + x];
                    assert_close(g.merged.fluence[c][(z * 15 + y) * 15 + 14 - x], value, 1e-6 * value);
                    assert_close(g.merged.fluence[c][(x * 15 + z) * 15 + y], value, 1e-5 * value);
                }
    free_glow(&g);
}

static void residuum_ends(void** state) {
    static const float absorption[3] = {0, 0.5f, 3};
    glow g = make_glow(absorption);
    double left;
    const int32_t iterations = ty_pop_residuum(*state, &g.medium, 1e-3, 10000, &g.merged, &left);
    assert_true(iterations > 20 && iterations < 2000);
    assert_true(left > 0 && left <= 1e-3);
    for (int c = 0; c < 3; ++c) assert_true(sum_of(g.merged.unpropagated[c]) <= 1e-3 * (c + 1));
    free_glow(&g);
    g = make_glow(absorption);
    for (int c = 0; c < 3; ++c) g.merged.unpropagated[c][lit] = 0;
    assert_int_equal(ty_pop_residuum(*state, &g.medium, 1e-3, 10, &g.merged, &left), 0);
    assert_true(left == 0 && sum_of(g.merged.fluence[0]) == 0);
    free_glow(&g);
}

/* Cells are as large as the lights', and hold the box at their center. */
static void residuum_has_the_lights_cells(void** state) {
    (void)state;
    for (int d = 0; d < DIRECTIONS; ++d) {
        ty_pop_light lights[2] = {parallel_light(&slab, direction_of(d), TY_POP_CELL_FLOATS_PROPAGATED),
                                  parallel_light(&slab, direction_of(d), TY_POP_CELL_FLOATS_PROPAGATED)};
        const ty_pop_grid* grid = &lights[0].grid;
        const ty_grid_box box = ty_pop_residuum_box(&slab, lights, 2);
        double squares = 0;
        for (int a = 0; a < 3; ++a) {
            squares += pow((box.upper[a] - box.lower[a]) / box.size[a], 2);
            assert_true(box.size[a] >= grid->size[2]);
            assert_true(box.lower[a] <= slab.lower[a] + 1e-3 && box.upper[a] >= slab.upper[a] - 1e-3);
            assert_close(box.lower[a] + box.upper[a], slab.lower[a] + slab.upper[a], 1e-6);
        }
        assert_close(squares, (double)ty_dot(grid->step, grid->step), 1e-5 * squares);
        for (int l = 0; l < 2; ++l) free_light(&lights[l]);
    }
}

/* Nothing is lost, wherever grids reach and point lights are. */
static void residuum_takes_all(void** state) {
    for (int d = 0; d < DIRECTIONS; ++d) {
        ty_pop_light lights[2] = {parallel_light(&slab, direction_of(d), TY_POP_CELL_FLOATS_PROPAGATED),
                                  radial_light(box_center(&slab), 6, 7, 0.1f, 3, TY_POP_CELL_FLOATS_PROPAGATED)};
        const ty_vec step = lights[0].grid.step;
        const double outer = 3,
                     volumes[2] = {990 * (double)(step.x * step.y * step.z), 4 * 3.14159265358979 * (outer - 0.1)};
        const ty_grid_box box = ty_pop_residuum_box(&slab, lights, 1);
        const double cell = (box.upper[0] - box.lower[0]) * (box.upper[1] - box.lower[1]) *
                            (box.upper[2] - box.lower[2]) / (double)box_cells(&box);
        ty_pop_merged merged = make_merged(&box, true);
        for (int l = 0; l < 2; ++l) fill_light(&lights[l], fill_constant);
        ty_pop_residuum_deposit(*state, lights, 2, &merged);
        for (int c = 0; c < 3; ++c) {
            double sum = 0;
            for (size_t i = 0; i < box_cells(&box); ++i) sum += cell * (double)merged.unpropagated[c][i];
            assert_close(sum, (c + 9) * (volumes[0] + volumes[1]), 1e-4 * sum);
        }
        free_merged(&merged);
        for (int l = 0; l < 2; ++l) free_light(&lights[l]);
    }
}

/* A slope stays one on other cells, between the middles of the outer ones. */
static void residuum_is_brought_to_other_cells(void** state) {
    static const ty_grid_box large = {{-2, 0, 1}, {4, 2, 4}, {12, 11, 10}};
    ty_pop_merged from = make_merged(&large, false), to = make_merged(&slab, false);
    for (size_t i = 0; i < box_cells(&large); ++i)
        for (int c = 0; c < 3; ++c) {
            from.accumulated_radiance[c][i] = slope(c, merged_center(&large, i));
            from.fluence[c][i] = slope(3 + c, merged_center(&large, i));
        }
    for (size_t i = 0; i < box_cells(&slab); ++i) to.fluence[1][i] = 1;
    ty_pop_merged_add(*state, &from, &to);
    for (size_t i = 0; i < box_cells(&slab); ++i)
        for (int c = 0; c < 3; ++c) {
            const ty_vec center = merged_center(&slab, i);
            assert_close(to.accumulated_radiance[c][i], slope(c, center), 3e-5);
            assert_close(to.fluence[c][i], slope(3 + c, center) + (c == 1 ? 1 : 0), 3e-5);
        }
    free_merged(&from);
    free_merged(&to);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(constants_stay),
        cmocka_unit_test(slopes_stay_between_middles),
        cmocka_unit_test(cells_lie_where_points_are),
        cmocka_unit_test(points_outside_do_no_harm),
        cmocka_unit_test(lamps_spread),
        cmocka_unit_test(weights_decide),
        cmocka_unit_test(lights_add_up),
        cmocka_unit_test(threads_make_no_difference),
        cmocka_unit_test(residuum_is_absorbed_alone),
        cmocka_unit_test(residuum_leaves_through_faces),
        cmocka_unit_test(residuum_is_symmetric),
        cmocka_unit_test(residuum_ends),
        cmocka_unit_test(residuum_has_the_lights_cells),
        cmocka_unit_test(residuum_takes_all),
        cmocka_unit_test(residuum_is_brought_to_other_cells),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
