/* Method auto: the library's choice for a scene, with path tracing as the fallback where the chosen method refuses it.
 */
#include "cli/methods/methods.h"

/* Prints one line on stderr: the method, what is expected of it, and the reason. */
static void say(cli_session* session, const cli_report* report) {
    char expected[64] = "";
    if (session->common.quiet) return;
    if (report->expected_seconds > 0) cli_expectation_text(report, expected, sizeof expected);
    cli_progress_clear(&session->progress);
    fprintf(stderr, "method: %s%s%s (%s)\n", report->method, expected[0] != '\0' ? ", " : "", expected, report->choice);
}

static ty_result choose(cli_session* session, const ty_scene* scene, const cli_request* request, cli_report* report) {
    ty_choose_def def = ty_default_choose_def();
    ty_choice choice;
    def.aovs = request->aovs;
    if (request->crop[2] > 0) def.asks |= TY_ASK_CROP;
    if (request->seconds > 0) def.asks |= TY_ASK_TIME;
    if (request->error > 0) def.asks |= TY_ASK_ERROR;
    if (request->checkpoint != NULL) def.asks |= TY_ASK_RESUME;
    if (request->samples) def.asks |= TY_ASK_SAMPLES;
    def.width = request->width;
    def.height = request->height;
    def.spp = request->spp;
    const double begun = cli_wall_seconds();
    const ty_result result = ty_choose_method(scene, &def, &choice);
    if (result != TY_OK) return result;
    report->method = choice.method;
    report->choice_seconds = cli_wall_seconds() - begun;
    snprintf(report->choice, sizeof report->choice, "%s", choice.reason);
    if ((def.asks & (TY_ASK_TIME | TY_ASK_ERROR | TY_ASK_CROP)) == 0) {
        report->expected_error = choice.error;
        report->expected_seconds = choice.seconds / ty_context_threads(session->context);
    }
    say(session, report);
    return TY_OK;
}

/* True if path tracing can be the fallback for another method's error. */
static bool is_refusal(ty_result result) {
    return result == TY_ERROR_ARGUMENT || result == TY_ERROR_UNSUPPORTED || result == TY_ERROR_MEMORY;
}

ty_result cli_render_auto(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
                          cli_report* report) {
    ty_result result = choose(session, scene, request, report);
    if (result != TY_OK) return result;
    const ty_method* method = cli_find_method(session->command, report->method);
    result = cli_render_method(session, scene, method, request, out, report);
    if (!is_refusal(result) || method == &ty_method_path) return result;
    report->method = ty_method_path.name;
    report->expected_error = report->expected_seconds = 0;
    snprintf(report->choice, sizeof report->choice, "%s refused: %s", method->name, ty_take_error(session->context));
    say(session, report);
    return cli_render_method(session, scene, &ty_method_path, request, out, report);
}

const ty_method cli_method_auto = {
    .name = "auto", .summary = "the method that suits the scene", .aovs = TY_AOV_ALL | TY_AOV_HALF, .crops = true};
