/* Numbers in text files. */
#define _GNU_SOURCE
#include "base/number.h"

#include <errno.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

double ty_parse_number(const char* text, const char** end) {
    char* rest = NULL;
    const locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0); /* takes no memory */
    const double value = strtod_l(text, &rest, plain);
    freelocale(plain);
    *end = rest;
    return value;
}

int64_t ty_parse_integer(const char* text, const char** end) {
    char* rest = NULL;
    errno = 0;
    const long long value = strtoll(text, &rest, 10);
    *end = errno == 0 ? rest : text;
    return value;
}

void ty_format_number(double value, char* text, size_t size) {
    char digits_text[40];
    int digits = value == floor(value) && fabs(value) < 1e6 ? 6 : 1;
    do snprintf(digits_text, sizeof digits_text, "%.*g", digits, value);
    while (strtod(digits_text, NULL) != value && ++digits <= 17);
    const char* point = localeconv()->decimal_point;
    char* at = strcmp(point, ".") == 0 ? NULL : strstr(digits_text, point);
    if (at == NULL)
        snprintf(text, size, "%s", digits_text);
    else
        snprintf(text, size, "%.*s.%s", (int)(at - digits_text), digits_text, at + strlen(point));
}
