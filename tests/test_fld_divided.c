/* Diffusion on grids that are divided among ranks, which are threads of this program: what a cell gets does not depend
 * on the cuts. */
#include "diffusion_maker.h"
#include "effort.h"
#include "ranks.h"
#include "solve/diffusion/divided/joint_faces.h"
#include "solve/diffusion/divided/plan.h"

/* A whole problem, and where the ranks put their parts of its solution. */
typedef struct divided_problem {
    const problem* whole;
    float *fluence, *diffusivity, *flux[3], *side_flux, *side_irradiance; /* NULL sides: without surfaces */
    ty_diffusion_stats stats;                                             /* of rank 0 */
    ty_comm_traffic halos;
    int32_t ranks[3];
    ty_result result;
    int cancel_on; /* rank whose caller cancels, or -1 */
} divided_problem;

/* Copies rows between the whole grid and a box. more: items beyond the cells along each axis. */
static void copy_box(const ty_domain* d, float* whole, float* part, const int32_t more[3], bool out) {
    int32_t size[3], rows[3];
    for (int a = 0; a < 3; ++a) size[a] = d->end[a] - d->first[a] + more[a];
    for (int a = 0; a < 3; ++a) rows[a] = d->cells[a] + more[a];
    for (int32_t z = 0; z < size[2]; ++z)
        for (int32_t y = 0; y < size[1]; ++y) {
            float* row =
                whole + ((size_t)(z + d->first[2]) * (size_t)rows[1] + (size_t)(y + d->first[1])) * (size_t)rows[0];
            float* own = part + ((size_t)z * (size_t)size[1] + (size_t)y) * (size_t)size[0];
            memcpy(out ? row : own, out ? own : row, sizeof(float) * (size_t)size[0]);
        }
}

static float* part_of(const ty_domain* d, const float* whole) {
    size_t cells = 1;
    for (int a = 0; a < 3; ++a) cells *= (size_t)(d->end[a] - d->first[a]);
    float* part = make_floats(cells);
    copy_box(d, (float*)(uintptr_t)whole, part, (int32_t[3]){0, 0, 0}, false);
    return part;
}

/* Values of a rank's faces of a side. */
static float* part_of_side(const ty_domain* d, int side, const float* whole) {
    const int axis = side / 2, u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    const int32_t nu = d->end[u] - d->first[u], nv = d->end[v] - d->first[v];
    float* part = make_floats((size_t)nu * (size_t)nv);
    for (int32_t j = 0; j < nv; ++j)
        memcpy(part + (size_t)j * (size_t)nu,
               whole + (size_t)(j + d->first[v]) * (size_t)d->cells[u] + (size_t)d->first[u],
               sizeof(float) * (size_t)nu);
    return part;
}

static bool go_on(void* user, const ty_progress* progress) {
    (void)progress;
    return *(const int*)user != own_rank;
}

