/* Fig. 10 of the paper: zonal harmonics of point and directional emitters over distance, and checks of the tables
 * against quadrature along rays, exact transport and energy conservation. */
#include "figures/figure.h"
#include "figures/impulse_rays.h"
#include "figures/point_transport.h"

#include <math.h>
#include <tyndall/impulse.h>

enum { SHOWN = 3, TAUS = 8, LINE_POINTS = 56, ALBEDOS = 3, COLORS = 8 /* number of colors before they repeat */ };

static const int32_t shown[SHOWN] = {1, 2, 10};
static const double taus[TAUS] = {0.01, 0.034, 0.1, 0.37, 1, 4.9, 9.1, 20};
static const struct {
    const char* name;
    ty_impulse_emitter emitter;
} kinds[] = {{"point", TY_IMPULSE_POINT}, {"directional", TY_IMPULSE_DIRECTIONAL}};

static ty_impulse_response interpolate(const ty_impulse* tables, ty_impulse_emitter emitter, double tau, double g,
                                       double cosine, int32_t bounces) {
    const ty_impulse_medium medium = {1, 1, (float)g};
    ty_impulse_response out;
    ty_impulse_look(tables, emitter, &medium, (float)tau, (float)cosine, bounces, &out);
    return out;
}

/* One curve per harmonic, as in the paper. */
static void fill_chart(const ty_impulse* tables, int kind, int32_t bounces, const char* title, plot_chart* out) {
    const bool point = kinds[kind].emitter == TY_IMPULSE_POINT;
    *out = (plot_chart){.title = title,
                        .x_label = "optical distance",
                        .y_label = point ? "coefficient times distance²" : "coefficient",
                        .x_logarithmic = true,
                        .width = 330,
                        .series_count = TY_IMPULSE_TERMS};
    for (int l = 0; l < TY_IMPULSE_TERMS; ++l) {
        plot_series* series = &out->series[l];
        series->style = l < COLORS ? PLOT_LINE : PLOT_DASHES;
        if (bounces == shown[SHOWN - 1]) snprintf(series->name, sizeof series->name, "l = %d", l);
        for (int i = 0; i < LINE_POINTS; ++i) {
            const double tau = 0.01 * pow(2000, (double)i / (LINE_POINTS - 1));
            const ty_impulse_response r = interpolate(tables, kinds[kind].emitter, tau, 0, 1, bounces);
            plot_add_point(series, tau, (double)(r.single[l] + r.multiple[l]) * (point ? tau * tau : 1), 0);
        }
    }
}

/* The maximum difference of a harmonic, relative to the constant one. */
static double worst_of(const float is[TY_IMPULSE_TERMS], const double should[TY_IMPULSE_TERMS]) {
    double worst = 0;
    for (int l = 0; l < TY_IMPULSE_TERMS; ++l) worst = fmax(worst, fabs((double)is[l] - should[l]) / should[0]);
    return worst;
}

static void sum_rays(ty_impulse_emitter emitter, double tau, double cosine, double shift,
                     double out[RAYS_PHASES][TY_IMPULSE_TERMS]) {
    const rays_area area = {{sqrt(1 - cosine * cosine), 0, cosine}};
    rays_scene scene = {.source = rays_point, .user = &area, .top = HUGE_VAL};
    double at[3] = {0, 0, tau};
    if (emitter == TY_IMPULSE_POINT) {
        rays_harmonics(&scene, at, -1, 0, 8, 0, out);
    } else if (emitter == TY_IMPULSE_AREA) {
        scene.source = rays_area_light;
        rays_harmonics(&scene, at, -1, asin(shift), 4, 3, out);
    } else {
        scene.source = rays_directional;
        scene.top = 0;
        scene.emitter[2] = at[2] = -tau;
        rays_harmonics(&scene, at, 1, 0, 24, 0, out);
    }
}

static ty_result note_single(figure_run* run, const ty_impulse* tables, const char* name, ty_impulse_emitter emitter,
                             double cosine) {
    ty_result result = TY_OK;
    for (int i = 0; i < TAUS && result == TY_OK; ++i) {
        double should[RAYS_PHASES][TY_IMPULSE_TERMS];
        sum_rays(emitter, taus[i], cosine, (double)interpolate(tables, emitter, taus[i], 0, cosine, 1).shift, should);
        for (int g = 0; g < RAYS_PHASES && result == TY_OK; ++g) {
            char item[FIGURE_NAME_SIZE];
            const ty_impulse_response is = interpolate(tables, emitter, taus[i], 0.5 * (g - 1), cosine, 1);
            snprintf(item, sizeof item, "%s, g %g, optical distance %g", name, 0.5 * (g - 1), taus[i]);
            figure_expect(run, item, "scattered once, worst over constant term", "1", worst_of(is.single, should[g]), 0,
                          0.01);
        }
        if (result == TY_OK) result = figure_check_interrupt();
    }
    return result;
}

