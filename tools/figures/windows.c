/* A synthetic environment. */
#include "figures/windows.h"

#include <math.h>
#include <string.h>

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

ty_result figure_create_windows(ty_context* context, ty_image** out) {
    const ty_result result = ty_image_create_rgb(context, ROOM_WIDTH, ROOM_HEIGHT, out);
    for (int32_t y = 0; y < ROOM_HEIGHT && result == TY_OK; ++y)
        for (int32_t x = 0; x < ROOM_WIDTH; ++x) {
            float color[3];
            environment_color(((x + 0.5) / ROOM_WIDTH - 0.5) * 360, (0.5 - (y + 0.5) / ROOM_HEIGHT) * 180, color);
            for (int c = 0; c < 3; ++c) ty_image_plane(*out, c)[y * ROOM_WIDTH + x] = color[c];
        }
    return result;
}

ty_result figure_add_windows(ty_scene* scene) {
    ty_image* image = NULL;
    ty_result result = figure_create_windows(ty_scene_context(scene), &image);
    if (result != TY_OK) return result;
    ty_light_def light = ty_default_light_def();
    light.kind = TY_LIGHT_ENVIRONMENT;
    light.image = image;
    result = ty_scene_add_light(scene, &light);
    ty_image_destroy(image);
    return result == TY_OK ? ty_scene_commit(scene) : result;
}
