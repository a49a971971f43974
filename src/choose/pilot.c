/* A pilot of path tracing: all light, and the light of surfaces that no medium scatters. */
#include "choose/pilot.h"

#include "base/context.h"
#include "method/method.h"

enum { PIXELS = 768, SAMPLES = 4 };

/* Radiance of some channels, summed over the image. */
static double sum_rgb(const ty_image* image, const char* const names[3]) {
    const size_t pixels = (size_t)ty_image_width(image) * (size_t)ty_image_height(image);
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
        const float* plane = ty_image_plane_const(image, ty_image_find_channel(image, names[c]));
        for (size_t i = 0; i < pixels; ++i) sum += (double)plane[i];
    }
    return sum;
}

static double sum_image(const ty_image* image) {
    return sum_rgb(image, (const char* const[3]){"R", "G", "B"});
}

/* About PIXELS pixels of the camera's aspect ratio. */
static void find_size(const ty_scene* scene, int32_t* width, int32_t* height) {
    const ty_camera_def camera = ty_scene_camera(scene);
    const double aspect = (double)camera.resolution[0] / camera.resolution[1];
    *width = (int32_t)fmin(fmax(rint(sqrt(PIXELS * aspect)), 1), PIXELS);
    *height = (int32_t)fmax(rint((double)PIXELS / *width), 1);
}

static double vertices_of(const ty_path_stats* stats) {
    return stats->paths > 0 ? (double)stats->vertices / (double)stats->paths : 0;
}

ty_result ty_pilot_trace(const ty_scene* scene, ty_scene_features* out) {
    const ty_scene_info info = ty_scene_get_info(scene);
    const bool surfaces = info.shapes > 0 || info.meshes > 0;
    ty_render_request request = {.spp = SAMPLES, .aovs = TY_AOV_MULTIPLE};
    ty_path_stats stats = ty_default_path_stats();
    ty_image *all = NULL, *unscattered = NULL;
    ty_path_def def;
    find_size(scene, &request.width, &request.height);
    ty_result result = ty_request_path_def(scene, &request, &def);
    def.guide = TY_PATH_GUIDE_NONE;
    if (result == TY_OK) result = ty_path_render(scene, &def, &all, &stats);
    const double sum = result == TY_OK ? sum_image(all) : 0;
    if (sum > 0) {
        out->noise = stats.error * sqrt(stats.spp);
        out->vertices = vertices_of(&stats);
        out->multiple = sum_rgb(all, (const char* const[3]){"multiple.R", "multiple.G", "multiple.B"}) / sum;
    }
    def.aovs = 0;
    def.unscattered = true;
    if (sum > 0 && surfaces) {
        result = ty_path_render(scene, &def, &unscattered, &stats);
        if (result == TY_OK) {
            out->unscattered = sum_image(unscattered) / sum;
            out->surface_noise = stats.error * sqrt(stats.spp) * out->unscattered;
            out->surface_vertices = vertices_of(&stats);
        }
    }
    ty_image_destroy(all);
    ty_image_destroy(unscattered);
    return result;
}
