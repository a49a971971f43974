/* Light propagation volumes with scattering, which see surfaces themselves. */
#include "cli/methods.h"
#include "image/march.h"

static ty_result render(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
                        cli_report* report) {
    const ty_lpv_settings settings = ty_scene_render_settings(scene).lpv;
    ty_lpv_def def = ty_lpv_def_of(&settings);
    CLI_TAKE_REQUEST(def, session, request);
    const ty_result result = ty_lpv_render(scene, &def, out, &report->lpv);
    report->own_seconds = report->path.seconds = report->lpv.seconds;
    return result;
}

const cli_method cli_method_lpv = {.name = "lpv",
                                   .summary = "light propagation volumes with scattering",
                                   .aovs = TY_MARCH_AOVS | TY_AOV_NORMAL | TY_AOV_SAMPLES,
                                   .crops = false,
                                   .check = ty_lpv_check_scene,
                                   .render = render};
