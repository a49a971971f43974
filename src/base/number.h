/* Numbers in text files, independent of the locale. */
#ifndef TY_BASE_NUMBER_H
#define TY_BASE_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Parses the number at the start of text after blanks, "-1.5e3", "inf" and "nan" included; *end points after it, or
 * to text if there is none. text is zero-terminated. */
double ty_parse_number(const char* text, const char** end);
/* Parses an integer in the range of int64_t; *end is text if there is none. */
int64_t ty_parse_integer(const char* text, const char** end);
/* The shortest decimal that reads back as value, with a point in every locale; cut when size is too small. */
void ty_format_number(double value, char* text, size_t size);

#endif
