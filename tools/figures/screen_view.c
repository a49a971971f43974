/* Views: rendering the room, and applying media to views. */
#include "figures/screen_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROOM_SAMPLES = 64, ROOM_SAMPLES_QUICK = 4 };

void screen_free_view(screen_view* view) {
    ty_image_destroy(view->surface);
    free(view->distance);
    *view = (screen_view){0};
}

ty_result screen_load_room(figure_run* run, const screen_water* water, ty_scene** out) {
    char scattering[48] = "media=[]", cosine[48] = "";
    const char* const overrides[2] = {scattering, cosine};
    if (water != NULL) {
        snprintf(scattering, sizeof scattering, "media[0].sigma_s=%.9g", water->thickness / SCREEN_ROOM_DEPTH);
        snprintf(cosine, sizeof cosine, "media[0].g=%.9g", (double)water->g);
    }
    return ty_scene_load(run->session->context, "builtin:screen_room", overrides, water != NULL ? 2 : 1, out);
}

void screen_room_size(const figure_run* run, int32_t width, int32_t size[2]) {
    const figure_options* options = run->options;
    const int32_t chosen = options->quick && width > 96 ? 96 : width;
    size[0] = options->size[0] > 0 ? options->size[0] : chosen;
    size[1] = options->size[0] > 0 ? options->size[1] : chosen * 2 / 3;
}

static ty_result find_absorption(figure_run* run, screen_view* view) {
    ty_scene* scene = NULL;
    ty_medium_def medium;
    ty_result result = ty_scene_load(run->session->context, "builtin:screen_room", NULL, 0, &scene);
    if (result == TY_OK) result = ty_scene_get_medium(scene, 0, &medium);
    if (result == TY_OK) memcpy(view->absorption, medium.sigma_a, sizeof view->absorption);
    ty_scene_destroy(scene);
    return result;
}

static ty_result render_surfaces(figure_run* run, const int32_t size[2], screen_view* view) {
    ty_scene* scene = NULL;
    ty_result result = screen_load_room(run, NULL, &scene);
    if (result != TY_OK) return result;
    ty_path_def def = ty_default_path_def();
    def.spp = figure_samples(run, run->options->quick ? ROOM_SAMPLES_QUICK : ROOM_SAMPLES);
    def.seed = run->session->common.seed;
    def.width = size[0];
    def.height = size[1];
    def.aovs = TY_AOV_DEPTH;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    view->camera = ty_scene_camera(scene);
    result = ty_path_render(scene, &def, &view->surface, NULL);
    ty_scene_destroy(scene);
    return result;
}

ty_result screen_render_room(figure_run* run, const int32_t size[2], screen_view* out) {
    screen_view view = {.width = size[0], .height = size[1], .center = {-1, -1}};
    const size_t count = (size_t)size[0] * (size_t)size[1];
    ty_result result = find_absorption(run, &view);
    if (result == TY_OK) result = render_surfaces(run, size, &view);
    if (result == TY_OK) {
        view.distance = malloc(count * sizeof *view.distance);
        result = view.distance == NULL ? TY_ERROR_MEMORY : TY_OK;
    }
    if (result != TY_OK) {
        screen_free_view(&view);
        return result;
    }
    const int32_t depth = ty_image_find_channel(view.surface, "depth.Z");
    memcpy(view.distance, ty_image_plane_const(view.surface, depth), count * sizeof *view.distance);
    view.focal[0] = view.focal[1] = ty_screen_focal(size[1], view.camera.fov_y);
    *out = view;
    return TY_OK;
}

ty_screen_def screen_view_def(const screen_view* view) {
    ty_screen_def def = ty_default_screen_def();
    memcpy(def.focal, view->focal, sizeof def.focal);
    memcpy(def.center, view->center, sizeof def.center);
    def.distance_kind = view->distance_kind;
    return def;
}

ty_screen_def screen_room_def(const screen_view* view, const screen_water* water) {
    ty_screen_def def = screen_view_def(view);
    for (int c = 0; c < 3; ++c) {
        def.sigma_s[c] = (float)(water->thickness / SCREEN_ROOM_DEPTH);
        def.sigma_a[c] = view->absorption[c];
        def.g[c] = water->g;
    }
    return def;
}

ty_result screen_apply(figure_run* run, const screen_view* view, const ty_screen_def* def, ty_image** out,
                       ty_screen_stats* stats) {
    ty_screen_def own = *def;
    own.progress = cli_progress_report;
    own.progress_user = &run->session->progress;
    ty_image* image = NULL;
    ty_result result = ty_image_create_rgb(run->session->context, view->width, view->height, &image);
    if (result != TY_OK) return result;
    ty_screen_image planes = ty_default_screen_image();
    planes.width = view->width;
    planes.height = view->height;
    planes.distance = view->distance;
    planes.color.row = planes.out.row = planes.distance_row = view->width;
    for (int c = 0; c < 3; ++c) {
        planes.color.data[c] = ty_image_plane(view->surface, c);
        planes.out.data[c] = ty_image_plane(image, c);
    }
    result = ty_screen_apply(run->session->context, &own, &planes, NULL, 0, stats);
    if (result == TY_OK) result = figure_check_interrupt();
    if (result == TY_OK)
        *out = image;
    else
        ty_image_destroy(image);
    return result;
}

ty_result screen_distance_picture(figure_run* run, const screen_view* view, plot_picture* out) {
    const size_t count = (size_t)view->width * (size_t)view->height;
    float* logarithm = malloc(count * sizeof *logarithm);
    if (logarithm == NULL) return TY_ERROR_MEMORY;
    plot_scale scale = {PLOT_SEQUENTIAL, INFINITY, -INFINITY, ""};
    for (size_t i = 0; i < count; ++i) {
        logarithm[i] = view->distance[i] > 0 ? -logf(view->distance[i]) : -INFINITY;
        if (!isfinite(logarithm[i])) continue;
        scale.lower = fmin(scale.lower, (double)logarithm[i]);
        scale.upper = fmax(scale.upper, (double)logarithm[i]);
    }
    if (!(scale.upper > scale.lower)) scale.upper = scale.lower + 1;
    const ty_result result =
        plot_picture_of_values(run->session->context, logarithm, view->width, view->height, &scale, out);
    free(logarithm);
    return result;
}