static void solve_part(ty_comm* comm, void* user) {
    divided_problem* p = user;
    ty_domain domain;
    ty_context_def context_def = ty_default_context_def();
    ty_context* context = NULL;
    context_def.threads = 1 + own_rank % 2;
    require(ty_context_create(&context_def, &context) == TY_OK);
    ty_diffusion_def def = p->whole->def;
    require(ty_diffusion_divide(comm, &def, &domain));
    if (own_rank == 0) memcpy(p->ranks, domain.ranks, sizeof p->ranks);
    size_t cells = 1;
    for (int a = 0; a < 3; ++a) cells *= (size_t)(def.size[a] = domain.end[a] - domain.first[a]);
    float* sides[6] = {0};
    for (int side = 0; side < 6; ++side)
        if (def.boundary[side].value != NULL)
            def.boundary[side].value = sides[side] = part_of_side(&domain, side, def.boundary[side].value);
    float *extinction = part_of(&domain, def.extinction), *absorption = part_of(&domain, def.absorption),
          *source = part_of(&domain, def.source), *start = def.start != NULL ? part_of(&domain, def.start) : NULL;
    def.extinction = extinction;
    def.absorption = absorption;
    def.source = source;
    def.start = start;
    def.domain = &domain;
    if (p->cancel_on >= 0) {
        def.progress = go_on;
        def.progress_user = &p->cancel_on;
    }
    ty_joint_faces sides_part = {
        .context = context, .domain = &domain, .whole = own_rank == 0 ? def.faces : NULL, .has_radiosity = true};
    const bool has_faces = def.faces != NULL;
    if (has_faces) require(ty_joint_faces_take(&sides_part) == TY_OK);
    if (has_faces) def.faces = &sides_part.faces;
    ty_diffusion_stats stats;
    ty_diffusion_out out = {.side_flux = sides_part.flux,
                            .side_irradiance = sides_part.irradiance,
                            .fluence = make_floats(cells),
                            .diffusivity = make_floats(cells)};
    for (int a = 0; a < 3; ++a) out.flux[a] = make_floats(cells / (size_t)def.size[a] * (size_t)(def.size[a] + 1));
    const ty_result result = ty_diffusion_solve(context, &def, &out, &stats);
    if (own_rank == 0) p->result = result;
    if (own_rank == 0) p->stats = stats;
    if (own_rank == 0) p->halos = domain.halos;
    require(p->cancel_on >= 0 || (result == TY_OK && stats.converged));
    if (has_faces) require(ty_joint_faces_give(&sides_part, p->side_flux, p->side_irradiance));
    ty_joint_faces_free(&sides_part);
    pthread_mutex_lock(&box_lock); /* faces between boxes are written by both ranks */
    copy_box(&domain, p->fluence, out.fluence, (int32_t[3]){0, 0, 0}, true);
    copy_box(&domain, p->diffusivity, out.diffusivity, (int32_t[3]){0, 0, 0}, true);
    for (int a = 0; a < 3; ++a) {
        int32_t more[3] = {0, 0, 0};
        more[a] = 1;
        copy_box(&domain, p->flux[a], out.flux[a], more, true);
        free(out.flux[a]);
    }
    pthread_mutex_unlock(&box_lock);
    float* const arrays[] = {extinction, absorption, source, start, out.fluence, out.diffusivity};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; ++i) free(arrays[i]);
    for (int side = 0; side < 6; ++side) free(sides[side]);
    ty_domain_destroy(&domain);
    ty_context_destroy(context);
}

/* Dense balls in thin air or vacuum, and absorption; light of a corner. */
static void fill_medium(problem* p, size_t i, const double at[3], float thinnest) {
    const double wave = sin(9 * at[0]) * sin(7 * at[1] + 1) * sin(11 * at[2]);
    p->extinction[i] = wave > 0.2 ? 60 : wave > 0 ? 4 : thinnest;
    p->absorption[i] = 0.02f * p->extinction[i];
    p->source[i] = (float)exp(-20 * (at[0] * at[0] + at[1] * at[1] + at[2] * at[2]));
}

static void fill_cell(problem* p, size_t i, const double at[3]) {
    fill_medium(p, i, at, 1e-3f);
}

static void fill_thick_cell(problem* p, size_t i, const double at[3]) {
    fill_medium(p, i, at, 3);
}

static double glow(const double at[3]) {
    return 0.1 + 0.05 * sin(5 * at[0] + 3 * at[1] + 4 * at[2]);
}

/* Under sanitizers, whose programs are up to 20 times as slow. */
static bool few_cases(void) {
    return !in_full() && !numbers_count();
}

