/* Flux-limited diffusion, over what paths see of the surfaces through the media. */
#include "cli/methods.h"
#include "cli/surfaces.h"
#include "image/march.h"

static ty_fld_def make_def(cli_session* session, const ty_scene* scene, const cli_request* request) {
    const ty_fld_settings settings = ty_scene_render_settings(scene).fld;
    ty_fld_def def = ty_fld_def_of(&settings);
    CLI_TAKE_REQUEST(def, session, request);
    return def;
}

static ty_result render_limited(cli_session* session, const ty_scene* scene, const cli_request* request, bool limited,
                                ty_image** out, cli_report* report) {
    ty_image* surfaces = NULL;
    ty_fld_def def = make_def(session, scene, request);
    if (!limited) def.limiter = TY_FLD_LIMITER_NONE;
    ty_result result = cli_trace_surfaces(session, scene, request, &surfaces, report);
    def.unscattered = surfaces;
    if (result == TY_OK) result = ty_fld_render(scene, &def, out, &report->fld);
    report->own_seconds = report->fld.seconds;
    report->path.seconds += report->own_seconds;
    ty_image_destroy(surfaces);
    return result;
}

static ty_result render_fld(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
                            cli_report* report) {
    return render_limited(session, scene, request, true, out, report);
}

static ty_result render_cda(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
                            cli_report* report) {
    return render_limited(session, scene, request, false, out, report);
}

const cli_method cli_method_fld = {.name = "fld",
                                   .summary = "flux-limited diffusion",
                                   .aovs = TY_MARCH_AOVS | TY_AOV_SAMPLES,
                                   .crops = false,
                                   .render = render_fld};

const cli_method cli_method_cda = {.name = "cda",
                                   .summary = "classical diffusion: fld without a limiter",
                                   .aovs = TY_MARCH_AOVS | TY_AOV_SAMPLES,
                                   .crops = false,
                                   .render = render_cda};
