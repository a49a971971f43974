/* The method that the library chooses for a scene; path tracing where that one does not take it after all. */
#include "cli/methods.h"

/* One line on stderr. */
static void say(cli_session* session, const cli_report* report) {
    if (session->common.quiet) return;
    cli_progress_clear(&session->progress);
    fprintf(stderr, "method: %s (%s)\n", report->method, report->choice);
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
    const ty_result result = ty_choose_method(scene, &def, &choice);
    if (result != TY_OK) return result;
    report->method = choice.method;
    snprintf(report->choice, sizeof report->choice, "%s", choice.reason);
    say(session, report);
    return TY_OK;
}

/* Whether path tracing may do what another method did not. */
static bool is_refusal(ty_result result) {
    return result == TY_ERROR_ARGUMENT || result == TY_ERROR_UNSUPPORTED || result == TY_ERROR_MEMORY;
}

static ty_result render(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
                        cli_report* report) {
    ty_result result = choose(session, scene, request, report);
    if (result != TY_OK) return result;
    const cli_method* method = cli_find_method(session->command, report->method);
    result = method->render(session, scene, request, out, report);
    if (!is_refusal(result) || method == &cli_method_path) return result;
    report->method = cli_method_path.name;
    snprintf(report->choice, sizeof report->choice, "%s refused: %s", method->name, ty_take_error(session->context));
    say(session, report);
    return cli_method_path.render(session, scene, request, out, report);
}

const cli_method cli_method_auto = {
    .name = "auto", .summary = "the method that suits the scene", .aovs = TY_AOV_ALL, .crops = true, .render = render};
