/* Ordinates' grids: where their cells lie, and transmittances in them. */
#include "pop_grid_maker.h"

#include "method/pop/lobe.k.h"

static const double anisotropies[] = {0, 0.5, 0.9, -0.5};

/* ---- frames ---- */

static void test_axis_frame(void** state) {
    (void)state;
    const ty_grid_box box = {{0, 0, 0}, {1, 1, 1}, {16, 16, 16}};
    for (int a = 0; a < 6; ++a) {
        const double way[3] = {a / 2 == 0, a / 2 == 1, a / 2 == 2}, sign = a % 2 ? -1 : 1;
        const ty_pop_ordinate light = parallel_light(sign * way[0], sign * way[1], sign * way[2]);
        ty_pop_frame frame;
        ty_pop_frame_fit(&box, &light, 16, &frame);
        assert_vec_close(frame.step, ty_vec_make(0.0625f, 0.0625f, 0.0625f), 1e-8);
        const ty_vec middle = ty_pop_middle(&frame, 3, 5, 0);
        const double place[3] = {(double)middle.x * 16, (double)middle.y * 16, (double)middle.z * 16};
        for (int b = 0; b < 3; ++b) assert_close(place[b] - floor(place[b]), 0.5, 1e-5);
        assert_close(place[a / 2], sign > 0 ? 0.5 : 15.5, 1e-5);
    }
}

/* Every corner of the box is in the grid, and every side of the grid meets one. */
static void test_slanted_frame(void** state) {
    (void)state;
    const ty_grid_box box = {{-1, 2, 0}, {1.5, 3, 4}, {16, 16, 16}};
    uint64_t random = 1;
    for (int n = 0; n < 20; ++n) {
        const ty_vec way = random_unit(&random);
        const ty_pop_ordinate light = parallel_light((double)way.x, (double)way.y, (double)way.z);
        ty_pop_frame frame;
        ty_pop_frame_fit(&box, &light, 10, &frame);
        assert_vec_close(frame.axis[2], way, 1e-6);
        const float step[3] = {frame.step.x, frame.step.y, frame.step.z};
        for (int a = 0; a < 3; ++a) {
            assert_close((double)ty_dot(frame.axis[a], frame.axis[(a + 1) % 3]), 0, 1e-6);
            double low = 1e9, high = -1e9;
            for (int corner = 0; corner < 8; ++corner) {
                const ty_vec at = ty_vec_make(corner & 1 ? 1.5f : -1, corner & 2 ? 3 : 2, corner & 4 ? 4 : 0);
                const double along = (double)ty_dot(ty_sub(at, frame.origin), frame.axis[a]);
                low = fmin(low, along);
                high = fmax(high, along);
            }
            assert_close(low, 0, 1e-5);
            assert_close(high, 10 * (double)step[a], 1e-5);
        }
    }
}

static void test_radial_frame(void** state) {
    (void)state;
    const ty_grid_box box = {{-1, -1, -1}, {1, 1, 1}, {16, 16, 16}};
    ty_pop_frame frame;
    ty_pop_ordinate light = point_light(0, 0, 0);
    ty_pop_frame_fit(&box, &light, 20, &frame);
    assert_int_equal(frame.kind, TY_POP_RADIAL);
    assert_close((double)ty_pop_radius(&frame, 20), sqrt(3), 1e-4);
    assert_true((double)frame.inner <= 0.0501);
    assert_close((double)frame.growth, sqrt(4 * 3.14159265) / 20, 2e-3);
    light = point_light(1.5, 0, 0);
    ty_pop_frame_fit(&box, &light, 20, &frame);
    assert_int_equal(frame.kind, TY_POP_RADIAL);
    assert_close((double)frame.inner, 0.5, 1e-6);
    light = point_light(60, 0, 0);
    ty_pop_frame_fit(&box, &light, 20, &frame);
    assert_int_equal(frame.kind, TY_POP_PARALLEL);
    assert_vec_close(frame.axis[2], ty_vec_make(-1, 0, 0), 1e-6);
}

/* ---- transmittances ---- */

/* Lengths of a ray within the unit cube. */
static void cube_range(ty_vec origin, ty_vec way, double range[2]) {
    const float o[3] = {origin.x, origin.y, origin.z}, w[3] = {way.x, way.y, way.z};
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
    const ty_pop_frame* frame = &c->light.frame;
    const ty_vec middle = ty_pop_middle(frame, i, j, k), way = ty_pop_way(frame, i, j);
    const double length = (double)ty_pop_length(frame, k);
    const double below = frame->kind == TY_POP_RADIAL
                             ? (double)ty_pop_radius(frame, (float)k + 0.5f) - (double)ty_pop_radius(frame, (float)k)
                             : 0.5 * length;
    double range[2];
    cube_range(middle, way, range);
    const double start = frame->kind == TY_POP_RADIAL ? -(double)ty_pop_radius(frame, (float)k + 0.5f) : -1e9;
    const double enter = fmax(range[0], start), from = fmax(enter, -below), to = fmin(range[1], length - below);
    if (!(to > from)) return;
    const size_t cells = pop_cells(frame);
    const size_t at = (size_t)i + (size_t)frame->size[0] * ((size_t)j + (size_t)frame->size[1] * (size_t)k);
    for (size_t order = 0; order < 3; ++order)
        assert_close((double)c->light.lobes[(3 * plane + order) * cells + at],
                     mean_decay(sigma[order], from - enter, to - enter), 2e-5);
}

static void check_homogeneous(ty_context* context, const ty_pop_ordinate* ordinate, double g, bool colored) {
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
    const ty_pop_frame* frame = &made.light.frame;
    for (int p = 0; p < made.light.planes; ++p) {
        const double kept = fmax(0, g), s = (double)sigma_s[p], t = s + (double)sigma_a[p];
        const double sigma[3] = {t, t - kept * s, t - kept * kept * s};
        for (int32_t k = 0; k < frame->size[2]; ++k)
            for (int32_t j = 0; j < frame->size[1]; ++j)
                for (int32_t i = 0; i < frame->size[0]; ++i) check_cell(&made, sigma, i, j, k, (size_t)p);
    }
    pop_end(&made);
}

static void test_homogeneous(void** state) {
    const ty_pop_ordinate lights[] = {parallel_light(0, -1, 0), parallel_light(0.4, -1, 0.3),
                                      point_light(0.5, 0.5, 0.5), point_light(0.4, 1.6, 0.3)};
    for (int l = 0; l < 4; ++l)
        for (int g = 0; g < 4; ++g)
            for (int colored = 0; colored < 2; ++colored)
                check_homogeneous(*state, &lights[l], anisotropies[g], colored != 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_axis_frame),
        cmocka_unit_test(test_slanted_frame),
        cmocka_unit_test(test_radial_frame),
        cmocka_unit_test(test_homogeneous),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
