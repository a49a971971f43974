/* Renders a scene to an EXR image: 01_render [SCENE [OUT.exr]]. */
#include <tyndall/tyndall.h>

#include <stdio.h>

static ty_result render(ty_context* context, const char* scene_path, const char* image_path) {
    ty_scene* scene = NULL;
    ty_result result = ty_scene_load(context, scene_path, NULL, 0, &scene);
    if (result != TY_OK) return result;

    ty_path_def def = ty_default_path_def();
    def.spp = 4;
    def.width = 64;
    def.height = 48;
    ty_image* image = NULL;
    ty_path_stats stats = ty_default_path_stats();
    result = ty_path_render(scene, &def, &image, &stats);
    if (result == TY_OK) {
        printf("%g samples per pixel in %.2f s, relative error %.2g\n", stats.spp, stats.seconds, stats.error);
        result = ty_image_write_exr(context, image, image_path);
    }
    ty_image_destroy(image);
    ty_scene_destroy(scene);
    return result;
}

int main(int count, char** arguments) {
    const char* scene_path = count > 1 ? arguments[1] : "builtin:cube_g0";
    const char* image_path = count > 2 ? arguments[2] : "01_render.exr";

    const ty_context_def def = ty_default_context_def();
    ty_context* context = NULL;
    if (ty_context_create(&def, &context) != TY_OK) return 1;
    const ty_result result = render(context, scene_path, image_path);
    if (result != TY_OK) fprintf(stderr, "%s: %s\n", ty_result_name(result), ty_take_error(context));
    ty_context_destroy(context);
    return result == TY_OK ? 0 : 1;
}
