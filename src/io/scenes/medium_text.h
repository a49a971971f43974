/* A homogeneous medium as text, beyond ty_medium_parse. */
#ifndef TY_IO_MEDIUM_TEXT_H
#define TY_IO_MEDIUM_TEXT_H

#include <jansson.h>
#include <tyndall/io.h>

/* The keys of a scene's medium that such a medium can have, ended by NULL. */
extern const char* const ty_homogeneous_keys[];

/* The object of a scene file that a text of ty_medium_parse stands for: "fog:50" is {"preset": "fog", "visibility":
 * 50}. *out is the caller's to release. Errors: those of ty_medium_parse, but for the limits of coefficients. */
ty_result ty_medium_object(ty_context* context, const char* text, json_t** out);

#endif
