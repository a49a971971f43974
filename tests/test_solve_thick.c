/* Thick cells of discrete ordinates: what half-spaces and slabs are known to send back and let through, clouds in
 * vacuum of any thickness, and light that is the same everywhere. */
#include "checks.h"
#include "effort.h"
#include "solve/ordinates/job.h"

#include <string.h>

#define PI 3.141592653589793
#define SQRT_4PI 3.5449077018110318

enum { TERMS = 16 };

typedef struct thick_box {
    ty_ordinates_def def;
    ty_angular_quadrature set;
    ty_ordinates_stats stats;
    size_t cells;
    float *extinction, *scattering, *g, *source[TERMS], *moments[TERMS];
    const float* sources[TERMS];
    int32_t *first, *x;
    uint8_t* face;
    float *albedo, *emission, *arrived, *inflow;
} thick_box;

static float* make_floats(size_t count) {
    float* floats = calloc(count, sizeof *floats);
    assert_non_null(floats);
    return floats;
}

static thick_box* make_box(void* context, int32_t nx, int32_t ny, int32_t nz, int32_t bands) {
    thick_box* box = calloc(1, sizeof *box);
    box->def = ty_default_ordinates_def();
    box->cells = (size_t)nx * (size_t)ny * (size_t)nz;
    assert_int_equal(ty_angular_quadrature_create(context, 96, &box->set, NULL), TY_OK);
    const int32_t size[3] = {nx, ny, nz};
    for (int a = 0; a < 3; ++a) {
        box->def.size[a] = size[a];
        box->def.cell[a] = 1.0 / nz;
    }
    box->def.extinction = box->extinction = make_floats(box->cells);
    box->def.scattering = box->scattering = make_floats(box->cells);
    box->def.g = box->g = make_floats(box->cells);
    box->def.bands = box->def.output_order = bands;
    box->def.source_terms = bands * bands;
    for (int t = 0; t < TERMS; ++t) {
        box->sources[t] = box->source[t] = make_floats(box->cells);
        box->moments[t] = make_floats(box->cells);
    }
    box->def.source = box->sources;
    box->def.set = &box->set;
    box->inflow = make_floats((size_t)box->set.count);
    return box;
}

static void free_box(thick_box* box) {
    void* const all[] = {box->extinction, box->scattering, box->g,        box->first,   box->x,
                         box->face,       box->albedo,     box->emission, box->arrived, box->inflow};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i) free(all[i]);
    for (int t = 0; t < TERMS; ++t) {
        free(box->source[t]);
        free(box->moments[t]);
    }
    free(box);
}

static void solve(void* context, thick_box* box) {
    if (ty_ordinates_solve(context, &box->def, box->moments, NULL, 0, &box->stats) != TY_OK)
        fail_msg("%s", ty_take_error(context));
    if (!box->stats.converged) fail_msg("%g is left after %d sweeps", box->stats.change, (int)box->stats.sweeps);
    for (int32_t t = 0; t < box->def.output_order * box->def.output_order; ++t)
        for (size_t i = 0; i < box->cells; ++i) assert_true(isfinite(box->moments[t][i]));
    const ty_ordinates_stats* s = &box->stats;
    const double in = s->emitted + s->walls_emitted + s->entering;
    assert_close(s->absorbed + s->walls_absorbed + s->leaving, in, 1e-3 * in);
}

static void fill_even(thick_box* box, double extinction, double albedo, double g) {
    for (size_t i = 0; i < box->cells; ++i) {
        box->extinction[i] = (float)extinction;
        box->scattering[i] = (float)(albedo * extinction);
        box->g[i] = (float)g;
    }
}

/* ---- half-spaces and slabs ---- */

