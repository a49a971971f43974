/* Ordinates' grids: where their cells lie, and transmittances in them. */
#include "pop_grid_maker.h"

#include "method/pop/grid/lobe.k.h"

static const double anisotropies[] = {0, 0.5, 0.9, -0.5};

/* ---- geometry ---- */

static void grids_follow_an_axis(void** state) {
    (void)state;
    const ty_grid_box box = {{0, 0, 0}, {1, 1, 1}, {16, 16, 16}};
    for (int a = 0; a < 6; ++a) {
        const double omega[3] = {a / 2 == 0, a / 2 == 1, a / 2 == 2}, sign = a % 2 ? -1 : 1;
        const ty_discrete_light light = parallel_light(sign * omega[0], sign * omega[1], sign * omega[2]);
        ty_pop_grid grid;
        ty_pop_grid_fit(&box, &light, 16, &grid);
        assert_vec_close(grid.step, ty_vec_make(0.0625f, 0.0625f, 0.0625f), 1e-8);
        const ty_vec center = ty_pop_cell_center(&grid, 3, 5, 0);
        const double place[3] = {(double)center.x * 16, (double)center.y * 16, (double)center.z * 16};
        for (int b = 0; b < 3; ++b) assert_close(place[b] - floor(place[b]), 0.5, 1e-5);
        assert_close(place[a / 2], sign > 0 ? 0.5 : 15.5, 1e-5);
    }
}

/* Every corner of the box is in the grid, and every side of the grid meets one. */
static void grids_follow_a_slanted_direction(void** state) {
    (void)state;
    const ty_grid_box box = {{-1, 2, 0}, {1.5, 3, 4}, {16, 16, 16}};
    uint64_t random = 1;
    for (int n = 0; n < 20; ++n) {
        const ty_vec omega = random_unit(&random);
        const ty_discrete_light light = parallel_light((double)omega.x, (double)omega.y, (double)omega.z);
        ty_pop_grid grid;
        ty_pop_grid_fit(&box, &light, 10, &grid);
        assert_vec_close(grid.axis[2], omega, 1e-6);
        const float step[3] = {grid.step.x, grid.step.y, grid.step.z};
        for (int a = 0; a < 3; ++a) {
            assert_close((double)ty_dot(grid.axis[a], grid.axis[(a + 1) % 3]), 0, 1e-6);
            double low = 1e9, high = -1e9;
            for (int corner = 0; corner < 8; ++corner) {
                const ty_vec at = ty_vec_make(corner & 1 ? 1.5f : -1, corner & 2 ? 3 : 2, corner & 4 ? 4 : 0);
                const double along = (double)ty_dot(ty_sub(at, grid.origin), grid.axis[a]);
                low = fmin(low, along);
                high = fmax(high, along);
            }
            assert_close(low, 0, 1e-5);
            assert_close(high, 10 * (double)step[a], 1e-5);
        }
    }
}

static void grids_surround_a_point(void** state) {
    (void)state;
    const ty_grid_box box = {{-1, -1, -1}, {1, 1, 1}, {16, 16, 16}};
    ty_pop_grid grid;
    ty_discrete_light light = point_light(0, 0, 0);
    ty_pop_grid_fit(&box, &light, 20, &grid);
    assert_int_equal(grid.kind, TY_DISCRETE_POINT);
    assert_close((double)ty_pop_radius(&grid, 20), sqrt(3), 1e-4);
    assert_true((double)grid.inner <= 0.0501);
    assert_close((double)grid.growth, sqrt(4 * 3.14159265) / 20, 2e-3);
    light = point_light(1.5, 0, 0);
    ty_pop_grid_fit(&box, &light, 20, &grid);
    assert_int_equal(grid.kind, TY_DISCRETE_POINT);
    assert_close((double)grid.inner, 0.5, 1e-6);
    light = point_light(60, 0, 0);
    ty_pop_grid_fit(&box, &light, 20, &grid);
    assert_int_equal(grid.kind, TY_DISCRETE_DIRECTIONAL);
    assert_vec_close(grid.axis[2], ty_vec_make(-1, 0, 0), 1e-6);
}

/* ---- transmittances ---- */

