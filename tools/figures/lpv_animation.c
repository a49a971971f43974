/* Temporal stability of the lattice: light and camera move in small steps. */
#include "base/constants.h"
#include "figures/view.h"

#include <math.h>
#include <string.h>

enum { FRAMES = 12, FRAMES_QUICK = 3, SUN = 0, CAMERA = 1, WAYS = 2, PICTURE_WIDTH = 300, WIDTH = 256, HEIGHT = 144 };

static const char* const motion_names[WAYS] = {"the sun turns by a quarter of a degree a frame",
                                               "the camera, with its lattice, moves by an eighth of a cell a frame"};
static const double sun_step = 0.25, camera_step = 1.0 / 8;
static const double camera_extent = 20; /* m */
enum { CAMERA_CELLS = 32 };

/* Fluence is compared in the court, in cells of 1.5 m. */
static const double lower[3] = {-4.5, 0.5, -2.5}, upper[3] = {4.5, 8, 2.5};
static const int32_t size[3] = {6, 5, 3};
enum { POINTS = 6 * 5 * 3 };

/* One frame: fluence at points, and the image. */
typedef struct frame {
    double fluence[POINTS][3];
    ty_image* image;
} frame;

static void write_override(int motion, int f, char out[96]) {
    if (motion == SUN) {
        const double angle = (20 + sun_step * f) * TY_PI_F64 / 180;
        snprintf(out, 96, "lights[0].direction=[%.9f,-1,%.9f]", 0.5 * cos(angle), 0.5 * sin(angle));
        return;
    }
    snprintf(out, 96, "camera.position=[%.9f,1.8,-0.6]", -4 + camera_step * f * camera_extent / CAMERA_CELLS);
}

static ty_result render_frame(figure_run* run, int motion, int f, frame* out) {
    char override[96];
    const char* const overrides[1] = {override};
    ty_scene* scene = NULL;
    ty_lpv* light = NULL;
    int32_t pixels[2];
    write_override(motion, f, override);
    figure_view_size(run, WIDTH, HEIGHT, pixels);
    ty_result result = figure_load_scene(run, lpv_scene_files[LPV_ATRIUM], overrides, 1, &scene);
    if (result != TY_OK) return result;
    ty_lpv_def def;
    result = figure_method_def(scene, &ty_method_lpv, NULL, &def);
    if (motion == CAMERA) {
        def.place = TY_LPV_PLACE_CAMERA;
        def.extent = camera_extent;
        def.resolution = CAMERA_CELLS;
    }
    def.width = pixels[0];
    def.height = pixels[1];
    def.aovs = TY_AOV_MULTIPLE;
    if (result == TY_OK) result = ty_lpv_solve(scene, &def, &light, NULL);
    if (result == TY_OK) result = ty_lpv_fluence(light, lower, upper, size, out->fluence[0]);
    if (result == TY_OK) result = ty_lpv_view(light, scene, &def, &out->image, NULL);
    ty_lpv_destroy(light);
    ty_scene_destroy(scene);
    return result == TY_OK ? figure_check_interrupt() : result;
}

/* Changes between successive frames, relative to the mean. */
typedef struct changes {
    double mean, largest;
} changes;

static changes compare_values(size_t count, const double* before, const double* now) {
    double sum = 0, total = 0, largest = 0;
    for (size_t i = 0; i < count; ++i) {
        const double change = fabs(now[i] - before[i]);
        sum += change;
        total += 0.5 * (now[i] + before[i]);
        largest = fmax(largest, change);
    }
    return (changes){sum / total, largest * (double)count / total};
}

/* Changes of three channels by name. */
static changes compare_images(const ty_image* before, const ty_image* now, const char* const names[3]) {
    const size_t count = (size_t)ty_image_width(now) * (size_t)ty_image_height(now);
    double sum = 0, total = 0, largest = 0;
    for (int c = 0; c < 3; ++c) {
        const float* old = ty_image_plane_const(before, ty_image_find_channel(before, names[c]));
        const float* new = ty_image_plane_const(now, ty_image_find_channel(now, names[c]));
        for (size_t i = 0; i < count; ++i) {
            const double a = (double)old[i], b = (double)new[i];
            sum += fabs(b - a);
            total += 0.5 * (a + b);
            largest = fmax(largest, fabs(b - a));
        }
    }
    return (changes){sum / total, largest * 3.0 * (double)count / total};
}

