/* Walls of discrete ordinates: sweeps between them, and light that they send to and fro. */
#include "checks.h"
#include "base/context.h"
#include "solve/ordinates/job.h"

#include <string.h>

#define PI 3.141592653589793
#define SQRT_4PI 3.5449077018110318

/* A box whose faces, and some of those between its cells, are walls. */
typedef struct walled_box {
    int32_t size[3];
    double cell[3];
    ptrdiff_t cells;
    float *extinction, *scattering, *g, *source;
    uint8_t* closed; /* of each cell: bit 2 * axis, and 1 more for the upper face */
    int32_t count, *first, *x;
    uint8_t* face;
    float *albedo, *emission, *arrived;
    ty_angular_quadrature set;
} walled_box;

static walled_box* make_box(void* context, int32_t nx, int32_t ny, int32_t nz) {
    walled_box* box = calloc(1, sizeof *box);
    *box = (walled_box){.size = {nx, ny, nz}, .cell = {0.2, 0.3, 0.1}, .cells = (ptrdiff_t)nx * ny * nz};
    const size_t cells = (size_t)box->cells;
    box->extinction = calloc(cells, sizeof(float));
    box->scattering = calloc(cells, sizeof(float));
    box->g = calloc(cells, sizeof(float));
    box->source = calloc(cells, sizeof(float));
    box->closed = calloc(cells, 1);
    assert_int_equal(ty_angular_quadrature_create(context, 96, &box->set, NULL), TY_OK);
    return box;
}

static void free_box(walled_box* box) {
    void* const all[] = {box->extinction, box->scattering, box->g,      box->source,   box->closed, box->first,
                         box->x,          box->face,       box->albedo, box->emission, box->arrived};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i) free(all[i]);
    free(box);
}

static ptrdiff_t at_of(const walled_box* box, const int32_t at[3]) {
    return ((ptrdiff_t)at[2] * box->size[1] + at[1]) * box->size[0] + at[0];
}

/* The face of a cell towards the next one up along an axis, or the box's; lower: the box's below the first cell. */
static void close_face(walled_box* box, const int32_t at[3], int axis, bool lower) {
    int32_t next[3] = {at[0], at[1], at[2]};
    ++next[axis];
    box->closed[at_of(box, at)] |= (uint8_t)(1 << (2 * axis + !lower));
    if (!lower && next[axis] < box->size[axis]) box->closed[at_of(box, next)] |= (uint8_t)(1 << 2 * axis);
}

static void close_all_around(walled_box* box) {
    int32_t at[3];
    for (at[2] = 0; at[2] < box->size[2]; ++at[2])
        for (at[1] = 0; at[1] < box->size[1]; ++at[1])
            for (at[0] = 0; at[0] < box->size[0]; ++at[0])
                for (int a = 0; a < 3; ++a) {
                    if (at[a] == 0) close_face(box, at, a, true);
                    if (at[a] == box->size[a] - 1) close_face(box, at, a, false);
                }
}

/* Lists sides; they reflect and send the same. */
static void list_sides(walled_box* box, float albedo, float emission) {
    const size_t rows = (size_t)box->size[1] * (size_t)box->size[2], most = 6 * (size_t)box->cells;
    box->first = calloc(rows + 1, sizeof *box->first);
    box->x = calloc(most, sizeof *box->x);
    box->face = calloc(most, 1);
    for (size_t row = 0; row < rows; ++row) {
        for (int32_t x = 0; x < box->size[0]; ++x)
            for (uint8_t f = 0; f < 6; ++f) {
                if ((box->closed[row * (size_t)box->size[0] + (size_t)x] >> f & 1) == 0) continue;
                box->x[box->count] = x;
                box->face[box->count++] = f;
            }
        box->first[row + 1] = box->count;
    }
    box->albedo = calloc((size_t)box->count, sizeof(float));
    box->emission = calloc((size_t)box->count, sizeof(float));
    box->arrived = calloc((size_t)box->count, sizeof(float));
    for (int32_t i = 0; i < box->count; ++i) {
        box->albedo[i] = albedo;
        box->emission[i] = emission;
    }
}

