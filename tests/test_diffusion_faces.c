/* Diffusion between surfaces: closed forms of the solver's equations. */
#include "diffusion_maker.h"

#include <string.h>

/* A box of cells whose outer faces are closed, and those between x = `split` - 1 and `split` (0: none). */
typedef struct closed_box {
    ty_diffusion_faces faces;
    int32_t *first, *x;
    uint8_t *face, *closed;
    float *albedo, *radiosity, *staircase;
} closed_box;

static closed_box close_box(const problem* p, int32_t split, float albedo, float radiosity) {
    const int32_t* size = p->def.size;
    const size_t rows = (size_t)size[1] * (size_t)size[2], most = 6 * p->cells;
    closed_box box = {.first = calloc(rows + 1, sizeof *box.first),
                      .x = calloc(most, sizeof *box.x),
                      .face = calloc(most, 1),
                      .closed = calloc(p->cells, 1),
                      .albedo = make_floats(most),
                      .radiosity = make_floats(most),
                      .staircase = make_floats(most)};
    int32_t count = 0;
    for (size_t row = 0; row < rows; ++row) {
        box.first[row] = count;
        int32_t at[3] = {0, (int32_t)row % size[1], (int32_t)row / size[1]};
        for (; at[0] < size[0]; ++at[0])
            for (uint8_t face = 0; face < 6; ++face) {
                const bool up = (face & 1) != 0;
                const bool outer = at[face / 2] == (up ? size[face / 2] - 1 : 0);
                if (!outer && !(face / 2 == 0 && split > 0 && at[0] == (up ? split - 1 : split))) continue;
                box.closed[row * (size_t)size[0] + (size_t)at[0]] |= (uint8_t)(1 << face);
                box.x[count] = at[0];
                box.face[count] = face;
                box.albedo[count] = albedo;
                box.radiosity[count] = radiosity;
                box.staircase[count++] = 1;
            }
    }
    box.first[rows] = count;
    box.faces =
        (ty_diffusion_faces){count, box.first, box.x, box.face, box.closed, box.albedo, box.radiosity, box.staircase};
    return box;
}

static void free_box(closed_box* box) {
    free(box->first);
    free(box->x);
    free(box->face);
    free(box->closed);
    free(box->albedo);
    free(box->radiosity);
    free(box->staircase);
}

static void fill(problem* p, float source, float absorption) {
    for (size_t i = 0; i < p->cells; ++i) {
        p->source[i] = source;
        p->absorption[i] = absorption;
    }
}

/* All that is emitted is absorbed: phi = q / sigma_a everywhere, whatever the limiter. */
static void white_walls_keep_all_light(void** state) {
    for (int limiter = 0; limiter < TY_LIMITER_COUNT; ++limiter) {
        problem p = make_problem(10, 7, 5, 2, 3);
        closed_box box = close_box(&p, 4, 1, 0);
        fill(&p, 0.6f, 0.2f);
        p.def.limiter = (ty_limiter)limiter;
        p.def.faces = &box.faces;
        solve_problem(*state, &p);
        for (size_t i = 0; i < p.cells; ++i) assert_true(fabs((double)p.fluence[i] - 3) < 1e-4);
        free_box(&box);
        free_problem(&p);
    }
}

/* Walls of albedo a and radiosity M around media that neither absorb nor emit: phi = 4 M / (1 - a). */
static void glowing_walls_fill_their_room(void** state) {
    problem p = make_problem(8, 8, 8, 1, 2);
    closed_box box = close_box(&p, 0, 0.4f, 1.5f);
    float* irradiance = make_floats((size_t)box.faces.count);
    p.def.faces = &box.faces;
    p.out.side_irradiance = irradiance;
    solve_problem(*state, &p);
    for (size_t i = 0; i < p.cells; ++i) assert_true(fabs((double)p.fluence[i] - 10) < 1e-3);
    for (int32_t i = 0; i < box.faces.count; ++i) assert_true(fabs((double)irradiance[i] - 2.5) < 1e-3);
    assert_true(fabs(p.stats.surfaces_emitted / p.stats.surfaces_absorbed - 1) < 1e-4);
    assert_true(fabs(p.stats.surfaces_emitted - 6 * 1.5) < 1e-4);
    free(irradiance);
    free_box(&box);
    free_problem(&p);
}

/* Between walls of albedo a, d apart, a uniform source has
 * phi = q x (d - x) / (2 D) + q d / (2 k), k = (1 - a) / (2 (1 + a)), without limiter; cells hold means. */
static void a_slab_between_walls_has_its_parabola(void** state) {
    enum { CELLS = 32 };
    const double albedo = 0.7, q = 1.3, sigma = 4, k = (1 - albedo) / (2 * (1 + albedo));
    problem p = make_problem(CELLS, 1, 1, 1, (float)sigma);
    closed_box box = close_box(&p, 0, (float)albedo, 0);
    for (int32_t i = 0; i < box.faces.count; ++i)
        if (box.face[i] > 1) box.albedo[i] = 1;
    fill(&p, (float)q, 0);
    p.def.limiter = TY_LIMITER_NONE;
    p.def.faces = &box.faces;
    solve_problem(*state, &p);
    for (int i = 0; i < CELLS; ++i) {
        const double x = (i + 0.5) / CELLS, expected = q * x * (1 - x) * 1.5 * sigma + q / (2 * k);
        /* Measured: 2.8e-4, of second order in the cells. */
        assert_true(fabs((double)p.fluence[i] / expected - 1) < 1e-3);
    }
    assert_true(fabs(p.stats.surfaces_absorbed / p.stats.emitted - 1) < 1e-4);
    free_box(&box);
    free_problem(&p);
}

static void no_light_passes_a_wall(void** state) {
    problem p = make_problem(12, 6, 6, 1, 5);
    closed_box box = close_box(&p, 5, 0.5f, 0);
    for (size_t i = 0; i < p.cells; ++i) p.source[i] = i % 12 < 5 ? 1 : 0;
    p.def.faces = &box.faces;
    p.def.tolerance = 1e-5;
    solve_problem(*state, &p);
    double lit = 0, dark = 0;
    for (size_t i = 0; i < p.cells; ++i) *(i % 12 < 5 ? &lit : &dark) += (double)p.fluence[i];
    assert_true(lit > 0);
    assert_true(dark < 1e-4 * lit);
    free_box(&box);
    free_problem(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(white_walls_keep_all_light), cmocka_unit_test(glowing_walls_fill_their_room),
        cmocka_unit_test(a_slab_between_walls_has_its_parabola), cmocka_unit_test(no_light_passes_a_wall)};
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