/* Lengths of a ray within the unit cube. */
static void cube_range(ty_vec origin, ty_vec omega, double range[2]) {
    const float o[3] = {origin.x, origin.y, origin.z}, w[3] = {omega.x, omega.y, omega.z};
    range[0] = -1e9;
    range[1] = 1e9;
    for (int a = 0; a < 3; ++a) {
        if (fabsf(w[a]) < 1e-7f) continue;
        const double t0 = (0 - (double)o[a]) / (double)w[a], t1 = (1 - (double)o[a]) / (double)w[a];
        range[0] = fmax(range[0], fmin(t0, t1));
        range[1] = fmin(range[1], fmax(t0, t1));
    }
}

/* The mean over [from, to] of e^-(sigma t). */
static double mean_decay(double sigma, double from, double to) {
    if (sigma * (to - from) < 1e-7) return exp(-sigma * 0.5 * (from + to));
    return (exp(-sigma * from) - exp(-sigma * to)) / (sigma * (to - from));
}

static void check_cell(const pop_case* c, const double sigma[3], int32_t i, int32_t j, int32_t k, size_t plane) {
    const ty_pop_grid* grid = &c->light.grid;
    const ty_vec center = ty_pop_cell_center(grid, i, j, k), omega = ty_pop_direction(grid, i, j);
    const double length = (double)ty_pop_cell_length(grid, k);
    const double below = grid->kind == TY_DISCRETE_POINT
                             ? (double)ty_pop_radius(grid, (float)k + 0.5f) - (double)ty_pop_radius(grid, (float)k)
                             : 0.5 * length;
    double range[2];
    cube_range(center, omega, range);
    const double start = grid->kind == TY_DISCRETE_POINT ? -(double)ty_pop_radius(grid, (float)k + 0.5f) : -1e9;
    const double enter = fmax(range[0], start), from = fmax(enter, -below), to = fmin(range[1], length - below);
    if (!(to > from)) return;
    const size_t cells = pop_cells(grid);
    const size_t at = (size_t)i + (size_t)grid->size[0] * ((size_t)j + (size_t)grid->size[1] * (size_t)k);
    for (size_t order = 0; order < 3; ++order)
        assert_close((double)c->light.lobes[(3 * plane + order) * cells + at],
                     mean_decay(sigma[order], from - enter, to - enter), 2e-5);
}

static void check_homogeneous(ty_context* context, const ty_discrete_light* ordinate, double g, bool colored) {
    static const float sigma_s[3] = {4, 2, 1}, sigma_a[3] = {0.5f, 0, 3};
    ty_scene* scene = make_scene(context);
    ty_medium_def medium = pop_cube(4, 0.5, g);
    for (int c = 0; c < 3 && colored; ++c) {
        medium.sigma_s[c] = sigma_s[c];
        medium.sigma_a[c] = sigma_a[c];
    }
    check_result(context, ty_scene_add_medium(scene, &medium));
    pop_case made = pop_begin(scene, ordinate, TY_POP_MODE_SPLIT, 16, 1);
    pop_run(&made);
    assert_int_equal(made.light.planes, colored ? 3 : 1);
    const ty_pop_grid* grid = &made.light.grid;
    for (int p = 0; p < made.light.planes; ++p) {
        const double forward_g = fmax(0, g), s = (double)sigma_s[p], t = s + (double)sigma_a[p];
        const double sigma[3] = {t, t - forward_g * s, t - forward_g * forward_g * s};
        for (int32_t k = 0; k < grid->size[2]; ++k)
            for (int32_t j = 0; j < grid->size[1]; ++j)
                for (int32_t i = 0; i < grid->size[0]; ++i) check_cell(&made, sigma, i, j, k, (size_t)p);
    }
    pop_end(&made);
}

static void homogeneous_media_fade_light_exactly(void** state) {
    const ty_discrete_light lights[] = {parallel_light(0, -1, 0), parallel_light(0.4, -1, 0.3),
                                        point_light(0.5, 0.5, 0.5), point_light(0.4, 1.6, 0.3)};
    for (int l = 0; l < 4; ++l)
        for (int g = 0; g < 4; ++g)
            for (int colored = 0; colored < 2; ++colored)
                check_homogeneous(*state, &lights[l], anisotropies[g], colored != 0);
}

