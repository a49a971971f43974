/* JSON text of files. */
#ifndef TY_IO_JSON_PARSE_H
#define TY_IO_JSON_PARSE_H

#include <tyndall/base.h>

#include <jansson.h>

/* Parses text in which no key occurs twice in an object. The caller releases *out. Errors: TY_ERROR_INPUT with path and
 * line, TY_ERROR_MEMORY. */
ty_result ty_json_parse(ty_context* context, const char* path, const char* text, size_t size, json_t** out);

#endif
