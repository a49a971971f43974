/* Shared by tests of src/method/pop: defs without the method's own defaults, environments made on the spot. */
#ifndef TY_TESTS_POP_MAKER_H
#define TY_TESTS_POP_MAKER_H

#include "direct_maker.h"

static inline ty_pop_def pop_def(int32_t ordinates) {
    return (ty_pop_def){.resolution = 20,
                        .fine_lights = true,
                        .ordinates = ordinates,
                        .prefilter = 1,
                        .importance = true,
                        .surface_points = 16,
                        .vpls = 64,
                        .shadow_texels = 128,
                        .vpl_min_distance = 0.05};
}

/* A cube of fog of edge 2 m about the origin. */
static inline ty_scene* pop_fog(ty_context* context, float sigma_s, float sigma_a) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(context);
    const ty_medium_def medium = box_medium(lower, upper, sigma_s, sigma_a);
    check_result(context, ty_scene_add_medium(scene, &medium));
    return scene;
}

/* pixels: width x height x 3; NULL: a constant of 1, 2, 3. */
static inline void pop_add_environment(ty_scene* scene, int32_t width, int32_t height, const float* pixels,
                                       double rotation) {
    ty_context* context = ty_scene_context(scene);
    ty_light_def def = ty_default_light_def();
    ty_image* image = NULL;
    def.kind = TY_LIGHT_ENVIRONMENT;
    def.rotation = rotation;
    set3f(def.color, 1, 2, 3);
    if (pixels != NULL) {
        check_result(context, ty_image_create_rgb(context, width, height, &image));
        for (int c = 0; c < 3; ++c)
            for (int32_t i = 0; i < width * height; ++i) ty_image_plane(image, c)[i] = pixels[3 * i + c];
        def.image = image;
    }
    check_result(context, ty_scene_add_light(scene, &def));
    ty_image_destroy(image);
}

#endif
