/* The light that leaves a beam's forward lobe, and the distance over which it is delta_source before it is diffuse. */
#include "method/pop/delta_source.h"
#include "pop_merge_maker.h"

/* Cells of different sides, fine and merged. */
static const ty_grid_box fine_box = {{-1, 0.5, 2}, {3, 1.5, 3.25}, {24, 12, 18}};
static const ty_grid_box merged_box = {{-1, 0.5, 2}, {3, 1.5, 3.25}, {8, 6, 6}};

enum { FINE = 24 * 12 * 18, MERGED = 8 * 6 * 6 };

/* A medium and a beam through it, one plane for all channels, and what it comes to. */
typedef struct beam {
    ty_grid_medium fine, merged;
    ty_light_fluence light;
    ty_pop_delta_source delta_source;
    float extinction[FINE], scattering[FINE], g[FINE], phi_order_1[FINE], phi_unscattered[FINE],
        phi_second_moment[FINE];
} beam;

static beam* new_beam(ty_context* context, ty_vec direction, float g) {
    static const float color[3] = {1, 0.5f, 2};
    beam* b = calloc(1, sizeof *b);
    assert_non_null(b);
    b->fine = (ty_grid_medium){.context = context, .box = fine_box, .cells = FINE, .planes = 1};
    b->merged = (ty_grid_medium){.context = context, .box = merged_box, .cells = MERGED, .planes = 1};
    for (int a = 0; a < 3; ++a) {
        b->fine.cell[a] = (fine_box.upper[a] - fine_box.lower[a]) / fine_box.size[a];
        b->merged.cell[a] = (merged_box.upper[a] - merged_box.lower[a]) / merged_box.size[a];
        b->light.color[a] = color[a];
    }
    b->fine.extinction[0] = b->extinction;
    b->fine.scattering[0] = b->scattering;
    b->fine.g[0] = b->g;
    b->light.kind = TY_FLUENCE_DIRECTIONAL;
    b->light.anchor = direction;
    b->light.lobe_order = b->light.shared = 1;
    b->light.fluence[0] = b->phi_order_1;
    b->light.unscattered[0] = b->phi_unscattered;
    b->light.next_order[0] = b->phi_second_moment;
    for (int i = 0; i < FINE; ++i) b->g[i] = g;
    assert_true(TY_OK == ty_pop_delta_source_create(context, MERGED, &b->delta_source));
    return b;
}

static void free_beam(ty_context* context, beam* b) {
    ty_pop_delta_source_destroy(context, &b->delta_source);
    free(b);
}

/* Any light in any medium, with vacuum in it. */
static void fill_any(beam* b, uint64_t seed) {
    for (int i = 0; i < FINE; ++i) {
        const float density = (float)uniform(&seed) < 0.3f ? 0 : 20 * (float)uniform(&seed);
        b->extinction[i] = density;
        b->scattering[i] = density * (float)uniform(&seed);
        b->phi_second_moment[i] = (float)uniform(&seed);
        b->phi_order_1[i] = b->phi_second_moment[i] + (float)uniform(&seed);
    }
}

/* Even light in an even medium. */
static void fill_even(beam* b, float extinction, float scattering) {
    for (int i = 0; i < FINE; ++i) {
        b->extinction[i] = extinction;
        b->scattering[i] = scattering;
        b->phi_second_moment[i] = 0.5f;
        b->phi_order_1[i] = 0.75f;
    }
}

static double mean_of(const float* values, int count) {
    double sum = 0;
    for (int i = 0; i < count; ++i) sum += (double)values[i];
    return sum / count;
}

static double mean_diffuse_source(const beam* b) {
    double sum = 0;
    for (int i = 0; i < FINE; ++i)
        sum += (1 - (double)(b->g[i] * b->g[i])) * (double)b->scattering[i] * (double)b->phi_second_moment[i];
    return sum / FINE;
}

static ty_vec direction_of(int n) {
    static const ty_vec axes[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    uint64_t state = (uint64_t)n;
    return n < 6 ? axes[n] : random_unit(&state);
}

/* Wherever it is delta_source, all that leaves the lobe is emitted, and nowhere less than nothing. */
static void all_is_emitted(void** state) {
    for (int d = 0; d < 12; ++d) {
        beam* b = new_beam(*state, direction_of(d), 0.7f);
        fill_any(b, (uint64_t)d + 1);
        assert_true(TY_OK == ty_pop_delta_source_add_light(&b->fine, &b->light, &b->merged, &b->delta_source));
        for (int c = 0; c < 3; ++c) {
            for (int i = 0; i < MERGED; ++i) assert_true(b->delta_source.arrays[c][0][i] >= 0);
            assert_close(mean_of(b->delta_source.arrays[c][0], MERGED),
                         (double)b->light.color[c] * mean_diffuse_source(b), 1e-4);
        }
        free_beam(*state, b);
    }
}

/* Light that scatters evenly is diffuse where it scatters. */
static void even_scattering_stays(void** state) {
    beam* b = new_beam(*state, direction_of(7), 0);
    fill_even(b, 3, 2);
    for (int i = 0; i < FINE; ++i) b->phi_order_1[i] = b->phi_second_moment[i];
    assert_true(TY_OK == ty_pop_delta_source_add_light(&b->fine, &b->light, &b->merged, &b->delta_source));
    for (int i = 0; i < MERGED; ++i) {
        assert_close(b->delta_source.arrays[0][0][i], 1, 1e-5);
        for (int n = 1; n < TY_POP_DELTA_SOURCE_ARRAYS; ++n) assert_true(b->delta_source.arrays[0][n][i] == 0);
    }
    free_beam(*state, b);
}

/* Deep within, as much flows as goes on flowing, and what is emitted stays: 0.62 g (1 - g) sigma_s S / (sigma_t - g
 * sigma_s); at the first cells nothing has come from upstream, and at the last all is left. */
static void flux_comes_and_stays(void** state) {
    for (int d = 0; d < 6; ++d) {
        const ty_vec omega = direction_of(d);
        const float along[3] = {omega.x, omega.y, omega.z};
        const int a = d / 2, count = merged_box.size[a], step = a == 0 ? 1 : a == 1 ? 8 : 48;
        const int first = along[a] > 0 ? 0 : count - 1, last = count - 1 - first, center = count / 2;
        beam* b = new_beam(*state, omega, 0.5f);
        fill_even(b, 50, 40);
        assert_true(TY_OK == ty_pop_delta_source_add_light(&b->fine, &b->light, &b->merged, &b->delta_source));
        const double flux = 0.62 * 0.5 * 0.5 * 40 * 0.5 / (50 - 0.5 * 40), emitted = 0.75 * 40 * 0.5;
        const float *source = b->delta_source.arrays[0][0], *flux_correction = b->delta_source.arrays[0][2 + a];
        assert_close(source[step * center], emitted, 1e-4);
        assert_close((double)flux_correction[step * center], (flux - 0.25) * (double)along[a], 1e-4);
        assert_close(b->delta_source.arrays[0][1][step * center], -0.25, 1e-5);
        assert_close((double)source[step * first], emitted - flux / b->merged.cell[a], 1e-4);
        assert_close((double)source[step * last], emitted + flux / b->merged.cell[a], 1e-4);
        free_beam(*state, b);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_is_emitted),
        cmocka_unit_test(even_scattering_stays),
        cmocka_unit_test(flux_comes_and_stays),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
