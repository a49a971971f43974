/* Lines, words and numbers of text mesh files. */
#include "io/meshes/model_text.h"

#include "base/number.h"

#include <string.h>

/* Line ends count as blanks: inside a line they occur only after a backslash. */
static bool is_blank(const char* at, const char* end) {
    if (*at == '\\') return at + 1 < end && (at[1] == '\n' || at[1] == '\r');
    return *at == ' ' || *at == '\t' || *at == '\n' || *at == '\r' || *at == '\v' || *at == '\f';
}

static void skip_blanks(ty_words* words) {
    while (words->at < words->end && is_blank(words->at, words->end)) ++words->at;
}

/* True if the line from `start` to `newline` continues on the next one. */
static bool continues(const char* start, const char* newline) {
    if (newline > start && newline[-1] == '\r') --newline;
    return newline > start && newline[-1] == '\\';
}

bool ty_next_line(ty_words* text, ty_words* line, size_t* number) {
    if (text->at == text->end) return false;
    const char* start = text->at;
    for (;;) {
        const char* newline = memchr(text->at, '\n', (size_t)(text->end - text->at));
        const char* end = newline == NULL ? text->end : newline;
        text->at = newline == NULL ? text->end : newline + 1;
        ++*number;
        if (newline != NULL && continues(start, newline) && text->at < text->end) continue;
        *line = (ty_words){start, end};
        return true;
    }
}

bool ty_next_word(ty_words* words, ty_word* word) {
    skip_blanks(words);
    const char* start = words->at;
    while (words->at < words->end && !is_blank(words->at, words->end)) ++words->at;
    *word = (ty_word){start, (size_t)(words->at - start)};
    return word->length > 0;
}

bool ty_next_number(ty_words* words, double* number) {
    skip_blanks(words);
    if (words->at == words->end) return false;
    const char* after;
    *number = ty_parse_number(words->at, &after);
    if (after == words->at || after > words->end) return false;
    if (after < words->end && !is_blank(after, words->end)) return false;
    words->at = after;
    return true;
}

ty_word ty_rest_of_line(ty_words* words) {
    skip_blanks(words);
    const char* end = words->end;
    while (end > words->at && (is_blank(end - 1, words->end))) --end;
    const ty_word rest = {words->at, (size_t)(end - words->at)};
    words->at = words->end;
    return rest;
}

bool ty_word_is(ty_word word, const char* text) {
    return strlen(text) == word.length && memcmp(word.text, text, word.length) == 0;
}
