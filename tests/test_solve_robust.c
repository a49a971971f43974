/* Invariants of any medium, size and solver: energy, the flux limit, one answer from all. */
#include "diffusion_maker.h"
#include "effort.h"

static ty_diffusion_stats solve_into(ty_context* context, problem* p, float* fluence) {
    p->out.fluence = fluence;
    solve_problem(context, p);
    return p->stats;
}

static void assert_energy(const problem* p) {
    assert_close(p->stats.absorbed + p->stats.leaving, p->stats.emitted, 1e-3 * p->stats.emitted);
    assert_true(p->stats.emitted > 0);
}

/* A lumpy ball, of a tenth of its extinction absorbing, in vacuum. */
static void fill_cloud(problem* p, size_t i, const double at[3]) {
    const double x = at[0] - 0.5, y = at[1] - 0.5, z = at[2] - 0.5;
    const double surface = 0.35 + 0.08 * sin(20 * at[0]) * sin(17 * at[1]) * sin(23 * at[2]);
    const bool inside = x * x + y * y + z * z < surface * surface;
    p->extinction[i] = inside ? 20 : 0;
    p->absorption[i] = inside ? 2 : 0;
    p->source[i] = inside ? (float)(20 + 10 * sin(31 * at[0])) : 0;
}

/* Light from below the x axis into a medium of 4/m. */
static void fill_beam(problem* p, size_t i, const double at[3]) {
    p->extinction[i] = 4;
    p->source[i] = (float)(4 * exp(-4 * at[0]));
}

/* Blocks of 10^4/m and 10^-2/m in turn. */
static void fill_blocks(problem* p, size_t i, const double at[3]) {
    const bool dense = (((int)(at[0] * 4) + (int)(at[1] * 4) + (int)(at[2] * 4)) & 1) != 0;
    p->extinction[i] = dense ? 1e4f : 1e-2f;
    p->absorption[i] = dense ? 1 : 0;
    p->source[i] = dense ? 1 : 0;
}

typedef struct medium_case {
    void (*fill)(problem* p, size_t i, const double at[3]);
    ty_limiter limiter;
    ty_boundary_kind boundary;
    int32_t size[3];
    double streaming;
} medium_case;

static const medium_case cases[] = {
    {fill_beam, TY_LIMITER_LEVERMORE_POMRANING, TY_BOUNDARY_MARSHAK, {16, 16, 16}, 1},
    {fill_beam, TY_LIMITER_KERSHAW, TY_BOUNDARY_MARSHAK, {33, 17, 9}, 1},
    {fill_beam, TY_LIMITER_LARSEN, TY_BOUNDARY_MARSHAK, {1, 12, 7}, 1},
    {fill_beam, TY_LIMITER_SUM, TY_BOUNDARY_MARSHAK, {12, 1, 1}, 1},
    {fill_beam, TY_LIMITER_LEVERMORE_POMRANING, TY_BOUNDARY_MARSHAK, {139, 3, 4}, 1},
    {fill_beam, TY_LIMITER_NONE, TY_BOUNDARY_MARSHAK, {1, 1, 1}, 1},
    {fill_beam, TY_LIMITER_NONE, TY_BOUNDARY_MARSHAK, {31, 2, 19}, 1},
    {fill_cloud, TY_LIMITER_LEVERMORE_POMRANING, TY_BOUNDARY_DIRICHLET, {16, 16, 16}, 1},
    {fill_cloud, TY_LIMITER_MAX, TY_BOUNDARY_DIRICHLET, {15, 16, 17}, 1},
    {fill_cloud, TY_LIMITER_LEVERMORE_POMRANING, TY_BOUNDARY_MARSHAK, {15, 14, 13}, 0.5},
    {fill_cloud, TY_LIMITER_NONE, TY_BOUNDARY_DIRICHLET, {16, 16, 16}, 1},
    {fill_blocks, TY_LIMITER_NONE, TY_BOUNDARY_MARSHAK, {8, 8, 8}, 1},
};
enum { CASES = sizeof cases / sizeof *cases };

static problem make_case(const medium_case* c) {
    problem p = make_problem(c->size[0], c->size[1], c->size[2], 1, 1);
    for (int axis = 0; axis < 3; ++axis) p.def.cell[axis] = 1.0 / c->size[axis];
    fill_problem(&p, c->fill);
    set_boundaries(&p, c->boundary);
    p.def.limiter = c->limiter;
    p.def.streaming = c->streaming;
    return p;
}

