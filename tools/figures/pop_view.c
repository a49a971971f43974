/* Common code of figures of principal-ordinates propagation: comparison with path tracing, a synthetic environment,
 * fluence. */
#include "figures/pop_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- pictures ---- */

ty_pop_def pop_scene_def(const ty_scene* scene) {
    ty_pop_def def = ty_default_pop_def();
    ty_method_options(scene, "pop", &def);
    return def;
}

ty_result pop_render(figure_run* run, const char* item, ty_scene* scene, const ty_pop_def* settings,
                     const int32_t size[2], figure_picture* out, ty_pop_stats* stats) {
    cli_report report;
    ty_result result = settings != NULL ? ty_method_set_options(scene, "pop", settings) : TY_OK;
    if (result != TY_OK) return result;
    result = figure_render(run, item, scene, settings != NULL ? &ty_method_pop : &ty_method_path, size, out, &report);
    const ty_pop_stats* pop = (const ty_pop_stats*)report.run.stats;
    if (result == TY_OK && settings != NULL)
        result = figure_note(run, item, "time before the march", "s", pop->seconds - pop->march_seconds);
    if (stats != NULL) *stats = *pop;
    return result;
}

ty_result pop_render_variant(figure_run* run, const char* item, ty_scene* scene, const int32_t size[2],
                             const void* user, figure_picture* out) {
    return pop_render(run, item, scene, user, size, out, NULL);
}

/* ---- synthetic environment ---- */

enum { ROOM_WIDTH = 256, ROOM_HEIGHT = 128 };

/* Windows and a light: azimuth from +x towards +z and elevation, degrees, half widths, degrees, and radiance, W m^-2
 * sr^-1. */
static const struct {
    double azimuth, elevation, width, height;
    float color[3];
} windows[] = {{-104, 6, 5, 10, {7, 8, 10}}, {-91, 6, 5, 10, {7, 8, 10}},       {-78, 6, 5, 10, {7, 8, 10}},
               {-65, 6, 5, 10, {7, 8, 10}},  {-97, -9, 1.5, 1.5, {90, 60, 30}}, {45, 25, 8, 6, {14, 9, 5}},
               {160, 50, 16, 9, {5, 6, 7}}};
enum { WINDOWS = sizeof windows / sizeof windows[0] };

static void environment_color(double azimuth, double elevation, float color[3]) {
    const float wall[3] = {0.30f, 0.27f, 0.23f}, floor_color[3] = {0.16f, 0.11f, 0.08f};
    memcpy(color, elevation < -20 ? floor_color : wall, 3 * sizeof *color);
    for (int i = 0; i < WINDOWS; ++i)
        if (fabs(azimuth - windows[i].azimuth) < windows[i].width &&
            fabs(elevation - windows[i].elevation) < windows[i].height)
            memcpy(color, windows[i].color, 3 * sizeof *color);
}

static ty_result add_environment(ty_scene* scene) {
    ty_image* image = NULL;
    ty_result result = ty_image_create_rgb(ty_scene_context(scene), ROOM_WIDTH, ROOM_HEIGHT, &image);
    if (result != TY_OK) return result;
    for (int32_t y = 0; y < ROOM_HEIGHT; ++y)
        for (int32_t x = 0; x < ROOM_WIDTH; ++x) {
            float color[3];
            environment_color(((x + 0.5) / ROOM_WIDTH - 0.5) * 360, (0.5 - (y + 0.5) / ROOM_HEIGHT) * 180, color);
            for (int c = 0; c < 3; ++c) ty_image_plane(image, c)[y * ROOM_WIDTH + x] = color[c];
        }
    ty_light_def light = ty_default_light_def();
    light.kind = TY_LIGHT_ENVIRONMENT;
    light.image = image;
    result = ty_scene_add_light(scene, &light);
    ty_image_destroy(image);
    return result;
}

ty_result pop_make_scene(figure_run* run, const char* name, const char* const* overrides, int32_t override_count,
                         ty_scene** out) {
    ty_result result = figure_load_scene(run, name, overrides, override_count, out);
    if (result == TY_OK) result = add_environment(*out);
    return result == TY_OK ? ty_scene_commit(*out) : result;
}

ty_result pop_make_smoke(figure_run* run, const char* const* overrides, int32_t override_count, ty_scene** out) {
    return pop_make_scene(run, "pop_smoke", overrides, override_count, out);
}

/* ---- fluence ---- */

size_t pop_box_cells(const pop_box* box) {
    return (size_t)box->size[0] * (size_t)box->size[1] * (size_t)box->size[2];
}

/* total becomes the scattered fluence. */
static void subtract_uncollided(size_t count, const double* uncollided, double* total) {
    for (size_t i = 0; i < count; ++i) total[i] -= uncollided[i];
}

ty_result pop_path_fluence(figure_run* run, const ty_scene* scene, const pop_box* box, int32_t samples,
                           pop_truth* out) {
    ty_path_def def = ty_default_path_def();
    def.spp = figure_samples(run, run->options->quick ? samples / 16 : samples);
    def.seed = run->session->common.seed;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    const ty_result result = ty_path_fluence(scene, &def, box->lower, box->upper, box->size, out->scattered[0],
                                             out->uncollided[0], out->variance[0]);
    if (result == TY_OK) subtract_uncollided(3 * pop_box_cells(box), out->uncollided[0], out->scattered[0]);
    return result;
}

ty_result pop_scattered_fluence(const ty_pop* light, const pop_box* box, double (*out)[3]) {
    const size_t count = 3 * pop_box_cells(box);
    double* uncollided = calloc(count, sizeof *uncollided);
    if (uncollided == NULL) return TY_ERROR_MEMORY;
    const ty_result result = ty_pop_fluence(light, box->lower, box->upper, box->size, out[0], uncollided);
    if (result == TY_OK) subtract_uncollided(count, uncollided, out[0]);
    free(uncollided);
    return result;
}

figure_errors pop_compare_fluence(const pop_box* box, const double (*fluence)[3], const pop_truth* truth) {
    const size_t cells = pop_box_cells(box);
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