/* Solves as one rank and as several, and compares the bits. */
static void compare_ranks(const problem* p, const int32_t* counts, int count_of_counts, bool bits_of_cuts_along_y) {
    const size_t cells = p->cells;
    divided_problem one = {.whole = p, .cancel_on = -1}, many = one;
    divided_problem* const both[] = {&one, &many};
    size_t faces[3];
    for (int a = 0; a < 3; ++a) faces[a] = cells / (size_t)p->def.size[a] * (size_t)(p->def.size[a] + 1);
    const size_t sides = p->def.faces != NULL ? (size_t)p->def.faces->count : 0;
    for (int i = 0; i < 2; ++i) {
        both[i]->side_flux = make_floats(sides + 1);
        both[i]->side_irradiance = make_floats(sides + 1);
        both[i]->fluence = make_floats(cells);
        both[i]->diffusivity = make_floats(cells);
        for (int a = 0; a < 3; ++a) both[i]->flux[a] = make_floats(faces[a]);
    }
    run_ranks(1, solve_part, &one);
    for (int n = few_cases() ? count_of_counts - 1 : 0; n < count_of_counts; ++n) {
        run_ranks(counts[n], solve_part, &many);
        assert_int_equal(many.ranks[0] * many.ranks[1] * many.ranks[2], counts[n]);
        printf("%d ranks (%d x %d): %d iterations, %d cycles, residual %.3g (%.3g); largest difference %.3g\n",
               (int)counts[n], (int)many.ranks[1], (int)many.ranks[2], (int)many.stats.iterations,
               (int)many.stats.cycles, many.stats.residual, one.stats.residual,
               largest_difference(one.fluence, many.fluence, cells));
        ty_diffusion_plan plan;
        ty_context* context = make_context(1);
        assert_int_equal(ty_diffusion_plan_ranks(context, &p->def, counts[n], &plan), TY_OK);
        ty_context_destroy(context);
        assert_close(plan.solve, many.stats.bytes, 0);
        assert_memory_equal(plan.ranks, many.ranks, sizeof many.ranks);
        /* Layers that rank 0 sends and receives, in units of those of linear cycles: linearisations and conjugate
         * gradients have some, too, and iterations of limited diffusion more. Measured 1.03 and 1.05. */
        const double cycles = (double)many.halos.bytes / (2 * many.stats.cycles * plan.halo_bytes);
        if (many.stats.cycles > 0) printf("halos of %.2f cycles a cycle\n", cycles);
        if (p->def.limiter == TY_LIMITER_NONE && sides == 0 && plan.ranks[1] <= 2 && plan.ranks[2] <= 2)
            assert_true(cycles > 1 && cycles < 1.1);
        assert_int_equal(many.stats.iterations, one.stats.iterations);
        assert_int_equal(many.stats.cycles, one.stats.cycles);
        assert_close(many.stats.emitted / one.stats.emitted, 1, 1e-12);
        assert_close(many.stats.absorbed / one.stats.absorbed, 1, 1e-12);
        if (sides == 0) assert_close(many.stats.leaving / one.stats.leaving, 1, 1e-9);
        if (sides > 0) assert_close(many.stats.surfaces_absorbed / one.stats.surfaces_absorbed, 1, 1e-12);
        if (sides > 0) assert_close(many.stats.surfaces_emitted / one.stats.surfaces_emitted, 1, 1e-12);
        if (many.ranks[1] > 1 && !bits_of_cuts_along_y) {
            assert_true(largest_difference(one.fluence, many.fluence, cells) < 0.3 * p->def.tolerance);
            continue;
        }
        assert_memory_equal(many.fluence, one.fluence, sizeof(float) * cells);
        assert_memory_equal(many.side_flux, one.side_flux, sizeof(float) * (sides + 1));
        assert_memory_equal(many.side_irradiance, one.side_irradiance, sizeof(float) * (sides + 1));
        assert_memory_equal(many.diffusivity, one.diffusivity, sizeof(float) * cells);
        for (int a = 0; a < 3; ++a) assert_memory_equal(many.flux[a], one.flux[a], sizeof(float) * faces[a]);
    }
    for (int i = 0; i < 2; ++i) {
        free(both[i]->side_flux);
        free(both[i]->side_irradiance);
        free(both[i]->fluence);
        free(both[i]->diffusivity);
        for (int a = 0; a < 3; ++a) free(both[i]->flux[a]);
    }
}

static const int32_t rank_counts[] = {2, 3, 4, 6};

static void limited_diffusion_is_that_of_one_rank(void** state) {
    (void)state;
    const ty_limiter limiters[] = {TY_LIMITER_LEVERMORE_POMRANING, TY_LIMITER_KERSHAW};
    for (int i = 0; i < (few_cases() ? 1 : 2); ++i) {
        problem p = make_problem(37, 40, i == 0 ? 44 : 35, 1, 1);
        p.def.limiter = limiters[i];
        p.def.tolerance = i == 0 ? 1e-4 : 1e-5;
        fill_problem(&p, fill_cell);
        compare_ranks(&p, rank_counts + (i == 0 ? 0 : 2), i == 0 ? 4 : 1, true);
        free_problem(&p);
    }
}

/* Also on two levels that are divided, with incident flux, and from a start. */
static void light_from_the_sides_is_that_of_one_rank(void** state) {
    (void)state;
    float* values[6];
    problem p = make_problem(40, 84, 84, 1, 1);
    p.def.tolerance = 1e-4;
    fill_problem(&p, fill_thick_cell);
    set_faces(&p, values, glow);
    set_boundaries(&p, TY_BOUNDARY_MARSHAK);
    for (int side = 0; side < 6; ++side) p.def.boundary[side].value = values[side];
    p.def.boundary[2].kind = TY_BOUNDARY_REFLECTING;
    p.def.boundary[5].kind = TY_BOUNDARY_DIRICHLET;
    compare_ranks(&p, rank_counts + 2, 1, true);
    p.def.start = p.extinction;
    compare_ranks(&p, rank_counts, 1, true);
    for (int side = 0; side < 6; ++side) free(values[side]);
    free_problem(&p);
}

