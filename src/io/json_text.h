/* JSON values as text whose numbers are the shortest that read back as they are. */
#ifndef TY_IO_JSON_TEXT_H
#define TY_IO_JSON_TEXT_H

#include <jansson.h>
#include <tyndall/base.h>

/* A number: a whole one without a point. */
json_t* ty_json_number(double value);

/* Text that grows. After `failed` is set, because memory ran out, further calls do nothing. */
typedef struct ty_text {
    ty_context* context;
    char* at;
    size_t length, capacity;
    bool failed;
} ty_text;

void ty_text_add(ty_text* text, const char* bytes, size_t length);
void ty_text_add_word(ty_text* text, const char* word);
/* A number, string, true, false or null; a real number has a point or an exponent. */
void ty_text_add_scalar(ty_text* text, const json_t* scalar);
/* Any value, without spaces. */
void ty_text_add_compact(ty_text* text, const json_t* value);

/* The text, freed with ty_free_text, or NULL with a message; *text is empty then. */
char* ty_text_finish(ty_text* text);

#endif
