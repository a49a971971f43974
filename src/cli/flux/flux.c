/* tyndall flux: fluxes through levels, absorbed power and radiance, by columns of a scene. */
#include "cli/flux/flux.h"

#include "cli/commands.h"
#include "cli/methods/methods.h"
#include "method/method.h"

#include <stdlib.h>
#include <string.h>

enum { SPP_MAX = 1 << 24, LIST_SIZE = 1 << 14 }; /* characters of a list of numbers */

typedef struct flux_options {
    const char *output, *levels_text, *views_text, *bands_file;
    int32_t spp, columns[2];
    double time, error;
    bool spp_given;
    int method; /* 0: path, 1: dom */
    cli_list overrides;
    double levels[TY_FLUX_LEVELS_MAX];
    ty_flux_view views[TY_FLUX_LEVELS_MAX];
    int32_t level_count, view_count;
} flux_options;

/* The next part of a list, up to a separator; NULL past the end. */
static char* next_part(char** rest, char separator) {
    char* part = *rest;
    if (part == NULL) return NULL;
    char* end = strchr(part, separator);
    *rest = end != NULL ? end + 1 : NULL;
    if (end != NULL) *end = '\0';
    return part;
}

/* Copies the text of a list, which the parsing cuts up. */
static int copy_list(const char* option, const char* list, char text[LIST_SIZE]) {
    if (strlen(list) >= LIST_SIZE)
        return cli_usage_error("flux", "%s: it is longer than %d characters", option, LIST_SIZE - 1);
    memcpy(text, list, strlen(list) + 1);
    return CLI_GO;
}

static int parse_levels(flux_options* options) {
    char text[LIST_SIZE];
    if (options->levels_text == NULL) return CLI_GO;
    const int status = copy_list("--levels", options->levels_text, text);
    if (status != CLI_GO) return status;
    char* rest = text;
    for (char* part; (part = next_part(&rest, ',')) != NULL;) {
        if (options->level_count == TY_FLUX_LEVELS_MAX)
            return cli_usage_error("flux", "--levels: there are more than %d", TY_FLUX_LEVELS_MAX);
        double* level = &options->levels[options->level_count++];
        if (!cli_parse_real(part, level)) return cli_usage_error("flux", "--levels: '%s' is not a number", part);
        if (options->level_count > 1 && !(level[0] > level[-1]))
            return cli_usage_error("flux", "--levels: %g is not above the level before it", level[0]);
    }
    return CLI_GO;
}

static int parse_views(flux_options* options) {
    char text[LIST_SIZE];
    if (options->views_text == NULL) return CLI_GO;
    const int status = copy_list("--views", options->views_text, text);
    if (status != CLI_GO) return status;
    char* rest = text;
    for (char* part; (part = next_part(&rest, ',')) != NULL;) {
        if (options->view_count == TY_FLUX_LEVELS_MAX)
            return cli_usage_error("flux", "--views: there are more than %d", TY_FLUX_LEVELS_MAX);
        ty_flux_view* view = &options->views[options->view_count++];
        char* angles = part;
        const char* zenith = next_part(&angles, ':');
        view->azimuth = 0;
        if (!cli_parse_real(zenith, &view->zenith) || (angles != NULL && !cli_parse_real(angles, &view->azimuth)))
            return cli_usage_error("flux", "--views: '%s%s%s' is not ZENITH:AZIMUTH in degrees", zenith,
                                   angles != NULL ? ":" : "", angles != NULL ? angles : "");
    }
    return CLI_GO;
}

static int check_options(flux_options* options) {
    if (options->output != NULL) {
        if (!cli_has_extension(options->output, ".json") && !cli_has_extension(options->output, ".csv"))
            return cli_usage_error("flux", "%s: the extension is not .json or .csv", options->output);
        const int status = cli_check_output("flux", options->output);
        if (status != CLI_GO) return status;
    }
    const int status = parse_levels(options);
    return status == CLI_GO ? parse_views(options) : status;
}

/* The lowest and the highest point of the scene, where no levels are given. */
static void choose_levels(const ty_scene* scene, flux_options* options) {
    const ty_scene_info info = ty_scene_get_info(scene);
    const ty_axis up = ty_scene_up_axis(scene);
    options->levels[0] = info.lower[up];
    options->levels[1] = info.upper[up];
    options->level_count = info.upper[up] > info.lower[up] ? 2 : 1;
}

/* ---- methods ---- */

static ty_result trace(cli_session* session, const ty_scene* scene, const cli_request* request, const ty_flux_def* def,
                       flux_band* band) {
    ty_path_def path;
    ty_path_stats stats = ty_default_path_stats();
    ty_result result = cli_path_def(session, scene, request, &path);
    if (result == TY_OK) result = ty_path_flux(scene, &path, def, &band->flux, &stats);
    band->spp = stats.spp;
    return result;
}

static ty_result solve_dom(cli_session* session, const ty_scene* scene, const ty_flux_def* def, flux_band* band) {
    ty_dom_def dom = ty_default_dom_def();
    ty_result result = ty_method_options(scene, "dom", &dom);
    dom.progress = cli_progress_report;
    dom.progress_user = &session->progress;
    if (result == TY_OK) result = ty_dom_flux(scene, &dom, def, &band->flux, NULL);
    return result;
}

