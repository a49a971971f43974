/* Discrete ordinates solved: with and without acceleration, against what is known of even, thick and empty media. */
#include "checks.h"
#include "on_device.h"

#include "solve/diffusion/diffusion.h"
#include "solve/ordinates/ordinates.h"

#include <stdio.h>

#define Y_0 0.28209479177387814 /* 1 / sqrt(4 pi) */

enum { TERMS_MAX = TY_SCATTERING_ORDER_MAX * TY_SCATTERING_ORDER_MAX };

static ty_angular_quadrature directions; /* of the problem at hand */

typedef struct problem {
    ty_ordinates_def def;
    ty_ordinates_stats stats;
    size_t cells;
    float *extinction, *scattering, *g;
    float *source[TERMS_MAX], *moments[TERMS_MAX];
    const float* sources[TERMS_MAX];
} problem;

static float* make_floats(size_t count) {
    float* floats = calloc(count, sizeof *floats);
    assert_non_null(floats);
    return floats;
}

/* A box whose x axis is 1 m long, cells cubes; an even medium without absorption, dark. */
static problem make_problem(ty_context* context, const int32_t size[3], int32_t bands, double extinction, double g) {
    problem p = {.def = ty_default_ordinates_def(), .cells = 1};
    assert_int_equal(ty_angular_quadrature_create(context, 48, &directions, NULL), TY_OK);
    for (int axis = 0; axis < 3; ++axis) {
        p.def.size[axis] = size[axis];
        p.def.cell[axis] = 1.0 / size[0];
        p.cells *= (size_t)size[axis];
    }
    p.extinction = make_floats(p.cells);
    p.scattering = make_floats(p.cells);
    p.g = make_floats(p.cells);
    for (size_t i = 0; i < p.cells; ++i) {
        p.extinction[i] = p.scattering[i] = (float)extinction;
        p.g[i] = (float)g;
    }
    for (int t = 0; t < TERMS_MAX; ++t) p.moments[t] = make_floats(p.cells);
    for (int t = 0; t < bands * bands; ++t) p.sources[t] = p.source[t] = make_floats(p.cells);
    p.def.set = &directions;
    p.def.bands = p.def.output_order = bands;
    p.def.extinction = p.extinction;
    p.def.scattering = p.scattering;
    p.def.g = p.g;
    return p;
}

/* The pointers that a problem's def has into it. */
static void point(problem* p) {
    p->def.source = p->sources;
}

static void free_problem(problem* p) {
    free(p->extinction);
    free(p->scattering);
    free(p->g);
    for (int t = 0; t < TERMS_MAX; ++t) {
        free(p->source[t]);
        free(p->moments[t]);
    }
}

static problem make_cube(ty_context* context, int32_t n, int32_t bands, double extinction, double g) {
    const int32_t size[3] = {n, n, n};
    return make_problem(context, size, bands, extinction, g);
}

/* Solves, and asserts that it converged with every moment finite. */
static void solve(ty_context* context, problem* p) {
    point(p);
    if (ty_ordinates_solve(context, &p->def, p->moments, NULL, 0, &p->stats) != TY_OK)
        fail_msg("%s", ty_take_error(context));
    if (!p->stats.converged) fail_msg("%g is left after %d sweeps", p->stats.change, (int)p->stats.sweeps);
    for (int t = 0; t < p->def.output_order * p->def.output_order; ++t)
        for (size_t i = 0; i < p->cells; ++i) assert_true(isfinite(p->moments[t][i]));
}

static void assert_energy(const problem* p) {
    assert_true(p->stats.emitted > 0);
    assert_close(p->stats.absorbed + p->stats.leaving, p->stats.emitted, 1e-3 * p->stats.emitted);
}

/* Rms of a - b over that of b. */
static double difference(const float* a, const float* b, size_t count) {
    double sum = 0, squares = 0;
    for (size_t i = 0; i < count; ++i) {
        sum += ((double)a[i] - (double)b[i]) * ((double)a[i] - (double)b[i]);
        squares += (double)b[i] * (double)b[i];
    }
    return sqrt(sum / squares);
}

