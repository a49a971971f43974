/* tyndall render: a scene to an image. */
#include "cli/commands.h"
#include "cli/session.h"

#include <inttypes.h>
#include <string.h>

enum { SPP_MAX = 1 << 24 };

typedef struct render_options {
    const char *output, *png, *aov, *method;
    int32_t spp, size[2];
    double time, error, exposure;
    bool spp_given, exposure_given;
    cli_list overrides;
} render_options;

/* What a run did, for --stats and the file's metadata. */
typedef struct render_report {
    char scene[17]; /* hash */
    size_t scene_bytes;
    char method[16];
    ty_path_stats path;
    uint64_t seed;
    int32_t width, height;
    double load_seconds;
    bool complete;
} render_report;

static void add_stats(json_writer* json, const void* user) {
    const render_report* report = user;
    json_text(json, "method", report->method);
    json_text(json, "scene", report->scene);
    json_integer(json, "scene_bytes", (int64_t)report->scene_bytes);
    json_integer(json, "width", report->width);
    json_integer(json, "height", report->height);
    json_unsigned(json, "seed", report->seed);
    json_bool(json, "complete", report->complete);
    json_number(json, "spp", report->path.spp);
    json_unsigned(json, "paths", report->path.paths);
    json_unsigned(json, "vertices", report->path.vertices);
    json_number(json, "error", report->path.error);
    json_text(json, "isa", report->path.isa == NULL ? "" : report->path.isa);
    json_number(json, "load_seconds", report->load_seconds);
    json_number(json, "render_seconds", report->path.seconds);
    json_number(json, "render_cpu_seconds", report->path.cpu_seconds);
}

static ty_result set_metadata(ty_image* image, const render_report* report) {
    char seed[24];
    snprintf(seed, sizeof seed, "%" PRIu64, report->seed);
    const struct {
        const char *key, *value;
    } texts[] = {
        {"tyndall.version", ty_version()},
        {"tyndall.method", report->method},
        {"tyndall.scene", report->scene},
        {"tyndall.seed", seed}, /* text: a double does not hold 64 bits */
    };
    const struct {
        const char* key;
        double value;
    } numbers[] = {
        {"tyndall.spp", report->path.spp},
        {"tyndall.seconds", report->path.seconds},
        {"tyndall.error", report->path.error},
        {"tyndall.complete", report->complete ? 1 : 0},
    };
    ty_result result = TY_OK;
    for (size_t i = 0; result == TY_OK && i < sizeof texts / sizeof texts[0]; ++i)
        result = ty_image_set_text(image, texts[i].key, texts[i].value);
    for (size_t i = 0; result == TY_OK && i < sizeof numbers / sizeof numbers[0]; ++i)
        result = ty_image_set_number(image, numbers[i].key, numbers[i].value);
    return result;
}

/* The image's R, G and B alone. */
static ty_result copy_rgb(ty_context* context, const ty_image* image, ty_image** out) {
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    const float* planes[3];
    if (!ty_image_rgb_planes(image, planes)) return TY_ERROR_INTERNAL;
    const ty_result result = ty_image_create_rgb(context, width, height, out);
    for (int32_t channel = 0; result == TY_OK && channel < 3; ++channel)
        memcpy(ty_image_plane(*out, channel), planes[channel], sizeof(float) * (size_t)width * (size_t)height);
    return result;
}

