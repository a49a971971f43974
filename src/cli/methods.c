/* The methods that render scenes. */
#include "cli/methods.h"
#include "cli/options.h"

#include <stdio.h>
#include <string.h>

static const cli_method methods[] = {
    {"path", "unbiased path tracing", ty_path_render},
};
enum { METHOD_COUNT = sizeof methods / sizeof methods[0] };

const cli_method* cli_find_method(const char* command, const char* name) {
    char known[128] = "";
    for (int i = 0; i < METHOD_COUNT; ++i) {
        if (strcmp(name, methods[i].name) == 0) return &methods[i];
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", i == 0 ? "" : ", ", methods[i].name);
    }
    cli_usage_error(command, "unknown method '%s'; known: %s", name, known);
    return NULL;
}
