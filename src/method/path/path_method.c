/* Path tracing as a method, and as the source of surface images for other methods. */
#include "image/aovs.h"
#include "method/method.h"
#include "method/path/driver.h"
#include "method/path/enclosed_light.h"

#include <string.h>

ty_result ty_request_path_def(const ty_scene* scene, const ty_render_request* request, ty_path_def* def) {
    *def = ty_default_path_def();
    def->spp = request->spp;
    def->seed = request->seed;
    def->seconds = request->seconds;
    def->error = request->error;
    def->width = request->width;
    def->height = request->height;
    def->aovs = request->aovs;
    memcpy(def->crop, request->crop, sizeof def->crop);
    def->progress = request->progress;
    def->progress_user = request->progress_user;
    def->state = request->state;
    def->state_change = request->state_change;
    def->state_user = request->state_user;
    if (request->state != NULL) def->state_seconds = request->state_seconds;
    def->resume = request->resume;
    def->resume_size = request->resume_size;
    def->partial = request->partial;
    def->partial_user = request->partial_user;
    return ty_method_options(scene, "path", def);
}

ty_result ty_solve_enclosed(const ty_scene* scene, const ty_render_request* request, const ty_enclosed_def* def,
                            ty_enclosed** out, ty_enclosed_stats* stats) {
    ty_path_def path;
    ty_enclosed_def reporting = *def;
    *out = NULL;
    const ty_result result = ty_request_path_def(scene, request, &path);
    if (result != TY_OK) return result;
    reporting.progress = request->progress;
    reporting.progress_user = request->progress_user;
    return ty_path_solve_enclosed(scene, &path, &reporting, out, stats);
}

static ty_result render(const ty_scene* scene, const ty_render_request* request, ty_image** out, ty_method_run* run) {
    ty_path_def def;
    ty_result result = ty_request_path_def(scene, request, &def);
    run->path = ty_default_path_stats();
    if (result == TY_OK) result = ty_path_render(scene, &def, out, &run->path);
    run->own_seconds = run->path.seconds;
    return result;
}

const ty_method ty_method_path = {.name = "path",
                                  .summary = "unbiased path tracing",
                                  .options = &ty_path_options,
                                  .aovs = TY_AOV_ALL | TY_AOV_HALF,
                                  .crops = true,
                                  .render = render};
