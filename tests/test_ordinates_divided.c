/* Solves by discrete ordinates whose box is cut among ranks, against those of one rank. */
#include "box_parts.h"
#include "checks.h"
#include "ranks.h"
#include "solve/ordinates/ordinates.h"

enum { TERMS_MAX = 16 };

/* A problem, and its solution by any number of ranks. */
typedef struct whole {
    ty_ordinates_def def; /* of the whole */
    unsigned cuts;
    int32_t ranks[2];
    float *extinction, *scattering, *g, *source[TERMS_MAX], *moments[TERMS_MAX];
    bool walls;
    float* irradiance; /* six a cell */
    ty_ordinates_stats stats;
    double bytes; /* of the rank that needs most */
} whole;

static ty_angular_quadrature directions, more;
static float around[3][8 * 4 * TY_ORDINATES_MAX];
static pthread_mutex_t result_lock = PTHREAD_MUTEX_INITIALIZER;

static size_t cells_of(const int32_t size[3]) {
    return (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
}

/* ---- parts ---- */

static float* take_part(const whole* w, const ty_domain* d, float* all) {
    int32_t size[3];
    size_of_part(d, size);
    float* part = calloc(cells_of(size), sizeof *part);
    copy_part(w->def.size, d, 1, all, part, false);
    return part;
}

static void solve_part(ty_comm* comm, void* user) {
    whole* w = user;
    const int32_t pairs = w->def.size[0] > 20 ? 2 : 1, unit[3] = {pairs, pairs, 1};
    ty_domain d;
    require(ty_domain_create(comm, w->def.size, w->cuts, unit, 1, &d));
    ty_ordinates_def def = w->def;
    size_of_part(&d, def.size);
    const size_t cells = cells_of(def.size);
    float *extinction = take_part(w, &d, w->extinction), *scattering = take_part(w, &d, w->scattering),
          *g = take_part(w, &d, w->g), *source[TERMS_MAX], *moments[TERMS_MAX];
    for (int32_t t = 0; t < def.source_terms; ++t) source[t] = take_part(w, &d, w->source[t]);
    const int32_t kept = def.output_order * def.output_order;
    for (int32_t t = 0; t < kept; ++t) moments[t] = calloc(cells, sizeof(float));
    part_sides s = make_sides(w->def.size, &d, w->walls ? 11 : 0);
    for (int32_t i = 0; i < s.count; ++i) {
        s.given[0][i] = 0.15f * (float)(s.face[i] + 1);
        s.given[1][i] = s.face[i] == 2 ? 3 : 0;
    }
    def.walls = (ty_ordinates_faces){.count = s.count,
                                     .first = s.first,
                                     .x = s.x,
                                     .face = s.face,
                                     .albedo = s.given[0],
                                     .emission = s.given[1],
                                     .irradiance = s.found};
    def.domain = comm != NULL ? &d : NULL;
    def.extinction = extinction;
    def.scattering = scattering;
    def.g = g;
    def.source = (const float* const*)source;
    ty_context_def context_def = ty_default_context_def();
    ty_context* context = NULL;
    context_def.threads = 1;
    require(ty_context_create(&context_def, &context) == TY_OK);
    ty_ordinates_stats stats;
    if (ty_ordinates_solve(context, &def, moments, NULL, 0, &stats) != TY_OK) {
        fprintf(stderr, "%s\n", ty_take_error(context));
        require(false);
    }
    pthread_mutex_lock(&result_lock);
    for (int32_t t = 0; t < kept; ++t) copy_part(w->def.size, &d, 1, w->moments[t], moments[t], true);
    for (int32_t i = 0; i < s.count; ++i) w->irradiance[s.global[i]] = s.found[i];
    w->bytes = fmax(w->bytes, stats.bytes);
    w->stats = stats;
    pthread_mutex_unlock(&result_lock);
    ty_context_destroy(context);
    free_sides(&s);
    free(extinction);
    free(scattering);
    free(g);
    for (int32_t t = 0; t < def.source_terms; ++t) free(source[t]);
    for (int32_t t = 0; t < kept; ++t) free(moments[t]);
    ty_domain_destroy(&d);
}

/* ---- problems ---- */

typedef struct problem {
    const char* name;
    int32_t size[3], bands;
    double thickness; /* of the box, mean free paths of a full cell */
    double g, albedo;
    bool walls, lit, point, accelerated, ends_finer;
} problem;

/* Lumps in vacuum, lit from a corner, from a point or from around. */
static whole make_whole(ty_context* context, const problem* p) {
    whole w = {.def = ty_default_ordinates_def(), .walls = p->walls};
    const size_t cells = cells_of(p->size);
    memcpy(w.def.size, p->size, sizeof p->size);
    w.extinction = calloc(cells, sizeof(float));
    w.scattering = calloc(cells, sizeof(float));
    w.g = calloc(cells, sizeof(float));
    w.irradiance = calloc(6 * cells, sizeof(float));
    for (int32_t t = 0; t < p->bands * p->bands; ++t) w.source[t] = calloc(cells, sizeof(float));
    for (int32_t t = 0; t < TERMS_MAX; ++t) w.moments[t] = calloc(cells, sizeof(float));
    for (int a = 0; a < 3; ++a) w.def.cell[a] = 1.0 / p->size[0];
    w.def.bands = p->bands;
    w.def.output_order = p->ends_finer ? 4 : p->bands;
    w.def.source_terms = p->bands * p->bands;
    w.def.accelerated = p->accelerated;
    w.def.tolerance = 1e-4;
    w.def.set = &directions;
    size_t i = 0;
    for (int32_t z = 0; z < p->size[2]; ++z)
        for (int32_t y = 0; y < p->size[1]; ++y)
            for (int32_t x = 0; x < p->size[0]; ++x, ++i) {
                const double at[3] = {(x + 0.5) / p->size[0], (y + 0.5) / p->size[1], (z + 0.5) / p->size[2]};
                const double lump = sin(9 * at[0] + 1) * sin(11 * at[1] + 2) * sin(7 * at[2] + 0.5);
                w.extinction[i] = lump > -0.1 ? (float)(p->thickness * (0.1 + fabs(lump))) : 0;
                w.scattering[i] = (float)p->albedo * w.extinction[i];
                w.g[i] = (float)(p->g * at[0]);
                const double far = hypot(hypot(at[0] - 0.3, at[1] - 0.6), at[2] - 0.55);
                const double beam = p->point ? 0.01 / (far * far + 1e-3) : exp(-2 * (1 - at[2]));
                if (p->lit) continue;
                w.source[0][i] = w.scattering[i] * (float)beam;
                if (p->bands > 1) w.source[2][i] = -0.6f * w.source[0][i];
            }
    uint64_t seed = 3;
    for (int axis = 0; axis < 3 && p->lit; ++axis)
        for (size_t k = 0; k < sizeof around[0] / sizeof(float); ++k) around[axis][k] = (float)uniform(&seed);
    if (p->lit)
        w.def.boundary_radiance =
            (ty_boundary_radiance){.across = {around[0], around[1], around[2]}, .patches = {2, 2, 2}};
    if (p->ends_finer && !p->lit) w.def.final_set = &more;
    assert_int_equal(ty_angular_quadrature_create(context, 48, &directions, NULL), TY_OK);
    assert_int_equal(ty_angular_quadrature_create(context, 96, &more, NULL), TY_OK);
    return w;
}

static void free_whole(whole* w) {
    free(w->extinction);
    free(w->scattering);
    free(w->g);
    free(w->irradiance);
    for (int t = 0; t < TERMS_MAX; ++t) {
        free(w->source[t]);
        free(w->moments[t]);
    }
}

static double difference(const float* a, const float* b, size_t count) {
    double sum = 0, squares = 0;
    for (size_t i = 0; i < count; ++i) {
        sum += ((double)a[i] - (double)b[i]) * ((double)a[i] - (double)b[i]);
        squares += (double)b[i] * (double)b[i];
    }
    return squares > 0 ? sqrt(sum / squares) : sqrt(sum);
}

static const problem problems[] = {
    {"sun on lumps", {14, 13, 11}, 3, 20, 0.85, 0.99, false, false, false, false, false},
    {"walls", {9, 14, 10}, 2, 6, 0.3, 0.9, true, false, false, false, false},
    {"light from around", {12, 9, 8}, 2, 8, 0, 0.95, false, true, false, false, false},
    {"accelerated", {14, 13, 11}, 3, 12, 0.85, 0.999, false, false, false, true, false},
    {"accelerated walls", {9, 14, 10}, 2, 6, 0.3, 0.98, true, false, true, true, false},
    {"accelerated isotropic", {12, 9, 8}, 1, 8, 0, 1, false, true, false, true, true},
    {"divided multigrid", {37, 40, 34}, 1, 25, 0, 0.99, false, false, true, true, false},
    {"a start from coarse cells", {28, 27, 25}, 3, 3, 0.6, 0.99, false, false, false, true, false},
    {"a last sweep", {9, 12, 7}, 1, 5, 0, 0.8, false, false, true, false, true},
};

typedef struct cut_case {
    int32_t ranks;
    unsigned cuts;
} cut_case;

static const cut_case cuts[] = {{2, TY_CUT_Y}, {2, TY_CUT_X}, {4, TY_CUT_X | TY_CUT_Y}, {6, TY_CUT_X | TY_CUT_Y}};

static void check_problem(ty_context* context, const problem* p) {
    whole w = make_whole(context, p);
    const size_t cells = cells_of(p->size);
    float* fluence = calloc(cells, sizeof *fluence);
    float* irradiance = calloc(6 * cells, sizeof *irradiance);
    run_ranks(1, solve_part, &w);
    assert_true(w.stats.converged);
    memcpy(fluence, w.moments[0], cells * sizeof *fluence);
    memcpy(irradiance, w.irradiance, 6 * cells * sizeof *irradiance);
    const ty_ordinates_stats one = w.stats;
    for (size_t i = 0; i < sizeof cuts / sizeof *cuts; ++i) {
        w.cuts = cuts[i].cuts;
        memset(w.moments[0], 0, cells * sizeof *fluence);
        run_ranks(cuts[i].ranks, solve_part, &w);
        printf("%s, %d ranks: %d sweeps, %d by one; fluence %g, irradiance %g, leaving %g\n", p->name,
               (int)cuts[i].ranks, (int)w.stats.sweeps, (int)one.sweeps, difference(w.moments[0], fluence, cells),
               difference(w.irradiance, irradiance, 6 * cells), w.stats.leaving / one.leaving - 1);
        assert_true(w.stats.converged);
        assert_true(abs(w.stats.sweeps - one.sweeps) <= 1);
        assert_true(difference(w.moments[0], fluence, cells) < 4e-7);
        assert_true(difference(w.irradiance, irradiance, 6 * cells) < 4e-7);
        const double power = one.emitted + one.entering + one.walls_emitted;
        assert_close(w.stats.leaving, one.leaving, 1e-7 * power);
        assert_close(w.stats.absorbed, one.absorbed, 1e-7 * power);
        assert_close(w.stats.emitted + w.stats.entering + w.stats.walls_emitted, power, 1e-7 * power);
    }
    free(fluence);
    free(irradiance);
    free_whole(&w);
}

static void ranks_solve_as_one(void** state) {
    for (size_t i = 0; i < sizeof problems / sizeof *problems; ++i) check_problem(*state, &problems[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ranks_solve_as_one),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
