/* Light propagation volumes with scattering, which see surfaces themselves. */
#include "cli/methods.h"
#include "method/lpv/job.h"

static const char* const parts_words[] = {"all", "shadow_map", "plain", "plain_march", "single", "both"};
static const uint32_t parts[] = {TY_LPV_ALL,    0,
                                 TY_LPV_PLAIN,  TY_LPV_PLAIN | TY_LPV_MARCH,
                                 TY_LPV_SINGLE, TY_LPV_PLAIN | TY_LPV_MARCH | TY_LPV_SINGLE};
enum { PARTS = sizeof parts / sizeof parts[0] };

ty_lpv_def cli_lpv_def(const ty_lpv_settings* settings) {
    static const char* const modes[] = {"links", "published"};
    static const char* const places[] = {"scene", "camera"};
    ty_lpv_def def = ty_default_lpv_def();
    def.mode = (ty_lpv_mode)cli_word_index(settings->mode, modes, 2);
    def.parts = parts[cli_word_index(settings->parts, parts_words, PARTS)];
    def.place = (ty_lpv_place)cli_word_index(settings->place, places, 2);
    def.resolution = settings->resolution;
    def.extent = settings->extent;
    def.cascades = settings->cascades;
    def.bands = settings->bands;
    def.window = settings->window;
    def.iterations = settings->iterations;
    def.tolerance = settings->tolerance;
    def.map_side = settings->map_side;
    def.samples = settings->samples;
    def.block_side = settings->block_side;
    def.shadow_side = settings->shadow_side;
    def.shadow_rays = settings->shadow_rays;
    def.half = settings->half;
    def.step = settings->step;
    def.spp = settings->spp;
    return def;
}

static ty_result render(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
                        cli_report* report) {
    const ty_lpv_settings settings = ty_scene_render_settings(scene).lpv;
    ty_lpv_def def = cli_lpv_def(&settings);
    def.seed = request->seed;
    def.width = request->width;
    def.height = request->height;
    def.aovs = request->aovs & ~(uint32_t)TY_AOV_SAMPLES;
    def.progress = cli_progress_report;
    def.progress_user = &session->progress;
    const ty_result result = ty_lpv_render(scene, &def, out, &report->lpv);
    report->own_seconds = report->path.seconds = report->lpv.seconds;
    return result;
}

/* Lights of other kinds are refused before any work. */
static ty_result check(const ty_scene* scene) {
    const ty_lpv_def def = ty_default_lpv_def();
    return ty_lpv_check_lights(scene, &def);
}

const cli_method cli_method_lpv = {.name = "lpv",
                                   .summary = "light propagation volumes with scattering",
                                   .aovs = TY_AOV_TRANSMITTANCE | TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_DEPTH |
                                           TY_AOV_NORMAL | TY_AOV_SAMPLES,
                                   .crops = false,
                                   .check = check,
                                   .render = render};
