/* Methods and requests of commands. */
#include "cli/methods/methods.h"
#include "cli/options/aovs.h"

#include <string.h>

const ty_method* cli_find_method(const char* command, const char* name) {
    char known[128] = "";
    if (strcmp(name, cli_method_auto.name) == 0) return &cli_method_auto;
    const ty_method* method = ty_method_find(name);
    if (method != NULL) return method;
    for (int i = 0; ty_methods[i] != NULL; ++i) {
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s, ", ty_methods[i]->name);
    }
    cli_usage_error(command, "unknown method '%s'; known: %s%s", name, known, cli_method_auto.name);
    return NULL;
}

void cli_name_methods_in(const char* text, char* out, size_t size) {
    size_t used = (size_t)snprintf(out, size, "%s", cli_method_auto.name);
    for (int i = 0; ty_methods[i] != NULL && used < size; ++i)
        used += (size_t)snprintf(out + used, size - used, "%s%s", ty_methods[i + 1] != NULL ? ", " : " or ",
                                 ty_methods[i]->name);
    if (used < size) snprintf(out + used, size - used, " %s", text);
}

int cli_check_request(cli_session* session, const ty_scene* scene, const ty_method* method,
                      const cli_request* request) {
    const char* command = session->command;
    const char* aov = cli_aov_outside(request->aovs, method->aovs);
    if (aov != NULL) return cli_usage_error(command, "--aov: the method %s has no '%s'", method->name, aov);
    if (request->crop[2] > 0 && !method->crops)
        return cli_usage_error(command, "--crop: the method %s renders whole frames, since light spreads over them",
                               method->name);
    const ty_result result = method->check != NULL ? method->check(scene) : TY_OK;
    return result == TY_OK ? CLI_GO : cli_fail_reading(session, result);
}

static ty_render_request to_library(cli_session* session, const cli_request* request) {
    ty_render_request out = {.spp = request->spp,
                             .seed = request->seed,
                             .seconds = request->seconds,
                             .error = request->error,
                             .width = request->width,
                             .height = request->height,
                             .aovs = request->aovs,
                             .progress = cli_progress_report,
                             .progress_user = &session->progress,
                             .partial = request->partial,
                             .partial_user = request->partial_user,
                             .light = request->light};
    memcpy(out.crop, request->crop, sizeof out.crop);
    if (request->checkpoint == NULL) return out;
    out.state = cli_checkpoint_write;
    out.state_change = cli_checkpoint_append;
    out.state_user = request->checkpoint;
    out.state_seconds = request->checkpoint_seconds;
    out.resume = request->checkpoint->bytes;
    out.resume_size = request->checkpoint->size;
    return out;
}

ty_result cli_path_def(cli_session* session, const ty_scene* scene, const cli_request* request, ty_path_def* def) {
    const ty_render_request asked = to_library(session, request);
    return ty_request_path_def(scene, &asked, def);
}

ty_result cli_render_method(cli_session* session, const ty_scene* scene, const ty_method* method,
                            const cli_request* request, ty_image** out, cli_report* report) {
    if (method == &cli_method_auto) return cli_render_auto(session, scene, request, out, report);
    const ty_render_request asked = to_library(session, request);
    report->run = (ty_method_run){.own_seconds = 0};
    const ty_result result = method->render(scene, &asked, out, &report->run);
    report->ran = *out != NULL ? method : NULL;
    return result;
}
