/* Sweeps of boxes that are cut among ranks: schedules, and moments against those of the whole box. */
#include "box_parts.h"
#include "checks.h"
#include "ranks.h"
#include "solve/ordinates/sweep.h"
#include "solve/ordinates/sweep_schedule.h"

/* ---- schedules ---- */

/* A unit begins after those upwind of it: all ranks' orders together have no circle. */
static void check_order(ty_context* context, const int32_t parts[2], int32_t planes) {
    const int32_t ranks = parts[0] * parts[1];
    ty_sweep_schedule s[36];
    int32_t done[36][TY_SWEEP_STREAMS_MAX] = {{0}}, next[36] = {0}, left = 0;
    for (int32_t r = 0; r < ranks; ++r) {
        const int32_t at[2] = {r % parts[0], r / parts[0]};
        s[r] = ty_sweep_choose_blocks(parts, planes);
        assert_int_equal(ty_sweep_schedule_make(context, parts, at, &s[r]), TY_OK);
        left += s[r].count;
    }
    for (bool any = true; any;) {
        any = false;
        for (int32_t r = 0; r < ranks; ++r) {
            if (next[r] == s[r].count) continue;
            const ty_sweep_unit* unit = &s[r].units[next[r]];
            const int32_t stream = unit->stream, bits = s[r].streams == 4 ? 2 * stream : stream;
            const int32_t at[2] = {r % parts[0], r / parts[0]};
            const int32_t step = (bits & 4) != 0 ? s[r].blocks - 1 - unit->block : unit->block;
            bool ready = done[r][stream] == step;
            for (int a = s[r].streams == 4 ? 1 : 0; a < 2; ++a) {
                int32_t from[2] = {at[0], at[1]};
                from[a] += (bits >> a & 1) != 0 ? 1 : -1;
                if (from[a] < 0 || from[a] >= parts[a]) continue;
                ready = ready && done[from[0] + parts[0] * from[1]][stream] > step;
            }
            if (!ready) continue;
            ++done[r][stream];
            ++next[r];
            --left;
            any = true;
        }
    }
    assert_int_equal(left, 0);
    for (int32_t r = 0; r < ranks; ++r) ty_sweep_schedule_free(context, &s[r]);
}

static void units_follow_those_upwind(void** state) {
    static const int32_t parts[][3] = {{1, 1, 5},  {1, 2, 16}, {2, 1, 16}, {2, 2, 9},
                                       {1, 5, 40}, {3, 4, 64}, {6, 6, 33}};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i) check_order(*state, parts[i], parts[i][2]);
}

