/* What figures of screen-space scattering start from: an image with distances, and media to put before it. */
#ifndef TY_CLI_FIGURES_SCREEN_VIEW_H
#define TY_CLI_FIGURES_SCREEN_VIEW_H

#include "cli/figures/figure.h"

#include <tyndall/screen.h>

/* How far the back wall of the room in scenes/builtin is, m. */
#define SCREEN_ROOM_DEPTH 20.0

/* What the room's medium may be instead of its own: scattering of an optical thickness as far as the back wall, and its
 * mean cosine. Absorption is always the room's. */
typedef struct screen_water {
    double thickness;
    float g;
} screen_water;

typedef struct screen_view {
    ty_camera_def camera;
    int32_t width, height;
    ty_image* surface;          /* R, G, B without a medium */
    float* distance;            /* m along each pixel's ray; width * height, 0 where there is none */
    double focal[2], center[2]; /* pixels; as in ty_screen_def */
    ty_screen_distance_kind distance_kind;
    float absorption[3]; /* of the room's medium, 1/m */
} screen_view;

void screen_free_view(screen_view* view);

/* The builtin room; water NULL: without a medium. */
ty_result screen_load_room(figure_run* run, const screen_water* water, ty_scene** out);
/* The size of its pictures: what the options say, or width x 2/3 of it, less when quick. */
void screen_room_size(const figure_run* run, int32_t width, int32_t size[2]);
/* The empty room as the camera sees it. */
ty_result screen_render_room(figure_run* run, const int32_t size[2], screen_view* out);

/* Options for a view in water. */
ty_screen_def screen_room_def(const screen_view* view, const screen_water* water);
/* Options for a view without a medium. */
ty_screen_def screen_view_def(const screen_view* view);
/* ty_screen_apply into a new image; stats may be NULL. */
ty_result screen_apply(figure_run* run, const screen_view* view, const ty_screen_def* def, ty_image** out,
                       ty_screen_stats* stats);

/* Distances in false colours, brighter where nearer: by their logarithm, of those from the nearest to the farthest. */
ty_result screen_distance_picture(figure_run* run, const screen_view* view, plot_picture* out);

#endif
