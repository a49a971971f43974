/* The adjoint of discrete ordinates against central differences of the solves themselves. */
#include "checks.h"
#include "effort.h"
#include "uniform.h"

#include "solve/ordinates/adjoint.h"

#include <stdio.h>

enum { BANDS = 4, TERMS = BANDS * BANDS, CELLS = 14 * 11 * 9 };

/* Relative error; at most 2.8e-5 is measured, of the single precision of the moments that are subtracted. */
static const double TOLERANCE = 1e-4;

static ty_angular_quadrature directions;

/* Planes of a problem; source: q_lm. */
typedef struct planes {
    float extinction[CELLS], scattering[CELLS], g[CELLS], source[TERMS][CELLS], weight[CELLS];
} planes;

/* A cloud in empty space, lit from one place along one direction, so that sweeps set many faces to zero. */
static void make_planes(planes* p, double thickness, double albedo, double g) {
    uint64_t state = 5;
    memset(p, 0, sizeof *p);
    for (int i = 0; i < CELLS; ++i) {
        const double x = i % 14 / 14.0 - 0.5, y = i / 14 % 11 / 11.0 - 0.5, z = i / 154 / 9.0 - 0.5;
        if (x * x + y * y + z * z < 0.16) p->extinction[i] = (float)(thickness * uniform_in(&state, 0.5, 1.5));
        p->scattering[i] = (float)albedo * p->extinction[i];
        p->g[i] = (float)g;
        p->weight[i] = (float)uniform_in(&state, -0.5, 1);
        if (x > -0.2 || y > 0) continue;
        p->source[0][i] = p->scattering[i];
        p->source[3][i] = 0.7f * p->scattering[i];
        p->source[8][i] = 0.3f * p->scattering[i];
    }
}

static ty_ordinates_def define(const planes* p, const float** source) {
    ty_ordinates_def def = ty_default_ordinates_def();
    const int32_t size[3] = {14, 11, 9};
    for (int a = 0; a < 3; ++a) {
        def.size[a] = size[a];
        def.cell[a] = 1.0 / 12 + 0.01 * a;
    }
    for (int t = 0; t < TERMS; ++t) source[t] = p->source[t];
    def.set = &directions;
    def.bands = def.output_order = BANDS;
    def.extinction = p->extinction;
    def.scattering = p->scattering;
    def.g = p->g;
    def.source = source;
    def.source_terms = TERMS;
    def.diffusive_paths = (double)INFINITY;
    def.tolerance = 1e-7;
    return def;
}

static float moments[TERMS][CELLS];

static double loss_of(ty_context* context, const planes* p) {
    const float* source[TERMS];
    float* out[TERMS];
    ty_ordinates_stats stats;
    double sum = 0;
    for (int t = 0; t < TERMS; ++t) out[t] = moments[t];
    const ty_ordinates_def def = define(p, source);
    if (ty_ordinates_solve(context, &def, out, NULL, 0, &stats) != TY_OK) fail_msg("%s", ty_take_error(context));
    for (int i = 0; i < CELLS; ++i) sum += (double)p->weight[i] * (double)moments[0][i];
    return sum;
}

typedef struct derivatives {
    float source[TERMS][CELLS], extinction[CELLS], scattered[BANDS][CELLS];
    ty_ordinates_adjoint_stats stats;
} derivatives;

static void differentiate(ty_context* context, const planes* p, derivatives* d) {
    const float *source[TERMS], *solution[TERMS];
    float *by_source[TERMS], *by_scattered[BANDS];
    for (int t = 0; t < TERMS; ++t) {
        solution[t] = moments[t];
        by_source[t] = d->source[t];
    }
    for (int l = 0; l < BANDS; ++l) by_scattered[l] = d->scattered[l];
    const ty_ordinates_def def = define(p, source);
    const ty_ordinates_adjoint_out out = {by_source, d->extinction, by_scattered};
    if (ty_ordinates_adjoint(context, &def, solution, p->weight, 1e-6, &out, &d->stats) != TY_OK)
        fail_msg("%s", ty_take_error(context));
}