static void note_points(figure_run* run, const ty_impulse* tables, plot_table* table) {
    static const double albedos[ALBEDOS] = {0.3, 0.6, 0.9};
    static const double spheres[] = {0.1, 0.5, 1, 2};
    char item[FIGURE_NAME_SIZE];
    for (int a = 0; a < ALBEDOS; ++a) {
        plot_set_cell(table, 0, 1 + a, "albedo %g", albedos[a]);
        for (int i = 0; i < TAUS; ++i) {
            const ty_impulse_medium medium = {1, (float)albedos[a], 0};
            ty_impulse_response r;
            if (albedos[a] > 0.8 && taus[i] > 10) continue;
            ty_impulse_look(tables, TY_IMPULSE_POINT, &medium, (float)taus[i], 1, TY_IMPULSE_BOUNCES_MAX, &r);
            const double is = sqrt(4 * TY_PI_F64) * (double)(r.single[0] + r.multiple[0]);
            const double should = transport_fluence(albedos[a], taus[i]) - exp(-taus[i]) / (taus[i] * taus[i]);
            snprintf(item, sizeof item, "point, albedo %g, optical distance %g", albedos[a], taus[i]);
            plot_set_cell(table, 1 + i, 0, "%g", taus[i]);
            plot_set_cell(table, 1 + i, 1 + a, "%.5f", is / should);
            figure_expect(run, item, "64 bounces' fluence over exact transport's", "1", is / should, 1, 0.01);
        }
    }
    for (size_t i = 0; i < sizeof spheres / sizeof spheres[0]; ++i) {
        const ty_impulse_response r = interpolate(tables, TY_IMPULSE_POINT, spheres[i], 0, 1, TY_IMPULSE_BOUNCES_MAX);
        const double flux = spheres[i] * spheres[i] * sqrt(4 * TY_PI_F64 / 3) * (double)(r.single[1] + r.multiple[1]);
        snprintf(item, sizeof item, "point, albedo 1, optical distance %g", spheres[i]);
        figure_expect(run, item, "64 bounces' net flux over power", "1", exp(-spheres[i]) + flux, 1, 0.02);
    }
}

static ty_result make(figure_run* run, const ty_impulse* tables, const ty_impulse_stats* stats) {
    static const char* const titles[2][SHOWN] = {
        {"point, 1 bounce", "point, 2 bounces", "point, 10 bounces"},
        {"directional, 1 bounce", "directional, 2 bounces", "directional, 10 bounces"}};
    static plot_chart charts[SHOWN];
    plot_table table;
    ty_result result = plot_create_table(1 + TAUS, 1 + ALBEDOS, 1, &table);
    if (result != TY_OK) return result;
    plot_set_cell(&table, 0, 0, "optical distance");
    for (int kind = 0; kind < 2; ++kind) {
        for (int i = 0; i < SHOWN; ++i) fill_chart(tables, kind, shown[i], titles[kind][i], &charts[i]);
        plot_page_charts(&run->page, charts, SHOWN);
    }
    figure_expect(run, "tables of 64 bounces", "time to make them", "s", stats->seconds, 0, 60);
    if (result == TY_OK) result = note_single(run, tables, "point", TY_IMPULSE_POINT, 1);
    if (result == TY_OK) result = note_single(run, tables, "directional", TY_IMPULSE_DIRECTIONAL, 1);
    if (result == TY_OK) result = note_single(run, tables, "area, cosine 1", TY_IMPULSE_AREA, 1);
    if (result == TY_OK) result = note_single(run, tables, "area, cosine 0.53", TY_IMPULSE_AREA, 0.53);
    if (result == TY_OK) result = note_single(run, tables, "area, cosine 0", TY_IMPULSE_AREA, 0);
    if (result == TY_OK) note_points(run, tables, &table);
    if (result == TY_OK) plot_page_table(&run->page, &table);
    plot_free_table(&table);
    return result;
}

ty_result figure_impulse_tables(figure_run* run) {
    ty_impulse_def def = ty_default_impulse_def();
    ty_impulse_stats stats = ty_default_impulse_stats();
    ty_impulse* tables = NULL;
    def.bounces = TY_IMPULSE_BOUNCES_MAX;
    def.folder = "";
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    ty_result result = ty_impulse_create(run->session->context, &def, &tables, &stats);
    if (result == TY_OK) result = make(run, tables, &stats);
    ty_impulse_destroy(tables);
    figure_caption(run, "Zonal harmonics of radiance that has scattered up to 1, 2 and 10 times, isotropically, σt = "
                        "σs = 1/m, per unit of intensity or irradiance. Below: fluence of up to 64 bounces about a "
                        "point over that of exact transport. The files hold the tables against sums along rays.");
    return result;
}
