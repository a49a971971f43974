/* Reading and naming the images of a comparison. */
#include "cli/compare/read.h"
#include "cli/session/metadata.h"

#include <string.h>

int cli_read_compared(cli_session* session, const char* path, cli_compared* out) {
    const ty_result result = ty_image_read(session->context, path, &out->image);
    if (result != TY_OK) return cli_fail_reading(session, result);
    out->source = path;
    out->seconds = out->own_seconds = out->spp = -1; /* unknown */
    cli_metadata_number(out->image, "tyndall.seconds", &out->seconds);
    cli_metadata_number(out->image, "tyndall.own_seconds", &out->own_seconds);
    cli_metadata_number(out->image, "tyndall.spp", &out->spp);
    return CLI_GO;
}

static bool name_taken(const cli_comparison* comparison, const char* name) {
    for (int i = 0; i < comparison->count; ++i)
        if (strcmp(comparison->entries[i].name, name) == 0) return true;
    return strcmp(name, "reference") == 0;
}

void cli_choose_name(const cli_comparison* comparison, const char* source, char out[CLI_COMPARE_NAME]) {
    char base[CLI_COMPARE_NAME - 16];
    const char* slash = strrchr(source, '/');
    snprintf(base, sizeof base, "%.*s", (int)sizeof base - 1, slash != NULL ? slash + 1 : source);
    char* dot = strrchr(base, '.');
    if (dot != NULL && dot != base) *dot = '\0';
    for (char* c = base; *c != '\0'; ++c)
        if (strchr("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_.", *c) == NULL) *c = '_';
    snprintf(out, CLI_COMPARE_NAME, "%s", base);
    for (int n = 2; name_taken(comparison, out); ++n) snprintf(out, CLI_COMPARE_NAME, "%s-%d", base, n);
}