static int run_band(cli_session* session, const char* scene_path, flux_options* options, flux_band* band,
                    flux_result* result) {
    const char* changes[2 * CLI_LIST_MAX];
    int32_t count = 0;
    ty_scene* scene = NULL;
    for (int32_t i = 0; i < options->overrides.count; ++i) changes[count++] = options->overrides.items[i];
    for (int32_t i = 0; i < band->change_count; ++i) changes[count++] = band->changes[i];
    cli_end_on_interrupt(true);
    const ty_result loaded = ty_scene_load(session->context, scene_path, changes, count, &scene);
    cli_end_on_interrupt(false);
    if (loaded != TY_OK) return cli_fail_reading(session, loaded);
    const ty_render_settings settings = ty_scene_render_settings(scene);
    const cli_request request = {.spp = options->spp_given                        ? options->spp
                                        : options->time > 0 || options->error > 0 ? SPP_MAX
                                                                                  : settings.spp,
                                 .seed = session->common.seed_given ? session->common.seed : settings.seed,
                                 .seconds = options->time,
                                 .error = options->error};
    result->seed = request.seed;
    result->z_up = ty_scene_up_axis(scene) == TY_AXIS_Z;
    if (options->level_count == 0) choose_levels(scene, options);
    ty_flux_def def = ty_default_flux_def();
    def.levels = options->levels;
    def.level_count = options->level_count;
    def.views = options->views;
    def.view_count = options->view_count;
    for (int i = 0; i < 2 && options->columns[0] > 0; ++i) def.columns[i] = options->columns[i];
    const ty_result done =
        options->method == 0 ? trace(session, scene, &request, &def, band) : solve_dom(session, scene, &def, band);
    cli_progress_clear(&session->progress);
    ty_scene_destroy(scene);
    if (done == TY_ERROR_ARGUMENT) return cli_fail(CLI_USAGE, "%s: %s", scene_path, ty_take_error(session->context));
    return done == TY_OK ? CLI_DONE : cli_fail_running(session, done);
}

static int run_bands(cli_session* session, const char* scene_path, flux_options* options, flux_bands* bands) {
    flux_result result = {.scene = scene_path, .bands = bands};
    int status = CLI_DONE;
    for (int32_t i = 0; i < bands->count && status == CLI_DONE; ++i)
        status = run_band(session, scene_path, options, &bands->bands[i], &result);
    if (status != CLI_DONE) return status;
    if (!session->common.quiet) flux_print(&result);
    if (options->output == NULL) return CLI_DONE;
    const ty_result written = flux_write(session, options->output, &result);
    if (written != TY_OK) return cli_fail_running(session, written);
    if (!session->common.quiet) printf("wrote %s\n", options->output);
    return CLI_DONE;
}

int cli_flux(int count, char** arguments) {
    flux_options options = {.output = NULL};
    const cli_option table[] = {
        {"output", 'o', CLI_TEXT, "FILE", "a file of all columns: .json or .csv (default: means on stdout alone)",
         &options.output, 0, 0, NULL},
        {"levels", 0, CLI_TEXT, "Z,...", "heights, m, ascending (default: bottom and top of the scene)",
         &options.levels_text, 0, 0, NULL},
        {"columns", 0, CLI_SIZE, "NXxNY", "columns along both horizontal axes (default 1x1)", options.columns, 0, 0,
         NULL},
        {"views", 0, CLI_TEXT, "ZENITH:AZIMUTH,...", "directions in which radiance leaves the scene, degrees",
         &options.views_text, 0, 0, NULL},
        {"bands", 0, CLI_TEXT, "FILE", "spectral bands: changes of the scene and weights (see above)",
         &options.bands_file, 0, 0, NULL},
        {"method", 'm', CLI_CHOICE, "path|dom", "how the light is found (default path)", &options.method, 0, 0, NULL},
        {"spp", 0, CLI_INT, "N", "samples of each number (default: what the scene says)", &options.spp, 1, SPP_MAX,
         &options.spp_given},
        {"time", 0, CLI_REAL, "SECONDS", "stop each band after this time; without --spp nothing else does",
         &options.time, 1e-3, 1e7, NULL},
        {"error", 0, CLI_REAL, "E", "stop at this relative error of the numbers, 0.01 for 1%", &options.error, 1e-6, 1,
         NULL},
        {"define", 'D', CLI_LIST, "KEY=VALUE", "change the scene: -D media[0].g=0.5 (again for more)",
         &options.overrides, 0, 0, NULL},
    };
    const cli_syntax syntax = {
        "flux",
        "SCENE [-o OUT.json|OUT.csv] [options]",
        "Estimates fluxes through levels, absorbed power and radiance, by columns of a scene.",
        "SCENE is a JSON file, or builtin:NAME. Fluxes are W m^-2: up, and down of diffuse and of direct light, just\n"
        "above each level. Absorbed power is that of the media of a column, W m^-2 of its area. Radiance, W m^-2 "
        "sr^-1,\n"
        "is that of light that rises through the highest level (zenith angles below 90 degrees), or sinks through the\n"
        "lowest. All have standard errors. Columns fill the cell of a periodic scene, or the box around the media.\n"
        "With --method dom there are no samples and no errors: fluxes of scenes without surfaces that repeat along "
        "both\n"
        "horizontal axes, and no radiance.\n\n"
        "FILE of --bands is an array of {\"name\": TEXT, \"weight\": W, \"set\": {\"media[0].sigma_t\": 0.3, ...}}.\n"
        "All bands have the same random numbers, so that differences between them have less noise. Their weighted sum\n"
        "comes last.",
        table,
        sizeof table / sizeof table[0],
        1,
        1,
        NULL};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO) status = check_options(&options);
    if (status != CLI_GO) return status;
    flux_bands bands = {.bands = NULL};
    status = flux_read_bands(options.bands_file, &bands);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "flux", &given.common);
    if (status == CLI_GO)
        status = cli_session_close(&session, run_bands(&session, given.positional[0], &options, &bands));
    flux_free_bands(&bands);
    return status;
}