static void fill_problem(problem* p, void (*fill)(problem* p, size_t i, const double at[3])) {
    size_t i = 0;
    for (int32_t z = 0; z < p->def.size[2]; ++z)
        for (int32_t y = 0; y < p->def.size[1]; ++y)
            for (int32_t x = 0; x < p->def.size[0]; ++x) {
                const double at[3] = {(x + 0.5) * p->def.cell[0], (y + 0.5) * p->def.cell[1],
                                      (z + 0.5) * p->def.cell[2]};
                fill(p, i++, at);
            }
}

/* ---- media ---- */

/* First-collision source of a cell for a beam along -z through 1 m of the even scaled medium. */
static void fill_beam(problem* p, size_t i, const double at[3]) {
    const double forward = pow((double)p->g[i], p->def.bands), half = p->def.cell[2] / 2;
    const double sigma = (double)p->extinction[i] - forward * (double)p->scattering[i], depth = 1 - at[2];
    p->source[0][i] = (float)(Y_0 * (exp(-sigma * (depth - half)) - exp(-sigma * (depth + half))) / (2 * half));
}

/* Lumps of up to 30/m, of which a hundredth absorbs, in vacuum. */
static void fill_lumps(problem* p, size_t i, const double at[3]) {
    const double lump = sin(9 * at[0] + 1) * sin(11 * at[1] + 2) * sin(7 * at[2] + 0.5);
    p->extinction[i] = lump > 0.1 ? (float)(30 * lump) : 0;
    p->scattering[i] = 0.99f * p->extinction[i];
    p->source[0][i] = p->scattering[i];
}

/* Blocks of 40/m and 4e-3/m in turn. */
static void fill_blocks(problem* p, size_t i, const double at[3]) {
    const bool dense = (((int)(at[0] * 4) + (int)(at[1] * 4) + (int)(at[2] * 4)) & 1) != 0;
    p->extinction[i] = p->scattering[i] = dense ? 40 : 4e-3f;
    p->source[0][i] = p->scattering[i];
}

static void fill_even(problem* p, size_t i, const double at[3]) {
    (void)at;
    p->source[0][i] = 1;
}

/* ---- tests ---- */

/* Far from the faces of a thick box moments are those of an endless medium. */
static void middles_of_thick_boxes_are_endless_media(void** state) {
    for (int accelerated = 0; accelerated < 2; ++accelerated) {
        problem p = make_cube(*state, 31, 3, 40, 0.6);
        for (size_t i = 0; i < p.cells; ++i) {
            p.scattering[i] = 20;
            for (int t = 0; t < 9; ++t) p.source[t][i] = t == 0 ? 3 : 0.5f;
        }
        p.def.source_terms = 9;
        p.def.accelerated = accelerated != 0;
        p.def.tolerance = 1e-4;
        solve(*state, &p);
        const size_t middle = p.cells / 2;
        for (int t = 0; t < 9; ++t) {
            const int l = t == 0 ? 0 : t < 4 ? 1 : 2;
            const double expected = (t == 0 ? 3 : 0.5) / (40 - 20 * pow(0.6, l));
            assert_close((double)p.moments[t][middle], expected, 2e-3 * expected);
        }
        assert_energy(&p);
        free_problem(&p);
    }
}

typedef struct pair_case {
    void (*fill)(problem* p, size_t i, const double at[3]);
    int32_t size[3];
    int32_t bands;
    double extinction, g;
} pair_case;

