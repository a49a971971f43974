/* Words and numbers in messages about JSON. */
#ifndef TY_IO_SCHEMA_TEXT_H
#define TY_IO_SCHEMA_TEXT_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

/* Edit distance (Damerau-Levenshtein: insertions, deletions, replacements, swaps of neighbours), case-insensitive;
 * words are compared up to 63 characters. */
size_t ty_word_distance(const char* a, const char* b);
/* True if b may be a misspelling of a: a small distance, or one is a prefix of the other. */
bool ty_word_is_similar(const char* a, const char* b);

/* Each function appends to the text in out, truncated to size. */
void ty_append(char* out, size_t size, const char* format, ...) __attribute__((format(printf, 3, 4)));
/* A quoted word, truncated if long, with control characters replaced. */
void ty_append_quoted(char* out, size_t size, const char* word);
/* The shortest decimal that reads back as value, with a point in every locale. */
void ty_append_number(char* out, size_t size, double value);
/* A value: scalars as text, others by type. */
void ty_append_value(char* out, size_t size, const json_t* value);

#endif
