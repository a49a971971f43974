/* Discrete ordinates with a first-collision source, over what paths see of the surfaces through the media. */
#include "cli/methods.h"
#include "cli/surfaces.h"
#include "image/march.h"

static ty_dom_def make_def(cli_session* session, const ty_scene* scene, const cli_request* request) {
    const ty_dom_settings settings = ty_scene_render_settings(scene).dom;
    ty_dom_def def = ty_dom_def_of(&settings);
    CLI_TAKE_REQUEST(def, session, request);
    return def;
}

static ty_result render(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
                        cli_report* report) {
    ty_image* surfaces = NULL;
    ty_dom_def def = make_def(session, scene, request);
    ty_result result = cli_trace_surfaces(session, scene, request, &surfaces, report);
    def.unscattered = surfaces;
    if (result == TY_OK) result = ty_dom_render(scene, &def, out, &report->dom);
    report->own_seconds = report->dom.seconds;
    report->path.seconds += report->own_seconds;
    ty_image_destroy(surfaces);
    return result;
}

const cli_method cli_method_dom = {.name = "dom",
                                   .summary = "discrete ordinates with a first-collision source",
                                   .aovs = TY_MARCH_AOVS | TY_AOV_SAMPLES,
                                   .crops = false,
                                   .render = render};