static const pair_case pairs[] = {
    {fill_beam, {12, 12, 12}, 1, 4, 0},    {fill_beam, {12, 12, 12}, 4, 4, 0.7}, {fill_beam, {12, 12, 12}, 6, 4, 0.96},
    {fill_beam, {12, 12, 12}, 3, 4, -0.5}, {fill_beam, {8, 8, 8}, 2, 0.01, 0.3}, {fill_lumps, {12, 12, 12}, 1, 0, 0},
    {fill_lumps, {13, 12, 9}, 4, 0, 0.8},  {fill_blocks, {12, 12, 12}, 1, 0, 0}, {fill_blocks, {12, 12, 12}, 4, 0, 0.7},
    {fill_even, {1, 1, 1}, 2, 3, 0.5},     {fill_even, {1, 7, 20}, 2, 3, 0.5},   {fill_even, {24, 2, 1}, 1, 30, 0},
    {fill_even, {8, 8, 8}, 1, 40, 0},
};

/* Both ways lead to one field, one of them soon, and lose no energy. */
static void acceleration_changes_sweeps_alone(void** state) {
    for (size_t k = 0; k < sizeof pairs / sizeof *pairs; ++k) {
        const pair_case* c = &pairs[k];
        problem plain = make_problem(*state, c->size, c->bands, c->extinction, c->g);
        problem fast = make_problem(*state, c->size, c->bands, c->extinction, c->g);
        plain.def.accelerated = false;
        plain.def.tolerance = fast.def.tolerance = 1e-4;
        fill_problem(&plain, c->fill);
        fill_problem(&fast, c->fill);
        solve(*state, &plain);
        solve(*state, &fast);
        const double off = difference(fast.moments[0], plain.moments[0], plain.cells);
        if (!(off <= 4e-4)) fail_msg("case %d: %g", (int)k, off);
        if (fast.stats.sweeps > 12) fail_msg("case %d: %d sweeps", (int)k, (int)fast.stats.sweeps);
        assert_energy(&plain);
        assert_energy(&fast);
        free_problem(&plain);
        free_problem(&fast);
    }
}

/* 1000 and 10,000 free paths across, nothing absorbed: diffusion. */
static void thick_boxes_diffuse(void** state) {
    for (int thicker = 0; thicker < 2; ++thicker) {
        problem p = make_cube(*state, 32, 1, thicker != 0 ? 10000 : 1000, 0);
        fill_problem(&p, fill_even);
        solve(*state, &p);
        ty_diffusion_def def = ty_default_diffusion_def();
        ty_diffusion_out out = {.fluence = make_floats(p.cells)};
        memcpy(def.size, p.def.size, sizeof def.size);
        memcpy(def.cell, p.def.cell, sizeof def.cell);
        def.limiter = TY_LIMITER_NONE;
        def.extinction = p.extinction;
        def.source = p.source[0];
        assert_int_equal(ty_diffusion_solve(*state, &def, &out, NULL), TY_OK);
        const double off = difference(p.moments[0], out.fluence, p.cells);
        if (!(off < 0.01)) fail_msg("%g", off);
        assert_true(p.stats.sweeps <= 5);
        free(out.fluence);
        free_problem(&p);
    }
}

static void sweeps_hardly_depend_on_thickness(void** state) {
    static const double extinctions[] = {0.01, 0.1, 1, 10, 100, 1000, 10000};
    for (int k = 0; k < 7; ++k) {
        problem p = make_cube(*state, 16, 3, extinctions[k], 0.5);
        fill_problem(&p, fill_beam);
        solve(*state, &p);
        if (p.stats.sweeps > 8) fail_msg("%g/m: %d sweeps", extinctions[k], (int)p.stats.sweeps);
        free_problem(&p);
    }
}

