/* Light that cells of ordinates' grids pass on to their neighbours. */
#include "pop_grid_maker.h"

#include "method/pop/grid/lobe.k.h"

static ty_scene* cube_scene(ty_context* context, double sigma_s, double sigma_a, double g, ty_grid* density) {
    ty_scene* scene = make_scene(context);
    ty_medium_def medium = pop_cube(sigma_s, sigma_a, g);
    medium.density_grid = density;
    check_result(context, ty_scene_add_medium(scene, &medium));
    return scene;
}

/* One of the arrays of stored lobes: 0 what has not scattered, then bands' light and that times its mean cosine. */
static const float* lobe_array(const pop_case* made, size_t number) {
    return made->light.lobes + number * pop_cells(&made->light.grid);
}

static size_t cell_at(const ty_pop_grid* grid, int32_t i, int32_t j, int32_t k) {
    return (size_t)i + (size_t)grid->size[0] * ((size_t)j + (size_t)grid->size[1] * (size_t)k);
}

static double total(const float* values, size_t count) {
    double sum = 0;
    for (size_t i = 0; i < count; ++i) sum += (double)values[i];
    return sum;
}

static double total_left(const pop_case* made) {
    const int32_t* size = made->light.grid.size;
    double sum = 0;
    for (int32_t k = 0; k < size[2]; ++k)
        for (int32_t j = 0; j < size[1]; ++j)
            for (int32_t i = 0; i < size[0]; ++i) sum += (double)pop_accumulated(&made->light, i, j, k)[8];
    return sum;
}

/* ---- energy ---- */

/* Fraction of the cells' light that leaves over the grid's faces. cosines: NULL for the ordinate's own. */
static double leaving(const pop_case* made, const float* light, const float* turned) {
    const ty_pop_grid* grid = &made->light.grid;
    const int32_t n = grid->size[0];
    double sum = 0;
    for (int32_t k = 0; k < n; ++k)
        for (int32_t j = 0; j < n; ++j)
            for (int32_t i = 0; i < n; ++i) {
                const size_t at = cell_at(grid, i, j, k);
                const float a =
                    turned != NULL ? turned[at] / fmaxf(light[at], 1e-30f) : made->light.ordinate.mean_cosine;
                float front, side, back;
                ty_pop_patch_fractions(a, &front, &side, &back);
                double fraction = (double)((k == n - 1 ? front : 0) + (k == 0 ? back : 0));
                if (grid->kind == TY_DISCRETE_DIRECTIONAL)
                    fraction += (double)side * ((i == 0) + (i == n - 1) + (j == 0) + (j == n - 1));
                sum += fraction * (double)light[at];
            }
    return sum;
}

/* Without absorption, what is in the grid and what leaves is what there was. */
static void energy_is_conserved(void** state) {
    ty_grid* noise = direct_noise(*state, 12, 12, 12, 7);
    const ty_discrete_light lights[] = {parallel_light(0, -1, 0), parallel_light(0.5, 1, -0.2),
                                        point_light(0.4, 0.5, 0.6)};
    for (int l = 0; l < 3; ++l)
        for (int g = 0; g < 3; ++g) {
            ty_discrete_light light = lights[l];
            light.mean_cosine = 0.8f;
            const ty_pop_mode mode = TY_POP_MODE_PUBLISHED;
            pop_case made = pop_begin(cube_scene(*state, 4, 0, 0.45 * g, noise), &light, mode, 12, 2);
            const size_t cells = pop_cells(&made.light.grid);
            made.iterations = 1;
            pop_run(&made);
            const double entered = total(lobe_array(&made, 0), cells), first = total_left(&made);
            assert_close(first, entered - leaving(&made, lobe_array(&made, 0), NULL), 1e-5 * entered);
            assert_close(total(lobe_array(&made, 1), cells), first, 1e-5 * entered);
            const double out = leaving(&made, lobe_array(&made, 1), lobe_array(&made, 2));
            assert_true(out > 0.003 * entered);
            made.iterations = 2;
            pop_run(&made);
            assert_close(total_left(&made), first - out, 1e-5 * entered);
            pop_end(&made);
        }
    ty_grid_release(noise);
}

/* Fluence times volume: of what enters the unit cube along an axis, 1 without a medium. */
static void statistics_tell_what_was_done(void** state) {
    const ty_discrete_light light = parallel_light(0, 0, -1);
    pop_case made = pop_begin(cube_scene(*state, 4, 0, 0, NULL), &light, TY_POP_MODE_PUBLISHED, 16, 3);
    pop_run(&made);
    assert_close(made.propagation.initial, 3 * (1 - exp(-4)) / 4, 1e-5);
    assert_close(made.propagation.unpropagated, 3 * total_left(&made) / (16 * 16 * 16), 1e-5);
    pop_end(&made);
}