static ty_ordinates_def def_of(const walled_box* box) {
    static const float* source[1];
    ty_ordinates_def def = ty_default_ordinates_def();
    source[0] = box->source;
    memcpy(def.size, box->size, sizeof def.size);
    memcpy(def.cell, box->cell, sizeof def.cell);
    def.set = &box->set;
    def.bands = def.output_order = 1;
    def.extinction = box->extinction;
    def.scattering = box->scattering;
    def.g = box->g;
    def.source = source;
    def.walls = (ty_ordinates_faces){.count = box->count,
                                     .first = box->first,
                                     .x = box->x,
                                     .face = box->face,
                                     .albedo = box->albedo,
                                     .emission = box->emission,
                                     .irradiance = box->arrived};
    return def;
}

static ty_ordinates_stats solve(void* context, const walled_box* box, float* fluence) {
    const ty_ordinates_def def = def_of(box);
    ty_ordinates_stats stats;
    assert_int_equal(ty_ordinates_solve(context, &def, &fluence, NULL, 0, &stats), TY_OK);
    assert_true(stats.converged);
    for (ptrdiff_t i = 0; i < box->cells; ++i) fluence[i] *= (float)SQRT_4PI;
    return stats;
}

static void check_balance(const ty_ordinates_stats* stats) {
    const double in = stats->emitted + stats->walls_emitted;
    assert_close((stats->absorbed + stats->walls_absorbed + stats->leaving) / in, 1, 1e-3);
}

/* ---- what must be ---- */

/* Walls that send and reflect, the medium that scatters, and light that is the same everywhere: 1 / (1 - albedo). */
static void light_between_walls_is_even(void** state) {
    static const float extinctions[] = {0, 1, 40, 400, 4000};
    for (int thick = 0; thick < 6; ++thick) {
        walled_box* box = make_box(*state, 9, 11, 14);
        close_all_around(box);
        for (int32_t y = 2; y < 9; ++y)
            for (int32_t z = 4; z < 14; ++z) close_face(box, (const int32_t[3]){4, y, z}, 0, false);
        for (int32_t x = 1; x < 7; ++x) close_face(box, (const int32_t[3]){x, 5, 6}, 1, false);
        for (int32_t x = 1; x < 7; ++x) close_face(box, (const int32_t[3]){x, 3, 8}, 2, false);
        list_sides(box, 0.6f, 1);
        for (ptrdiff_t i = 0; i < box->cells; ++i)
            box->extinction[i] = box->scattering[i] = extinctions[thick < 5 ? thick : i % 5];
        float* fluence = calloc((size_t)box->cells, sizeof(float));
        const ty_ordinates_stats stats = solve(*state, box, fluence);
        for (ptrdiff_t i = 0; i < box->cells; ++i) assert_close((double)fluence[i], 4 * PI / 0.4, 0.01 * 4 * PI / 0.4);
        for (int32_t i = 0; i < box->count; ++i) assert_close((double)box->arrived[i], PI / 0.4, 0.01 * PI / 0.4);
        assert_close(stats.leaving, 0, 1e-6);
        check_balance(&stats);
        print_message("%d sweeps\n", (int)stats.sweeps);
        free(fluence);
        free_box(box);
    }
}

/* Nothing comes through a wall across the box. */
static void walls_do_not_leak(void** state) {
    for (int axis = 0; axis < 3; ++axis) {
        walled_box* box = make_box(*state, 8, 8, 8);
        int32_t at[3];
        for (ptrdiff_t i = 0; i < box->cells; ++i) {
            box->extinction[i] = 3;
            box->scattering[i] = 2.9f;
            const ptrdiff_t place[3] = {i % 8, i / 8 % 8, i / 64};
            box->source[i] = place[axis] < 4 ? 1 : 0;
            for (int a = 0; a < 3; ++a) at[a] = (int32_t)place[a];
            if (place[axis] == 3) close_face(box, at, axis, false);
        }
        list_sides(box, 0.8f, 0);
        float* fluence = calloc((size_t)box->cells, sizeof(float));
        const ty_ordinates_stats stats = solve(*state, box, fluence);
        check_balance(&stats);
        print_message("wall across axis %d: %d sweeps\n", axis, (int)stats.sweeps);
        for (ptrdiff_t i = 0; i < box->cells; ++i) {
            const ptrdiff_t place[3] = {i % 8, i / 8 % 8, i / 64};
            if (place[axis] < 4)
                assert_true(fluence[i] > 0.1f);
            else
                assert_close((double)fluence[i], 0, 1e-5);
        }
        free(fluence);
        free_box(box);
    }
}

