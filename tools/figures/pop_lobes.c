/* Fig. 12 of the paper: a cube in a parallel beam; radiance by direction at points of a slice, and fluence. */
#include "base/constants.h"
#include "figures/pop_cube.h"

#include <math.h>

enum { COSINES = 3, MODES = 4, LATTICE = 8, DIRECTIONS = 72, SAMPLES = 256, FLUENCE_SAMPLES = 512, SHOWN = 3 };

static const double cosines[COSINES] = {0, 0.7, 0.96};

/* iterations: 0: until 0.1 % is left, with the isotropic residuum. ratio: expected ratio of scattered fluence to path
 * tracing, from a prototype; NaN: none. */
static const struct {
    ty_pop_mode mode;
    const char* name;
    int32_t iterations;
    double ratio[COSINES], tolerance;
} modes[MODES] = {{TY_POP_MODE_SPLIT, "split", 0, {1, 1, 1}, 0.07},
                  {TY_POP_MODE_PUBLISHED, "published", 0, {NAN, NAN, NAN}, NAN},
                  {TY_POP_MODE_PUBLISHED, "published, 16 iterations", 16, {4.6, 4.8, 4.2}, NAN},
                  {TY_POP_MODE_COLLIDED, "collided", 0, {3.6, 4.6, 1.19}, NAN}};

enum { POINTS = LATTICE * LATTICE, RAYS = POINTS * DIRECTIONS };

/* Radiance by direction at points of the slice y = 0: path tracing, and the first modes. */
typedef struct slice {
    float values[SHOWN][RAYS];
} slice;

/* Points in rows from the top; directions in the slice's plane, from +x over +z. */
static void point_of(int index, double point[3]) {
    point[0] = (index % LATTICE + 0.5) / LATTICE - 0.5;
    point[1] = 0;
    point[2] = 0.5 - (index / LATTICE + 0.5) / LATTICE;
}

static void direction_of(int index, double direction[3]) {
    const double angle = 2 * TY_PI_F64 * index / DIRECTIONS;
    direction[0] = cos(angle);
    direction[1] = 0;
    direction[2] = sin(angle);
}

/* Makes the ray of every direction at every point: rays[RAYS][6]. */
static void make_rays(double (*rays)[6]) {
    for (int i = 0; i < RAYS; ++i) {
        point_of(i / DIRECTIONS, rays[i]);
        direction_of(i % DIRECTIONS, rays[i] + 3);
    }
}

/* The beam is a delta distribution in direction, so that no ray samples it. */
static ty_result trace_slice(figure_run* run, const ty_scene* scene, const double* rays, double* radiance) {
    ty_path_def def = ty_default_path_def();
    def.spp = figure_samples(run, run->options->quick ? 8 : SAMPLES);
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    return ty_path_radiance(scene, &def, rays, RAYS, radiance, NULL);
}

/* The slice's green radiance, by path tracing where no solution is given. */
static ty_result see_slice(figure_run* run, const ty_scene* scene, const ty_pop* light, float* out) {
    static double rays[RAYS][6], radiance[RAYS][3];
    make_rays(rays);
    const ty_result result = light != NULL ? ty_pop_radiance(light, rays[0], RAYS, radiance[0])
                                           : trace_slice(run, scene, rays[0], radiance[0]);
    for (int i = 0; i < RAYS && result == TY_OK; ++i) out[i] = (float)radiance[i][1];
    return result;
}

/* The ratio of a mode's mean radiance to path tracing's over all points and directions, and the relative RMSE of the
 * angular distributions, each normalized to the reference's brightness. */
static ty_result note_shape(figure_run* run, const char* item, const float* values, const float* truth) {
    double sum = 0, expected = 0, squares = 0, weight = 0;
    for (int i = 0; i < RAYS; ++i) {
        sum += (double)values[i];
        expected += (double)truth[i];
    }
    for (int i = 0; i < RAYS; ++i) {
        squares += pow((double)values[i] * expected / sum - (double)truth[i], 2);
        weight += pow((double)truth[i], 2);
    }
    figure_notes(run, item, {"mean ratio of radiance in the slice", "1", sum / expected},
                 {"RMSE of its shape, over the truth's rms", "1", sqrt(squares / weight)});
    return TY_OK;
}

