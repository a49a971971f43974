/* Surfaces by path tracing, for methods that know media alone. */
#include "cli/surfaces.h"

ty_result cli_trace_surfaces(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
                             cli_report* report) {
    const ty_scene_info info = ty_scene_get_info(scene);
    if (info.shapes == 0 && info.meshes == 0) return TY_OK;
    ty_path_def def = cli_path_def(session, scene, request);
    def.unscattered = true;
    def.aovs = 0;
    def.state = NULL;
    def.resume = NULL;
    def.resume_size = 0;
    const ty_result result = ty_path_render(scene, &def, out, &report->path);
    if (result != TY_CANCELLED) return result;
    ty_image_destroy(*out);
    *out = NULL;
    return result;
}
