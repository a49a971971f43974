/* Numbers in text files, which mean the same in every locale. */
#ifndef TY_BASE_NUMBER_H
#define TY_BASE_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The number at the start of text after blanks, "-1.5e3", "inf" and "nan" included; *end is what follows it, or text
 * when there is none. text ends with a zero. */
double ty_parse_number(const char* text, const char** end);
/* The same for a whole number that fits; *end is text when it does not. */
int64_t ty_parse_integer(const char* text, const char** end);
/* The shortest decimal that reads back as value, with a point in every locale; cut when size is too small. */
void ty_format_number(double value, char* text, size_t size);

#endif