static void a_start_saves_sweeps_and_changes_nothing_else(void** state) {
    problem first = make_cube(*state, 12, 3, 20, 0.5), again = make_cube(*state, 12, 3, 20, 0.5);
    fill_problem(&first, fill_beam);
    fill_problem(&again, fill_beam);
    solve(*state, &first);
    again.def.start = (const float* const*)first.moments;
    solve(*state, &again);
    assert_true(again.stats.sweeps < first.stats.sweeps);
    assert_true(difference(again.moments[0], first.moments[0], first.cells) < 2e-3);
    assert_energy(&again);
    /* Nor does a start that is far off. */
    for (size_t i = 0; i < first.cells; ++i)
        for (int t = 0; t < 9; ++t) first.moments[t][i] *= i % 3 == 0 ? 3 : 0.1f;
    solve(*state, &again);
    problem none = make_cube(*state, 12, 3, 20, 0.5);
    fill_problem(&none, fill_beam);
    solve(*state, &none);
    assert_true(difference(again.moments[0], none.moments[0], none.cells) < 2e-3);
    free_problem(&first);
    free_problem(&again);
    free_problem(&none);
}

/* The same with all of its moments, which thin boxes of many cells take coarser ones for. */
static void fill_directed_beam(problem* p, size_t i, const double at[3]) {
    const double g = (double)p->g[i], cut = pow(g, p->def.bands);
    fill_beam(p, i, at);
    for (int l = p->def.bands - 1; l >= 0; --l) {
        const double along = sqrt(2 * l + 1) * (l % 2 == 0 ? 1 : -1); /* Y_l0 at -z over Y_00 */
        p->source[l * (l + 1)][i] = (float)(along * (pow(g, l) - cut) / (1 - cut) * (double)p->source[0][i]);
    }
}

static void coarse_cells_save_work_and_change_nothing_else(void** state) {
    static const int32_t size[3] = {28, 27, 25}, few[3] = {28, 27, 21};
    double left[2]; /* estimates after two sweeps */
    for (int box = 0; box < 2; ++box) {
        problem p = make_problem(*state, box == 0 ? size : few, 5, 10, 0.7);
        problem dark = make_problem(*state, box == 0 ? size : few, 5, 10, 0.7);
        float* none = make_floats(p.cells);
        const float* start[25];
        for (int t = 0; t < 25; ++t) start[t] = none;
        dark.def.start = start;
        p.def.source_terms = dark.def.source_terms = 25;
        fill_problem(&p, fill_directed_beam);
        fill_problem(&dark, fill_directed_beam);
        solve(*state, &p);
        solve(*state, &dark);
        assert_energy(&p);
        double history[2];
        assert_int_equal(ty_ordinates_solve(*state, &p.def, p.moments, history, 2, &p.stats), TY_OK);
        left[box] = history[1];
        for (int t = 0; t < 25; ++t) {
            double off = 0, all = 0;
            for (size_t i = 0; i < p.cells; ++i) {
                off += pow((double)p.moments[t][i] - (double)dark.moments[t][i], 2);
                all += pow((double)dark.moments[0][i], 2);
            }
            if (!(off < 2e-3 * 2e-3 * all)) fail_msg("term %d: %g", t, sqrt(off / all));
        }
        free(none);
        free_problem(&p);
        free_problem(&dark);
    }
    if (!(left[0] < 0.5 * left[1])) fail_msg("%g is left, and %g without coarse cells", left[0], left[1]);
}

/* Nor do they need one in thick cells, where one that is far off does no harm. */
static void thick_cells_need_no_start(void** state) {
    problem p = make_cube(*state, 16, 1, 1000, 0), started = make_cube(*state, 16, 1, 1000, 0);
    fill_problem(&p, fill_even);
    fill_problem(&started, fill_even);
    solve(*state, &p);
    float* wrong = make_floats(p.cells);
    const float* start[] = {wrong};
    started.def.start = start;
    solve(*state, &started);
    assert_true(difference(started.moments[0], p.moments[0], p.cells) < 2e-3);
    free(wrong);
    free_problem(&p);
    free_problem(&started);
}

