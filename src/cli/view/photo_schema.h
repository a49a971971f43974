/* The document of a photograph in the viewer: its keys are the options of tyndall screen. */
#ifndef TY_CLI_VIEW_PHOTO_SCHEMA_H
#define TY_CLI_VIEW_PHOTO_SCHEMA_H

#include "cli/screen/screen_options.h"

#include <jansson.h>

/* The JSON Schema, for the caller to release; NULL without memory. A key that only some variants have lists them as
 * "x-variants". */
json_t* view_photo_schema(void);

/* The document that says what options say: those at their defaults are left out. CLI_GO, or an exit status after a
 * message. */
int view_photo_document(cli_session* session, const json_t* schema, screen_options* options, json_t** out);
/* The text of an option's value in a document, freed with free(); NULL where the document or its variant has no such
 * option. */
char* view_photo_text(ty_context* context, const json_t* document, const cli_option* option);

#endif