/* A column of cubes from the box's lower face at z = 0 to z = 1 m, white all around and black at its end. */
static thick_box* make_column(void* context, int32_t count, int32_t bands) {
    thick_box* box = make_box(context, 1, 1, count, bands);
    const size_t most = 4 * (size_t)count + 1;
    int32_t side = 0;
    box->first = calloc((size_t)count + 1, sizeof *box->first);
    box->x = calloc(most, sizeof *box->x);
    box->face = calloc(most, 1);
    box->albedo = make_floats(most);
    box->emission = make_floats(most);
    box->arrived = make_floats(most);
    for (int32_t z = 0; z < count; ++z) {
        for (int face = 0; face < (z == count - 1 ? 6 : 4); ++face) {
            if (face == 4) continue;
            box->face[side] = (uint8_t)face;
            box->albedo[side++] = face < 4 ? 1 : 0;
        }
        box->first[z + 1] = side;
    }
    box->def.walls = (ty_ordinates_faces){.count = side,
                                          .first = box->first,
                                          .x = box->x,
                                          .face = box->face,
                                          .albedo = box->albedo,
                                          .emission = box->emission,
                                          .irradiance = box->arrived};
    return box;
}

/* Of even light on a slab that absorbs nothing, what goes through: 4/3 over its reduced optical thickness and twice the
 * extrapolated length of .7104. */
static void slabs_let_through_what_they_should(void** state) {
    static const struct {
        double thickness, g;
        int32_t bands;
    } slabs[] = {{300, 0, 1}, {1000, 0, 1}, {10000, 0, 1}, {1000, 0.8, 4}, {10000, -0.3, 2}};
    for (size_t i = 0; i < sizeof slabs / sizeof *slabs; ++i) {
        thick_box* box = make_column(*state, 32, slabs[i].bands);
        fill_even(box, slabs[i].thickness, 1, slabs[i].g);
        for (int32_t d = 0; d < box->set.count; ++d) box->inflow[d] = box->set.direction[2][d] > 0 ? 1 : 0;
        for (int a = 0; a < 3; ++a) box->def.boundary_radiance.across[a] = box->inflow;
        box->def.tolerance = 2e-5;
        box->def.sweeps = 400;
        solve(*state, box);
        const double arrived = box->stats.walls_absorbed / (PI * box->def.cell[0] * box->def.cell[1]);
        const double expected = 4.0 / 3 / (slabs[i].thickness * (1 - slabs[i].g) + 2 * 0.7104);
        print_message("%g, g %g: %.4f, %d sweeps\n", slabs[i].thickness, slabs[i].g, arrived / expected,
                      (int)box->stats.sweeps);
        assert_close(arrived / expected, 1, 3e-3);
        free_box(box);
    }
}

/* Chandrasekhar's H. */
enum { ANGLES = 200 };

static void make_h(double albedo, double h[ANGLES]) {
    for (int i = 0; i < ANGLES; ++i) h[i] = 1;
    for (int pass = 0; pass < 200; ++pass)
        for (int i = 0; i < ANGLES; ++i) {
            double sum = 0;
            const double mu = (i + 0.5) / ANGLES;
            for (int k = 0; k < ANGLES; ++k) sum += (k + 0.5) / ANGLES * h[k] / (mu + (k + 0.5) / ANGLES) / ANGLES;
            h[i] = 1 / (sqrt(1 - albedo) + albedo / 2 * sum);
        }
}

static const double albedos[] = {0.1, 0.5, 0.9, 0.99, 0.999};
enum { ALBEDOS = sizeof albedos / sizeof *albedos };

/* Light that a half-space emits everywhere alike leaves with the cosine-weighted mean of sqrt(1 - albedo) H. */
static void half_spaces_glow_as_they_should(void** state) {
    for (int i = 0; i < ALBEDOS; ++i)
        for (int finer = 0; finer < 2; ++finer) {
            double h[ANGLES], mean = 0;
            make_h(albedos[i], h);
            for (int k = 0; k < ANGLES; ++k) mean += 2 * (k + 0.5) / ANGLES / ANGLES * h[k];
            thick_box* box = make_column(*state, finer != 0 ? 64 : 16, 1);
            fill_even(box, 640, albedos[i], 0);
            for (size_t c = 0; c < box->cells; ++c) box->source[0][c] = (float)(1 / SQRT_4PI);
            solve(*state, box);
            const double leaving = box->stats.leaving / (box->def.cell[0] * box->def.cell[1]);
            const double expected = sqrt(1 - albedos[i]) * mean / (4 * 640 * (1 - albedos[i]));
            print_message("albedo %g, cells of %d: %.4f\n", albedos[i], finer != 0 ? 10 : 40, leaving / expected);
            assert_close(leaving / expected, 1, 0.05);
            free_box(box);
        }
}

