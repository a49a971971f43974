/* Numbers in text files. */
#define _GNU_SOURCE
#include "io/number.h"

#include <errno.h>
#include <locale.h>
#include <stdlib.h>

double ty_parse_number(const char* text, const char** end) {
    char* rest = NULL;
    const locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0); /* the "C" locale needs no allocation */
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