/* ---- one step ---- */

/* Light that is a line goes to the cell in front, less what is absorbed on the way (Eq. 2). */
static void absorption_fades_light(void** state) {
    const ty_discrete_light light = parallel_light(1, 0, 0);
    pop_case made = pop_begin(cube_scene(*state, 3, 2, 0.5, NULL), &light, TY_POP_MODE_PUBLISHED, 16, 1);
    pop_run(&made);
    const float *before = lobe_array(&made, 0), *after = lobe_array(&made, 1);
    for (int32_t k = 1; k < 16; ++k) {
        const double expected = (double)before[cell_at(&made.light.grid, 4, 5, k - 1)] * exp(-2.0 / 16);
        assert_close((double)after[cell_at(&made.light.grid, 4, 5, k)], expected, 1e-5 * expected);
    }
    pop_end(&made);
}

/* Eq. 4, and exactly; with channels that differ. */
static void cosines_fall_as_published(void** state) {
    static const double gs[] = {0, 0.5, 0.9};
    for (int i = 0; i < 3; ++i)
        for (int mode = TY_POP_MODE_PUBLISHED; mode <= TY_POP_MODE_COLLIDED; ++mode) {
            ty_scene* scene = make_scene(*state);
            ty_medium_def medium = pop_cube(3, 0, gs[i]);
            medium.sigma_s[2] = 6;
            check_result(*state, ty_scene_add_medium(scene, &medium));
            ty_discrete_light light = parallel_light(0, 1, 0);
            light.mean_cosine = 0.9f;
            pop_case made = pop_begin(scene, &light, (ty_pop_mode)mode, 10, 1);
            pop_run(&made);
            assert_int_equal(made.light.planes, 3);
            for (size_t p = 0; p < 3; p += 2) {
                const double sigma = p == 2 ? 6 : 3;
                const bool collided = mode == TY_POP_MODE_COLLIDED;
                const size_t at = cell_at(&made.light.grid, 3, 4, 5);
                /* In mode collided the band has what light starts from, too. */
                const double start = collided ? sigma * 0.1 * (double)lobe_array(&made, 3 * p)[at] : 0;
                const double passed = (double)lobe_array(&made, 3 * p + 1)[at] - start;
                const double first = collided ? 0.9 * gs[i] : 0.9;
                const double turned = (double)lobe_array(&made, 3 * p + 2)[at] - start * first;
                const double keep = collided ? exp(-sigma * (1 - gs[i]) * 0.1) : pow(gs[i], sigma * 0.1);
                assert_close(turned / passed, first * keep, 2e-5);
            }
            pop_end(&made);
        }
}

/* ---- what comes of it ---- */

/* Fluence and radiance towards the eye are sums over iterations; stored lobes give them for another eye. */
static void fluence_and_radiance_are_sums_over_iterations(void** state) {
    const ty_discrete_light lights[2] = {parallel_light(0.3, -1, 0.2), point_light(0.3, 0.4, 0.55)};
    for (int l = 0; l < 2; ++l)
        for (int mode = TY_POP_MODE_PUBLISHED; mode <= TY_POP_MODE_COLLIDED; ++mode) {
            ty_discrete_light light = lights[l];
            light.mean_cosine = 0.9f;
            light.color[1] = 3;
            pop_case made = pop_begin(cube_scene(*state, 2, 0.5, 0.6, NULL), &light, (ty_pop_mode)mode, 8, 2);
            pop_case other = pop_begin(cube_scene(*state, 2, 0.5, 0.6, NULL), &light, (ty_pop_mode)mode, 8, 2);
            pop_run(&made);
            pop_run(&made); /* whatever was there before */
            other.eye[0] = 4;
            pop_run(&other);
            for (int32_t k = 0; k < 8; ++k) {
                const size_t at = cell_at(&made.light.grid, 2, 6, k);
                double sum = (double)lobe_array(&made, 0)[at];
                for (size_t band = 0; band < 2; ++band) sum += (double)lobe_array(&made, 1 + 2 * band)[at];
                assert_close((double)pop_accumulated(&made.light, 2, 6, k)[3], sum, 1e-5 * sum);
                assert_close((double)pop_accumulated(&made.light, 2, 6, k)[4], 3 * sum, 3e-5 * sum);
            }
            ty_pop_evaluate_lobes(made.medium, other.eye, &made.light);
            double worst = 0, most = 0;
            for (size_t i = 0; i < ty_pop_accumulated_floats(&made.light.grid, made.light.floats); ++i) {
                if (i % (size_t)made.light.floats >= 3) continue; /* what another eye sees */
                worst = fmax(worst, fabs((double)made.light.accumulated[i] - (double)other.light.accumulated[i]));
                most = fmax(most, (double)other.light.accumulated[i]);
            }
            /* In mode collided two cosines are in the first band. */
            assert_close(worst, 0, mode == TY_POP_MODE_COLLIDED ? 0.01 * most : 2e-5 * most);
            pop_end(&made);
            pop_end(&other);
        }
}