static void solvers_agree(void** state) {
    for (int i = 0; i < CASES; ++i) {
        problem p = make_case(&cases[i]);
        float* other = make_floats(p.cells);
        p.def.tolerance = 1e-7;
        solve_into(*state, &p, p.fluence);
        assert_energy(&p);
        p.def.solver = TY_DIFFUSION_SOR;
        p.def.relaxation = cases[i].fill == fill_blocks ? 1.95 : 1.3;
        solve_into(*state, &p, other);
        assert_energy(&p);
        const double difference = largest_difference(p.fluence, p.out.fluence, p.cells);
        if (!(difference < 1e-5)) fail_msg("case %d: %g", i, difference);
        free(other);
        free_problem(&p);
    }
}

static void jumps_of_a_million_take_few_cycles(void** state) {
    problem p = make_case(&(medium_case){fill_blocks, TY_LIMITER_NONE, TY_BOUNDARY_MARSHAK, {41, 40, 39}, 1});
    solve_into(*state, &p, p.fluence);
    assert_energy(&p);
    assert_true(p.stats.cycles <= 30);
    free_problem(&p);
}

static void cycles_do_not_grow_with_cells(void** state) {
    static const int32_t sizes[] = {20, 41, 80};
    for (int i = 0; i < 3; ++i) {
        const int32_t n = sizes[i];
        problem p = make_case(&(medium_case){fill_beam, TY_LIMITER_NONE, TY_BOUNDARY_MARSHAK, {n, n, n}, 1});
        solve_into(*state, &p, p.fluence);
        assert_true(p.stats.cycles <= 12);
        assert_true(p.stats.work < 100);
        free_problem(&p);
    }
}

static int32_t iterations_of(ty_context* context, const medium_case* c, double tolerance) {
    problem p = make_case(c);
    p.def.tolerance = tolerance;
    solve_into(context, &p, p.fluence);
    const int32_t iterations = p.stats.iterations;
    assert_energy(&p);
    free_problem(&p);
    return iterations;
}

/* Light that streams is what Picard iterations alone hardly touch. */
static void limited_problems_take_few_iterations(void** state) {
    skip_under_sanitizers();
    static const int32_t sizes[] = {24, 33, 48};
    for (int i = 0; i < 3; ++i) {
        const int32_t n = sizes[i];
        const medium_case beam = {fill_beam, TY_LIMITER_LEVERMORE_POMRANING, TY_BOUNDARY_MARSHAK, {n, n, n}, 1};
        const medium_case slow = {fill_cloud, TY_LIMITER_LEVERMORE_POMRANING, TY_BOUNDARY_MARSHAK, {n, n, n}, 0.5};
        const medium_case fast = {fill_cloud, TY_LIMITER_LEVERMORE_POMRANING, TY_BOUNDARY_DIRICHLET, {n, n, n}, 1};
        assert_true(iterations_of(*state, &beam, 1e-6) <= 5);
        assert_true(iterations_of(*state, &slow, 1e-4) <= 16);
        assert_true(iterations_of(*state, &fast, 1e-4) <= 16);
    }
}

/* In light that streams with about what the faces let through, too, which is steepest beside them. */
static void iterations_hardly_grow_with_cells(void** state) {
    skip_under_sanitizers();
    static const int32_t sizes[] = {20, 40, 80};
    for (int i = 0; i < 3; ++i) {
        const int32_t n = sizes[i];
        const medium_case slow = {fill_beam, TY_LIMITER_LEVERMORE_POMRANING, TY_BOUNDARY_MARSHAK, {n, n, n}, 0.55};
        const medium_case fast = {fill_beam, TY_LIMITER_LEVERMORE_POMRANING, TY_BOUNDARY_MARSHAK, {n, n, n}, 1};
        assert_true(iterations_of(*state, &slow, 1e-6) <= 6);
        assert_true(iterations_of(*state, &fast, 1e-6) <= 4);
    }
}

/* Here coarser boxes and sweeps do harm, and the solver must notice. */
static void plain_iterations_are_fallen_back_to(void** state) {
    iterations_of(*state, &(medium_case){fill_blocks, TY_LIMITER_KERSHAW, TY_BOUNDARY_MARSHAK, {16, 16, 16}, 1}, 1e-6);
    iterations_of(*state, &(medium_case){fill_cloud, TY_LIMITER_MAX, TY_BOUNDARY_MARSHAK, {24, 24, 24}, 1}, 1e-6);
    iterations_of(
        *state, &(medium_case){fill_cloud, TY_LIMITER_LEVERMORE_POMRANING, TY_BOUNDARY_MARSHAK, {40, 40, 40}, 1}, 1e-6);
}