/* A beam straight down on a half-space: 1 - sqrt(1 - albedo) H(1) of it comes back, however much thicker cells are than
 * what it gets through. */
static void half_spaces_reflect_as_they_should(void** state) {
    for (int i = 0; i < ALBEDOS; ++i)
        for (int finer = 0; finer < 2; ++finer) {
            double h[ANGLES];
            make_h(albedos[i], h);
            thick_box* box = make_column(*state, finer != 0 ? 64 : 16, 1);
            fill_even(box, 640, albedos[i], 0);
            for (size_t c = 0; c < box->cells; ++c) {
                const double edge = box->def.cell[2], depth = 640 * edge * (double)c;
                box->source[0][c] = (float)(albedos[i] * exp(-depth) * -expm1(-640 * edge) / (edge * SQRT_4PI));
            }
            float* seen = box->def.face_fluence = make_floats(6 * box->cells);
            solve(*state, box);
            const double leaving = box->stats.leaving / (box->def.cell[0] * box->def.cell[1]);
            const double expected = 1 - sqrt(1 - albedos[i]) * h[ANGLES - 1];
            print_message("albedo %g, cells of %d: %.4f, %.4f expected\n", albedos[i], finer != 0 ? 10 : 40, leaving,
                          expected);
            assert_close(leaving, expected, 0.03);
            /* Of the faces of all cells an eye sees the first one's alone. */
            assert_close((double)seen[4] * SQRT_4PI / 4, leaving, 2e-3);
            for (size_t face = 0; face < 6 * box->cells; ++face) assert_true(face == 4 || seen[face] < 0);
            free(seen);
            free_box(box);
        }
}

/* ---- clouds ---- */

/* A lumpy ball of a diameter of 0.7 m in vacuum. */
static void fill_cloud(thick_box* box, double thickness, double albedo, double g) {
    const int32_t n = box->def.size[0];
    for (size_t i = 0; i < box->cells; ++i) {
        const double x = ((double)(i % (size_t)n) + 0.5) / n, y = ((double)(i / (size_t)n % (size_t)n) + 0.5) / n;
        const double z = ((double)(i / (size_t)n / (size_t)n) + 0.5) / n;
        const double lumps = sin(23 * x) * sin(19 * y + 1) * sin(21 * z + 2);
        const bool inside = hypot(hypot(x - 0.5, y - 0.5), z - 0.5) < 0.35 + 0.05 * lumps;
        box->extinction[i] = inside ? (float)(thickness * (1 + 0.8 * lumps) / 0.7) : 0;
        box->scattering[i] = (float)albedo * box->extinction[i];
        box->g[i] = (float)g;
        box->source[0][i] = inside ? (float)(1 + lumps) : 0;
    }
}

static void sweeps_are_few_at_any_thickness(void** state) {
    skip_under_sanitizers();
    static const double thicknesses[] = {0.01, 1, 30, 100, 150, 200, 316, 500, 1000, 3162, 10000};
    for (size_t i = 0; i < sizeof thicknesses / sizeof *thicknesses; ++i)
        for (int kind = 0; kind < 6; ++kind) {
            const double albedo = kind < 2 ? 1 : kind < 4 ? 0.999 : 0.5, g = (kind & 1) != 0 ? 0.6 : 0;
            thick_box* box = make_box(*state, 24, 24, 24, g > 0 ? 3 : 1);
            if (i % 2 == 0) fill_even(box, thicknesses[i], albedo, g);
            for (size_t c = 0; c < box->cells; ++c) box->source[0][c] = 1;
            if (i % 2 != 0 || kind != 0) fill_cloud(box, thicknesses[i], albedo, g);
            solve(*state, box);
            if (box->stats.sweeps > 12)
                fail_msg("thickness %g, albedo %g, g %g: %d sweeps", thicknesses[i], albedo, g, (int)box->stats.sweeps);
            free_box(box);
        }
}