/* More moments come out of the same light. */
static void more_moments_can_be_kept(void** state) {
    problem few = make_cube(*state, 10, 2, 5, 0.5), many = make_cube(*state, 10, 2, 5, 0.5);
    few.def.tolerance = many.def.tolerance = 1e-5;
    fill_problem(&few, fill_beam);
    fill_problem(&many, fill_beam);
    many.def.output_order = 5;
    solve(*state, &few);
    solve(*state, &many);
    assert_int_equal(many.stats.sweeps, few.stats.sweeps + 1);
    for (int t = 0; t < 4; ++t) assert_true(difference(many.moments[t], few.moments[t], few.cells) < 1e-4);
    double squares = 0;
    for (size_t i = 0; i < many.cells; ++i) squares += (double)many.moments[6][i] * (double)many.moments[6][i];
    assert_true(squares > 0);
    assert_energy(&many);
    free_problem(&few);
    free_problem(&many);
}

/* One cell that glows in thin air, between cells of which a few hundredths scatter. */
static void fill_lamp(problem* p, size_t i, const double at[3]) {
    const double off = fmax(fmax(fabs(at[0] - 0.5), fabs(at[1] - 0.5)), fabs(at[2] - 0.5));
    p->source[0][i] = off < 0.01 ? 1 : 0;
}

/* Mean relative error of cells at some distance from the inverse square of it. */
static double off_inverse_square(const problem* p) {
    const int32_t n = p->def.size[0], middle = n / 2;
    double sum = 0;
    int count = 0;
    for (int32_t i = 0; i < n * n * n; ++i) {
        const int32_t x = i % n - middle, y = i / n % n - middle, z = i / n / n - middle;
        const double square = (double)(x * x + y * y + z * z);
        if (square < 36 || square > 100) continue;
        const double expected = p->def.cell[0] / (4 * 3.141592653589793 * square);
        sum += fabs((double)p->moments[0][i] / expected - 1);
        ++count;
    }
    return sum / count;
}

/* Few directions leave a lamp in vacuum as rays; more of them in a last sweep are as good as more all along. */
static void a_last_sweep_of_more_directions_shows_no_rays(void** state) {
    static ty_angular_quadrature more;
    double off[2];
    assert_int_equal(ty_angular_quadrature_create(*state, 400, &more, NULL), TY_OK);
    for (int i = 0; i < 2; ++i) {
        problem p = make_cube(*state, 21, 1, 0.01, 0);
        fill_problem(&p, fill_lamp);
        if (i == 1) p.def.final_set = &more;
        solve(*state, &p);
        assert_energy(&p);
        off[i] = off_inverse_square(&p);
        free_problem(&p);
    }
    printf("off the inverse square: %.3f with 48 directions, %.3f with 400 in a last sweep\n", off[0], off[1]);
    assert_true(off[1] < 0.5 * off[0]);
}

static void threads_change_nothing(void** state) {
    float* first = NULL;
    for (int32_t threads = 1; threads <= 3; ++threads) {
        ty_context* context = make_context(threads);
        problem p = make_cube(context, 17, 3, 0, 0.6);
        fill_problem(&p, fill_lumps);
        solve(context, &p);
        if (first == NULL) {
            first = make_floats(9 * p.cells);
            for (int t = 0; t < 9; ++t) memcpy(first + (size_t)t * p.cells, p.moments[t], p.cells * sizeof(float));
        }
        for (int t = 0; t < 9; ++t)
            assert_memory_equal(first + (size_t)t * p.cells, p.moments[t], p.cells * sizeof(float));
        free_problem(&p);
        ty_context_destroy(context);
    }
    free(first);
    (void)state;
}

static void darkness_stays_dark(void** state) {
    for (int accelerated = 0; accelerated < 2; ++accelerated) {
        problem p = make_cube(*state, 6, 2, accelerated != 0 ? 10 : 0, 0.5);
        p.def.accelerated = accelerated != 0;
        solve(*state, &p);
        for (size_t i = 0; i < p.cells; ++i) assert_true(!(p.moments[0][i] > 0) && !(p.moments[0][i] < 0));
        free_problem(&p);
    }
}