/* D |grad phi| of a cell, by central differences. */
static double cell_flux(const problem* p, int32_t x, int32_t y, int32_t z) {
    double square = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int32_t dx = axis == 0, dy = axis == 1, dz = axis == 2;
        const double slope = (double)p->fluence[cell_index(p, x + dx, y + dy, z + dz)] -
                             (double)p->fluence[cell_index(p, x - dx, y - dy, z - dz)];
        square += slope * slope / (4 * p->def.cell[axis] * p->def.cell[axis]);
    }
    return sqrt(square) * (double)p->diffusivity[cell_index(p, x, y, z)];
}

static void flux_never_exceeds_fluence(void** state) {
    for (ty_limiter limiter = TY_LIMITER_SUM; limiter < TY_LIMITER_COUNT; ++limiter) {
        const double streaming = limiter == TY_LIMITER_KERSHAW ? 0.5 : 1;
        problem p = make_case(&(medium_case){fill_cloud, limiter, TY_BOUNDARY_DIRICHLET, {20, 21, 22}, streaming});
        p.def.tolerance = 1e-3;
        solve_into(*state, &p, p.fluence);
        for (int32_t z = 1; z < 21; ++z)
            for (int32_t y = 1; y < 20; ++y)
                for (int32_t x = 1; x < 19; ++x) {
                    const double fluence = (double)p.fluence[cell_index(&p, x, y, z)];
                    assert_true(fluence > 0 && cell_flux(&p, x, y, z) <= streaming * fluence * (1 + 1e-5));
                }
        free_problem(&p);
    }
}

/* The flux into each cell is its absorption less its source, and all of the flux is in the balance. */
static void fluxes_balance_in_every_cell(void** state) {
    problem p = make_case(&(medium_case){fill_beam, TY_LIMITER_LEVERMORE_POMRANING, TY_BOUNDARY_MARSHAK, {9, 8, 7}, 1});
    float *fx = make_floats(10 * 8 * 7), *fy = make_floats(9 * 9 * 7), *fz = make_floats(9 * 8 * 8);
    p.out.flux[0] = fx;
    p.out.flux[1] = fy;
    p.out.flux[2] = fz;
    p.def.tolerance = 1e-7;
    for (size_t i = 0; i < p.cells; ++i) p.absorption[i] = 0.3f;
    solve_into(*state, &p, p.fluence);
    for (int z = 0; z < 7; ++z)
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 9; ++x) {
                const float *ax = fx + (z * 8 + y) * 10 + x, *ay = fy + (z * 9 + y) * 9 + x,
                            *az = fz + (z * 8 + y) * 9 + x;
                const double out =
                    (double)(ax[1] - ax[0]) * 9 + (double)(ay[9] - ay[0]) * 8 + (double)(az[72] - az[0]) * 7;
                const size_t i = cell_index(&p, x, y, z);
                assert_close(out, (double)p.source[i] - 0.3 * (double)p.fluence[i], 2e-5);
            }
    free(fx);
    free(fy);
    free(fz);
    free_problem(&p);
}

static void single_precision_relaxation_is_good_to_a_thousandth(void** state) {
    problem p = make_case(&cases[0]);
    float* other = make_floats(p.cells);
    solve_into(*state, &p, p.fluence);
    p.def.solver = TY_DIFFUSION_SOR_FLOAT;
    p.def.tolerance = 1e-4;
    p.def.relaxation = 1.6;
    solve_into(*state, &p, other);
    assert_true(largest_difference(p.fluence, other, p.cells) < 2e-3);
    free(other);
    free_problem(&p);
}

static void threads_do_not_change_results(void** state) {
    (void)state;
    for (ty_diffusion_solver solver = 0; solver < TY_DIFFUSION_SOLVER_COUNT; ++solver) {
        problem p = make_case(&(medium_case){fill_beam, TY_LIMITER_SUM, TY_BOUNDARY_MARSHAK, {40, 33, 31}, 1});
        float* other = make_floats(p.cells);
        p.def.solver = solver;
        p.def.tolerance = 1e-3;
        ty_context *one = make_context(1), *three = make_context(3);
        solve_into(one, &p, p.fluence);
        solve_into(three, &p, other);
        assert_memory_equal(p.fluence, other, sizeof(float) * p.cells);
        ty_context_destroy(one);
        ty_context_destroy(three);
        free(other);
        free_problem(&p);
    }
}

static bool refuse(void* user, const ty_progress* progress) {
    ++*(int*)user;
    assert_true(progress->fraction >= 0 && progress->fraction <= 1);
    return false;
}