/* Radiance at a point adds up, over directions, to the fluence of what has scattered. */
static void radiance_adds_up_to_fluence(void** state) {
    ty_discrete_light light = parallel_light(0, -1, 0);
    light.mean_cosine = 0.9f;
    pop_case made = pop_begin(cube_scene(*state, 2, 0, 0.6, NULL), &light, TY_POP_MODE_PUBLISHED, 8, 9);
    pop_run(&made);
    assert_int_equal(made.light.bands, 5);
    const ty_vec point = ty_pop_cell_center(&made.light.grid, 3, 4, 5);
    const float* seen = pop_accumulated(&made.light, 3, 4, 5);
    float uncollided[3] = {0, 0, 0};
    double sum = 0;
    const int count = 5000;
    for (int i = 0; i < count; ++i) {
        const float z = (float)((i + 0.5) / count * 2 - 1), turn = (float)fmod(i * 0.6180339887498949, 1);
        float radiance[3] = {0, 0, 0};
        ty_pop_light_radiance(made.medium, &made.light, point, ty_direction_about(ty_vec_make(0, 1, 0), z, turn),
                              radiance, i == 0 ? uncollided : NULL);
        sum += (double)radiance[0] * 4 * 3.14159265 / count;
    }
    assert_close(sum + (double)uncollided[0], (double)seen[3], 1e-3 * (double)seen[3]);
    pop_end(&made);
}

/* A lamp at the center lights a shell alike all around, over the map's edges too. */
static void a_point_light_lights_shells_alike(void** state) {
    for (int mode = 0; mode < 3; ++mode) {
        const ty_discrete_light light = point_light(0.5, 0.5, 0.5);
        pop_case made = pop_begin(cube_scene(*state, 4, 0, 0.5, NULL), &light, (ty_pop_mode)mode, 16, 12);
        pop_run(&made);
        const ty_pop_grid* grid = &made.light.grid;
        for (int32_t k = 0; k < 16 && (double)ty_pop_radius(grid, (float)(k + 2)) < 0.5; ++k) {
            double low = 1e9, high = 0;
            for (int32_t j = -1; j <= 16; ++j)
                for (int32_t i = -1; i <= 16; ++i) {
                    const double value = (double)pop_accumulated(&made.light, i, j, k)[3];
                    low = fmin(low, value);
                    high = fmax(high, value);
                }
            assert_true(low > 0 && high < 1.04 * low);
        }
        pop_end(&made);
    }
}

/* Eq. 10. */
static void lengths_follow_the_mean_cosine(void** state) {
    const ty_discrete_light light = parallel_light(0, -1, 0);
    pop_case made = pop_begin(cube_scene(*state, 1, 0, 0.95, NULL), &light, TY_POP_MODE_PUBLISHED, 16, 1);
    made.def.residuum = 0.1;
    assert_int_equal(ty_pop_iteration_count(&made.def, made.medium, 1, 0.25f), (int)ceil(log(0.1) / log(0.95) / 0.25));
    assert_int_equal(ty_pop_iteration_count(&made.def, made.medium, 1, 30), 16);
    made.def.mode = TY_POP_MODE_COLLIDED;
    assert_int_equal(ty_pop_iteration_count(&made.def, made.medium, 0.5f, 0.25f), (int)ceil(log(5) / 0.05 / 0.25));
    made.def.residuum = 0;
    assert_int_equal(ty_pop_iteration_count(&made.def, made.medium, 1, 0.25f), 16);
    pop_end(&made);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(energy_is_conserved),
        cmocka_unit_test(statistics_tell_what_was_done),
        cmocka_unit_test(absorption_fades_light),
        cmocka_unit_test(cosines_fall_as_published),
        cmocka_unit_test(fluence_and_radiance_are_sums_over_iterations),
        cmocka_unit_test(radiance_adds_up_to_fluence),
        cmocka_unit_test(a_point_light_lights_shells_alike),
        cmocka_unit_test(lengths_follow_the_mean_cosine),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
