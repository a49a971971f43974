/* Words and numbers as messages about JSON name them. */
#ifndef TY_IO_SCHEMA_TEXT_H
#define TY_IO_SCHEMA_TEXT_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

/* How many characters must be put in, left out, replaced or swapped with a neighbour to make b from a, whatever the
 * case; words are compared up to 63 characters. */
size_t ty_word_distance(const char* a, const char* b);
/* Whether b may be a slip of the pen for a: a small distance, or one begins with the other. */
bool ty_word_near(const char* a, const char* b);

/* Each adds to the text in out, which is cut when size is too small. */
void ty_append(char* out, size_t size, const char* format, ...) __attribute__((format(printf, 3, 4)));
/* A word in quotes, cut when it is long, control characters replaced. */
void ty_append_quoted(char* out, size_t size, const char* word);
/* The shortest decimal that reads back as value, with a point in every locale. */
void ty_append_number(char* out, size_t size, double value);
/* A value: scalars themselves, others by type. */
void ty_append_value(char* out, size_t size, const json_t* value);

#endif
