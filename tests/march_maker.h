/* Shared by tests of the marcher: scenes seen along an axis, uniform fields, pixels. */
#ifndef TY_TESTS_MARCH_MAKER_H
#define TY_TESTS_MARCH_MAKER_H

#include "direct_maker.h"
#include "image/march/march.h"

/* A camera so far away, and so narrow, that its rays are all but parallel to -z; the pixel in the middle looks along
 * the axis. */
static inline void march_look(ty_scene* scene, double x, double y, double z, double tx, double ty, double tz) {
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, x, y, z);
    set3(camera.target, tx, ty, tz);
    camera.fov_y = 1e-3;
    check_result(ty_scene_context(scene), ty_scene_set_camera(scene, &camera));
}

static inline ty_march_def march_def(int32_t width, int32_t height) {
    ty_march_def def = ty_default_march_def();
    def.width = width;
    def.height = height;
    return def;
}

static inline ty_image* march_image(const ty_scene* scene, const ty_march_def* def, ty_march_stats* stats) {
    ty_image* image = NULL;
    check_result(ty_scene_context(scene), ty_march(scene, def, &image, stats));
    return image;
}

static inline double march_value(const ty_image* image, const char* channel, int32_t pixel) {
    const int32_t plane = ty_image_find_channel(image, channel);
    assert_true(plane >= 0);
    return (double)ty_image_plane_const(image, plane)[pixel];
}

/* R of an image of one pixel, and what else there is of it. */
static inline double march_once(const ty_scene* scene, const ty_march_def* def, const char* channel) {
    ty_image* image = march_image(scene, def, NULL);
    const double value = march_value(image, channel, 0);
    ty_image_destroy(image);
    return value;
}

/* Smooth lumps between 0 and 2 in 16^3 voxels, empty at the faces. */
static inline ty_grid* lumpy_grid(ty_context* context) {
    enum { LUMPY_SIDE = 16 };
    static float values[LUMPY_SIDE * LUMPY_SIDE * LUMPY_SIDE];
    for (int i = 0; i < LUMPY_SIDE * LUMPY_SIDE * LUMPY_SIDE; ++i) {
        const double x = i % LUMPY_SIDE, y = i / LUMPY_SIDE % LUMPY_SIDE, z = i / LUMPY_SIDE / LUMPY_SIDE;
        const double square = pow(x - 7.5, 2) + pow(y - 7.5, 2) + pow(z - 7.5, 2);
        values[i] = (float)fmax(0, (1 + sin(x) * sin(1.3 * y + 1) * cos(0.9 * z)) * (1 - square / 49));
    }
    ty_grid_def def = ty_default_grid_def();
    ty_grid* grid = NULL;
    def.size[0] = def.size[1] = def.size[2] = LUMPY_SIDE;
    def.values = values;
    check_result(context, ty_grid_create(context, &def, &grid));
    return grid;
}

/* A field of one cell, alike in all channels. */
typedef struct even_field {
    float values[TY_FIELD_TERMS];
    ty_source_field field;
} even_field;

static inline void even_begin(even_field* even, const double lower[3], const double upper[3], float value) {
    *even = (even_field){.values = {value}};
    even->field.term_count = 1;
    for (int a = 0; a < 3; ++a) {
        even->field.box.lower[a] = lower[a];
        even->field.box.upper[a] = upper[a];
        even->field.box.size[a] = 1;
    }
    for (int c = 0; c < 3; ++c)
        for (int t = 0; t < TY_FIELD_TERMS; ++t) even->field.terms[c][t] = &even->values[t];
}

#endif
