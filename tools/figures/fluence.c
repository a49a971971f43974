/* Scattered fluence by path tracing and by methods, and its errors. */
#include "figures/fluence.h"

#include <math.h>
#include <stdlib.h>

size_t fluence_cells(const fluence_box* box) {
    return (size_t)box->size[0] * (size_t)box->size[1] * (size_t)box->size[2];
}

/* total becomes the scattered fluence. */
static void subtract_uncollided(size_t count, const double* uncollided, double* total) {
    for (size_t i = 0; i < count; ++i) total[i] -= uncollided[i];
}

ty_result path_fluence(figure_run* run, const ty_scene* scene, const fluence_box* box, int32_t samples,
                       fluence_truth* out) {
    ty_path_def def = ty_default_path_def();
    def.spp = figure_samples(run, run->options->quick ? samples / 16 : samples);
    def.seed = run->session->common.seed;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    const ty_result result = ty_path_fluence(scene, &def, box->lower, box->upper, box->size, out->scattered[0],
                                             out->uncollided[0], out->variance[0]);
    if (result == TY_OK) subtract_uncollided(3 * fluence_cells(box), out->uncollided[0], out->scattered[0]);
    return result;
}

ty_result pop_fluence(const ty_pop* light, const fluence_box* box, double (*out)[3]) {
    const size_t count = 3 * fluence_cells(box);
    double* uncollided = calloc(count, sizeof *uncollided);
    if (uncollided == NULL) return TY_ERROR_MEMORY;
    const ty_result result = ty_pop_fluence(light, box->lower, box->upper, box->size, out[0], uncollided);
    if (result == TY_OK) subtract_uncollided(count, uncollided, out[0]);
    free(uncollided);
    return result;
}

figure_errors fluence_compare(const fluence_box* box, const double (*fluence)[3], const fluence_truth* truth) {
    const size_t cells = fluence_cells(box);
    double sum = 0, expected = 0, squares = 0, noise = 0;
    for (size_t i = 0; i < cells; ++i)
        for (int c = 0; c < 3; ++c) {
            sum += fluence[i][c];
            expected += truth->scattered[i][c];
            squares += pow(fluence[i][c] - truth->scattered[i][c], 2);
            noise += truth->variance[i][c];
        }
    const double count = 3.0 * (double)cells, mean = expected / count;
    return (figure_errors){.mean_ratio = sum / expected,
                           .relative_rmse = bench_without_noise(sqrt(squares / count), sqrt(noise / count)) / mean,
                           .rel_mse = NAN};
}

ty_result dom_fluence(figure_run* run, const ty_scene* scene, int32_t directions, int32_t last, int32_t resolution,
                      const fluence_box* box, const fluence_truth* truth, double (*out)[3], ty_dom_stats* stats) {
    const size_t count = 3 * fluence_cells(box);
    ty_dom_def def = ty_default_dom_def();
    ty_dom* light = NULL;
    double* own = calloc(count, sizeof *own);
    if (own == NULL) return TY_ERROR_MEMORY;
    def.directions = directions;
    def.last_directions = last;
    def.resolution = resolution;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    ty_result result = ty_dom_solve(scene, &def, &light, stats);
    if (result == TY_OK) result = ty_dom_fluence(light, box->lower, box->upper, box->size, out[0], own);
    if (result == TY_OK) subtract_uncollided(count, truth != NULL ? truth->uncollided[0] : own, out[0]);
    ty_dom_destroy(light);
    free(own);
    return result;
}
