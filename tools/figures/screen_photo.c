/* Fig. 9 of the paper: a photograph with depth, seen through three media. */
#include "figures/screen_view.h"

#include <stdlib.h>
#include <string.h>

enum { MEDIA = 3, PICTURE_WIDTH = 640 };

/* The TUM RGB-D benchmark's camera fr1: 16-bit depth along the axis in 1/5000 m, intrinsics in pixels. */
static const double depth_per_unit = 65535 / 5000.0;
static const double focal[2] = {517.3, 516.5}, center[2] = {318.6, 255.3};
static const char* const color_name = "rgbd/tum_fr1_color.png";
static const char* const depth_name = "rgbd/tum_fr1_depth.png";

static const struct {
    const char *title, *medium; /* in the syntax of ty_medium_parse */
    float around[3];            /* ambient radiance, on a scale on which a white sheet in the image has about 1 */
} media[MEDIA] = {
    {"fog, visibility 5 m", "fog:5", {0.4f, 0.41f, 0.43f}},
    {"milk, one part in 80000 of water",
     "{\"preset\": \"wholemilk\", \"dilution\": 80000, \"g\": 0.95}",
     {0.3f, 0.33f, 0.36f}},
    {"coastal water, Jerlov 3C", "jerlov3c", {0.02f, 0.1f, 0.12f}},
};

/* Converts a depth map's samples to metres; 0 means unknown. */
static ty_result copy_depth(const ty_image* depth, screen_view* view) {
    if (ty_image_width(depth) != view->width || ty_image_height(depth) != view->height) return TY_ERROR_INPUT;
    const size_t count = (size_t)view->width * (size_t)view->height;
    const float* plane = ty_image_plane_const(depth, 0);
    view->distance = malloc(count * sizeof *view->distance);
    if (view->distance == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) view->distance[i] = (float)(depth_per_unit * (double)plane[i]);
    return TY_OK;
}

static ty_result read_view(figure_run* run, const char* color_path, const char* depth_path, screen_view* view) {
    ty_context* context = run->session->context;
    ty_image* depth = NULL;
    int64_t filled = 0;
    ty_result result = ty_image_read(context, color_path, &view->surface);
    if (result == TY_OK) result = ty_image_read_raw(context, depth_path, &depth);
    if (result == TY_OK) {
        view->width = ty_image_width(view->surface);
        view->height = ty_image_height(view->surface);
        view->distance_kind = TY_SCREEN_DISTANCE_AXIS;
        memcpy(view->focal, focal, sizeof focal);
        memcpy(view->center, center, sizeof center);
        result = copy_depth(depth, view);
    }
    ty_image_destroy(depth);
    if (result == TY_OK) result = ty_screen_fill_distance(context, view->width, view->height, view->distance, &filled);
    if (result == TY_OK) figure_note(run, "photograph", "pixels without a distance, filled", "pixel", (double)filled);
    return result;
}

static ty_result make_def(figure_run* run, const screen_view* view, int medium, ty_screen_def* out) {
    ty_medium_def parsed;
    const ty_result result = ty_medium_parse(run->session->context, media[medium].medium, &parsed);
    if (result != TY_OK) return result;
    *out = screen_view_def(view);
    memcpy(out->sigma_s, parsed.sigma_s, sizeof out->sigma_s);
    memcpy(out->sigma_a, parsed.sigma_a, sizeof out->sigma_a);
    memcpy(out->g, parsed.g, sizeof out->g);
    ty_screen_balance(out, media[medium].around);
    return TY_OK;
}

static void write_lines(const ty_screen_def* def, int medium, plot_cell* cell) {
    snprintf(cell->title, sizeof cell->title, "%s", media[medium].title);
    snprintf(cell->lines[0], PLOT_LABEL_SIZE, "per m: σs %.3g %.3g %.3g, σa %.2g %.2g %.2g; g %.3g",
             (double)def->sigma_s[0], (double)def->sigma_s[1], (double)def->sigma_s[2], (double)def->sigma_a[0],
             (double)def->sigma_a[1], (double)def->sigma_a[2], (double)def->g[1]);
}

static ty_result fill_medium(figure_run* run, const screen_view* view, int medium, plot_cell* cell) {
    const char* item = media[medium].title;
    ty_screen_def def;
    ty_screen_stats stats = ty_default_screen_stats();
    ty_image* image = NULL;
    ty_result result = make_def(run, view, medium, &def);
    if (result == TY_OK) result = screen_apply(run, view, &def, &image, &stats);
    if (result == TY_OK)
        figure_notes(run, item, {"time", "s", stats.seconds}, {"largest half-light radius", "pixel", stats.spread});
    if (result == TY_OK) result = plot_picture_of_image(run->session->context, image, 0, &cell->picture);
    if (result == TY_OK) write_lines(&def, medium, cell);
    ty_image_destroy(image);
    return result;
}

static ty_result fill_page(figure_run* run, const screen_view* view) {
    plot_sheet sheet = {0};
    ty_result result = plot_create_sheet(2, 2, PICTURE_WIDTH, &sheet);
    if (result != TY_OK) return result;
    plot_cell* photograph = plot_sheet_cell(&sheet, 0, 0);
    snprintf(photograph->title, sizeof photograph->title, "photograph and distances, near is bright");
    result = plot_picture_of_image(run->session->context, view->surface, 0, &photograph->picture);
    if (result == TY_OK) result = screen_distance_picture(run, view, &photograph->inset);
    for (int medium = 0; medium < MEDIA && result == TY_OK; ++medium)
        result = fill_medium(run, view, medium, plot_sheet_cell(&sheet, (medium + 1) / 2, (medium + 1) % 2));
    figure_place_sheet(run, result, &sheet, NULL);
    return result;
}

ty_result figure_screen_photo(figure_run* run) {
    char color_path[FIGURE_PATH_SIZE], depth_path[FIGURE_PATH_SIZE];
    if (!figure_find_data(run, color_name, color_path) || !figure_find_data(run, depth_name, depth_path)) return TY_OK;
    screen_view view = {0};
    ty_result result = read_view(run, color_path, depth_path, &view);
    if (result == TY_OK) result = fill_page(run, &view);
    screen_free_view(&view);
    figure_caption(run, "A photograph with depth (TUM RGB-D benchmark, sequence fr1, CC BY), decoded from sRGB; where "
                        "the sensor saw no depth it is filled from around. Scattered light that leaves the image's "
                        "half space is made up for by the surroundings' radiance.");
    return result;
}
