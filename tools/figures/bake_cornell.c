/* Fig. 9 of the paper: lightmaps of the Cornell box in fog, without and with back-scattering, after 1, 2 and 10
 * scatterings, against path-traced ones; and by light gathered in cells. */
#include "cli/bake/bake.h"
#include "figures/bake_view.h"

#include <stdlib.h>
#include <string.h>

enum { ROWS = 3, WITHOUT = 0, WITH = 1, CELLS = 2, TRUTH = 3, METHODS = 4, SIDE = 96, PICTURE_WIDTH = 230 };
enum { ROOM = 3, PARTS = 3 };

static const int32_t scatterings[ROWS] = {1, 2, 10};
static const char* const titles[METHODS] = {"impulse, no back-scattering", "impulse", "cache", "path tracing"};

typedef struct maps {
    ty_scene* scene;
    ty_impulse* tables;
    ty_atlas* atlases[PARTS]; /* atlases of the box's primitives, in one map */
} maps;

static void close_maps(maps* m) {
    for (int i = 0; i < PARTS; ++i) ty_atlas_destroy(m->atlases[i]);
    ty_impulse_destroy(m->tables);
    ty_scene_destroy(m->scene);
}

static ty_result open_maps(figure_run* run, maps* m) {
    ty_context* context = run->session->context;
    const ty_impulse_def def = ty_default_impulse_def();
    ty_atlas_def atlas = ty_default_atlas_def();
    atlas.width = atlas.height = run->options->size[0] >= 16 ? run->options->size[0]
                                 : run->options->quick       ? SIDE / 3
                                                             : SIDE;
    ty_result result = figure_load_scene(run, "bake_cornell", NULL, 0, &m->scene);
    if (result == TY_OK) result = ty_impulse_create(context, &def, &m->tables, NULL);
    for (int i = 0; i < PARTS && result == TY_OK; ++i)
        result = ty_atlas_create(m->scene, ROOM + i, "room", &atlas, &m->atlases[i]);
    return result;
}

/* The result of one bake. */
typedef struct baked {
    ty_bake_light* light[PARTS];
    ty_image* image;
    double seconds;
} baked;

static void free_baked(baked* b) {
    for (int i = 0; i < PARTS; ++i) free(b->light[i]);
    ty_image_destroy(b->image);
    *b = (baked){.image = NULL};
}

/* Sets R, G and B to the scattered irradiance, as in the paper. */
static void set_scattered(ty_image* image) {
    static const char* const names[3][2] = {
        {"single.R", "multiple.R"}, {"single.G", "multiple.G"}, {"single.B", "multiple.B"}};
    const size_t count = (size_t)ty_image_width(image) * (size_t)ty_image_height(image);
    for (int c = 0; c < 3; ++c) {
        const float* single = ty_image_plane(image, ty_image_find_channel(image, names[c][0]));
        const float* multiple = ty_image_plane(image, ty_image_find_channel(image, names[c][1]));
        for (size_t i = 0; i < count; ++i) ty_image_plane(image, c)[i] = single[i] + multiple[i];
    }
}

static ty_result bake(figure_run* run, const maps* m, const char* item, int method, int32_t max_scatterings,
                      baked* out) {
    ty_image* images[PARTS] = {NULL};
    ty_bake_def def = ty_default_bake_def();
    ty_result result = TY_OK;
    bool apart = false;
    ty_bake_cache* cache = NULL;
    def.method = method == TRUTH ? TY_BAKE_PATH : method == CELLS ? TY_BAKE_CACHE : TY_BAKE_IMPULSE;
    def.composition = TY_BAKE_PUBLISHED;
    def.back_scattering = method != WITHOUT;
    def.scatterings = max_scatterings;
    def.tables = m->tables;
    def.spp = bake_spp(run, method == TRUTH);
    if (method == CELLS) result = ty_bake_cache_create(m->scene, &def, &cache);
    if (cache != NULL) out->seconds += ty_bake_cache_get_info(cache).seconds;
    def.cache = cache;
    for (int i = 0; i < PARTS && result == TY_OK; ++i) {
        int64_t count = 0;
        double seconds = 0;
        const ty_bake_receiver* receivers = ty_atlas_receivers(m->atlases[i], &count);
        def.seed = (uint64_t)(10 * method + i);
        result = bake_view_light(run, item, m->scene, &def, receivers, count, &out->light[i], &seconds);
        out->seconds += seconds;
        if (result == TY_OK) result = ty_atlas_create_image(m->atlases[i], out->light[i], &images[i]);
    }
    ty_bake_cache_destroy(cache);
    if (result == TY_OK) result = bake_merge(images, PARTS, &apart);
    if (result == TY_OK) set_scattered(images[0]);
    for (int i = 1; i < PARTS; ++i) ty_image_destroy(images[i]);
    out->image = images[0];
    return result;
}

