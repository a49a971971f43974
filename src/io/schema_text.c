/* Words and numbers in messages about JSON. */
#define _GNU_SOURCE
#include "io/schema_text.h"

#include "base/number.h"
#include "io/json_locate.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { WORD_MAX = 63, SHOWN_MAX = 60 };

static char fold_case(char c) {
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
}

static size_t smaller(size_t a, size_t b) {
    return a < b ? a : b;
}

size_t ty_word_distance(const char* a, const char* b) {
    const size_t rows = strnlen(a, WORD_MAX);
    const size_t columns = strnlen(b, WORD_MAX);
    size_t line[3][WORD_MAX + 1]; /* rows of the distance table: two before, previous, current */
    for (size_t j = 0; j <= columns; ++j) line[0][j] = j;
    for (size_t i = 1; i <= rows; ++i) {
        size_t* now = line[i % 3];
        const size_t* before = line[(i + 2) % 3];
        const size_t* two_before = line[(i + 1) % 3];
        now[0] = i;
        for (size_t j = 1; j <= columns; ++j) {
            const bool same = fold_case(a[i - 1]) == fold_case(b[j - 1]);
            now[j] = smaller(smaller(now[j - 1], before[j]) + 1, before[j - 1] + (same ? 0 : 1));
            if (i > 1 && j > 1 && fold_case(a[i - 1]) == fold_case(b[j - 2]) &&
                fold_case(a[i - 2]) == fold_case(b[j - 1]))
                now[j] = smaller(now[j], two_before[j - 2] + 1);
        }
    }
    return line[rows % 3][columns];
}

static bool begins_with(const char* word, const char* start) {
    size_t i = 0;
    while (start[i] != '\0' && fold_case(word[i]) == fold_case(start[i])) ++i;
    return start[i] == '\0' && i >= 3;
}

bool ty_word_is_similar(const char* a, const char* b) {
    const size_t length = smaller(strnlen(a, WORD_MAX), strnlen(b, WORD_MAX));
    return ty_word_distance(a, b) <= (length + 1) / 3 || begins_with(a, b) || begins_with(b, a);
}

void ty_append(char* out, size_t size, const char* format, ...) {
    const size_t used = strlen(out);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(out + used, size - used, format, arguments);
    va_end(arguments);
}

void ty_append_quoted(char* out, size_t size, const char* word) {
    const int shown = (int)ty_text_fit(word, SHOWN_MAX);
    const size_t start = strlen(out);
    ty_append(out, size, "\"%.*s%s\"", shown, word, word[shown] != '\0' ? "..." : "");
    for (char* at = out + start; *at != '\0'; ++at)
        if ((unsigned char)*at < ' ' || *at == 0x7f) *at = '?';
}

void ty_append_number(char* out, size_t size, double value) {
    char text[40];
    ty_format_number(value, text, sizeof text);
    ty_append(out, size, "%s", text);
}

void ty_append_value(char* out, size_t size, const json_t* value) {
    switch (json_typeof(value)) {
    case JSON_STRING: ty_append_quoted(out, size, json_string_value(value)); break;
    case JSON_INTEGER: ty_append(out, size, "%" JSON_INTEGER_FORMAT, json_integer_value(value)); break;
    case JSON_REAL: ty_append_number(out, size, json_real_value(value)); break;
    case JSON_OBJECT: ty_append(out, size, "an object"); break;
    case JSON_ARRAY: ty_append(out, size, "an array"); break;
    case JSON_TRUE: ty_append(out, size, "true"); break;
    case JSON_FALSE: ty_append(out, size, "false"); break;
    case JSON_NULL: ty_append(out, size, "null"); break;
    }
}