/* Linear diffusion uses conjugate gradients where cycles are slow: their factors are quotients of sums. */
static void linear_diffusion_is_that_of_one_rank(void** state) {
    (void)state;
    problem p = make_problem(40, 36, 48, 1, 1);
    p.def.limiter = TY_LIMITER_NONE;
    fill_problem(&p, fill_cell);
    compare_ranks(&p, rank_counts, 4, false);
    free_problem(&p);
}

/* A cell twice as long along one axis is coarsened there later. */
static void long_cells_are_divided(void** state) {
    (void)state;
    problem p = make_problem(40, 48, 20, 1, 1);
    p.def.cell[2] *= 2;
    p.def.tolerance = 1e-4;
    fill_problem(&p, fill_cell);
    compare_ranks(&p, rank_counts, 3, true);
    free_problem(&p);
}

/* Walls around all cells and across the middle, also at cuts; of one rank's cells alone in the thickest box. */
static void surfaces_are_those_of_one_rank(void** state) {
    (void)state;
    for (int axis = 1; axis < 3; ++axis) {
        problem p = make_problem(28, 26, 30, 1, 1);
        closed_box box = close_box(&p, axis, axis == 1 ? 13 : 14, 0.6f, 0.5f);
        for (int32_t i = 0; i < box.faces.count; i += 3) box.staircase[i] = 1.3f;
        if (axis == 2) p.def.limiter = TY_LIMITER_NONE;
        p.def.tolerance = 1e-4;
        p.def.faces = &box.faces;
        fill_problem(&p, fill_thick_cell);
        compare_ranks(&p, rank_counts + 1, 2, axis == 1);
        free_box(&box);
        free_problem(&p);
    }
}

static void over_relaxation_is_that_of_one_rank(void** state) {
    (void)state;
    for (int i = 0; i < 2; ++i) {
        problem p = make_problem(24, 20, 26, 1, 1);
        p.def.solver = i == 0 ? TY_DIFFUSION_SOR : TY_DIFFUSION_SOR_FLOAT;
        p.def.tolerance = 1e-2;
        p.def.start = i == 0 ? p.extinction : NULL;
        fill_problem(&p, fill_thick_cell);
        compare_ranks(&p, rank_counts + 1, 2, true);
        free_problem(&p);
    }
}

static void one_rank_cancels_all(void** state) {
    (void)state;
    problem p = make_problem(24, 24, 24, 1, 1);
    fill_problem(&p, fill_cell);
    p.def.tolerance = 1e-9;
    divided_problem d = {.whole = &p, .fluence = p.fluence, .diffusivity = p.diffusivity, .cancel_on = 1};
    for (int a = 0; a < 3; ++a) d.flux[a] = make_floats(p.cells / 24 * 25);
    run_ranks(2, solve_part, &d);
    assert_true(d.result == TY_CANCELLED || d.result == TY_OK); /* progress is looked at from time to time */
    for (int a = 0; a < 3; ++a) free(d.flux[a]);
    free_problem(&p);
}

static void small_grids_are_not_divided(void** state) {
    (void)state;
    ty_domain domain;
    ty_comm* comm = NULL;
    problem p = make_problem(8, 6, 6, 1, 1);
    box_ranks = 4;
    assert_int_equal(ty_comm_join(&box_backend, 1, 0, &comm), TY_OK);
    assert_false(ty_diffusion_divide(comm, &p.def, &domain));
    ty_comm_close(comm, true, 0);
    free_problem(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(limited_diffusion_is_that_of_one_rank),
        cmocka_unit_test(light_from_the_sides_is_that_of_one_rank),
        cmocka_unit_test(linear_diffusion_is_that_of_one_rank),
        cmocka_unit_test(long_cells_are_divided),
        cmocka_unit_test(surfaces_are_those_of_one_rank),
        cmocka_unit_test(over_relaxation_is_that_of_one_rank),
        cmocka_unit_test(one_rank_cancels_all),
        cmocka_unit_test(small_grids_are_not_divided),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
