/* tyndall screen: fog and water over an image with per-pixel distances. */
#include "cli/screen_output.h"
#include "cli/commands.h"

#include <math.h>
#include <string.h>

static ty_screen_image describe_image(const screen_input* input, const screen_output* output) {
    ty_screen_image image = ty_default_screen_image();
    image.width = input->width;
    image.height = input->height;
    image.distance = input->distance;
    /* A read-only view of an input. */
    for (int c = 0; c < 3; ++c) {
        image.color.data[c] = (float*)(uintptr_t)input->color[c];
        image.out.data[c] = output->color[c];
    }
    image.color.row = image.out.row = image.distance_row = input->width;
    return image;
}

/* The distances in use, with the substitute for unknown ones. */
static void copy_distances(const screen_input* input, const ty_screen_def* def, float* out) {
    const int64_t pixels = (int64_t)input->width * input->height;
    for (int64_t i = 0; out != NULL && i < pixels; ++i) {
        const float distance = input->distance[i];
        out[i] = distance > 0 && isfinite(distance) ? distance : def->missing_depth;
    }
}

static ty_result compute(cli_session* session, screen_report* report, const screen_output* output) {
    const ty_screen_image image = describe_image(report->input, output);
    const bool parts = output->attenuated[0] != NULL || output->scattered[0] != NULL || output->spread[0] != NULL;
    copy_distances(report->input, report->def, output->distance);
    ty_result result = TY_OK;
    if (parts)
        result = ty_screen_split(
            session->context, report->def, &image, output->attenuated[0] == NULL ? NULL : output->attenuated,
            output->scattered[0] == NULL ? NULL : output->scattered, output->spread[0] == NULL ? NULL : output->spread);
    if (result == TY_OK) result = ty_screen_apply(session->context, report->def, &image, NULL, 0, &report->stats);
    cli_progress_clear(&session->progress);
    return result;
}

/* Sets all fields of the def; the camera comes from the image. */
static int make_def(cli_session* session, const screen_options* options, const screen_input* input,
                    const ty_medium_def* medium, ty_screen_def* def) {
    *def = ty_default_screen_def();
    memcpy(def->sigma_s, medium->sigma_s, sizeof def->sigma_s);
    memcpy(def->sigma_a, medium->sigma_a, sizeof def->sigma_a);
    memcpy(def->g, medium->g, sizeof def->g);
    def->missing_depth = (float)options->sky_distance;
    def->progress = cli_progress_report;
    def->progress_user = &session->progress;
    screen_set_variant(options, def);
    const int status = screen_set_camera(options, input, def);
    return status == CLI_GO ? screen_set_environment(session, options, def) : status;
}

static int apply(cli_session* session, screen_input* input, screen_report* report) {
    screen_output output;
    int status = screen_create_output(session, report, &output);
    if (status == CLI_GO) status = screen_prepare_distances(session, report->options, input);
    if (status == CLI_GO) {
        report->load_seconds = cli_wall_seconds() - session->started;
        const ty_result result = compute(session, report, &output);
        if (result != TY_OK) status = screen_fail_running(session, report, output.channels, result);
    }
    if (status == CLI_GO) {
        screen_print_notes(session, report);
        status = screen_write_output(session, report, &output);
    }
    ty_image_destroy(output.image);
    return status;
}

static int load_and_apply(cli_session* session, const screen_options* options, const cli_arguments* given) {
    screen_input input = {0};
    ty_screen_def def;
    ty_medium_def medium = ty_default_medium_def();
    screen_report report = {.options = options, .input = &input, .def = &def, .stats = ty_default_screen_stats()};
    cli_end_on_interrupt(true);
    const ty_result result = ty_medium_parse(session->context, options->medium, &medium);
    int status = result == TY_OK ? CLI_GO : cli_fail_reading(session, result);
    if (status == CLI_GO)
        status = screen_open_input(session, options, given->positional[0],
                                   given->positional_count > 1 ? given->positional[1] : NULL, &input);
    if (status == CLI_GO) status = make_def(session, options, &input, &medium, &def);
    cli_end_on_interrupt(false);
    if (status == CLI_GO) {
        session->stats = screen_report_stats;
        session->stats_user = &report;
        status = apply(session, &input, &report);
    }
    screen_close_input(&input);
    return cli_session_close(session, status);
}

static const char* const details =
    "IMAGE: EXR or HDR, or a photograph (PNG, JPEG: decoded from sRGB). DISTANCE: of each of its pixels, an EXR in\n"
    "metres, or a PNG with --distance-scale; without one, a channel of IMAGE ('tyndall render --aov depth').\n"
    "Pixels without a distance (0, negative, not finite) count as sky, --sky metres away; for depth sensors, whose\n"
    "holes are no sky, there is --sky fill.\n\n"
    "--medium: fog:50 (visibility, metres), a measured medium and how much water it is in (wholemilk:1000), or JSON\n"
    "with the keys of a scene's medium: '{\"sigma_s\": [0.1, 0.1, 0.2], \"sigma_a\": 0.01, \"g\": 0.9}'.\n\n"
    "The camera comes from IMAGE if 'tyndall render' wrote it, else from --fov-y or --focal and --center.\n\n"
    "--aov: attenuated, scattered (what is left of the pixel's own light, and what is scattered of it), spread "
    "(pixels,\n"
    "of the scattered light), distance (metres), or all.";