static bool is_above(ptrdiff_t x, ptrdiff_t y, ptrdiff_t z) {
    return 3 * z > 10 + x - y;
}

/* Nor through stairs, but for what the tolerance leaves of corrections, whose coarse cells have both sides. */
static void stairs_do_not_leak(void** state) {
    walled_box* box = make_box(*state, 11, 9, 10);
    for (ptrdiff_t i = 0; i < box->cells; ++i) {
        const int32_t at[3] = {(int32_t)(i % 11), (int32_t)(i / 11 % 9), (int32_t)(i / 99)};
        const bool above = is_above(at[0], at[1], at[2]);
        box->extinction[i] = 6;
        box->scattering[i] = 5.8f;
        box->source[i] = above ? 1 : 0;
        for (int a = 0; a < 3; ++a)
            if (above != is_above(at[0] + (a == 0), at[1] + (a == 1), at[2] + (a == 2)) && at[a] + 1 < box->size[a])
                close_face(box, at, a, false);
    }
    list_sides(box, 0.8f, 0);
    float* fluence = calloc((size_t)box->cells, sizeof(float));
    const ty_ordinates_stats stats = solve(*state, box, fluence);
    check_balance(&stats);
    float most = 0;
    for (ptrdiff_t i = 0; i < box->cells; ++i) most = fmaxf(most, fluence[i]);
    for (ptrdiff_t i = 0; i < box->cells; ++i)
        if (!is_above(i % 11, i / 11 % 9, i / 99)) assert_close((double)fluence[i], 0, 1e-3 * (double)most);
    free(fluence);
    free_box(box);
}

/* A box of mirrors made of white walls, but for one side, loses through that one what is emitted. */
static void white_walls_take_nothing(void** state) {
    walled_box* box = make_box(*state, 12, 10, 8);
    close_all_around(box);
    for (int32_t i = 0; i < 120; ++i) box->closed[7 * 120 + i] &= (uint8_t) ~(1 << 5);
    list_sides(box, 1, 0);
    for (ptrdiff_t i = 0; i < box->cells; ++i) box->extinction[i] = box->scattering[i] = i % 3 == 0 ? 0 : 6;
    box->source[5] = 1;
    float* fluence = calloc((size_t)box->cells, sizeof(float));
    const ty_ordinates_stats stats = solve(*state, box, fluence);
    print_message("white walls: %d sweeps\n", (int)stats.sweeps);
    check_balance(&stats);
    assert_close(stats.walls_absorbed, 0, 0);
    assert_close(stats.leaving / stats.emitted, 1, 1e-3);
    free(fluence);
    free_box(box);
}

static void threads_do_not_matter(void** state) {
    (void)state;
    float* fluence[3];
    const size_t cells = 13 * 27 * 21;
    for (int i = 0; i < 3; ++i) {
        ty_context* context = make_context(i + 1);
        walled_box* box = make_box(context, 13, 27, 21);
        close_all_around(box);
        for (ptrdiff_t c = 0; c < box->cells; ++c) {
            box->extinction[c] = (float)(c % 11);
            box->scattering[c] = 0.9f * (float)(c % 11);
            box->source[c] = (float)(c % 5);
            const int32_t at[3] = {(int32_t)(c % 13), (int32_t)(c / 13 % 27), (int32_t)(c / 351)};
            if (c % 7 == 0) close_face(box, at, (int)(c / 7 % 3), false);
        }
        list_sides(box, 0.5f, 0.1f);
        fluence[i] = calloc(cells, sizeof(float));
        solve(context, box, fluence[i]);
        free_box(box);
        ty_context_destroy(context);
    }
    for (int i = 1; i < 3; ++i) assert_memory_equal(fluence[i], fluence[0], cells * sizeof(float));
    for (int i = 0; i < 3; ++i) free(fluence[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(light_between_walls_is_even, start_context, stop_context),
        cmocka_unit_test_setup_teardown(walls_do_not_leak, start_context, stop_context),
        cmocka_unit_test_setup_teardown(stairs_do_not_leak, start_context, stop_context),
        cmocka_unit_test_setup_teardown(white_walls_take_nothing, start_context, stop_context),
        cmocka_unit_test(threads_do_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
