#include "io/json_parse.h"

#include "base/context.h"

#include <string.h>

/* Jansson takes a string for which there is no memory for a mistake in the text. A mistake is found again, at the same
 * place. */
ty_result ty_json_parse(ty_context* context, const char* path, const char* text, size_t size, json_t** out) {
    json_error_t first, second;
    *out = json_loadb(text, size, JSON_REJECT_DUPLICATES, &first);
    if (*out == NULL) *out = json_loadb(text, size, JSON_REJECT_DUPLICATES, &second);
    if (*out != NULL) return TY_OK;
    if (first.text[0] == '\0' || first.position != second.position || strcmp(first.text, second.text) != 0)
        return ty_fail(context, TY_ERROR_MEMORY, "%s: not enough memory", path);
    return ty_fail(context, TY_ERROR_INPUT, "%s:%d: %s", path, first.line < 1 ? 1 : first.line, first.text);
}
