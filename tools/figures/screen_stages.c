/* Figs. 1 and 5 of the paper: inputs, intermediate stages and result of the method. */
#include "figures/screen_view.h"

#include <math.h>
#include <stdlib.h>

enum { ROOM_WIDTH = 576, PICTURE_WIDTH = 460, COLUMNS = 3, ROWS = 2 };
enum { INPUT, DISTANCE, RESULT, ATTENUATED, SCATTERED, SPREAD };

static const screen_water water = {.thickness = 3, .g = 0.95f};

/* Inputs of the filter. */
typedef struct split {
    ty_image *attenuated, *scattered;
    float* spread[3];
} split;

static void free_split(split* s) {
    ty_image_destroy(s->attenuated);
    ty_image_destroy(s->scattered);
    for (int c = 0; c < 3; ++c) free(s->spread[c]);
}

static ty_result create_split(figure_run* run, const screen_view* view, split* out) {
    const size_t count = (size_t)view->width * (size_t)view->height;
    ty_context* context = run->session->context;
    bool allocated = true;
    for (int c = 0; c < 3; ++c) allocated = (out->spread[c] = calloc(count, sizeof(float))) != NULL && allocated;
    if (!allocated) return TY_ERROR_MEMORY;
    ty_result result = ty_image_create_rgb(context, view->width, view->height, &out->attenuated);
    if (result == TY_OK) result = ty_image_create_rgb(context, view->width, view->height, &out->scattered);
    return result;
}

static ty_result split_view(figure_run* run, const screen_view* view, const ty_screen_def* def, split* out) {
    ty_screen_image image = ty_default_screen_image();
    image.width = view->width;
    image.height = view->height;
    image.distance = view->distance;
    const float* colors[3];
    float *attenuated[3], *scattered[3];
    ty_result result = create_split(run, view, out);
    if (result != TY_OK) return result;
    if (!ty_image_rgb_planes(view->surface, colors)) return TY_ERROR_INTERNAL;
    for (int c = 0; c < 3; ++c) {
        image.color.data[c] = (float*)colors[c]; /* read only, as the declaration says */
        attenuated[c] = ty_image_plane(out->attenuated, c);
        scattered[c] = ty_image_plane(out->scattered, c);
        image.out.data[c] = attenuated[c];
    }
    image.color.row = image.out.row = image.distance_row = view->width;
    return ty_screen_split(run->session->context, def, &image, attenuated, scattered, out->spread);
}

/* The logarithm of the spread, green channel. */
static ty_result show_spread(figure_run* run, const screen_view* view, const split* s, plot_picture* out) {
    const size_t count = (size_t)view->width * (size_t)view->height;
    double min_log = INFINITY, max_log = -INFINITY;
    for (size_t i = 0; i < count; ++i) {
        s->spread[1][i] = log10f(fmaxf(s->spread[1][i], 0.01f));
        min_log = fmin(min_log, (double)s->spread[1][i]);
        max_log = fmax(max_log, (double)s->spread[1][i]);
    }
    const plot_scale scale = {PLOT_SEQUENTIAL, min_log, fmax(max_log, min_log + 1e-3), ""};
    ty_result result = TY_OK;
    figure_notes(run, "split", {"smallest half-light radius", "pixel", pow(10, min_log)},
                 {"largest half-light radius", "pixel", pow(10, max_log)});
    if (result != TY_OK) return result;
    return plot_picture_of_values(run->session->context, s->spread[1], view->width, view->height, &scale, out);
}

/* Energy conservation: attenuated plus scattered radiance is the input. Eq. 3-4 (Elek 2013) */
static ty_result note_split(figure_run* run, const screen_view* view, const ty_screen_def* def, const split* s) {
    const size_t count = (size_t)view->width * (size_t)view->height;
    const float *in[3], *a[3], *b[3];
    double expected = 0, sum = 0;
    if (!ty_image_rgb_planes(view->surface, in) || !ty_image_rgb_planes(s->attenuated, a) ||
        !ty_image_rgb_planes(s->scattered, b))
        return TY_ERROR_INTERNAL;
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < count; ++i) {
            expected += (double)in[c][i] * exp(-(double)def->sigma_a[c] * (double)view->distance[i]);
            sum += (double)a[c][i] + (double)b[c][i];
        }
    figure_expect(run, "attenuated and scattered", "over what is not absorbed", "1", sum / expected, 1, 0.01);
    return TY_OK;
}

static ty_result show_image(figure_run* run, const screen_view* view, const ty_image* image, const char* title,
                            plot_cell* cell) {
    snprintf(cell->title, PLOT_LABEL_SIZE, "%s", title);
    return plot_picture_of_image(run->session->context, image, view->camera.exposure, &cell->picture);
}

static ty_result fill_sheet(figure_run* run, const screen_view* view, plot_sheet* sheet) {
    const ty_screen_def def = screen_room_def(view, &water);
    plot_cell* cells = sheet->cells;
    ty_image* image = NULL;
    ty_screen_stats stats = ty_default_screen_stats();
    split s = {0};
    ty_result result = split_view(run, view, &def, &s);
    if (result == TY_OK) result = screen_apply(run, view, &def, &image, &stats);
    if (result == TY_OK) figure_note(run, "result", "time", "s", stats.seconds);
    if (result == TY_OK) result = note_split(run, view, &def, &s);
    if (result == TY_OK) result = show_image(run, view, view->surface, "image without a medium", &cells[INPUT]);
    if (result == TY_OK) result = screen_distance_picture(run, view, &cells[DISTANCE].picture);
    if (result == TY_OK) result = show_image(run, view, image, "result", &cells[RESULT]);
    if (result == TY_OK) result = show_image(run, view, s.attenuated, "attenuated (Eq. 3)", &cells[ATTENUATED]);
    if (result == TY_OK) result = show_image(run, view, s.scattered, "scattered (Eq. 4)", &cells[SCATTERED]);
    if (result == TY_OK) result = show_spread(run, view, &s, &cells[SPREAD].picture);
    snprintf(cells[DISTANCE].title, PLOT_LABEL_SIZE, "distance, near is bright");
    snprintf(cells[SPREAD].title, PLOT_LABEL_SIZE, "spread (Eq. 5), wide is bright");
    if (result == TY_OK) snprintf(cells[RESULT].lines[0], PLOT_LABEL_SIZE, "%.2f ms", 1e3 * stats.seconds);
    free_split(&s);
    ty_image_destroy(image);
    return result;
}

ty_result figure_screen_stages(figure_run* run) {
    int32_t size[2];
    screen_view view = {0};
    plot_sheet sheet = {0};
    screen_room_size(run, ROOM_WIDTH, size);
    ty_result result = screen_render_room(run, size, &view);
    if (result == TY_OK) result = plot_create_sheet(ROWS, COLUMNS, PICTURE_WIDTH, &sheet);
    if (result == TY_OK) result = fill_sheet(run, &view, &sheet);
    figure_place_sheet(run, result, &sheet, NULL);
    screen_free_view(&view);
    figure_caption(
        run,
        "The builtin scene screen_room, %d × %d pixels, in water that scatters, optical thickness %g as far as the "
        "back wall (%g m), g = %g: the image and its distances, the light that comes straight and the light that is "
        "scattered and how far it spreads, and both put together (scatter, with our spread).",
        size[0], size[1], water.thickness, SCREEN_ROOM_DEPTH, (double)water.g);
    return result;
}
