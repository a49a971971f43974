/* Surfaces by path tracing, for methods that compute light in media alone, with media inside dielectrics, whose light
 * is solved before. */
#include "method/method.h"

ty_result ty_trace_surfaces(const ty_scene* scene, const ty_render_request* request, const ty_enclosed_field* fields,
                            ty_image** out, ty_method_run* run) {
    const ty_scene_info info = ty_scene_get_info(scene);
    if (info.shapes == 0 && info.meshes == 0) return TY_OK;
    ty_path_def def;
    ty_result result = ty_request_path_def(scene, request, &def);
    if (result != TY_OK) return result;
    def.aovs = 0;
    def.state = NULL;
    def.partial = NULL;
    def.resume = NULL;
    def.resume_size = 0;
    def.unscattered = true;
    def.enclosed = fields;
    run->path = ty_default_path_stats();
    result = ty_path_render(scene, &def, out, &run->path);
    if (result != TY_CANCELLED) return result;
    ty_image_destroy(*out);
    *out = NULL;
    return result;
}