static void note_changes(figure_run* run, int motion, const char* what, const changes* all, int count) {
    changes maximum = {0, 0};
    double sum = 0;
    char item[FIGURE_NAME_SIZE];
    snprintf(item, sizeof item, "%s, %s", motion == SUN ? "sun" : "camera", what);
    for (int i = 0; i < count; ++i) {
        sum += all[i].mean / count;
        maximum.mean = fmax(maximum.mean, all[i].mean);
        maximum.largest = fmax(maximum.largest, all[i].largest);
    }
    figure_notes(run, item, {"mean change", "1", sum}, {"largest change", "1", maximum.largest});
    /* A jump changes a frame by a multiple of the others' change; a lattice that follows the camera moves in steps. */
    if (motion == SUN) figure_note(run, item, "mean change, largest frame over mean", "1", maximum.mean / sum);
}

static void add_series(plot_chart* chart, const char* name, const changes* all, int count, bool largest) {
    plot_series* series = &chart->series[chart->series_count++];
    snprintf(series->name, PLOT_LABEL_SIZE, "%s", name);
    for (int i = 0; i < count; ++i) plot_add_point(series, i + 1, largest ? all[i].largest : all[i].mean, 0);
}

static ty_result run_motion(figure_run* run, int motion, frame* frames, plot_sheet* sheet, plot_chart* chart) {
    static const char *const rgb[3] = {"R", "G", "B"}, *const multiple[3] = {"multiple.R", "multiple.G", "multiple.B"};
    changes fluence[FRAMES - 1], fog[FRAMES - 1], images[FRAMES - 1];
    const int count = run->options->quick ? FRAMES_QUICK : FRAMES, pairs = count - 1;
    ty_result result = TY_OK;
    for (int f = 0; f < count && result == TY_OK; ++f) result = render_frame(run, motion, f, &frames[f]);
    if (result != TY_OK) return result;
    for (int f = 1; f < count; ++f) {
        fluence[f - 1] = compare_values(3 * POINTS, frames[f - 1].fluence[0], frames[f].fluence[0]);
        fog[f - 1] = compare_images(frames[f - 1].image, frames[f].image, multiple);
        images[f - 1] = compare_images(frames[f - 1].image, frames[f].image, rgb);
    }
    add_series(chart, "fluence of the lattice, mean", fluence, pairs, false);
    add_series(chart, "fluence of the lattice, largest", fluence, pairs, true);
    add_series(chart, "marched pixels, mean", fog, pairs, false);
    add_series(chart, "marched pixels, largest", fog, pairs, true);
    add_series(chart, "pixels, mean", images, pairs, false);
    add_series(chart, "pixels, largest", images, pairs, true);
    note_changes(run, motion, "fluence", fluence, pairs);
    note_changes(run, motion, "marched pixels", fog, pairs);
    note_changes(run, motion, "pixels", images, pairs);
    for (int i = 0; i < 2 && result == TY_OK; ++i)
        result = plot_picture_of_image(run->session->context, frames[i * pairs].image, 0,
                                       &plot_sheet_cell(sheet, 0, 2 * motion + i)->picture);
    return result;
}

static ty_result fill_page(figure_run* run, plot_sheet* sheet, plot_chart* charts) {
    ty_result result = TY_OK;
    for (int motion = 0; motion < WAYS && result == TY_OK; ++motion) {
        static frame frames[FRAMES];
        memset(frames, 0, sizeof frames);
        charts[motion] = (plot_chart){
            .title = motion_names[motion], .x_label = "frame", .y_label = "change, of the mean", .y_logarithmic = true};
        snprintf(sheet->column_titles[2 * motion], PLOT_LABEL_SIZE, "%s, first frame",
                 motion == SUN ? "sun" : "camera");
        snprintf(sheet->column_titles[2 * motion + 1], PLOT_LABEL_SIZE, "last frame");
        result = run_motion(run, motion, frames, sheet, &charts[motion]);
        for (int f = 0; f < FRAMES; ++f) ty_image_destroy(frames[f].image);
    }
    return result;
}

ty_result figure_lpv_animation(figure_run* run) {
    plot_sheet sheet;
    static plot_chart charts[WAYS];
    ty_result result = plot_create_sheet(1, 2 * WAYS, PICTURE_WIDTH, &sheet);
    if (result == TY_OK) {
        result = fill_page(run, &sheet, charts);
        if (result == TY_OK) {
            plot_page_sheet(&run->page, &sheet);
            plot_page_charts(&run->page, charts, WAYS);
        }
        plot_free_sheet(&sheet);
    }
    figure_caption(run, "The built-in atrium, each frame solved anew. Fluence is that of the lattice in cells of the "
                        "court, 1.5 m wide, and does not depend on the camera but by where the lattice lies; marched "
                        "pixels are light that fog scatters from the lattice; pixels are of the whole picture, where "
                        "edges of shadows and, with the camera, of things move by pixels.");
    return result;
}