/* scale: the sum of the absolute derivatives, which cancel in part where scattering and extinction move together. */
static void compare(const char* what, double found, double expected, double scale) {
    if (getenv("TYNDALL_SHOW") != NULL)
        print_message("%-12s %12.6g %12.6g  relative %.2g\n", what, found, expected, (found - expected) / scale);
    if (!(fabs(found - expected) <= TOLERANCE * scale))
        fail_msg("%s: %.9g, by differences %.9g", what, found, expected);
}

/* Moves the media (0), their scattering (1) or the source (2) of all cells at once, by amounts in proportion to these.
 * Differences of fourth order. */
static double difference(ty_context* context, const planes* p, int which, double step) {
    static planes moved;
    static const double weights[5] = {1, -8, 0, 8, -1};
    double sum = 0;
    for (int side = -2; side <= 2; ++side) {
        if (side == 0) continue;
        moved = *p;
        for (int i = 0; i < CELLS; ++i) {
            const float factor = (float)(1 + side * step * (0.5 + (i * 7 % 10) / 10.0));
            if (which == 0) moved.extinction[i] *= factor;
            if (which == 0) moved.scattering[i] *= factor;
            if (which == 1) moved.scattering[i] *= 2 - factor;
            for (int t = 0; t < TERMS && which == 2; ++t) moved.source[t][i] *= factor;
        }
        sum += weights[side + 2] * loss_of(context, &moved);
    }
    return sum / (12 * step);
}

static void check(ty_context* context, double thickness, double albedo, double g) {
    static planes p;
    static derivatives d;
    assert_int_equal(ty_angular_quadrature_create(context, 48, &directions, NULL), TY_OK);
    make_planes(&p, thickness, albedo, g);
    const double loss = loss_of(context, &p);
    differentiate(context, &p, &d);
    if (getenv("TYNDALL_SHOW") != NULL)
        print_message("loss %g: %d sweeps, change %.1e, imbalance %.1e\n", loss, d.stats.sweeps, d.stats.change,
                      d.stats.imbalance);
    assert_true(d.stats.converged);
    double by[3] = {0, 0, 0}, whole = 0, scale = 0;
    for (int i = 0; i < CELLS; ++i) {
        const double factor = 0.5 + (i * 7 % 10) / 10.0;
        double power = 1, forward = pow(g, BANDS);
        double by_scattering = -forward * (double)d.extinction[i];
        for (int l = 0; l < BANDS; ++l, power *= g) by_scattering += (power - forward) * (double)d.scattered[l][i];
        const double of_extinction = factor * (double)p.extinction[i] * (double)d.extinction[i];
        const double of_scattering = factor * (double)p.scattering[i] * by_scattering;
        by[0] += of_extinction + of_scattering;
        scale += fabs(of_extinction) + fabs(of_scattering);
        by[1] -= of_scattering;
        for (int t = 0; t < TERMS; ++t) {
            by[2] += factor * (double)p.source[t][i] * (double)d.source[t][i];
            whole += (double)p.source[t][i] * (double)d.source[t][i];
        }
    }
    compare("linear", whole, loss, fabs(loss));
    compare("source", by[2], difference(context, &p, 2, 0.02), fabs(by[2]));
    compare("media", by[0], difference(context, &p, 0, 0.01), scale);
    compare("scattering", by[1], difference(context, &p, 1, (thickness < 10 ? 0.2 : 0.08) * (1 - albedo)), fabs(by[1]));
}

static void thin_clouds(void** state) {
    check(*state, 3, 0.9, 0.6);
}

static void dense_clouds(void** state) {
    check(*state, 20, 0.99, 0.6);
}

static void thick_cells(void** state) {
    skip_under_sanitizers(); /* rounding there keeps the change above the tolerance */
    check(*state, 60, 0.99, 0.3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(thin_clouds),
        cmocka_unit_test(dense_clouds),
        cmocka_unit_test(thick_cells),
    };
    return cmocka_run_group_tests_name("ordinates adjoint", tests, start_context, stop_context);
}