/* A rank has streams x blocks units to do, and waits for at most an eighth of that (0.12 for 16 x 16 ranks). */
static void ranks_hardly_wait(void** state) {
    static const int32_t cases[][3] = {{1, 2, 0}, {2, 2, 0}, {1, 4, 0}, {4, 4, 0}, {8, 8, 0}, {16, 16, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const int32_t parts[2] = {cases[i][0], cases[i][1]}, at[2] = {0, 0};
        ty_sweep_schedule s = ty_sweep_choose_blocks(parts, 256);
        assert_int_equal(ty_sweep_schedule_make(*state, parts, at, &s), TY_OK);
        assert_true(s.stages <= s.count + s.count / 8);
        ty_sweep_schedule_free(*state, &s);
    }
}

/* ---- sweeps ---- */

enum { BANDS = 3, TERMS = BANDS * BANDS };

/* A box with walls and light from around. */
typedef struct whole {
    int32_t size[3];
    unsigned cuts;
    bool walls, lit;
    float *extinction, *emission, *moments, *power; /* power: incident on sides */
    double leaving, fixups;
} whole;

static ty_angular_quadrature directions;
static float around[3][8 * 4 * TY_ORDINATES_MAX];
static const double edges[3] = {0.2, 0.3, 0.1};

static pthread_mutex_t sum_lock = PTHREAD_MUTEX_INITIALIZER;

static void sweep_part(ty_comm* comm, void* user) {
    whole* w = user;
    static const int32_t unit[3] = {1, 1, 1};
    ty_domain d;
    require(ty_domain_create(comm, w->size, w->cuts, unit, 1, &d));
    int32_t size[3];
    size_of_part(&d, size);
    const size_t cells = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    float *extinction = calloc(cells, sizeof(float)), *emission = calloc(cells * TERMS, sizeof(float)),
          *moments = calloc(cells * TERMS, sizeof(float));
    copy_part(w->size, &d, 1, w->extinction, extinction, false);
    copy_part(w->size, &d, TERMS, w->emission, emission, false);
    part_sides s = make_sides(w->size, &d, w->walls ? 7 : 0);
    for (int32_t i = 0; i < s.count; ++i) s.given[0][i] = 0.1f * (float)(s.face[i] + 1);
    const ty_sweep_faces faces = {
        .count = s.count, .first = s.first, .x = s.x, .face = s.face, .emitted = s.given[0], .incident_power = s.found};
    const ty_boundary_radiance boundary = {.across = {around[0], around[1], around[2]}, .patches = {2, 2, 2}};
    ty_context_def def = ty_default_context_def();
    ty_context* context = NULL;
    def.threads = 2;
    require(ty_context_create(&def, &context) == TY_OK);
    ty_sweep* sweep;
    require(ty_sweep_create(context, size, edges, &directions, BANDS, extinction, &sweep) == TY_OK);
    require(ty_sweep_divide(sweep, comm != NULL ? &d : NULL) == TY_OK);
    if (w->lit) require(ty_sweep_set_boundary_radiance(sweep, &boundary) == TY_OK);
    if (w->walls) ty_sweep_set_faces(sweep, &faces);
    double sums[2];
    for (int twice = 0; twice < 2; ++twice)
        require(ty_sweep_run(sweep, emission, moments, &sums[0], &sums[1]) == TY_OK);
    require(ty_comm_sum(comm, sums, 2));
    pthread_mutex_lock(&sum_lock);
    copy_part(w->size, &d, TERMS, w->moments, moments, true);
    for (int32_t i = 0; i < s.count; ++i) w->power[s.global[i]] = s.found[i];
    w->leaving = sums[0];
    w->fixups = sums[1];
    pthread_mutex_unlock(&sum_lock);
    ty_sweep_destroy(sweep);
    ty_context_destroy(context);
    free_sides(&s);
    free(extinction);
    free(emission);
    free(moments);
    ty_domain_destroy(&d);
}

static size_t cells_of(const whole* w) {
    return (size_t)w->size[0] * (size_t)w->size[1] * (size_t)w->size[2];
}

/* From vacuum to thick cells, a fifth of which emit. */
static whole make_whole(const int32_t size[3], bool walls, bool lit) {
    whole w = {.size = {size[0], size[1], size[2]}, .walls = walls, .lit = lit};
    const size_t cells = cells_of(&w);
    uint64_t seed = 11;
    w.extinction = calloc(cells, sizeof(float));
    w.emission = calloc(cells * TERMS, sizeof(float));
    w.moments = calloc(cells * TERMS, sizeof(float));
    w.power = calloc(6 * cells, sizeof(float));
    for (size_t i = 0; i < cells; ++i) {
        w.extinction[i] = i % 3 == 0 ? 0 : (float)exp(uniform_in(&seed, log(1e-2), log(1e3)));
        if (i % 5 != 0) continue;
        w.emission[i * TERMS] = (float)uniform_in(&seed, 0.2, 1);
        for (size_t t = 1; t < TERMS; ++t) w.emission[i * TERMS + t] = (float)uniform_in(&seed, -0.05, 0.05);
    }
    for (int axis = 0; axis < 3; ++axis)
        for (size_t i = 0; i < sizeof around[0] / sizeof(float); ++i) around[axis][i] = (float)uniform(&seed);
    return w;
}

static void free_whole(whole* w) {
    free(w->extinction);
    free(w->emission);
    free(w->moments);
    free(w->power);
}

static float difference_of(const float* a, const float* b, size_t count) {
    float most = 0, largest = 0;
    for (size_t i = 0; i < count; ++i) {
        most = fmaxf(most, fabsf(a[i] - b[i]));
        largest = fmaxf(largest, fabsf(b[i]));
    }
    return largest > 0 ? most / largest : most;
}

typedef struct cut_case {
    int32_t ranks;
    unsigned cuts;
} cut_case;

/* Moments are sums of the same numbers in another order: 1.8e-7 of the largest one is measured. */
static void check_cuts(whole* w, bool walls) {
    static const cut_case cuts[] = {
        {2, TY_CUT_Y}, {2, TY_CUT_X}, {4, TY_CUT_X | TY_CUT_Y}, {3, TY_CUT_Y}, {6, TY_CUT_X | TY_CUT_Y}};
    const size_t cells = cells_of(w);
    float* moments = calloc(cells * TERMS, sizeof(float));
    float* power = calloc(6 * cells, sizeof(float));
    run_ranks(1, sweep_part, w);
    memcpy(moments, w->moments, cells * TERMS * sizeof(float));
    memcpy(power, w->power, 6 * cells * sizeof(float));
    const double leaving = w->leaving, fixups = w->fixups;
    assert_true(fixups > 0);
    for (size_t i = 0; i < sizeof cuts / sizeof *cuts; ++i) {
        memset(w->moments, 0, cells * TERMS * sizeof(float));
        w->cuts = cuts[i].cuts;
        run_ranks(cuts[i].ranks, sweep_part, w);
        assert_true(difference_of(w->moments, moments, cells * TERMS) < 4e-7f);
        assert_true(difference_of(w->power, power, 6 * cells) < 4e-7f);
        assert_close(w->leaving / leaving, 1, 1e-8);
        /* Radiance is the same, bit for bit. With walls, lanes without a direction count, too, and are not sent. */
        if (!walls) assert_close(w->fixups, fixups, 0);
    }
    free(moments);
    free(power);
}

static void parts_make_the_whole(void** state) {
    static const int32_t sizes[][3] = {{13, 11, 9}, {6, 20, 17}};
    assert_int_equal(ty_angular_quadrature_create(*state, 48, &directions, NULL), TY_OK);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i)
        for (int kind = 0; kind < 4; ++kind) {
            whole w = make_whole(sizes[i], (kind & 1) != 0, (kind & 2) != 0);
            check_cuts(&w, w.walls);
            free_whole(&w);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(units_follow_those_upwind),
        cmocka_unit_test(ranks_hardly_wait),
        cmocka_unit_test(parts_make_the_whole),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