/* Too few sweeps are no error, and what changes is noted after each. */
static void sweeps_can_be_bounded(void** state) {
    problem p = make_cube(*state, 8, 1, 50, 0);
    fill_problem(&p, fill_beam);
    point(&p);
    p.def.accelerated = false;
    p.def.sweeps = 5;
    double history[8] = {0};
    assert_int_equal(ty_ordinates_solve(*state, &p.def, p.moments, history, 8, &p.stats), TY_OK);
    assert_false(p.stats.converged);
    assert_int_equal(p.stats.sweeps, 5);
    assert_true(history[4] > p.def.tolerance && !(history[5] > 0));
    assert_true(p.stats.bytes > 0 && p.stats.seconds >= p.stats.sweep_seconds);
    free_problem(&p);
}

static bool stop(void* user, const ty_progress* progress) {
    assert_true(progress->fraction >= 0 && progress->fraction <= 1);
    ++*(int*)user;
    return false;
}

static void work_can_be_cancelled(void** state) {
    problem p = make_cube(*state, 16, 1, 1000, 0);
    fill_problem(&p, fill_even);
    point(&p);
    int calls = 0;
    p.def.accelerated = false;
    p.def.tolerance = 1e-9;
    p.def.sweeps = 1000000;
    p.def.progress = stop;
    p.def.progress_user = &calls;
    assert_int_equal(ty_ordinates_solve(*state, &p.def, p.moments, NULL, 0, &p.stats), TY_CANCELLED);
    assert_int_equal(calls, 1);
    assert_true(p.moments[0][p.cells / 2] > 0);
    free_problem(&p);
}

static void broken_defs_are_refused(void** state) {
    static const bad_field fields[] = {
        {offsetof(ty_ordinates_def, size), FIELD_INT, 0, "size[0]"},
        {offsetof(ty_ordinates_def, size), FIELD_INT, 1025, "size[0]"},
        {offsetof(ty_ordinates_def, cell), FIELD_DOUBLE, 0, "cell[0]"},
        {offsetof(ty_ordinates_def, cell), FIELD_DOUBLE, NAN, "cell[0]"},
        {offsetof(ty_ordinates_def, bands), FIELD_INT, 0, "bands"},
        {offsetof(ty_ordinates_def, bands), FIELD_INT, 13, "bands"},
        {offsetof(ty_ordinates_def, output_order), FIELD_INT, 1, "output_order"},
        {offsetof(ty_ordinates_def, output_order), FIELD_INT, 13, "output_order"},
        {offsetof(ty_ordinates_def, source_terms), FIELD_INT, 2, "source_terms"},
        {offsetof(ty_ordinates_def, tolerance), FIELD_DOUBLE, 0, "tolerance"},
        {offsetof(ty_ordinates_def, tolerance), FIELD_DOUBLE, 1, "tolerance"},
        {offsetof(ty_ordinates_def, sweeps), FIELD_INT, -1, "sweeps"},
    };
    problem p = make_cube(*state, 4, 2, 1, 0.5);
    point(&p);
    for (size_t i = 0; i < sizeof fields / sizeof *fields; ++i) {
        ty_ordinates_def def = p.def;
        set_field(&def, &fields[i]);
        assert_int_equal(ty_ordinates_solve(*state, &def, p.moments, NULL, 0, NULL), TY_ERROR_ARGUMENT);
        assert_error(*state, fields[i].words);
    }
    static const size_t pointers[] = {offsetof(ty_ordinates_def, set), offsetof(ty_ordinates_def, extinction),
                                      offsetof(ty_ordinates_def, scattering), offsetof(ty_ordinates_def, g),
                                      offsetof(ty_ordinates_def, source)};
    for (size_t i = 0; i < sizeof pointers / sizeof *pointers; ++i) {
        ty_ordinates_def def = p.def;
        memset((char*)&def + pointers[i], 0, sizeof(void*));
        assert_int_equal(ty_ordinates_solve(*state, &def, p.moments, NULL, 0, NULL), TY_ERROR_ARGUMENT);
        assert_error(*state, "ordinates: ");
    }
    static const ty_angular_quadrature none;
    const float inflow[TY_ORDINATES_MAX] = {1};
    for (int i = 0; i < 2; ++i) {
        ty_ordinates_def def = p.def;
        def.final_set = i == 0 ? &none : def.set;
        for (int a = 0; a < 3 && i == 1; ++a) def.boundary_radiance.across[a] = inflow;
        assert_int_equal(ty_ordinates_solve(*state, &def, p.moments, NULL, 0, NULL), TY_ERROR_ARGUMENT);
        assert_error(*state, "ordinates: final_set");
    }
    free_problem(&p);
}