static ty_result write_images(cli_session* session, const render_options* options, const ty_image* image,
                              double exposure) {
    const char* const paths[] = {options->output, options->png};
    for (int i = 0; i < 2; ++i) {
        if (paths[i] == NULL) continue;
        const ty_result result = cli_has_extension(paths[i], ".png")
                                     ? ty_image_write_png(session->context, image, exposure, true, paths[i])
                                     : ty_image_write_exr(session->context, image, paths[i]);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

static void print_closing_lines(const render_options* options, const render_report* report) {
    printf("%s: %dx%d, %.4g spp, relative error %.3g%%, %.1f s (%.3g Mpaths/s)%s\n", report->method, report->width,
           report->height, report->path.spp, 100 * report->path.error, report->path.seconds,
           report->path.seconds > 0 ? 1e-6 * (double)report->path.paths / report->path.seconds : 0.0,
           report->complete ? "" : ", interrupted");
    printf("wrote %s\n", options->output);
    if (options->png != NULL) printf("wrote %s\n", options->png);
}

static ty_path_def make_path_def(const render_options* options, cli_session* session,
                                 const ty_render_settings* settings) {
    ty_path_def def = ty_default_path_def();
    const bool bounded_otherwise = options->time > 0 || options->error > 0;
    def.spp = options->spp_given ? options->spp : bounded_otherwise ? SPP_MAX : settings->spp;
    def.seed = session->common.seed_given ? session->common.seed : settings->seed;
    def.max_depth = settings->max_depth;
    def.seconds = options->time;
    def.error = options->error;
    def.width = options->size[0];
    def.height = options->size[1];
    def.progress = cli_progress_report;
    def.progress_user = &session->progress;
    return def;
}

/* Renders and writes the scene; the exit status. */
static int render_scene(cli_session* session, const ty_scene* scene, const render_options* options,
                        render_report* report) {
    const ty_render_settings settings = ty_scene_render_settings(scene);
    const char* method = options->method != NULL ? options->method : settings.method;
    if (strcmp(method, "path") != 0) return cli_usage_error("render", "unknown method '%s'; known: path", method);
    snprintf(report->method, sizeof report->method, "%s", method);
    snprintf(report->scene, sizeof report->scene, "%016" PRIx64, ty_scene_hash(scene));
    report->scene_bytes = ty_scene_get_info(scene).bytes;
    const ty_path_def def = make_path_def(options, session, &settings);
    report->seed = def.seed;
    ty_image* image = NULL;
    ty_result result = ty_path_render(scene, &def, &image, &report->path);
    cli_progress_clear(&session->progress);
    if (result != TY_OK && result != TY_CANCELLED) return cli_fail_running(session, result);
    report->complete = result == TY_OK;
    report->width = ty_image_width(image);
    report->height = ty_image_height(image);
    if (options->aov == NULL) {
        ty_image* rgb = NULL;
        result = copy_rgb(session->context, image, &rgb);
        ty_image_destroy(image);
        image = rgb;
        if (result != TY_OK) return cli_fail_running(session, result);
    }
    const double exposure = options->exposure_given ? options->exposure : ty_scene_camera(scene).exposure;
    result = set_metadata(image, report);
    if (result == TY_OK) result = write_images(session, options, image, exposure);
    ty_image_destroy(image);
    if (result != TY_OK) return cli_fail_running(session, result);
    if (!session->common.quiet) print_closing_lines(options, report);
    return report->complete ? CLI_DONE : CLI_INTERRUPTED;
}

/* What can be known to be wrong before any work. */
static int check_options(const render_options* options) {
    if (options->output == NULL) return cli_usage_error("render", "where to? Give -o OUT.exr or -o OUT.png");
    if (!cli_has_extension(options->output, ".exr") && !cli_has_extension(options->output, ".png"))
        return cli_usage_error("render", "%s: the extension is not .exr or .png", options->output);
    if (options->png != NULL && !cli_has_extension(options->png, ".png"))
        return cli_usage_error("render", "%s: the extension is not .png", options->png);
    if (options->aov != NULL && strcmp(options->aov, "variance") != 0)
        return cli_usage_error("render", "unknown --aov '%s'; known: variance", options->aov);
    const int status = cli_check_output("render", options->output);
    return status != CLI_GO || options->png == NULL ? status : cli_check_output("render", options->png);
}

int cli_render(int count, char** arguments) {
    render_options options = {0};
    const cli_option table[] = {
        {"output", 'o', CLI_TEXT, "FILE", "the image to write: .exr (linear, with metadata) or .png", &options.output,
         0, 0, NULL},
        {"method", 0, CLI_TEXT, "NAME", "path (default: what the scene says)", &options.method, 0, 0, NULL},
        {"spp", 0, CLI_INT, "N", "samples per pixel (default: what the scene says)", &options.spp, 1, SPP_MAX,
         &options.spp_given},
        {"time", 0, CLI_REAL, "SECONDS", "stop after this time; without --spp nothing else does", &options.time, 1e-3,
         1e7, NULL},
        {"error", 0, CLI_REAL, "E", "stop at this relative error of the pixels, 0.01 for 1%", &options.error, 1e-6, 1,
         NULL},
        {"size", 0, CLI_SIZE, "WxH", "pixels (default: what the scene says)", options.size, 0, 0, NULL},
        {"define", 'D', CLI_LIST, "KEY=VALUE", "change the scene: -D media[0].g=0.5 (again for more)",
         &options.overrides, 0, 0, NULL},
        {"png", 0, CLI_TEXT, "FILE", "also write a PNG", &options.png, 0, 0, NULL},
        {"exposure", 0, CLI_REAL, "STOPS", "of the PNG (default: the camera's)", &options.exposure, -64, 64,
         &options.exposure_given},
        {"aov", 0, CLI_TEXT, "NAME", "also write these channels to the EXR: variance", &options.aov, 0, 0, NULL},
    };
    const cli_syntax syntax = {
        "render",
        "SCENE -o OUT.exr|OUT.png [options]",
        "Renders a scene to an image.",
        "SCENE is a JSON file, or builtin:NAME. Interrupting (Ctrl-C) writes what there is and exits with 130.",
        table,
        sizeof table / sizeof table[0],
        1,
        1};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO) status = check_options(&options);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "render", &given.common);
    if (status != CLI_GO) return status;

    ty_scene* scene = NULL;
    const ty_result result =
        ty_scene_load(session.context, given.positional[0], options.overrides.items, options.overrides.count, &scene);
    if (result != TY_OK) return cli_session_close(&session, cli_fail_reading(&session, result));
    render_report report = {.load_seconds = cli_wall_seconds() - session.started};
    session.stats = add_stats;
    session.stats_user = &report;
    status = render_scene(&session, scene, &options, &report);
    ty_scene_destroy(scene);
    return cli_session_close(&session, status);
}
