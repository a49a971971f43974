/* tyndall merge: combining renderings of one scene into a less noisy or larger one. */
#include "cli/commands.h"
#include "cli/images/merge_images.h"
#include "cli/session/session.h"

static int write_merged(cli_session* session, const ty_image* image, const char* output, double exposure, int count) {
    cli_end_on_interrupt(false);
    const ty_result result = cli_has_extension(output, ".png")
                                 ? ty_image_write_png(session->context, image, exposure, TY_TONE_FILMIC, output)
                                 : ty_image_write_exr(session->context, image, output);
    if (result != TY_OK) return cli_fail_running(session, result);
    if (!session->common.quiet)
        printf("merged %d images: %dx%d, %s spp\nwrote %s\n", count, ty_image_width(image), ty_image_height(image),
               ty_image_get_metadata(image, "tyndall.spp"), output);
    return CLI_DONE;
}

static int merge_inputs(cli_session* session, cli_piece* pieces, int count, const char* output, double exposure) {
    char message[CLI_MESSAGE_SIZE];
    ty_image* merged = NULL;
    const ty_result result = cli_merge_images(session->context, count, pieces, &merged, message);
    if (result != TY_OK) return cli_fail(result == TY_ERROR_INPUT ? CLI_USAGE : CLI_FAILED, "%s", message);
    const int status = write_merged(session, merged, output, exposure, count);
    ty_image_destroy(merged);
    return status;
}

static int merge_files(cli_session* session, const cli_arguments* given, const char* output, double exposure) {
    cli_piece pieces[CLI_POSITIONAL_MAX];
    ty_image* images[CLI_POSITIONAL_MAX];
    int read = 0;
    cli_end_on_interrupt(true);
    int status = CLI_GO;
    while (read < given->positional_count && status == CLI_GO) {
        const ty_result result = ty_image_read(session->context, given->positional[read], &images[read]);
        if (result != TY_OK) {
            status = cli_fail_reading(session, result);
        } else {
            pieces[read] = (cli_piece){given->positional[read], images[read]};
            ++read;
        }
    }
    if (status == CLI_GO) status = merge_inputs(session, pieces, read, output, exposure);
    for (int i = 0; i < read; ++i) ty_image_destroy(images[i]);
    return status;
}

static int check_output(const char* output) {
    if (output == NULL) return cli_usage_error("merge", "where to? Give -o OUT.exr or -o OUT.png");
    if (!cli_has_extension(output, ".exr") && !cli_has_extension(output, ".png"))
        return cli_usage_error("merge", "%s: the extension is not .exr or .png", output);
    return cli_check_output("merge", output);
}

int cli_merge(int count, char** arguments) {
    const char* output = NULL;
    double exposure = 0;
    const cli_option table[] = {
        {"output", 'o', CLI_TEXT, "FILE", "the image to write: .exr or .png", &output, 0, 0, NULL},
        {"exposure", 0, CLI_REAL, "STOPS", "exposure of a PNG (default 0)", &exposure, -64, 64, NULL},
    };
    const cli_syntax syntax = {"merge",
                               "A.exr B.exr ... -o OUT.exr [options]",
                               "Merges renderings of one scene, size and method.",
                               "Images of different seeds give their mean, weighted by samples (samples.N, else\n"
                               "tyndall.spp); variances are those of that mean. Crops are put in their place in the\n"
                               "frame, where they may overlap if their seeds differ. Results can be merged again.",
                               table,
                               sizeof table / sizeof table[0],
                               2,
                               CLI_POSITIONAL_MAX,
                               NULL};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO) status = check_output(output);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "merge", &given.common);
    if (status != CLI_GO) return status;
    return cli_session_close(&session, merge_files(&session, &given, output, exposure));
}
