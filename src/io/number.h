/* Numbers in text files, independent of the locale. */
#ifndef TY_IO_NUMBER_H
#define TY_IO_NUMBER_H

#include <stdbool.h>
#include <stdint.h>

/* Parses the number at the start of text after blanks, "-1.5e3", "inf" and "nan" included; *end points after it, or
 * to text if there is none. text is zero-terminated. */
double ty_parse_number(const char* text, const char** end);
/* Parses an integer in the range of int64_t; *end is text if there is none. */
int64_t ty_parse_integer(const char* text, const char** end);

#endif
