/* Principal-ordinates propagation, over what paths see of the surfaces through the media. */
#include "cli/methods.h"
#include "cli/surfaces.h"

static ty_pop_def make_def(cli_session* session, const ty_scene* scene, const cli_request* request) {
    static const char* const modes[] = {"split", "published", "collided"};
    const ty_pop_settings settings = ty_scene_render_settings(scene).pop;
    ty_pop_def def = ty_default_pop_def();
    def.mode = (ty_pop_mode)cli_word_index(settings.mode, modes, 3);
    def.resolution = settings.resolution;
    def.merged = settings.merged;
    def.sharp = settings.sharp;
    def.direct = settings.direct;
    def.ordinates = settings.ordinates;
    def.prefilter = settings.prefilter;
    def.importance = settings.importance;
    def.surface_points = settings.surface_points;
    def.vpls = settings.vpls;
    def.shadow_texels = settings.shadow_texels;
    def.clamp = settings.clamp;
    def.iterations = settings.iterations;
    def.residuum = settings.residuum;
    def.residuum_iterations = settings.residuum_iterations;
    def.streaming = settings.streaming;
    def.tolerance = settings.tolerance;
    def.spp = settings.spp;
    def.step = settings.step;
    def.seed = request->seed;
    def.width = request->width;
    def.height = request->height;
    def.aovs = request->aovs & ~(uint32_t)TY_AOV_SAMPLES;
    def.progress = cli_progress_report;
    def.progress_user = &session->progress;
    return def;
}

static ty_result render(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
                        cli_report* report) {
    ty_image* surfaces = NULL;
    ty_pop_def def = make_def(session, scene, request);
    ty_result result = cli_trace_surfaces(session, scene, request, &surfaces, report);
    def.unscattered = surfaces;
    if (result == TY_OK) result = ty_pop_render(scene, &def, out, &report->pop);
    report->own_seconds = report->pop.seconds;
    report->path.seconds += report->own_seconds;
    ty_image_destroy(surfaces);
    return result;
}

const cli_method cli_method_pop = {.name = "pop",
                                   .summary = "principal-ordinates propagation",
                                   .aovs = TY_AOV_TRANSMITTANCE | TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_DEPTH |
                                           TY_AOV_SAMPLES,
                                   .crops = false,
                                   .render = render};