/* ---- radiance towards the eye ---- */

/* Legendre moments of a lobe about its axis, times 2 l + 1 left out. */
static void moments_of(double (*lobe)(double mu, const double* p), const double* p, double moment[3]) {
    const int steps = 200000;
    moment[0] = moment[1] = moment[2] = 0;
    for (int i = 0; i < steps; ++i) {
        /* Cosines crowd where lobes peak. */
        const double x = (i + 0.5) / steps, mu = 1 - 2 * x * x, fraction = 2 * 3.14159265358979 * 4 * x / steps;
        const double value = fraction * lobe(mu, p);
        moment[0] += value;
        moment[1] += value * mu;
        moment[2] += value * (1.5 * mu * mu - 0.5);
    }
}

/* p: U, R, S, spread. */
static double scattered_lobe(double mu, const double* p) {
    const float m = (float)mu, spread = (float)p[3];
    return (double)((float)p[0] * ty_pop_hg(m, spread) +
                    ty_forward_lobe(m, (float)p[0], (float)p[1], (float)p[2], spread));
}

/* Scattering sends on g^n of light's l-th moments after n times; what comes in has a_n. */
static void moments_are_those_of_the_lobes(void** state) {
    (void)state;
    static const double gs[] = {0, 1e-4, 0.3, 0.5, 0.9}, depths[] = {0, 1e-6, 0.01, 1, 8};
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j)
            for (int k = 0; k < 3; ++k) {
                const double g = gs[i], spread = g * (1 - 0.3 * k), t = depths[j];
                const double p[4] = {exp(-t), exp(-t * (1 - g)), exp(-t * (1 - g * g)), spread};
                double moment[3];
                moments_of(scattered_lobe, p, moment);
                assert_close(moment[0], p[1], 2e-4);
                assert_close(moment[1], p[1] * spread, 2e-4);
                assert_close(moment[2], p[2] * spread * spread, 2e-4);
            }
}

/* A lobe's part between two cosines, in double and as Eq. 2 has it. */
static double between_cosines(double a, double low, double high) {
    if (fabs(a) < 1e-6) return 0.5 * (high - low);
    const double c = (1 - a * a) / (2 * a);
    return c * (1 / sqrt(1 + a * a - 2 * a * high) - 1 / sqrt(1 + a * a - 2 * a * low));
}

/* p: U, R, S, g, the disc's mean cosine. */
static double disc_lobe(double mu, const double* p) {
    const float m = (float)mu, g = (float)p[3], disc = (float)p[4], width = ty_pop_disc_width(disc);
    const float lobe = ty_pop_disc_lobe(fabsf(g), disc, width);
    const float once = ty_pop_disc_single(m, g, width, lobe, ty_pop_disc_mean(lobe, width));
    const float u = (float)p[0], r = (float)p[1], s = (float)p[2];
    return (double)(u * once + ty_pop_disc_forward(m, u, r, s, g, disc, width, lobe));
}

/* Discs take nothing away, and their fraction of the mean cosine. */
static void discs_scatter_as_they_should(void** state) {
    (void)state;
    static const double gs[] = {-0.8, 0, 1e-4, 0.3, 0.7, 0.9}, depths[] = {0, 1e-6, 0.01, 1, 8},
                        discs[] = {1, 0.999, 0.9, 0.5};
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 5; ++j)
            for (int k = 0; k < 4; ++k) {
                const double g = gs[i], on = fmax(0, g), t = depths[j];
                const double p[5] = {exp(-t), exp(-t * (1 - on)), exp(-t * (1 - on * on)), g, discs[k]};
                double moment[3];
                moments_of(disc_lobe, p, moment);
                assert_close(moment[0], p[1], 3e-4);
                assert_close(moment[1], p[1] * g * discs[k], 0.03 * p[1]);
            }
}

/* The light of lines is no brighter than light from a disc, and has no edge. */
static void a_line_of_light_becomes_a_disc(void** state) {
    (void)state;
    for (int n = 2; n < 100; n *= 2) {
        const double disc = 1 - 1.0 / n, p[5] = {1, 1, 1, 0.9999, disc};
        double before = disc_lobe(1, p);
        assert_close(before * 4 * 3.14159265358979, 4 * n / 3.0, 0.05 * n);
        for (int i = 1; i < 2000; ++i) {
            const double next = disc_lobe(1 - 0.001 * i, p);
            assert_true(next <= 1.005 * before && next >= before - 1e-4 * n * n);
            before = next;
        }
    }
}