static void solves_can_be_cancelled(void** state) {
    problem p = make_case(&cases[0]);
    int calls = 0;
    p.def.solver = TY_DIFFUSION_SOR;
    p.def.tolerance = 1e-300;
    p.def.iterations = INT32_MAX;
    p.def.progress = refuse;
    p.def.progress_user = &calls;
    assert_int_equal(ty_diffusion_solve(*state, &p.def, &p.out, &p.stats), TY_CANCELLED);
    assert_int_equal(calls, 1);
    assert_true(p.fluence[0] > 0 && !p.stats.converged);
    free_problem(&p);
}

static void memory_and_history_are_the_callers(void** state) {
    problem p = make_case(&cases[0]);
    double history[100];
    p.def.memory = aligned_alloc(64, ty_diffusion_memory(&p.def));
    p.out.history = history;
    p.out.history_capacity = 100;
    memset(p.def.memory, 0xff, ty_diffusion_memory(&p.def));
    solve_into(*state, &p, p.fluence);
    assert_int_equal(p.stats.history_count, p.stats.iterations + 1);
    assert_true(history[p.stats.iterations] <= 1e-6 && history[0] > 1e-3);
    const int32_t iterations = p.stats.iterations;
    /* From the answer there is nothing left to do but what single precision lost. */
    float* start = make_floats(p.cells);
    memcpy(start, p.fluence, sizeof(float) * p.cells);
    p.def.start = start;
    solve_into(*state, &p, p.fluence);
    assert_true(p.stats.iterations < iterations / 2);
    free(start);
    free(p.def.memory);
    free_problem(&p);
}

static void darkness_is_solved_at_once(void** state) {
    problem p = make_problem(4, 4, 4, 1, 1);
    p.fluence[5] = 7;
    solve_into(*state, &p, p.fluence);
    for (size_t i = 0; i < p.cells; ++i) assert_true(p.fluence[i] == 0);
    free_problem(&p);
}

static void bad_problems_are_refused(void** state) {
    static const bad_field bad[] = {
        {offsetof(ty_diffusion_def, size), FIELD_INT, 0, "size[0]"},
        {offsetof(ty_diffusion_def, size) + 4, FIELD_INT, 4097, "size[1]"},
        {offsetof(ty_diffusion_def, cell), FIELD_DOUBLE, 0, "cell[0]"},
        {offsetof(ty_diffusion_def, limiter), FIELD_INT, 6, "limiter"},
        {offsetof(ty_diffusion_def, solver), FIELD_INT, 3, "solver"},
        {offsetof(ty_diffusion_def, boundary), FIELD_INT, 3, "boundary[0]"},
        {offsetof(ty_diffusion_def, larsen_power), FIELD_DOUBLE, 0.5, "larsen_power"},
        {offsetof(ty_diffusion_def, streaming), FIELD_DOUBLE, 0, "streaming"},
        {offsetof(ty_diffusion_def, relaxation), FIELD_DOUBLE, 2, "relaxation"},
        {offsetof(ty_diffusion_def, tolerance), FIELD_DOUBLE, 0, "tolerance"},
        {offsetof(ty_diffusion_def, iterations), FIELD_INT, -1, "iterations"},
    };
    problem p = make_problem(4, 4, 4, 1, 1);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        ty_diffusion_def def = p.def;
        set_field(&def, &bad[i]);
        assert_int_equal(ty_diffusion_solve(*state, &def, &p.out, NULL), TY_ERROR_ARGUMENT);
        assert_error(*state, bad[i].words);
    }
    p.source[3] = NAN;
    assert_int_equal(ty_diffusion_solve(*state, &p.def, &p.out, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "not finite");
    free_problem(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solvers_agree),
        cmocka_unit_test(jumps_of_a_million_take_few_cycles),
        cmocka_unit_test(cycles_do_not_grow_with_cells),
        cmocka_unit_test(limited_problems_take_few_iterations),
        cmocka_unit_test(iterations_hardly_grow_with_cells),
        cmocka_unit_test(plain_iterations_are_fallen_back_to),
        cmocka_unit_test(flux_never_exceeds_fluence),
        cmocka_unit_test(fluxes_balance_in_every_cell),
        cmocka_unit_test(single_precision_relaxation_is_good_to_a_thousandth),
        cmocka_unit_test(threads_do_not_change_results),
        cmocka_unit_test(solves_can_be_cancelled),
        cmocka_unit_test(memory_and_history_are_the_callers),
        cmocka_unit_test(darkness_is_solved_at_once),
        cmocka_unit_test(bad_problems_are_refused),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
