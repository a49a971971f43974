/* tyndall convert: scenes of other renderers. */
#include "cli/convert/convert.h"
#include "cli/text/text.h"
#include "io/interchange/convert.h"

#include <stdio.h>

/* Prints one note, below a heading before the first. */
static void say(void* user, const char* note) {
    bool* begun = user;
    if (!*begun) printf("left out or approximated:\n");
    *begun = true;
    printf("- ");
    cli_print_text(stdout, note, 0);
    printf("\n");
}

int cli_convert_scene(cli_session* session, bool partial, const char* input, const char* output) {
    bool begun = false;
    if (!cli_has_extension(output, ".json")) return cli_usage_error("convert", "%s: a scene goes to .json", output);
    const ty_result result = ty_convert_scene(session->context, input, output, partial, say, &begun);
    return result == TY_OK ? CLI_DONE : cli_fail_reading(session, result);
}
