/* The cube in a beam of Figs. 12 and 13. */
#include "figures/pop_cube.h"

enum { EDGE = 16 };

const fluence_box pop_cube_cells = {{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, {EDGE, EDGE, EDGE}};

ty_result pop_load_cube(figure_run* run, double g, ty_scene** out) {
    char override[32];
    const char* const overrides[1] = {override};
    snprintf(override, sizeof override, "media[0].g=%g", g);
    return ty_scene_load(run->session->context, "builtin:cube_g0", overrides, 1, out);
}

ty_pop_def pop_cube_def(figure_run* run, ty_pop_mode mode) {
    ty_pop_def def = ty_default_pop_def();
    def.mode = mode;
    def.resolution = EDGE;
    def.merged = EDGE;
    def.direct = EDGE;
    def.keep_lobes = true;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    return def;
}
