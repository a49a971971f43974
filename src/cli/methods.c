/* The methods that render scenes. */
#include "cli/methods.h"
#include "cli/aovs.h"

#include <string.h>

/* All but auto, which is one of them. */
static const cli_method* const methods[] = {&cli_method_path, &cli_method_screen, &cli_method_fld, &cli_method_cda,
                                            &cli_method_pop,  &cli_method_lpv,    &cli_method_dom};
enum { METHOD_COUNT = sizeof methods / sizeof methods[0] };

const cli_method* cli_find_method(const char* command, const char* name) {
    char known[128] = "";
    if (strcmp(name, cli_method_auto.name) == 0) return &cli_method_auto;
    for (int i = 0; i < METHOD_COUNT; ++i) {
        if (strcmp(name, methods[i]->name) == 0) return methods[i];
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s, ", methods[i]->name);
    }
    cli_usage_error(command, "unknown method '%s'; known: %s%s", name, known, cli_method_auto.name);
    return NULL;
}

const cli_method* cli_method_at(int index) {
    return index < METHOD_COUNT ? methods[index] : NULL;
}

int cli_check_request(cli_session* session, const ty_scene* scene, const cli_method* method,
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