int cli_screen(int count, char** arguments) {
    screen_options options = {.filter = 1, .distance_scale = 1, .sky_distance = 1e6, .level_count = -1};
    const cli_option table[] = {
        {"output", 'o', CLI_TEXT, "FILE", "the image to write: .exr (linear, with metadata) or .png", &options.output,
         0, 0, NULL},
        {"medium", 0, CLI_TEXT, "NAME|JSON", "what lies between the camera and what it sees (see above)",
         &options.medium, 0, 0, NULL},
        {"distance-channel", 0, CLI_TEXT, "NAME", "of the distances (default: depth.Z, Z, depth, ...)",
         &options.channel, 0, 0, NULL},
        {"distance-scale", 0, CLI_REAL, "METRES", "what 1 in the file of distances is (default 1)",
         &options.distance_scale, 1e-12, 1e12, &options.distance_scale_given},
        {"depth-is", 0, CLI_CHOICE, "radial|planar", "distances are along rays (default) or along the camera's axis",
         &options.depth_is, 0, 0, NULL},
        {"sky", 0, CLI_TEXT, "METRES|fill", "pixels without a distance: so far away (default 1e6), or as those around",
         &options.sky, 0, 0, NULL},
        {"fov-y", 0, CLI_REAL, "DEGREES", "full vertical angle of view", &options.fov_y, 1e-3, 179.999,
         &options.fov_y_given},
        {"focal", 0, CLI_TEXT, "FX[,FY]", "focal length, pixels", &options.focal_text, 0, 0, NULL},
        {"center", 0, CLI_TEXT, "CX,CY", "principal point, pixels from the corner (default: the center)",
         &options.center_text, 0, 0, NULL},
        {"environment", 0, CLI_TEXT, "L|R,G,B|FILE", "radiance around, W m^-2 sr^-1, or a map of it (default 0)",
         &options.environment, 0, 0, NULL},
        {"balance", 0, CLI_FLAG, NULL, "what scatters backwards comes from --environment, not from the image",
         &options.balance, 0, 0, NULL},
        {"variant", 0, CLI_CHOICE, SCREEN_KINDS, "ours (default), the paper's, and baselines", &options.kind, 0, 0,
         NULL},
        {"spread", 0, CLI_CHOICE, "small-angle|gaussian", "scatter: by phase function (default), or the paper's",
         &options.spread, 0, 0, &options.spread_given},
        {"filter", 0, CLI_CHOICE, "2|4|6", "taps along x and y between levels (default 4)", &options.filter, 0, 0,
         NULL},
        {"levels", 0, CLI_TEXT, "N|auto|all", "of the pyramid (default auto: what it takes, of Gaussians 6 at most)",
         &options.levels, 0, 0, NULL},
        {"window", 0, CLI_INT, "N", "reference: pixels that light reaches along x and y (default: all)",
         &options.window, 1, 65536, &options.window_given},
        {"mask", 0, CLI_CHOICE, "none|step|smooth",
         "gather: what keeps near pixels out of wide levels (default smooth)", &options.mask, 0, 0,
         &options.mask_given},
        {"mask-width", 0, CLI_REAL, "E", "gather: epsilon of the smooth mask (default 0.5)", &options.mask_width, 1e-6,
         1e6, &options.mask_width_given},
        {"level-scale", 0, CLI_REAL, "C", "gather: pixels of spread at level 0 (default 0.8)", &options.level_scale,
         1e-3, 1e3, &options.level_scale_given},
        {"uniform-weights", 0, CLI_FLAG, NULL, "gather: spreads are averaged without luminance",
         &options.uniform_weights, 0, 0, NULL},
        {"plain-distance", 0, CLI_FLAG, NULL, "gather: levels from distances that are not blurred",
         &options.plain_distance, 0, 0, NULL},
        {"no-normalise", 0, CLI_FLAG, NULL, "gather: masks take light away", &options.no_normalise, 0, 0, NULL},
        {"png", 0, CLI_TEXT, "FILE", "also write a PNG", &options.png, 0, 0, NULL},
        {"exposure", 0, CLI_REAL, "STOPS", "exposure of the PNG (default 0)", &options.exposure, -64, 64, NULL},
        {"curve", 0, CLI_CHOICE, "auto|none|filmic", "curve of the PNG (default: none for PNG and JPEG, else filmic)",
         &options.curve, 0, 0, NULL},
        {"aov", 0, CLI_TEXT, "NAME,...", "also write these channels to the EXR (see above)", &options.aov, 0, 0, NULL},
    };
    const cli_syntax syntax = {"screen",
                               "IMAGE [DISTANCE] -o OUT.exr|OUT.png --medium NAME|JSON [options]",
                               "Puts fog, water or any other medium over an image whose distances are known.",
                               details,
                               table,
                               sizeof table / sizeof table[0],
                               1,
                               2,
                               NULL};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO) status = screen_check_options(&options);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "screen", &given.common);
    return status == CLI_GO ? load_and_apply(&session, &options, &given) : status;
}
