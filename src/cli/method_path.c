/* Path tracing, as a method of its own and for those that start from its images. */
#include "cli/methods.h"

#include <string.h>

ty_path_def cli_path_def(cli_session* session, const ty_scene* scene, const cli_request* request) {
    ty_path_def def = ty_default_path_def();
    def.spp = request->spp;
    def.seed = request->seed;
    def.max_depth = ty_scene_render_settings(scene).path.max_depth;
    def.seconds = request->seconds;
    def.error = request->error;
    def.width = request->width;
    def.height = request->height;
    def.aovs = request->aovs;
    memcpy(def.crop, request->crop, sizeof def.crop);
    def.progress = cli_progress_report;
    def.progress_user = &session->progress;
    if (request->checkpoint != NULL) {
        def.state = cli_checkpoint_write;
        def.state_user = request->checkpoint;
        def.state_seconds = request->checkpoint_seconds;
        def.resume = request->checkpoint->bytes;
        def.resume_size = request->checkpoint->size;
    }
    return def;
}

static ty_result render(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
                        cli_report* report) {
    const ty_path_def def = cli_path_def(session, scene, request);
    const ty_result result = ty_path_render(scene, &def, out, &report->path);
    report->own_seconds = report->path.seconds;
    return result;
}

const cli_method cli_method_path = {
    .name = "path", .summary = "unbiased path tracing", .aovs = TY_AOV_ALL, .crops = true, .render = render};
