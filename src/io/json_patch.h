/* JSON text with changed values: everything else stays as it is written, spaces and numbers included. */
#ifndef TY_IO_JSON_PATCH_H
#define TY_IO_JSON_PATCH_H

#include <jansson.h>
#include <tyndall/base.h>

/* text, which holds `before`, with those values replaced, inserted and removed in which `after` differs. Inserted
 * members and elements are laid out as those beside them. Freed with ty_free_text; NULL, with a message, if memory runs
 * out. */
char* ty_json_patch(ty_context* context, const char* text, size_t length, const json_t* before, const json_t* after);

/* Parts of two arrays: equal elements at the start and at the end, and the others between them. */
typedef struct ty_json_alignment {
    size_t start, end;    /* number of equal elements */
    size_t before, after; /* number of others */
} ty_json_alignment;

ty_json_alignment ty_json_align(const json_t* before, const json_t* after);

#endif
