/* Flux-limited diffusion, over what paths see of the surfaces through the media. */
#include "cli/methods.h"
#include "cli/surfaces.h"

static ty_fld_def make_def(cli_session* session, const ty_scene* scene, const cli_request* request) {
    static const char* const limiters[] = {"none", "sum", "max", "kershaw", "larsen", "levermore_pomraning"};
    static const char* const boundaries[] = {"marshak", "dirichlet"};
    static const char* const solvers[] = {"multigrid", "sor", "sor_float"};
    static const char* const beams[] = {"reduced", "published"};
    const ty_fld_settings settings = ty_scene_render_settings(scene).fld;
    ty_fld_def def = ty_default_fld_def();
    def.limiter = (ty_fld_limiter)cli_word_index(settings.limiter, limiters, 6);
    def.boundary = (ty_fld_boundary)cli_word_index(settings.boundary, boundaries, 2);
    def.solver = (ty_fld_solver)cli_word_index(settings.solver, solvers, 3);
    def.beam = (ty_fld_beam)cli_word_index(settings.beam, beams, 2);
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

enum { AOVS = TY_AOV_TRANSMITTANCE | TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_DEPTH | TY_AOV_SAMPLES };

const cli_method cli_method_fld = {
    .name = "fld", .summary = "flux-limited diffusion", .aovs = AOVS, .crops = false, .render = render_fld};

const cli_method cli_method_cda = {.name = "cda",
                                   .summary = "classical diffusion: fld without a limiter",
                                   .aovs = AOVS,
                                   .crops = false,
                                   .render = render_cda};
