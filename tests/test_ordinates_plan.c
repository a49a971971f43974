/* Plans of divided solves, against what solves take, and for large grids. */
#include "checks.h"
#include "ranks.h"
#include "solve/ordinates/divided/joint_solve.h"
#include "solve/ordinates/divided/plan.h"

enum { TERMS = 9 };

static ty_angular_quadrature directions;

typedef struct solved {
    ty_ordinates_def whole;
    double bytes; /* of rank 0 */
    uint64_t messages;
} solved;

static void solve_part(ty_comm* comm, void* user) {
    solved* s = user;
    ty_domain d;
    require(ty_ordinates_cut(comm, s->whole.size, &d));
    ty_ordinates_def def = s->whole;
    size_t cells = 1;
    for (int a = 0; a < 3; ++a) def.size[a] = d.end[a] - d.first[a];
    for (int a = 0; a < 3; ++a) cells *= (size_t)def.size[a];
    float *planes = calloc((3 + 2 * TERMS) * cells, sizeof *planes), *moments[TERMS];
    const float* source[TERMS];
    for (size_t i = 0; i < cells; ++i) planes[i] = 2, planes[cells + i] = 1.8f, planes[3 * cells + i] = 1;
    def.extinction = planes;
    def.scattering = planes + cells;
    def.g = planes + 2 * cells;
    for (size_t t = 0; t < TERMS; ++t) source[t] = planes + (3 + t) * cells;
    for (size_t t = 0; t < TERMS; ++t) moments[t] = planes + (3 + TERMS + t) * cells;
    def.source = source;
    def.domain = comm != NULL ? &d : NULL;
    ty_context_def context_def = ty_default_context_def();
    ty_context* context = NULL;
    context_def.threads = 1;
    require(ty_context_create(&context_def, &context) == TY_OK);
    ty_ordinates_stats stats;
    require(ty_ordinates_solve(context, &def, moments, NULL, 0, &stats) == TY_OK);
    if (ty_comm_rank(comm) == 0) s->bytes = stats.bytes;
    ty_context_destroy(context);
    ty_domain_destroy(&d);
    free(planes);
}

static ty_ordinates_def define(const int32_t size[3], int32_t bands) {
    ty_ordinates_def def = ty_default_ordinates_def();
    for (int a = 0; a < 3; ++a) def.size[a] = size[a];
    for (int a = 0; a < 3; ++a) def.cell[a] = 0.1;
    def.set = &directions;
    def.bands = def.output_order = bands;
    def.source_terms = bands * bands;
    return def;
}

/* Sums are of doubles: exact up to 2^53. */
static void plans_are_what_solves_take(void** state) {
    static const int32_t sizes[][3] = {{21, 33, 10}, {34, 35, 36}}, ranks[] = {1, 2, 4, 6};
    assert_int_equal(ty_angular_quadrature_create(*state, 24, &directions, NULL), TY_OK);
    for (size_t i = 0; i < 2; ++i)
        for (size_t r = 0; r < sizeof ranks / sizeof *ranks; ++r) {
            solved s = {.whole = define(sizes[i], 3)};
            ty_ordinates_plan plan;
            ty_context* context = make_context(1); /* scratch memory is per thread */
            assert_int_equal(ty_ordinates_plan_ranks(context, &s.whole, ranks[r], &plan), TY_OK);
            ty_context_destroy(context);
            run_ranks(ranks[r], solve_part, &s);
            assert_close(plan.solve, s.bytes, 0);
        }
    ty_ordinates_plan plan;
    const ty_ordinates_def small = define((const int32_t[]){8, 8, 8}, 1);
    assert_int_equal(ty_ordinates_plan_ranks(*state, &small, 1000, &plan), TY_ERROR_ARGUMENT);
    assert_error(*state, "too few cells for 1000 ranks");
}

/* The table of docs/farm.md, "Divided grids": 1024^3 cells, 96 directions, 4 bands, one channel. GB to three digits. */
typedef struct planned_row {
    int32_t ranks, along[2], units, stages;
    double arrays, solve;
} planned_row;

static void a_large_grid_fits_many_memories(void** state) {
    static const planned_row rows[] = {{1, {1, 1}, 0, 0, 150, 740},
                                       {4, {1, 4}, 24, 26, 37.6, 195},
                                       {16, {4, 4}, 48, 52, 9.4, 49},
                                       {64, {8, 8}, 112, 124, 2.35, 12.3},
                                       {256, {16, 16}, 240, 268, 0.587, 3.14},
                                       {1024, {32, 32}, 488, 548, 0.147, 0.831},
                                       {4096, {64, 64}, 912, 1036, 0.0367, 0.395}};
    assert_int_equal(ty_angular_quadrature_create(*state, 96, &directions, NULL), TY_OK);
    const ty_ordinates_def def = define((const int32_t[]){1024, 1024, 1024}, 4);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        const planned_row* row = &rows[i];
        ty_ordinates_plan p;
        assert_int_equal(ty_ordinates_plan_ranks(*state, &def, row->ranks, &p), TY_OK);
        for (int a = 0; a < 2; ++a) assert_int_equal(p.ranks[a], row->along[a]);
        if (row->ranks > 1) assert_int_equal(p.units, row->units);
        assert_int_equal(p.stages, row->stages);
        assert_close(1e-9 * p.arrays / row->arrays, 1, 0.01);
        /* Scratch memory and vectors differ a little among processors. */
        assert_close(1e-9 * p.solve / row->solve, 1, 0.1);
        if (row->ranks == 1) continue;
        const double sides = (double)(row->along[0] > 1 ? p.part[1] : 0) + (double)p.part[0];
        assert_close(p.message_bytes, 4 * 96 * sides * p.part[2], 0);
        assert_close(p.messages, (row->along[0] > 1 ? 2 : 1) * row->units, 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plans_are_what_solves_take),
        cmocka_unit_test(a_large_grid_fits_many_memories),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