static void patches_partition_the_sphere(void** state) {
    (void)state;
    const double c = sqrt(0.5);
    for (int i = -999; i <= 999; ++i) {
        const double a = i / 1000.0;
        float front, side, back;
        ty_pop_patch_fractions((float)a, &front, &side, &back);
        assert_close((double)(front + 4 * side + back), 1, 1e-6);
        assert_close((double)front, between_cosines(a, c, 1), 2e-5);
        assert_close((double)side, 0.25 * between_cosines(a, -c, c), 2e-5);
        assert_close((double)back, between_cosines(a, -1, -c), 2e-5);
    }
}

static ty_scene* scene_of(ty_context* context, const ty_medium_def* medium) {
    ty_scene* scene = make_scene(context);
    check_result(context, ty_scene_add_medium(scene, medium));
    return scene;
}

/* Single scattering of a thin medium towards the eye, and from stored lobes towards another one. */
static void views_add_up_lobes(void** state) {
    const ty_medium_def medium = pop_cube(2, 0.3, 0.7);
    const ty_discrete_light lights[2] = {parallel_light(0.2, -1, 0.4), point_light(0.4, 0.55, 0.6)};
    for (int l = 0; l < 2; ++l) {
        ty_discrete_light light = lights[l];
        light.mean_cosine = 0.9f;
        light.color[1] = 2;
        pop_case first = pop_begin(scene_of(*state, &medium), &light, TY_POP_MODE_SPLIT, 9, 1);
        pop_case second = pop_begin(scene_of(*state, &medium), &light, TY_POP_MODE_SPLIT, 9, 1);
        second.eye[0] = -3;
        pop_run(&first);
        pop_run(&second);
        const float* accumulated = pop_accumulated(&first.light, 4, 5, 6);
        assert_close((double)accumulated[1], 2 * (double)accumulated[0], 1e-6);
        ty_pop_evaluate_lobes(first.medium, second.eye, &first.light);
        const size_t floats = ty_pop_accumulated_floats(&first.light.grid, first.light.floats);
        for (size_t i = 0; i < floats; ++i)
            assert_close((double)first.light.accumulated[i], (double)second.light.accumulated[i], 1e-6);
        pop_end(&first);
        pop_end(&second);
    }
}

/* Against the formula of what a slab of light scatters towards the eye. */
static void views_have_the_value_of_the_lobe(void** state) {
    const double g = 0.6, sigma_s = 3, sigma_a = 1;
    const ty_medium_def medium = pop_cube(sigma_s, sigma_a, g);
    ty_discrete_light light = parallel_light(1, 0, 0);
    light.mean_cosine = 0.8f;
    pop_case made = pop_begin(scene_of(*state, &medium), &light, TY_POP_MODE_SPLIT, 32, 1);
    pop_run(&made);
    for (int32_t k = 0; k < 32; k += 5) {
        const ty_vec at = ty_pop_cell_center(&made.light.grid, 7, 20, k);
        const ty_vec to = ty_normalize(ty_sub(ty_vec_load(made.eye), at));
        const double depth = (double)at.x, t = sigma_s + sigma_a, mu = (double)to.x;
        const double u = exp(-t * depth), r = exp(-(t - g * sigma_s) * depth), s = exp(-(t - g * g * sigma_s) * depth);
        const double p[5] = {u, r, s, g, 0.8}, expected = disc_lobe(mu, p);
        const float* accumulated = pop_accumulated(&made.light, 7, 20, k);
        const double weight = (double)accumulated[TY_POP_CELL_WEIGHT];
        assert_true(weight > 0);
        assert_close((double)accumulated[0], weight * expected, 1e-3 * weight * expected);
        assert_close((double)accumulated[3], weight * r, 1e-3 * weight * r);
    }
    pop_end(&made);
}

