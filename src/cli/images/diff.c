/* tyndall diff: the difference of an image from a reference. */
#include "cli/commands.h"
#include "cli/images/difference.h"
#include "cli/session/session.h"

#include <inttypes.h>

static void print_difference(const ty_difference* difference) {
    printf("%-8s %14s %14s %14s %14s\n", "", "mean ratio", "RMSE", "relative RMSE", "relMSE");
    for (int i = 0; i < 4; ++i)
        printf("%-8s %14.8g %14.6g %14.6g %14.6g\n", cli_difference_names[i], difference->mean_ratio[i],
               difference->rmse[i], difference->relative_rmse[i], difference->rel_mse[i]);
    printf("values that differ: %" PRId64 "\nvalues not finite:  %" PRId64 "\n", difference->differing,
           difference->not_finite);
}

static void print_difference_json(const ty_difference* difference) {
    json_writer json = json_begin(stdout);
    json_open_object(&json, NULL);
    cli_difference_json(&json, difference);
    json_close_object(&json);
}

static int diff_images(cli_session* session, const char* const paths[2], ty_image* const images[2], int32_t block,
                       bool json, const char* png) {
    const ty_image *a = images[0], *b = images[1];
    ty_difference difference;
    const ty_result result = ty_image_compare(session->context, a, b, block, &difference);
    if (result != TY_OK)
        return cli_fail(result == TY_ERROR_ARGUMENT ? CLI_USAGE : CLI_FAILED, "%s and %s: %s", paths[0], paths[1],
                        ty_take_error(session->context));
    if (json)
        print_difference_json(&difference);
    else
        print_difference(&difference);
    cli_end_on_interrupt(false);
    const ty_result written = png == NULL ? TY_OK : cli_write_heat_map(session->context, a, b, png);
    return written == TY_OK ? CLI_DONE : cli_fail_running(session, written);
}

static int diff_files(cli_session* session, const char* const paths[2], int32_t block, bool json, const char* png) {
    ty_image* images[2] = {NULL, NULL};
    cli_end_on_interrupt(true);
    ty_result result = ty_image_read(session->context, paths[0], &images[0]);
    if (result == TY_OK) result = ty_image_read(session->context, paths[1], &images[1]);
    const int status =
        result == TY_OK ? diff_images(session, paths, images, block, json, png) : cli_fail_reading(session, result);
    ty_image_destroy(images[0]);
    ty_image_destroy(images[1]);
    return status;
}

int cli_diff(int count, char** arguments) {
    bool json = false;
    int32_t block = 1;
    const char* png = NULL;
    const cli_option table[] = {
        {"json", 0, CLI_FLAG, NULL, "print JSON", &json, 0, 0, NULL},
        {"block", 0, CLI_INT, "N", "compare means over N x N pixels (default 1)", &block, 1, 65536, NULL},
        {"png", 0, CLI_TEXT, "FILE", "write a heat map: red where A is brighter, blue where it is darker", &png, 0, 0,
         NULL},
    };
    const cli_syntax syntax = {"diff",
                               "A B [options]",
                               "Compares image A with the reference B (EXR, HDR, PNG or JPEG).",
                               "Mean ratio: mean(A) / mean(B). Relative RMSE: RMSE / mean(B). relMSE: mean of\n"
                               "(A - B)^2 / (B^2 + 0.01 mean(B)^2). Exit status 0 whenever the images can be compared.",
                               table,
                               sizeof table / sizeof table[0],
                               2,
                               2,
                               NULL};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO && png != NULL) {
        status = cli_has_extension(png, ".png") ? cli_check_output("diff", png)
                                                : cli_usage_error("diff", "%s: the extension is not .png", png);
    }
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "diff", &given.common);
    if (status != CLI_GO) return status;
    return cli_session_close(&session, diff_files(&session, given.positional, block, json, png));
}