/* Values of one cell that no medium and no light has. */
static void broken_cells_are_refused(void** state) {
    problem p = make_cube(*state, 4, 2, 1, 0.5);
    point(&p);
    float* const planes[] = {p.extinction, p.extinction, p.scattering, p.scattering, p.g, p.g, p.source[0]};
    const float values[] = {-1, INFINITY, -1, 1.1f, 1, NAN, NAN};
    for (int i = 0; i < 7; ++i) {
        const float before = planes[i][13];
        planes[i][13] = values[i];
        assert_int_equal(ty_ordinates_solve(*state, &p.def, p.moments, NULL, 0, NULL), TY_ERROR_ARGUMENT);
        assert_error(*state, "of a cell");
        planes[i][13] = before;
    }
    solve(*state, &p);
    free_problem(&p);
}

/* The host twin of devices takes as many sweeps, to the same light within rounding: measured 6e-7 of a cell's. */
static void a_device_solves_the_same(void** state) {
    (void)state;
    ty_context* contexts[2] = {context_on("cpu", 2), context_on("host", 2)};
    problem problems[2];
    for (int i = 0; i < 2; ++i) {
        problem* p = &problems[i];
        *p = make_cube(contexts[i], 10, 2, 12, 0.5);
        p->def.accelerated = true;
        p->def.output_order = 3; /* a final sweep */
        for (size_t c = 0; c < p->cells; ++c) {
            p->extinction[c] = (float)(4 + c % 13);
            p->scattering[c] = 0.9f * p->extinction[c];
        }
        p->source[0][333] = 1;
        solve(contexts[i], p);
    }
    double worst = 0;
    for (int t = 0; t < 9; ++t)
        for (size_t c = 0; c < problems[0].cells; ++c)
            worst = fmax(worst, fabs((double)problems[1].moments[t][c] - (double)problems[0].moments[t][c]) /
                                    (1e-6 + (double)problems[0].moments[0][c]));
    printf("%d and %d sweeps, %.1e\n", (int)problems[0].stats.sweeps, (int)problems[1].stats.sweeps, worst);
    assert_int_equal(problems[0].stats.sweeps, problems[1].stats.sweeps);
    assert_true(worst > 0 && worst <= 3e-6);
    for (int i = 0; i < 2; ++i) {
        free_problem(&problems[i]);
        ty_context_destroy(contexts[i]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(middles_of_thick_boxes_are_endless_media),
        cmocka_unit_test(acceleration_changes_sweeps_alone),
        cmocka_unit_test(thick_boxes_diffuse),
        cmocka_unit_test(sweeps_hardly_depend_on_thickness),
        cmocka_unit_test(a_start_saves_sweeps_and_changes_nothing_else),
        cmocka_unit_test(coarse_cells_save_work_and_change_nothing_else),
        cmocka_unit_test(thick_cells_need_no_start),
        cmocka_unit_test(more_moments_can_be_kept),
        cmocka_unit_test(a_last_sweep_of_more_directions_shows_no_rays),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(darkness_stays_dark),
        cmocka_unit_test(sweeps_can_be_bounded),
        cmocka_unit_test(work_can_be_cancelled),
        cmocka_unit_test(broken_defs_are_refused),
        cmocka_unit_test(broken_cells_are_refused),
        cmocka_unit_test(a_device_solves_the_same),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
