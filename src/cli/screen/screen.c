/* tyndall screen: fog and water over an image with per-pixel distances. */
#include "cli/screen/screen_output.h"
#include "cli/commands.h"

#include <math.h>
#include <string.h>

/* The distances in use, with the substitute for unknown ones. */
static void copy_distances(const screen_input* input, const ty_screen_def* def, float* out) {
    const int64_t pixels = (int64_t)input->width * input->height;
    for (int64_t i = 0; out != NULL && i < pixels; ++i) {
        const float distance = input->distance[i];
        out[i] = distance > 0 && isfinite(distance) ? distance : def->missing_depth;
    }
}

static ty_result compute(cli_session* session, screen_report* report, const screen_output* output) {
    const ty_screen_image image = screen_describe_image(report->input, output->color);
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
    float around[3];
    screen_report report = {.options = options, .input = &input, .def = &def, .stats = ty_default_screen_stats()};
    cli_end_on_interrupt(true);
    ty_result result = ty_medium_parse(session->context, options->medium, &medium);
    if (result == TY_OK) result = ty_medium_mean_cosine(session->context, &medium, medium.g);
    int status = result == TY_OK ? CLI_GO : cli_fail_reading(session, result);
    if (status == CLI_GO)
        status = screen_open_input(session, options, given->positional[0],
                                   given->positional_count > 1 ? given->positional[1] : NULL, &input);
    if (status == CLI_GO) status = screen_read_environment(session, options, around);
    if (status == CLI_GO) status = screen_make_def(options, &input, &medium, around, &def);
    cli_end_on_interrupt(false);
    def.progress = cli_progress_report;
    def.progress_user = &session->progress;
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
    screen_options options = screen_default_options("screen");
    const cli_option before[] = {
        {"output", 'o', CLI_TEXT, "FILE", "the image to write: .exr (linear, with metadata) or .png", &options.output,
         0, 0, NULL},
    };
    const cli_option after[] = {
        {"png", 0, CLI_TEXT, "FILE", "also write a PNG", &options.png, 0, 0, NULL},
        {"exposure", 0, CLI_REAL, "STOPS", "exposure of the PNG (default 0)", &options.exposure, -64, 64, NULL},
        {"curve", 0, CLI_CHOICE, "auto|none|filmic", "curve of the PNG (default: none for PNG and JPEG, else filmic)",
         &options.curve, 0, 0, NULL},
        {"aov", 0, CLI_TEXT, "NAME,...", "also write these channels to the EXR (see above)", &options.aov, 0, 0, NULL},
    };
    enum { BEFORE = sizeof before / sizeof before[0], AFTER = sizeof after / sizeof after[0] };
    cli_option table[BEFORE + SCREEN_OPTIONS + AFTER];
    memcpy(table, before, sizeof before);
    screen_list_options(&options, table + BEFORE);
    memcpy(table + BEFORE + SCREEN_OPTIONS, after, sizeof after);
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
    if (status == CLI_GO) status = screen_check_outputs(&options);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "screen", &given.common);
    return status == CLI_GO ? load_and_apply(&session, &options, &given) : status;
}
