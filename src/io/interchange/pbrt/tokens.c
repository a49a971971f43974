/* Words, strings, brackets and numbers of pbrt's text. */
#include "base/number.h"
#include "io/interchange/pbrt/pbrt.h"

#include <math.h>
#include <string.h>

static void skip_blanks(ty_pbrt_text* text) {
    for (; text->at < text->end; ++text->at) {
        if (*text->at == '#') {
            const char* line_end = memchr(text->at, '\n', (size_t)(text->end - text->at));
            if (line_end == NULL) {
                text->at = text->end;
                return;
            }
            text->at = line_end;
        }
        if (*text->at == '\n')
            ++text->line;
        else if (*text->at != ' ' && *text->at != '\t' && *text->at != '\r' && *text->at != '\f' && *text->at != '\v')
            return;
    }
}

static ty_pbrt_token string_token(ty_pbrt_text* text) {
    ty_pbrt_token token = {TY_PBRT_STRING, ++text->at, 0, text->line};
    for (; text->at < text->end && *text->at != '"' && *text->at != '\n'; ++text->at)
        if (*text->at == '\\' && text->at + 1 < text->end && text->at[1] != '\n') ++text->at;
    token.length = (size_t)(text->at - token.text);
    if (text->at == text->end || *text->at != '"')
        token.kind = TY_PBRT_BROKEN;
    else
        ++text->at;
    return token;
}

ty_pbrt_token ty_pbrt_next(ty_pbrt_text* text) {
    skip_blanks(text);
    ty_pbrt_token token = {TY_PBRT_END, text->at, 0, text->line};
    if (text->at == text->end) return token;
    if (*text->at == '"') return string_token(text);
    if (*text->at == '[' || *text->at == ']') {
        token.kind = *text->at++ == '[' ? TY_PBRT_OPEN : TY_PBRT_CLOSE;
        token.length = 1;
        return token;
    }
    token.kind = TY_PBRT_WORD;
    while (text->at < text->end && strchr(" \t\r\n\f\v\"[]#", *text->at) == NULL) ++text->at;
    if (text->at == token.text) ++text->at; /* a zero byte, which strchr finds */
    token.length = (size_t)(text->at - token.text);
    return token;
}

bool ty_pbrt_is(const ty_pbrt_token* token, const char* word) {
    return token->length == strlen(word) && memcmp(token->text, word, token->length) == 0;
}

bool ty_pbrt_number(const ty_pbrt_token* token, double* out) {
    if (token->kind != TY_PBRT_WORD) return false;
    const char* end;
    const double value = ty_parse_number(token->text, &end); /* the text ends with a zero byte */
    if (end != token->text + token->length || !isfinite(value)) return false;
    *out = value;
    return true;
}
