/* Rendering of an image. */
#include "base/context.h"
#include "image/options.h"
#include "method/path/aov.h"
#include "method/path/state.h"

#include <stdio.h>

/* Pixel rectangle to render: the whole frame unless the def crops. */
static ty_result choose_crop(ty_path_run* run) {
    const int32_t* crop = run->def->crop;
    int32_t* out = run->request.crop;
    const int32_t width = run->request.width, height = run->height;
    if (crop[0] == 0 && crop[1] == 0 && crop[2] == 0 && crop[3] == 0) {
        out[2] = width;
        out[3] = height;
        return TY_OK;
    }
    if (crop[0] < 0 || crop[1] < 0 || crop[2] < 1 || crop[3] < 1 || crop[0] > width - crop[2] ||
        crop[1] > height - crop[3])
        return ty_fail(run->context, TY_ERROR_ARGUMENT, "path.crop: %d x %d pixels at (%d, %d) are not within %d x %d",
                       crop[2], crop[3], crop[0], crop[1], width, height);
    for (int i = 0; i < 4; ++i) out[i] = crop[i];
    return TY_OK;
}

/* Sets the frame, the crop and the camera. */
static ty_result prepare_pixels(const ty_scene* scene, ty_path_run* run) {
    const ty_path_def* def = run->def;
    const ty_camera_def camera = ty_scene_camera(scene);
    run->stage = "path";
    run->scene_hash = ty_scene_hash(scene);
    run->request.kind = TY_PATH_PIXELS;
    run->request.first_hit = ty_aovs_need_first_hit(def->aovs);
    int32_t size[2];
    ty_image_resolution(scene, def->width, def->height, size);
    run->request.width = size[0];
    run->height = size[1];
    run->request.camera = ty_camera_get_view(&camera, run->request.width, run->height);
    const ty_result result = choose_crop(run);
    run->item_count = (int64_t)run->request.crop[2] * run->request.crop[3];
    return result;
}

/* Reports early if items, image and state together exceed the memory limit. */
static ty_result check_memory(const ty_path_run* run) {
    const double item =
        (double)(sizeof *run->items + (ty_aovs_need_classes(run->def->aovs) ? sizeof *run->aov_sums : 0) +
                 ((run->def->aovs & TY_AOV_HALF) != 0 ? sizeof *run->halves : 0));
    const double pixel = item * (run->def->state != NULL ? 2 : 1) + (double)ty_aovs_pixel_size(run->def->aovs);
    char what[64];
    snprintf(what, sizeof what, "path: %d x %d pixels", run->request.crop[2], run->request.crop[3]);
    return ty_check_memory(run->context, pixel * (double)run->item_count, what);
}

static ty_result render_pixels(ty_path_run* run, ty_image** out) {
    ty_image* image = NULL;
    ty_result result = run->def->resume != NULL ? ty_path_state_resume(run) : TY_OK;
    if (result == TY_OK) result = ty_path_image_create(run, &image);
    run->image = image;
    if (result == TY_OK) result = ty_path_sample(run);
    if (result != TY_OK && result != TY_CANCELLED) {
        ty_image_destroy(image);
        return result;
    }
    ty_path_image_fill(run, image);
    *out = image;
    return result;
}

ty_result ty_path_begin_pixels(const ty_scene* scene, const ty_path_def* def, ty_path_run* run) {
    ty_result result = ty_path_prepare(scene, def, run);
    if (result == TY_OK) result = prepare_pixels(scene, run);
    if (result == TY_OK) result = check_memory(run);
    return result == TY_OK ? ty_path_run_begin(run, scene, ty_aovs_need_classes(def->aovs)) : result;
}

ty_result ty_path_render(const ty_scene* scene, const ty_path_def* def, ty_image** out, ty_path_stats* stats) {
    ty_path_run run;
    ty_path_stats own;
    ty_result result = ty_take_stats(ty_scene_context(scene), stats, "ty_default_path_stats", &own, sizeof own);
    if (result == TY_OK) result = ty_path_begin_pixels(scene, def, &run);
    if (result != TY_OK) return result;
    result = render_pixels(&run, out);
    if (result == TY_OK || result == TY_CANCELLED) ty_give_stats(&run.stats, sizeof run.stats, stats);
    ty_path_run_end(&run);
    return result;
}