/* Errors over all primitives. */
static ty_result compare(const maps* m, const baked* b, const baked* truth, bake_component component,
                         bake_errors* out) {
    int64_t counts[PARTS], all = 0, at = 0;
    for (int i = 0; i < PARTS; ++i) {
        ty_atlas_receivers(m->atlases[i], &counts[i]);
        all += counts[i];
    }
    ty_bake_light* light = malloc((size_t)all * 2 * sizeof *light);
    if (light == NULL) return TY_ERROR_MEMORY;
    for (int i = 0; i < PARTS; ++i) {
        memcpy(light + at, b->light[i], (size_t)counts[i] * sizeof *light);
        memcpy(light + all + at, truth->light[i], (size_t)counts[i] * sizeof *light);
        at += counts[i];
    }
    *out = bake_compare(light, light + all, all, component);
    free(light);
    return TY_OK;
}

static ty_result note_errors(figure_run* run, const maps* m, const char* item, int method, const baked* b,
                             const baked* truth, plot_cell* cell) {
    char scattered_item[FIGURE_NAME_SIZE];
    bake_errors all, scattered;
    snprintf(scattered_item, sizeof scattered_item, "%.40s, scattered", item);
    ty_result result = compare(m, b, truth, BAKE_ALL, &all);
    if (result == TY_OK) result = compare(m, b, truth, BAKE_SCATTERED, &scattered);
    if (result == TY_OK) bake_note_errors(run, item, &all, method == CELLS && !run->options->quick);
    if (result == TY_OK) bake_note_errors(run, scattered_item, &scattered, false);
    if (result == TY_OK) result = figure_error_map(run, b->image, truth->image, 1, &cell->picture);
    if (result != TY_OK) return result;
    bake_write_errors("all light:", &all, cell->lines[0]);
    bake_write_errors("scattered:", &scattered, cell->lines[1]);
    return TY_OK;
}

static ty_result fill_row(figure_run* run, const maps* m, int row, plot_sheet* sheet) {
    baked b[METHODS] = {{.image = NULL}};
    char item[FIGURE_NAME_SIZE];
    ty_result result = TY_OK;
    for (int method = METHODS - 1; method >= 0 && result == TY_OK; --method) {
        plot_cell* cell = plot_sheet_cell(sheet, row, method);
        snprintf(item, sizeof item, "%d scatterings, %s", (int)scatterings[row], titles[method]);
        result = bake(run, m, item, method, scatterings[row], &b[method]);
        if (result == TY_OK) result = plot_picture_of_image(run->session->context, b[method].image, -2, &cell->picture);
        snprintf(cell->lines[0], PLOT_LABEL_SIZE, "%.3g s", b[method].seconds);
        if (result == TY_OK && method != TRUTH)
            result =
                note_errors(run, m, item, method, &b[method], &b[TRUTH], plot_sheet_cell(sheet, row, METHODS + method));
    }
    snprintf(sheet->row_titles[row], PLOT_LABEL_SIZE, "%d scattering%s", (int)scatterings[row], row == 0 ? "" : "s");
    for (int method = 0; method < METHODS; ++method) free_baked(&b[method]);
    return result;
}

static ty_result fill_page(figure_run* run, const maps* m) {
    plot_sheet sheet;
    ty_result result = plot_create_sheet(ROWS, METHODS + TRUTH, PICTURE_WIDTH, &sheet);
    if (result != TY_OK) return result;
    for (int method = 0; method < METHODS; ++method)
        snprintf(sheet.column_titles[method], PLOT_LABEL_SIZE, "%s", titles[method]);
    for (int method = 0; method < TRUTH; ++method)
        snprintf(sheet.column_titles[METHODS + method], PLOT_LABEL_SIZE, "errors: %s", titles[method]);
    for (int row = 0; row < ROWS && result == TY_OK; ++row) result = fill_row(run, m, row, &sheet);
    figure_place_sheet(run, result, &sheet, &figure_error_scale);
    return result;
}

ty_result figure_bake_cornell(figure_run* run) {
    char path[FIGURE_PATH_SIZE];
    maps m = {.scene = NULL};
    if (!figure_find_data(run, CORNELL_FILE, path)) return TY_OK;
    ty_result result = open_maps(run, &m);
    if (result == TY_OK) result = fill_page(run, &m);
    close_maps(&m);
    figure_caption(run,
                   "Lightmaps of the walls of the Cornell box by its author's texture coordinates, 5.6 m across, in "
                   "fog of σs = 0.2/m: what media scattered, alone. Impulse responses and light in cells at %d paths a "
                   "texel, path tracing at %d. Below the errors: ratio of means and relative RMSE of all light, "
                   "without the truth's own noise, and of what media scattered, with it.",
                   (int)bake_spp(run, false), (int)bake_spp(run, true));
    return result;
}
