/* Fig. 5 of the paper: the contribution of each part of the method, in both modes. */
#include "figures/view.h"

enum { PARTS = 6, MODES = 2 };

static const char* const modes[MODES] = {"links", "published"};
static const struct {
    const char *title, *parts;
} parts[PARTS] = {{"(a) full", "all"},
                  {"(b) shadow maps", "shadow_map"},
                  {"(c) plain", "plain"},
                  {"(d) single scattering", "single"},
                  {"(e) plain, marched", "plain_march"},
                  {"(f) (d) and (e) added", "both"}};

static ty_result show(figure_run* run, ty_scene* scene, int mode, int index, const int32_t size[2], plot_sheet* sheet) {
    char item[FIGURE_NAME_SIZE], options[64];
    const figure_variant variant = {.method = &ty_method_lpv, .options = options};
    figure_picture picture = {0};
    plot_cell* cell = plot_sheet_cell(sheet, mode, index);
    snprintf(item, sizeof item, "%s, %s", modes[mode], parts[index].parts);
    snprintf(options, sizeof options, "mode=%s parts=%s", modes[mode], parts[index].parts);
    ty_result result = figure_render_variant(run, item, scene, &variant, size, &picture, NULL);
    if (result == TY_OK) result = figure_show(run, item, scene, &picture, NULL, false, cell, NULL);
    if (result == TY_OK) {
        const double mean = figure_mean(picture.image);
        snprintf(cell->lines[1], PLOT_LABEL_SIZE, "mean %.3g W m⁻² sr⁻¹", mean);
        figure_note(run, item, "mean", "W m^-2 sr^-1", mean);
    }
    figure_free_picture(&picture);
    return result;
}

static ty_result fill_sheet(figure_run* run, ty_scene* scene, plot_sheet* sheet) {
    int32_t size[2];
    figure_view_size(run, 480, 270, size);
    ty_result result = TY_OK;
    for (int index = 0; index < PARTS; ++index)
        snprintf(sheet->column_titles[index], PLOT_LABEL_SIZE, "%s", parts[index].title);
    for (int mode = 0; mode < MODES && result == TY_OK; ++mode) {
        snprintf(sheet->row_titles[mode], PLOT_LABEL_SIZE, "%s", modes[mode]);
        for (int index = 0; index < PARTS && result == TY_OK; ++index)
            result = show(run, scene, mode, index, size, sheet);
    }
    return result;
}

ty_result figure_lpv_parts(figure_run* run) {
    ty_scene* scene = NULL;
    plot_sheet sheet;
    const lpv_scene which = tools_has_data(run->options->data, SPONZA_FILE) ? LPV_SPONZA : LPV_ATRIUM;
    ty_result result = plot_create_sheet(MODES, PARTS, 260, &sheet);
    if (result != TY_OK) return result;
    result = figure_load_scene(run, lpv_scene_files[which], NULL, 0, &scene);
    if (result == TY_OK) result = fill_sheet(run, scene, &sheet);
    figure_place_sheet(run, result, &sheet, NULL);
    ty_scene_destroy(scene);
    figure_caption(
        run,
        "%s: all parts (a); direct light alone (b); with plain light propagation volumes, which know of no media (c); "
        "with single scattering instead (d); the plain lattice marched (e); (d) and (e) together (f).",
        which == LPV_SPONZA ? "Sponza in fog" : "The built-in atrium in fog (Sponza's data are not there)");
    return result;
}
