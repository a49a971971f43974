/* Flux-limited diffusion, over what paths see of the surfaces through the media. */
#include "cli/methods.h"

#include <string.h>

/* A word's place in a list; the schema lets no other through. */
static int32_t index_of(const char* word, const char* const* words, int32_t count) {
    for (int32_t i = 0; i < count; ++i)
        if (strcmp(word, words[i]) == 0) return i;
    return 0;
}

static ty_fld_def make_def(cli_session* session, const ty_scene* scene, const cli_request* request) {
    static const char* const limiters[] = {"none", "sum", "max", "kershaw", "larsen", "levermore_pomraning"};
    static const char* const boundaries[] = {"marshak", "dirichlet"};
    static const char* const solvers[] = {"multigrid", "sor", "sor_float"};
    static const char* const beams[] = {"reduced", "published"};
    const ty_fld_settings settings = ty_scene_render_settings(scene).fld;
    ty_fld_def def = ty_default_fld_def();
    def.limiter = (ty_fld_limiter)index_of(settings.limiter, limiters, 6);
    def.boundary = (ty_fld_boundary)index_of(settings.boundary, boundaries, 2);
    def.solver = (ty_fld_solver)index_of(settings.solver, solvers, 3);
    def.beam = (ty_fld_beam)index_of(settings.beam, beams, 2);
    def.larsen_power = settings.larsen_power;
    def.streaming = settings.streaming;
    def.relaxation = settings.relaxation;
    def.tolerance = settings.tolerance;
    def.sigma_eps = settings.sigma_eps;
    def.ratio = settings.ratio;
    def.step = settings.step;
    def.resolution = settings.resolution;
    def.iterations = settings.iterations;
    def.environment_beams = settings.environment_beams;
    def.surface_points = settings.surface_points;
    def.spp = settings.spp;
    def.seed = request->seed;
    def.width = request->width;
    def.height = request->height;
    def.aovs = request->aovs & ~(uint32_t)TY_AOV_SAMPLES;
    def.progress = cli_progress_report;
    def.progress_user = &session->progress;
    return def;
}

/* What surfaces send through the media, where there are any. */
static ty_result trace_surfaces(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
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

static ty_result render_limited(cli_session* session, const ty_scene* scene, const cli_request* request, bool limited,
                                ty_image** out, cli_report* report) {
    ty_image* surfaces = NULL;
    ty_fld_def def = make_def(session, scene, request);
    if (!limited) def.limiter = TY_FLD_LIMITER_NONE;
    ty_result result = trace_surfaces(session, scene, request, &surfaces, report);
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

enum { AOVS = TY_AOV_TRANSMITTANCE | TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_DEPTH | TY_AOV_SAMPLES };

const cli_method cli_method_fld = {
    .name = "fld", .summary = "flux-limited diffusion", .aovs = AOVS, .crops = false, .render = render_fld};

const cli_method cli_method_cda = {.name = "cda",
                                   .summary = "classical diffusion: fld without a limiter",
                                   .aovs = AOVS,
                                   .crops = false,
                                   .render = render_cda};
