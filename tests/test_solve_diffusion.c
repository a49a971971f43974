/* The diffusion solvers against solutions in closed form. */
#include "diffusion_maker.h"

#include "solve/diffusion/limiter.k.h"

#define PI 3.14159265358979323846

/* ---- classical diffusion in a medium whose extinction varies ---- */

static double wave(const double at[3]) {
    return 2 + sin(PI * at[0] + 0.3) * sin(PI * at[1] + 0.2) * cos(PI * at[2] + 0.4);
}

static void fill_wave(problem* p, size_t i, const double at[3]) {
    const double sigma = 2 + at[0], d = 1 / (3 * sigma), slope = -d / sigma, absorption = 0.5 + at[1];
    const double laplacian = -3 * PI * PI * (wave(at) - 2);
    const double along = PI * cos(PI * at[0] + 0.3) * sin(PI * at[1] + 0.2) * cos(PI * at[2] + 0.4);
    p->extinction[i] = (float)sigma;
    p->absorption[i] = (float)absorption;
    p->source[i] = (float)(absorption * wave(at) - d * laplacian - slope * along);
}

/* Rms error with n cells along x; the box is a cube of 1 m. */
static double wave_error(ty_context* context, int32_t n, ty_diffusion_solver solver) {
    problem p = make_problem(n, n + 1, n - 1, 1, 1);
    p.def.cell[1] = 1.0 / (n + 1);
    p.def.cell[2] = 1.0 / (n - 1);
    p.def.limiter = TY_LIMITER_NONE;
    p.def.solver = solver;
    p.def.relaxation = 1.7;
    float* values[6];
    set_faces(&p, values, wave);
    fill_problem(&p, fill_wave);
    solve_problem(context, &p);
    double sum = 0;
    for (int32_t z = 0; z < n - 1; ++z)
        for (int32_t y = 0; y < n + 1; ++y)
            for (int32_t x = 0; x < n; ++x) {
                const double at[3] = {(x + 0.5) * p.def.cell[0], (y + 0.5) * p.def.cell[1], (z + 0.5) * p.def.cell[2]};
                const double error = (double)p.fluence[cell_index(&p, x, y, z)] - wave(at);
                sum += error * error;
            }
    for (int side = 0; side < 6; ++side) free(values[side]);
    free_problem(&p);
    return sqrt(sum / (n * (n + 1.0) * (n - 1.0)));
}

static void errors_fall_with_the_square_of_the_cell(void** state) {
    const double coarse = wave_error(*state, 8, TY_DIFFUSION_MULTIGRID);
    const double middle = wave_error(*state, 16, TY_DIFFUSION_MULTIGRID);
    const double fine = wave_error(*state, 32, TY_DIFFUSION_MULTIGRID);
    assert_true(fine < 1e-3);
    assert_close(log2(coarse / middle), 2, 0.25);
    assert_close(log2(middle / fine), 2, 0.25);
    assert_close(wave_error(*state, 16, TY_DIFFUSION_SOR), middle, 1e-4 * middle);
}

/* ---- every limiter: phi = e^(-k x) has the same R everywhere ---- */

enum { RATE = 6 };

static double decay(const double at[3]) {
    return exp(-RATE * at[0]);
}

/* The largest relative error with n cells along x. */
static double decay_error(ty_context* context, int32_t n, ty_limiter limiter) {
    problem p = make_problem(n, 3, 2, 1, 2);
    const double f = (double)ty_limiter_value((int32_t)limiter, 3, RATE / 2.0f), d = f / 2;
    for (size_t i = 0; i < p.cells; ++i) p.absorption[i] = (float)(d * RATE * RATE);
    set_boundaries(&p, TY_BOUNDARY_REFLECTING);
    p.def.limiter = limiter;
    p.def.larsen_power = 3;
    float* values[2];
    for (int side = 0; side < 2; ++side) {
        values[side] = face_values(&p, side, decay);
        p.def.boundary[side] = (ty_boundary){.kind = TY_BOUNDARY_DIRICHLET, .value = values[side]};
    }
    solve_problem(context, &p);
    double largest = 0;
    for (int32_t x = 0; x < n; ++x) {
        const double at[3] = {(x + 0.5) / n, 0, 0};
        largest = fmax(largest, fabs((double)p.fluence[cell_index(&p, x, 1, 0)] / decay(at) - 1));
    }
    for (int side = 0; side < 2; ++side) free(values[side]);
    free_problem(&p);
    return largest;
}