/* The same light from all sides stays the same in a medium that takes none, thick here and thin there. */
static void even_light_stays_even(void** state) {
    thick_box* box = make_box(*state, 13, 13, 13, 1);
    fill_cloud(box, 2000, 1, 0);
    for (size_t c = 0; c < box->cells; ++c) {
        if (c % 7 == 0) box->extinction[c] = box->scattering[c] = 300;
        box->source[0][c] = 0;
    }
    for (int32_t d = 0; d < box->set.count; ++d) box->inflow[d] = 1;
    for (int a = 0; a < 3; ++a) box->def.boundary_radiance.across[a] = box->inflow;
    box->def.tolerance = 1e-4;
    solve(*state, box);
    for (size_t c = 0; c < box->cells; ++c) assert_close((double)box->moments[0][c] / SQRT_4PI, 1, 5e-3);
    free_box(box);
}

/* Finer cells, which are not thick, find the same light. */
static void thin_cells_agree(void** state) {
    skip_under_sanitizers();
    double leaving[2];
    for (int finer = 0; finer < 2; ++finer) {
        thick_box* box = make_box(*state, finer != 0 ? 48 : 12, finer != 0 ? 48 : 12, finer != 0 ? 48 : 12, 1);
        fill_even(box, 120, 0.99, 0);
        for (size_t c = 0; c < box->cells; ++c) box->source[0][c] = 1;
        solve(*state, box);
        leaving[finer] = box->stats.leaving / box->stats.emitted;
        free_box(box);
    }
    assert_close(leaving[0] / leaving[1], 1, 0.03);
}

/* ---- the rest ---- */

static void threads_change_nothing(void** state) {
    float* first[4] = {NULL};
    for (int32_t threads = 1; threads <= 3; ++threads) {
        ty_context* context = make_context(threads);
        thick_box* box = make_box(context, 20, 20, 20, 2);
        fill_cloud(box, 400, 0.99, 0.5);
        solve(context, box);
        for (int t = 0; t < 4; ++t) {
            if (threads > 1) assert_memory_equal(box->moments[t], first[t], box->cells * sizeof(float));
            if (threads > 1) continue;
            first[t] = make_floats(box->cells);
            memcpy(first[t], box->moments[t], box->cells * sizeof(float));
        }
        free_box(box);
        ty_context_destroy(context);
    }
    for (int t = 0; t < 4; ++t) free(first[t]);
    (void)state;
}

static void a_start_changes_nothing(void** state) {
    thick_box* first = make_box(*state, 16, 16, 16, 2);
    thick_box* again = make_box(*state, 16, 16, 16, 2);
    fill_cloud(first, 300, 0.99, 0.5);
    fill_cloud(again, 300, 0.99, 0.5);
    solve(*state, first);
    again->def.start = (const float* const*)first->moments;
    solve(*state, again);
    assert_true(again->stats.sweeps <= first->stats.sweeps);
    double squares = 0, off = 0;
    for (size_t c = 0; c < first->cells; ++c) {
        const double light = (double)first->moments[0][c], change = (double)again->moments[0][c] - light;
        squares += light * light;
        off += change * change;
    }
    assert_true(off < 4e-6 * squares);
    free_box(first);
    free_box(again);
}

/* Light flows down the gradient of what comes out, and more bands than are solved for are dark. */
static void moments_are_those_of_diffusion(void** state) {
    thick_box* box = make_column(*state, 32, 2);
    fill_even(box, 1000, 1, 0);
    for (int32_t d = 0; d < box->set.count; ++d) box->inflow[d] = box->set.direction[2][d] > 0 ? 1 : 0;
    for (int a = 0; a < 3; ++a) box->def.boundary_radiance.across[a] = box->inflow;
    box->def.output_order = 4;
    box->def.tolerance = 5e-5;
    solve(*state, box);
    const double through = box->stats.walls_absorbed / (box->def.cell[0] * box->def.cell[1]);
    for (size_t c = 0; c < box->cells; ++c) {
        assert_close((double)box->moments[2][c] * sqrt(4 * PI / 3), through, 0.02 * through);
        assert_close((double)box->moments[6][c], 0, 1e-6);
    }
    free_box(box);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slabs_let_through_what_they_should),
        cmocka_unit_test(half_spaces_glow_as_they_should),
        cmocka_unit_test(half_spaces_reflect_as_they_should),
        cmocka_unit_test(sweeps_are_few_at_any_thickness),
        cmocka_unit_test(even_light_stays_even),
        cmocka_unit_test(thin_cells_agree),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(a_start_changes_nothing),
        cmocka_unit_test(moments_are_those_of_diffusion),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