static ty_result run_mode(figure_run* run, const ty_scene* scene, int column, int mode, const fluence_truth* truth,
                          double (*fluence)[3], slice* out, plot_table* table) {
    char item[FIGURE_NAME_SIZE], error[16];
    ty_pop* light = NULL;
    ty_pop_stats stats = ty_default_pop_stats();
    snprintf(item, sizeof item, "g %g, %s", cosines[column], modes[mode].name);
    ty_pop_def def = pop_cube_def(run, modes[mode].mode);
    def.iterations = modes[mode].iterations > 0 ? modes[mode].iterations : TY_AUTO;
    if (def.iterations > 0) def.residuum = 0;
    ty_result result = ty_pop_solve(scene, &def, &light, &stats);
    if (result == TY_OK) result = pop_fluence(light, &pop_cube_cells, fluence);
    if (result == TY_OK && mode + 1 < SHOWN) result = see_slice(run, scene, light, out->values[1 + mode]);
    if (result == TY_OK && mode + 1 < SHOWN) result = note_shape(run, item, out->values[1 + mode], out->values[0]);
    ty_pop_destroy(light);
    if (result != TY_OK) return result;
    const figure_errors errors = fluence_compare(&pop_cube_cells, (const double(*)[3])fluence, truth);
    const bool ours = modes[mode].mode == TY_POP_MODE_SPLIT;
    figure_format_error(errors.relative_rmse, error);
    plot_set_cell(table, 2 + mode, 1 + 2 * column, "%.3f", errors.mean_ratio);
    plot_set_cell(table, 2 + mode, 2 + 2 * column, "%s", error);
    figure_note(run, item, "time", "s", stats.seconds);
    figure_expect(run, item, "mean ratio of fluence", "1", errors.mean_ratio, modes[mode].ratio[column],
                  modes[mode].tolerance);
    figure_expect(run, item, "relative RMSE of fluence", "1", errors.relative_rmse, ours ? 0 : NAN, ours ? 0.2 : NAN);
    return TY_OK;
}

static ty_result run_column(figure_run* run, int column, fluence_truth* truth, double (*fluence)[3], slice* out,
                            plot_table* table) {
    ty_scene* scene = NULL;
    ty_result result = pop_load_cube(run, cosines[column], &scene);
    if (result == TY_OK) result = path_fluence(run, scene, &pop_cube_cells, FLUENCE_SAMPLES, truth);
    if (result == TY_OK) result = see_slice(run, scene, NULL, out->values[0]);
    for (int mode = 0; mode < MODES && result == TY_OK; ++mode)
        result = run_mode(run, scene, column, mode, truth, fluence, out, table);
    ty_scene_destroy(scene);
    return result;
}

/* Radii from radiance: cube roots, so that a lobe's volume is proportional to its energy, scaled to the reference's
 * maximum. The published mode is normalized to the reference's brightness. */
static void set_radii(slice* s) {
    double sums[SHOWN] = {0};
    float max_radiance = 0;
    for (int m = 0; m < SHOWN; ++m)
        for (int i = 0; i < RAYS; ++i) sums[m] += (double)s->values[m][i];
    for (int i = 0; i < RAYS; ++i) max_radiance = fmaxf(max_radiance, s->values[0][i]);
    for (int m = 0; m < SHOWN; ++m) {
        const float factor = (float)(m == SHOWN - 1 ? sums[0] / sums[m] : 1) / max_radiance;
        for (int i = 0; i < RAYS; ++i) s->values[m][i] = 0.95f * cbrtf(fmaxf(0, s->values[m][i] * factor));
    }
}

static void show_slice(int column, const slice* s, plot_lobes* out) {
    static const char* const titles[COSINES] = {"g = 0", "g = 0.7", "g = 0.96"};
    static const char* const names[SHOWN] = {"path tracing", "split", "published, made as bright"};
    *out = (plot_lobes){.title = titles[column],
                        .rows = LATTICE,
                        .columns = LATTICE,
                        .directions = DIRECTIONS,
                        .cell = 50,
                        .series_count = SHOWN};
    for (int m = 0; m < SHOWN; ++m) {
        snprintf(out->series[m].name, PLOT_LABEL_SIZE, "%s", names[m]);
        out->series[m].radii = s->values[m];
    }
}

static void begin_table(plot_table* table) {
    for (int column = 0; column < COSINES; ++column) {
        plot_set_cell(table, 0, 1 + 2 * column, "g = %g", cosines[column]);
        plot_set_cell(table, 1, 1 + 2 * column, "mean ratio");
        plot_set_cell(table, 1, 2 + 2 * column, "relative RMSE");
    }
    plot_set_cell(table, 0, 0, "fluence");
    for (int mode = 0; mode < MODES; ++mode) plot_set_cell(table, 2 + mode, 0, "%s", modes[mode].name);
}

ty_result figure_pop_lobes(figure_run* run) {
    plot_lobes lobes[COSINES];
    plot_table table = {0};
    static fluence_truth truth;
    static double fluence[FLUENCE_CELLS_MAX][3];
    static slice slices[COSINES];
    ty_result result = plot_create_table(2 + MODES, 1 + 2 * COSINES, 2, &table);
    if (result == TY_OK) begin_table(&table);
    for (int column = 0; column < COSINES && result == TY_OK; ++column) {
        result = run_column(run, column, &truth, fluence, &slices[column], &table);
        set_radii(&slices[column]);
        show_slice(column, &slices[column], &lobes[column]);
    }
    if (result == TY_OK) {
        plot_page_lobes(&run->page, lobes, COSINES);
        plot_page_table(&run->page, &table);
    }
    plot_free_table(&table);
    figure_caption(
        run, "A cube of 1 m, σs = 4/m, nothing absorbed, light from above, 16³ cells. Radiance by direction of light "
             "that has scattered, in the slice through the center; lengths are its cube root, and the published mode's "
             "are made as bright as path tracing's. Below: fluence of such light in all cells; relative RMSEs are "
             "without the truth's own noise. As published light counts once for every cell that it came through "
             "(collided mends that), and moves one cell a step, as if it scattered in each.");
    return result;
}