static void limited_diffusion_keeps_its_slope(void** state) {
    for (ty_limiter limiter = 0; limiter < TY_LIMITER_COUNT; ++limiter) {
        const double coarse = decay_error(*state, 32, limiter), fine = decay_error(*state, 64, limiter);
        if (!(fine < 0.02 && coarse / fine > 2.5)) fail_msg("limiter %d: %g, %g", (int)limiter, coarse, fine);
    }
}

/* ---- light that comes in through a slab: E = 4 J / (4 + 3 sigma L), on any grid ---- */

static void slab_lets_through_what_it_should(void** state) {
    static const int32_t sizes[] = {1, 2, 5, 40};
    for (int i = 0; i < 4; ++i) {
        problem p = make_problem(sizes[i], 1, 1, 2, 5);
        const float incoming[1] = {3};
        float flux[41];
        set_boundaries(&p, TY_BOUNDARY_REFLECTING);
        p.def.boundary[0] = (ty_boundary){.kind = TY_BOUNDARY_MARSHAK, .value = incoming};
        p.def.boundary[1] = (ty_boundary){.kind = TY_BOUNDARY_MARSHAK};
        p.def.limiter = TY_LIMITER_NONE;
        p.out.flux[0] = flux;
        solve_problem(*state, &p);
        for (int32_t x = 0; x <= sizes[i]; ++x) assert_close((double)flux[x], 4 * 3.0 / (4 + 3 * 5 * 2), 1e-5);
        free_problem(&p);
    }
}

/* ---- a point of light in an endless medium, from its fluence on the box's faces ---- */

static double point_albedo;

static double point(const double at[3]) {
    const double x = at[0] - 0.5, y = at[1] - 0.5, z = at[2] - 0.5, tau = 4 * sqrt(x * x + y * y + z * z);
    return 3 * 16 / (4 * PI) * exp(-sqrt(3 * (1 - point_albedo)) * tau) / tau;
}

static void check_point(ty_context* context, int32_t n, double albedo) {
    point_albedo = albedo;
    problem p = make_problem(n, n, n, 1, 4);
    float* values[6];
    set_faces(&p, values, point);
    for (size_t i = 0; i < p.cells; ++i) p.absorption[i] = (float)(4 * (1 - albedo));
    p.source[cell_index(&p, n / 2, n / 2, n / 2)] = (float)n * (float)n * (float)n;
    p.def.limiter = TY_LIMITER_NONE;
    solve_problem(context, &p);
    for (int32_t x = 0; x < n / 2 - 5; ++x) {
        const double at[3] = {(x + 0.5) / n, 0.5, 0.5};
        const double expected = point(at);
        assert_close((double)p.fluence[cell_index(&p, x, n / 2, n / 2)], expected, 0.03 * expected);
    }
    for (int side = 0; side < 6; ++side) free(values[side]);
    free_problem(&p);
}

static void point_source_matches_its_greens_function(void** state) {
    for (int i = 0; i <= 2; ++i) check_point(*state, 63, 0.5 * i);
}

/* Near the point FLD streams: phi r^2 is level, where diffusion's phi r is. */
static void limited_light_falls_with_the_square_of_distance(void** state) {
    problem p = make_problem(41, 41, 41, 1, 1);
    p.source[cell_index(&p, 20, 20, 20)] = 41.0f * 41 * 41;
    set_boundaries(&p, TY_BOUNDARY_DIRICHLET);
    solve_problem(*state, &p);
    const double near = (double)p.fluence[cell_index(&p, 24, 20, 20)],
                 far = (double)p.fluence[cell_index(&p, 30, 20, 20)];
    const double power = log(near / far) / log(10.0 / 4);
    if (!(power > 1.7 && power < 2.2)) fail_msg("power %g", power);
    free_problem(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_fall_with_the_square_of_the_cell),
        cmocka_unit_test(limited_diffusion_keeps_its_slope),
        cmocka_unit_test(slab_lets_through_what_it_should),
        cmocka_unit_test(point_source_matches_its_greens_function),
        cmocka_unit_test(limited_light_falls_with_the_square_of_distance),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