/* Directions all around: a point's radiance adds up to what has scattered and keeps its direction. */
static void radiance_is_that_of_the_lobes(void** state) {
    const ty_medium_def medium = pop_cube(2, 0.3, 0.5);
    ty_discrete_light lights[2] = {parallel_light(0.2, -1, 0.4), point_light(0.4, 0.55, 0.6)};
    const ty_vec point = ty_vec_make(0.7f, 0.31f, 0.4f);
    for (int l = 0; l < 2; ++l) {
        lights[l].mean_cosine = 0.9f;
        pop_case made = pop_begin(scene_of(*state, &medium), &lights[l], TY_POP_MODE_SPLIT, 24, 1);
        pop_run(&made);
        ty_vec omega = lights[l].direction;
        double range[2], square = 1;
        if (l == 1) {
            const ty_vec off = ty_sub(point, lights[l].position);
            square = (double)ty_dot(off, off);
            omega = ty_normalize(off);
        }
        cube_range(point, omega, range);
        const double length = l == 1 ? sqrt(square) : -range[0];
        const double u = exp(-2.3 * length) / square, r = exp(-1.3 * length) / square;
        double sum = 0, along = 0;
        const int count = 20000;
        float uncollided[3] = {0, 0, 0};
        for (int i = 0; i < count; ++i) {
            const float z = (float)((i + 0.5) / count * 2 - 1), turn = (float)fmod(i * 0.6180339887498949, 1);
            const ty_vec to = ty_direction_about(ty_vec_make(0, 0, 1), z, turn);
            float radiance[3] = {0, 0, 0};
            ty_pop_light_radiance(made.medium, &made.light, point, to, radiance, i == 0 ? uncollided : NULL);
            assert_close((double)radiance[2], (double)radiance[0], 0);
            sum += (double)radiance[0] * 4 * 3.14159265 / count;
            along += (double)radiance[0] * (double)ty_dot(to, omega) * 4 * 3.14159265 / count;
        }
        assert_close((double)uncollided[0], u, 0.03 * u);
        assert_close(sum, r - u, 0.04 * r);
        assert_close(along, 0.9 * (r - u), 0.04 * r);
        pop_end(&made);
    }
}

/* ---- lights and surfaces ---- */

static void add_wall(ty_scene* scene, double x0, double y, double x1) {
    ty_shape_def wall = quad_shape((const double[3][3]){{x0, y, -5}, {x1 - x0, 0, 0}, {0, 0, 10}});
    check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &wall));
}

/* A wall above half the cube, and one within: light gets up to a surface, unless its shadows are not asked for. */
static void surfaces_cast_shadows(void** state) {
    const ty_medium_def medium = pop_cube(2, 0, 0);
    for (int kind = 0; kind < 3; ++kind) {
        const double heights[2] = {1.2, 0.5};
        for (int inside = 0; inside < 2; ++inside) {
            ty_scene* scene = scene_of(*state, &medium);
            add_wall(scene, -9, heights[inside], 0.5);
            ty_discrete_light light =
                kind == 0 ? parallel_light(0, -1, 0) : point_light(0.5, kind == 1 ? 1.4 : 40, 0.5);
            light.shadowed = 1;
            pop_case made = pop_begin(scene, &light, TY_POP_MODE_SPLIT, 16, 1);
            pop_run(&made);
            const ty_pop_grid* grid = &made.light.grid;
            for (int32_t k = 0; k < 16; ++k)
                for (int32_t j = 0; j < 16; ++j)
                    for (int32_t i = 0; i < 16; ++i) {
                        const ty_vec at = ty_pop_cell_center(grid, i, j, k);
                        const bool beyond = (double)at.y<heights[inside] - 0.2, beside = fabsf(at.x - 0.5f)> 0.4f;
                        if (!beside || fabsf(at.y - 0.5f) > 0.5f || fabsf(at.x - 0.5f) > 0.5f) continue;
                        const float fluence = pop_accumulated(&made.light, i, j, k)[3];
                        if (at.x < 0.5f && beyond)
                            assert_close((double)fluence, 0, 0);
                        else if (at.x > 0.5f || (double)at.y > heights[inside] + 0.2)
                            assert_true(fluence > 0);
                    }
            made.light.ordinate.shadowed = 0;
            pop_run(&made);
            for (int32_t k = 0; k < 16; ++k) assert_true(pop_accumulated(&made.light, 8, 8, k)[3] > 0);
            pop_end(&made);
        }
    }
}

