/* Rendering an image. */
#include "base/context.h"
#include "method/path/driver.h"

static const char* const channel_names[6] = {"R", "G", "B", "variance.R", "variance.G", "variance.B"};

static void write_pixels(const ty_path_run* run, ty_image* image) {
    for (int c = 0; c < 3; ++c) {
        float* mean = ty_image_plane(image, c);
        float* variance = ty_image_plane(image, 3 + c);
        for (int64_t i = 0; i < run->item_count; ++i) {
            mean[i] = (float)ty_path_item_mean(&run->items[i], c);
            variance[i] = (float)ty_path_item_variance(&run->items[i], c);
        }
    }
}

ty_result ty_path_render(const ty_scene* scene, const ty_path_def* def, ty_image** out, ty_path_stats* stats) {
    ty_path_run run;
    ty_result result = ty_path_prepare(scene, def, &run);
    if (result != TY_OK) return result;
    const ty_camera_def camera = ty_scene_camera(scene);
    const int32_t width = def->width > 0 ? def->width : camera.resolution[0];
    const int32_t height = def->height > 0 ? def->height : camera.resolution[1];
    run.stage = "path";
    run.request.kind = TY_PATH_PIXELS;
    run.request.camera = ty_camera_get_view(&camera, width, height);
    run.request.width = width;
    run.request.crop[2] = width;
    run.request.crop[3] = height;
    run.item_count = (int64_t)width * height;
    run.items = ty_alloc_array(run.context, (size_t)run.item_count, sizeof *run.items, true);
    if (run.items == NULL) return TY_ERROR_MEMORY;
    ty_image* image = NULL;
    result = ty_image_create(run.context, width, height, 6, channel_names, &image);
    if (result == TY_OK) {
        result = ty_path_sample(&run);
        write_pixels(&run, image);
        *out = image;
        if (stats != NULL) *stats = run.stats;
    }
    ty_free_array(run.context, run.items, (size_t)run.item_count, sizeof *run.items);
    return result;
}
