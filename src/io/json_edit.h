/* Changes of single values in a JSON document, by path. */
#ifndef TY_IO_JSON_EDIT_H
#define TY_IO_JSON_EDIT_H

#include "io/json_locate.h"

#include <jansson.h>
#include <tyndall/base.h>

/* Splits "media[0].g"; keys point into the text, which is zero-terminated between them. */
bool ty_json_parse_path(char* text, ty_json_path* path);

/* Equal, with numbers compared by value: 1 and 1.0 are the same. */
bool ty_json_same(const json_t* a, const json_t* b);

/* `value`, which may be changed, with those parts of `old` that are the same: a new reference, or NULL. */
json_t* ty_json_keep_same(json_t* old, json_t* value);

typedef enum ty_json_put_result { TY_JSON_PUT, TY_JSON_REFUSED, TY_JSON_NO_MEMORY } ty_json_put_result;

/* Sets the value at path, which has at least one step. null removes a member, or an element of an array; the index
 * after the last appends an element. Missing objects on the way, and a missing array to append to, are created. Parts
 * of the old value that are the same in the new one stay as they are. On failure the document may hold some of the
 * objects on the way, and TY_JSON_REFUSED writes the cause to `reason`. value is released in any case. */
ty_json_put_result ty_json_put(json_t* root, const ty_json_path* path, json_t* value, char* reason, size_t size);

/* Changes that make `after` of `before`, in their order: "media[0].g=0.5", as ty_json_parse_path and ty_json_put take
 * them. *out has *count texts, released with ty_json_free_changes. Errors: TY_ERROR_MEMORY. */
ty_result ty_json_list_changes(ty_context* context, const json_t* before, const json_t* after, char*** out,
                               int32_t* count);
void ty_json_free_changes(ty_context* context, char** changes, int32_t count);

#endif