/* A point of a floor far away lights the medium above the floor: its own surface does not shade it. */
static void a_far_floor_does_not_shade_itself(void** state) {
    const ty_medium_def medium = pop_cube(1, 0, 0);
    for (int distance = 2; distance <= 20; distance += 6) {
        ty_scene* scene = scene_of(*state, &medium);
        ty_shape_def floor = quad_shape((const double[3][3]){{-50, -0.5, -50}, {0, 0, 100}, {100, 0, 0}});
        check_result(*state, ty_scene_add_shape(scene, &floor));
        ty_discrete_light light = point_light(distance, -0.5, 0.3);
        light.direction = ty_vec_make(0, 1, 0);
        light.profile = TY_PROFILE_COSINE;
        light.shadowed = 1;
        pop_case made = pop_begin(scene, &light, TY_POP_MODE_SPLIT, 12, 1);
        pop_run(&made);
        for (int32_t k = 0; k < 12; ++k)
            for (int32_t i = 0; i < 144; ++i) {
                const ty_vec at = ty_pop_cell_center(&made.light.grid, i % 12, i / 12, k);
                if (at.y > 0 && at.y < 1) assert_true(pop_accumulated(&made.light, i % 12, i / 12, k)[3] > 0);
            }
        pop_end(&made);
    }
}

static void profiles_follow_the_density(void** state) {
    const ty_medium_def medium = pop_cube(1, 0, 0);
    ty_scene* scene = scene_of(*state, &medium);
    ty_light_def spot = ty_default_light_def();
    spot.kind = TY_LIGHT_SPOT;
    set3(spot.position, 0.5, 0.5, 0.5);
    set3(spot.direction, 0, -1, 0);
    spot.cone = 60;
    check_result(*state, ty_scene_add_light(scene, &spot));
    ty_discrete_light light = point_light(0.5, 0.5, 0.5);
    light.direction = ty_vec_make(0, -1, 0);
    pop_case made = pop_begin(scene, &light, TY_POP_MODE_SPLIT, 16, 1);
    for (int profile = TY_PROFILE_ISOTROPIC; profile <= TY_PROFILE_COSINE; ++profile) {
        made.light.ordinate.profile = profile;
        pop_run(&made);
        for (int32_t j = 0; j < 16; ++j)
            for (int32_t i = 0; i < 16; ++i) {
                const double mu = -(double)ty_pop_direction(&made.light.grid, i, j).y,
                             value = pop_value(&made.light, i, j, 0, 3);
                if (profile == TY_PROFILE_ISOTROPIC) assert_close(value, 1, 0.1);
                if (profile == TY_PROFILE_COSINE) assert_close(value, fmax(0, mu), 0.1 * fmax(0, mu));
                if (profile == TY_PROFILE_SPOT && mu > cos(0.43)) assert_close(value, 1, 0.1);
                if (profile == TY_PROFILE_SPOT && mu < cos(0.53)) assert_close(value, 0, 0);
            }
    }
    pop_end(&made);
}

/* In a parallel grid the light of a point light still falls with distance, and with the medium passed. */
static void parallel_grids_keep_the_fall_with_distance(void** state) {
    const ty_medium_def medium = pop_cube(1, 0, 0);
    const ty_discrete_light light = point_light(0.5, 0.5, -5);
    pop_case made = pop_begin(scene_of(*state, &medium), &light, TY_POP_MODE_SPLIT, 16, 1);
    assert_int_equal(made.light.grid.kind, TY_DISCRETE_DIRECTIONAL);
    pop_run(&made);
    for (int32_t k = 0; k < 16; ++k) {
        const ty_vec at = ty_pop_cell_center(&made.light.grid, 3, 12, k);
        const ty_vec off = ty_sub(at, light.position);
        const double square = (double)ty_dot(off, off);
        assert_close(pop_value(&made.light, 3, 12, k, 3) * square, exp(-(double)at.z), 1e-3);
    }
    pop_end(&made);
}

/* ---- uneven media ---- */

