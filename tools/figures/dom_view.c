/* Scenes by discrete ordinates with settings of their own, and their fluence. */
#include "figures/dom_view.h"

#include <stdlib.h>

static int32_t all_sweeps(const ty_dom_stats* stats) {
    int32_t sum = 0;
    for (int32_t plane = 0; plane < stats->planes; ++plane) sum += stats->sweeps[plane];
    return sum;
}

ty_dom_def dom_scene_def(const ty_scene* scene) {
    ty_dom_def def = ty_default_dom_def();
    ty_method_options(scene, "dom", &def);
    return def;
}

ty_result dom_render(figure_run* run, const char* item, ty_scene* scene, const ty_dom_def* settings,
                     const int32_t size[2], figure_picture* out) {
    cli_report report;
    ty_result result = settings != NULL ? ty_method_set_options(scene, "dom", settings) : TY_OK;
    if (result == TY_OK) result = figure_render(run, item, scene, &ty_method_dom, size, out, &report);
    if (result != TY_OK) return result;
    const ty_dom_stats* dom = (const ty_dom_stats*)report.run.stats;
    result = figure_note(run, item, "time before the march", "s", dom->seconds - dom->march_seconds);
    if (result == TY_OK) result = figure_note(run, item, "sweeps", "1", all_sweeps(dom));
    if (result == TY_OK) result = figure_expect(run, item, "converged", "1", dom->converged ? 1 : 0, 1, 0);
    return result;
}

ty_result dom_render_variant(figure_run* run, const char* item, ty_scene* scene, const int32_t size[2],
                             const void* user, figure_picture* out) {
    return dom_render(run, item, scene, user, size, out);
}

ty_result dom_solve(figure_run* run, const ty_scene* scene, int32_t directions, int32_t last, int32_t resolution,
                    ty_dom** out, ty_dom_stats* stats) {
    ty_dom_def def = ty_default_dom_def();
    def.directions = directions;
    def.last_directions = last;
    def.resolution = resolution > 0 ? resolution : TY_AUTO;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    return ty_dom_solve(scene, &def, out, stats);
}

ty_result dom_scattered_fluence(const ty_dom* light, const pop_box* box, const pop_truth* truth, double (*out)[3]) {
    const size_t cells = pop_box_cells(box);
    double(*own)[3] = calloc(cells, sizeof *own);
    if (own == NULL) return TY_ERROR_MEMORY;
    const ty_result result = ty_dom_fluence(light, box->lower, box->upper, box->size, out[0], own[0]);
    for (size_t i = 0; i < cells && result == TY_OK; ++i)
        for (int c = 0; c < 3; ++c) out[i][c] -= truth != NULL ? truth->uncollided[i][c] : own[i][c];
    free(own);
    return result;
}
