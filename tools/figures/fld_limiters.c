/* Table 2 of the paper: the flux limiters, and the limited flux. */
#include "figures/fld_limiters.h"

#include "figures/figure.h"
#include "solve/diffusion/limiter.k.h"

#include <math.h>

enum { LINE_POINTS = 60, LISTED = 7, LARSEN_MORE = 8, CURVES = TY_LIMITER_COUNT + 1 };

const char* const fld_limiter_names[TY_LIMITER_COUNT] = {"none (CDA)", "sum",      "max",
                                                         "Kershaw",    "Larsen-2", "Levermore-Pomraning"};

/* Knudsen numbers of the table and the files. */
static const double listed[LISTED] = {0, 0.1, 1, 3, 10, 100, 1e4};

/* The last curve is Larsen's with a larger n. */
static ty_limiter limiter_of(int curve) {
    return curve < TY_LIMITER_COUNT ? (ty_limiter)curve : TY_LIMITER_LARSEN;
}

static double power_of(int curve) {
    return curve < TY_LIMITER_COUNT ? 2 : LARSEN_MORE;
}

static void name_curve(int curve, char name[FIGURE_NAME_SIZE]) {
    if (curve < TY_LIMITER_COUNT)
        snprintf(name, FIGURE_NAME_SIZE, "%s", fld_limiter_names[curve]);
    else
        snprintf(name, FIGURE_NAME_SIZE, "Larsen-%d", LARSEN_MORE);
}

/* Limiter value of the solvers. */
static double value_of(int curve, double r) {
    return (double)ty_limiter_value((int32_t)limiter_of(curve), (float)power_of(curve), (float)r);
}

/* Limiter value of the table. */
static double formula_of(int curve, double r) {
    const double n = power_of(curve);
    switch (limiter_of(curve)) {
    case TY_LIMITER_SUM: return 1 / (3 + r);
    case TY_LIMITER_MAX: return 1 / fmax(3, r);
    case TY_LIMITER_KERSHAW: return 2 / (3 + sqrt(9 + 4 * r * r));
    case TY_LIMITER_LARSEN: return pow(pow(3, n) + pow(r, n), -1 / n);
    case TY_LIMITER_LEVERMORE_POMRANING: return r > 0 ? (1 / tanh(r) - 1 / r) / r : 1.0 / 3;
    default: return 1.0 / 3;
    }
}

static void fill_charts(plot_chart charts[2]) {
    charts[0] = (plot_chart){.title = "flux limiter", .y_label = "F(R)"};
    charts[1] = (plot_chart){.title = "flux over fluence: 1 is streaming, more cannot be", .y_label = "R F(R)"};
    for (int chart = 0; chart < 2; ++chart) {
        charts[chart].x_label = "Knudsen number R";
        charts[chart].x_logarithmic = true;
        charts[chart].y_logarithmic = chart == 0;
        charts[chart].series_count = CURVES;
    }
    for (int curve = 0; curve < CURVES; ++curve) {
        name_curve(curve, charts[1].series[curve].name);
        for (int chart = 0; chart < 2; ++chart)
            charts[chart].series[curve].style = curve == TY_LIMITER_NONE ? PLOT_DASHES : PLOT_LINE;
        for (int i = 0; i < LINE_POINTS; ++i) {
            const double r = pow(10, -2 + 5.0 * i / (LINE_POINTS - 1)), f = value_of(curve, r);
            plot_add_point(&charts[0].series[curve], r, f, 0);
            /* Classical diffusion exceeds the physical limit of flux over fluence, 1; the chart ends there. */
            if (r * f < 1.2) plot_add_point(&charts[1].series[curve], r, r * f, 0);
        }
    }
}

static void note_curve(figure_run* run, int curve) {
    char item[FIGURE_NAME_SIZE], name[FIGURE_NAME_SIZE];
    name_curve(curve, item);
    for (int i = 0; i < LISTED; ++i) {
        const double expected = formula_of(curve, listed[i]);
        snprintf(name, sizeof name, "F(%g)", listed[i]);
        figure_expect(run, item, name, "1", value_of(curve, listed[i]), expected, 1e-5 * expected);
    }
    if (curve == TY_LIMITER_NONE) return;
    double max_flux = 0;
    for (double r = 1e-6; r < 1e12; r *= 1.1) max_flux = fmax(max_flux, r * value_of(curve, r));
    figure_expect(run, item, "maximum of R F(R)", "1", max_flux, 1, 1e-5);
}

static ty_result fill_table(figure_run* run) {
    plot_table table;
    ty_result result = plot_create_table(1 + CURVES, 1 + LISTED, 1, &table);
    if (result != TY_OK) return result;
    plot_set_cell(&table, 0, 0, "F(R)");
    for (int i = 0; i < LISTED; ++i) plot_set_cell(&table, 0, 1 + i, "R = %g", listed[i]);
    for (int curve = 0; curve < CURVES && result == TY_OK; ++curve) {
        char name[FIGURE_NAME_SIZE];
        name_curve(curve, name);
        plot_set_cell(&table, 1 + curve, 0, "%s", name);
        for (int i = 0; i < LISTED; ++i) plot_set_cell(&table, 1 + curve, 1 + i, "%.4g", value_of(curve, listed[i]));
        note_curve(run, curve);
    }
    plot_page_table(&run->page, &table);
    plot_free_table(&table);
    return TY_OK;
}

ty_result figure_fld_limiters(figure_run* run) {
    plot_chart charts[2];
    fill_charts(charts);
    plot_page_charts(&run->page, charts, 2);
    figure_caption(run, "As the solvers compute them, in single precision; the files hold them against Table 2's "
                        "formulas. R = |∇φ| / (σt φ); the flux is R F(R) times the fluence φ.");
    return fill_table(run);
}
