/* Inputs of figures of screen-space scattering: an image with distances, and media. */
#ifndef TY_FIGURES_SCREEN_VIEW_H
#define TY_FIGURES_SCREEN_VIEW_H

#include "figures/figure.h"

#include <tyndall/screen.h>

/* The distance of the back wall of the room in scenes/builtin, m. */
#define SCREEN_ROOM_DEPTH 20.0

/* Replacement of the room's scattering: the optical thickness of scattering up to the back wall, and the mean cosine.
 * Absorption is that of the room. */
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
/* The size of images: from the options, or width x 2/3 width, smaller with --quick. */
void screen_room_size(const figure_run* run, int32_t width, int32_t size[2]);
/* The camera's view of the room without a medium. */
ty_result screen_render_room(figure_run* run, const int32_t size[2], screen_view* out);

/* Options for a view in water. */
ty_screen_def screen_room_def(const screen_view* view, const screen_water* water);
/* Options for a view without a medium. */
ty_screen_def screen_view_def(const screen_view* view);
/* ty_screen_apply into a new image; stats may be NULL. */
ty_result screen_apply(figure_run* run, const screen_view* view, const ty_screen_def* def, ty_image** out,
                       ty_screen_stats* stats);

/* Distances in false colors on a logarithmic scale from nearest (bright) to farthest. */
ty_result screen_distance_picture(figure_run* run, const screen_view* view, plot_picture* out);

#endif