static void check_finite(const pop_case* made) {
    const size_t floats = ty_pop_accumulated_floats(&made->light.grid, made->light.floats);
    for (size_t i = 0; i < floats; ++i) assert_true(fabsf(made->light.accumulated[i]) < 1e9f);
}

/* Emptiness, thick cells, an eye at the center of a cell, all g: numbers stay numbers. */
static void extreme_media_are_finite(void** state) {
    static const double densities[] = {0, 1e-12, 1, 1e4}, gs[] = {-0.999, -0.5, 0, 1e-7, 0.5, 0.999};
    for (int mode = 0; mode < 3; ++mode)
        for (int d = 0; d < 4; ++d)
            for (int g = 0; g < 6; ++g)
                for (int radial = 0; radial < 2; ++radial) {
                    ty_medium_def medium = pop_cube(densities[d], 0, gs[g]);
                    medium.sigma_a[1] = (float)densities[d];
                    medium.density_grid = direct_noise(*state, 8, 8, 8, 3);
                    ty_discrete_light light = radial ? point_light(0.5, 0.5, 0.5) : parallel_light(0, 0, 1);
                    light.color[2] = 0;
                    pop_case made = pop_begin(scene_of(*state, &medium), &light, (ty_pop_mode)mode, 8, 5);
                    const ty_vec center = ty_pop_cell_center(&made.light.grid, 3, 3, 3);
                    memcpy(made.eye, &center, sizeof made.eye);
                    pop_run(&made);
                    check_finite(&made);
                    ty_pop_evaluate_lobes(made.medium, made.eye, &made.light);
                    check_finite(&made);
                    float radiance[3] = {0, 0, 0}, uncollided[3] = {0, 0, 0};
                    ty_pop_light_radiance(made.medium, &made.light, center, ty_pop_direction(&made.light.grid, 3, 3),
                                          radiance, uncollided);
                    for (int c = 0; c < 3; ++c) assert_true(fabsf(radiance[c]) < 1e11f && uncollided[c] < 1e9f);
                    pop_end(&made);
                    ty_grid_release(medium.density_grid);
                }
}

/* One density or several, the same coefficients: the same light. */
static void one_density_serves_all_channels(void** state) {
    ty_medium_def medium = pop_cube(4, 1, 0.5);
    medium.sigma_s[1] = 2;
    medium.density_grid = direct_noise(*state, 8, 8, 8, 5);
    const ty_discrete_light light = parallel_light(0.3, -1, 0.1);
    pop_case made = pop_begin(scene_of(*state, &medium), &light, TY_POP_MODE_SPLIT, 8, 1);
    pop_run(&made);
    const size_t floats = ty_pop_accumulated_floats(&made.light.grid, made.light.floats);
    float* one = malloc(floats * sizeof *one);
    assert_non_null(one);
    memcpy(one, made.light.accumulated, floats * sizeof *one);
    made.medium->g[2][77] += 1e-4f; /* no longer even */
    pop_run(&made);
    for (size_t i = 0; i < floats; ++i) assert_close((double)made.light.accumulated[i], (double)one[i], 2e-4);
    free(one);
    pop_end(&made);
    ty_grid_release(medium.density_grid);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grids_follow_an_axis),
        cmocka_unit_test(grids_follow_a_slanted_direction),
        cmocka_unit_test(grids_surround_a_point),
        cmocka_unit_test(homogeneous_media_fade_light_exactly),
        cmocka_unit_test(moments_are_those_of_the_lobes),
        cmocka_unit_test(discs_scatter_as_they_should),
        cmocka_unit_test(a_line_of_light_becomes_a_disc),
        cmocka_unit_test(patches_partition_the_sphere),
        cmocka_unit_test(views_add_up_lobes),
        cmocka_unit_test(views_have_the_value_of_the_lobe),
        cmocka_unit_test(radiance_is_that_of_the_lobes),
        cmocka_unit_test(surfaces_cast_shadows),
        cmocka_unit_test(a_far_floor_does_not_shade_itself),
        cmocka_unit_test(profiles_follow_the_density),
        cmocka_unit_test(parallel_grids_keep_the_fall_with_distance),
        cmocka_unit_test(extreme_media_are_finite),
        cmocka_unit_test(one_density_serves_all_channels),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
