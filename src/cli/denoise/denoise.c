/* tyndall denoise: removes the noise of path-traced images. */
#include "cli/commands.h"
#include "cli/denoise/denoised.h"

typedef struct denoise_options {
    const char *output, *png, *previous;
    double exposure;
    int denoiser;
    bool whole;
    cli_list features;
} denoise_options;

/* The images that a command line names: the one to denoise, features, the previous one. */
typedef struct denoise_images {
    ty_image *image, *features[TY_DENOISE_FEATURES_MAX], *previous;
} denoise_images;

static ty_result read_images(cli_session* session, const denoise_options* options, const char* input,
                             denoise_images* out) {
    ty_result result = ty_image_read(session->context, input, &out->image);
    for (int32_t i = 0; i < options->features.count && result == TY_OK; ++i)
        result = ty_image_read(session->context, options->features.items[i], &out->features[i]);
    if (options->previous != NULL && result == TY_OK)
        result = ty_image_read(session->context, options->previous, &out->previous);
    return result;
}

static void destroy_images(denoise_images* images) {
    for (int i = 0; i < TY_DENOISE_FEATURES_MAX; ++i) ty_image_destroy(images->features[i]);
    ty_image_destroy(images->previous);
    ty_image_destroy(images->image);
}

static int write_files(cli_session* session, const denoise_options* options, const ty_image* image) {
    ty_result result = ty_image_write_exr(session->context, image, options->output);
    if (result == TY_OK && options->png != NULL)
        result = cli_write_denoised_png(session, image, options->exposure, options->png);
    return result == TY_OK ? CLI_DONE : cli_fail_running(session, result);
}

static void denoise_stats(json_writer* json, const void* user) {
    cli_denoised_json(json, user);
}

static int denoise_images_of(cli_session* session, const denoise_options* options, const char* input,
                             denoise_images* images, ty_denoise_stats* stats) {
    ty_denoise_def def = ty_default_denoise_def();
    for (int i = 0; i < TY_DENOISE_FEATURES_MAX; ++i) def.features[i] = images->features[i];
    def.previous = images->previous;
    def.parts = !options->whole;
    def.denoiser = (ty_denoiser)options->denoiser;
    def.progress = cli_progress_report;
    def.progress_user = &session->progress;
    ty_result result = cli_add_denoised(session, &def, NULL, NULL, &images->image, stats);
    if (result == TY_OK) result = cli_denoised_metadata(images->image, stats);
    if (result == TY_ERROR_INPUT || result == TY_ERROR_ARGUMENT)
        return cli_fail(CLI_USAGE, "%s: %s", input, ty_take_error(session->context));
    if (result != TY_OK) return cli_fail_running(session, result);
    session->stats = denoise_stats;
    session->stats_user = stats;
    const int status = write_files(session, options, images->image);
    if (status != CLI_DONE || session->common.quiet) return status;
    cli_print_denoised(stats);
    printf("wrote %s\n", options->output);
    if (options->png != NULL) printf("wrote %s (denoised)\n", options->png);
    return status;
}

static int check_options(const denoise_options* options) {
    if (options->output == NULL) return cli_usage_error("denoise", "where to? Give -o OUT.exr");
    if (!cli_has_extension(options->output, ".exr"))
        return cli_usage_error("denoise", "%s: the extension is not .exr", options->output);
    if (options->png != NULL && !cli_has_extension(options->png, ".png"))
        return cli_usage_error("denoise", "%s: the extension is not .png", options->png);
    if (options->features.count > TY_DENOISE_FEATURES_MAX)
        return cli_usage_error("denoise", "--feature: %d images, and there may be %d", (int)options->features.count,
                               TY_DENOISE_FEATURES_MAX);
    const int status = cli_check_output("denoise", options->output);
    return status != CLI_GO || options->png == NULL ? status : cli_check_output("denoise", options->png);
}

static int denoise_file(const cli_arguments* given, const denoise_options* options) {
    cli_session session;
    int status = cli_session_open(&session, "denoise", &given->common);
    if (status != CLI_GO) return status;
    status = cli_check_denoiser(&session, options->denoiser);
    if (status != CLI_GO) return cli_session_close(&session, status);
    denoise_images images = {.image = NULL};
    ty_denoise_stats stats = ty_default_denoise_stats();
    cli_end_on_interrupt(true);
    const ty_result result = read_images(&session, options, given->positional[0], &images);
    cli_end_on_interrupt(false);
    const int done = result == TY_OK ? denoise_images_of(&session, options, given->positional[0], &images, &stats)
                                     : cli_fail_reading(&session, result);
    destroy_images(&images);
    return cli_session_close(&session, done);
}

int cli_denoise(int count, char** arguments) {
    denoise_options options = {.exposure = 0};
    const cli_option table[] = {
        {"output", 'o', CLI_TEXT, "FILE.exr", "the image to write: all channels of IMAGE and the denoised layers",
         &options.output, 0, 0, NULL},
        {"feature", 0, CLI_LIST, "FILE",
         "an image without noise of the same view, such as that of dom (again for more)", &options.features, 0, 0,
         NULL},
        {"previous", 0, CLI_TEXT, "FILE.exr", "the denoised image before this one in a sequence", &options.previous, 0,
         0, NULL},
        {"whole", 0, CLI_FLAG, NULL, "denoise all light at once, not single, multiple and other light apart",
         &options.whole, 0, 0, NULL},
        {"denoiser", 0, CLI_CHOICE, "regression|oidn",
         "what removes the noise (default regression; oidn: Intel Open Image Denoise, where it is installed)",
         &options.denoiser, 0, 0, NULL},
        {"png", 0, CLI_TEXT, "FILE", "also write a PNG of the denoised light", &options.png, 0, 0, NULL},
        {"exposure", 0, CLI_REAL, "STOPS", "exposure of the PNG (default 0)", &options.exposure, -64, 64, NULL},
    };
    const cli_syntax syntax = {
        "denoise",
        "IMAGE.exr -o OUT.exr [options]",
        "Removes the noise of a path-traced image.",
        "IMAGE.exr is of 'tyndall render --method path --aov half', best with all,half: noise is told from detail by\n"
        "two independent halves of the samples, and light is regressed on depth, normals, transmittance and albedo.\n"
        "OUT.exr has R, G, B and all other channels of IMAGE as they were, and the layers denoised.R, .G, .B and\n"
        "denoised_error.R, .G, .B: the denoised light, and its standard error with bias as estimated.\n\n"
        "Images of a sequence flicker less with --previous, the result of this command for the image before.",
        table,
        sizeof table / sizeof table[0],
        1,
        1,
        NULL};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO) status = check_options(&options);
    return status == CLI_GO ? denoise_file(&given, &options) : status;
}
