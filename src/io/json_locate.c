/* Skims valid JSON text to find the line of a value. */
#define _GNU_SOURCE
#include "io/json_locate.h"

#include <jansson.h>
#include <stdio.h>
#include <string.h>

enum { KEY_SHOWN = 60 }; /* max bytes of a key in messages */

typedef struct cursor {
    const char* at;
    const char* end;
    int32_t line;
} cursor;

ty_json_path ty_json_path_key(const ty_json_path* base, const char* key) {
    ty_json_path path = *base;
    if (path.depth < TY_JSON_PATH_STEPS) path.steps[path.depth++] = (ty_json_step){.key = key};
    return path;
}

ty_json_path ty_json_path_index(const ty_json_path* base, size_t index) {
    ty_json_path path = *base;
    if (path.depth < TY_JSON_PATH_STEPS) path.steps[path.depth++] = (ty_json_step){.index = index};
    return path;
}

bool ty_json_path_within(const ty_json_path* path, const ty_json_path* start) {
    if (start->depth > path->depth) return false;
    for (size_t i = 0; i < start->depth; ++i) {
        const ty_json_step* a = &path->steps[i];
        const ty_json_step* b = &start->steps[i];
        if ((a->key == NULL) != (b->key == NULL)) return false;
        if (a->key == NULL ? a->index != b->index : strcmp(a->key, b->key) != 0) return false;
    }
    return true;
}

size_t ty_text_fit(const char* text, size_t size) {
    size_t length = strnlen(text, size + 1);
    if (length <= size) return length;
    length = size;
    while (length > 0 && ((unsigned char)text[length] & 0xc0) == 0x80) --length;
    return length;
}

void ty_json_path_text(const ty_json_path* path, char* out, size_t size) {
    size_t used = 0;
    out[0] = '\0';
    for (size_t i = 0; i < path->depth && used < size; ++i) {
        const ty_json_step* step = &path->steps[i];
        int wrote;
        if (step->key == NULL)
            wrote = snprintf(out + used, size - used, "[%zu]", step->index);
        else
            wrote = snprintf(out + used, size - used, "%s%.*s", i > 0 ? "." : "",
                             (int)ty_text_fit(step->key, KEY_SHOWN), step->key);
        if (wrote < 0) break;
        used += (size_t)wrote;
    }
    for (char* c = out; *c != '\0'; ++c)
        if ((unsigned char)*c < ' ' || *c == 0x7f) *c = '?';
}

static bool more(const cursor* c) {
    return c->at < c->end;
}

static void advance(cursor* c) {
    if (*c->at == '\n') ++c->line;
    ++c->at;
}

static void skip_space(cursor* c) {
    while (more(c) && (*c->at == ' ' || *c->at == '\t' || *c->at == '\n' || *c->at == '\r')) advance(c);
}

/* Skips c and the space after it if c comes next. */
static bool skip_character(cursor* c, char character) {
    if (!more(c) || *c->at != character) return false;
    advance(c);
    skip_space(c);
    return true;
}

static void skip_string(cursor* c) {
    advance(c);
    while (more(c) && *c->at != '"') {
        if (*c->at == '\\') advance(c);
        if (more(c)) advance(c);
    }
    if (more(c)) advance(c);
}

/* Skips one value and the space after it. */
static void skip_value(cursor* c) {
    size_t depth = 0;
    while (more(c)) {
        const char first = *c->at;
        if (depth == 0 && (first == ',' || first == '}' || first == ']')) break;
        if (first == '"') {
            skip_string(c);
            continue;
        }
        if (first == '{' || first == '[') ++depth;
        if (first == '}' || first == ']') --depth;
        advance(c);
    }
}

/* True if a string token (`size` bytes at `token`, quotes included) equals key. */
static bool token_is(const char* token, size_t size, const char* key) {
    if (size < 2) return false;
    if (memchr(token, '\\', size) == NULL) return strlen(key) == size - 2 && memcmp(token + 1, key, size - 2) == 0;
    json_t* string = json_loadb(token, size, JSON_DECODE_ANY, NULL);
    const bool same = json_is_string(string) && strcmp(json_string_value(string), key) == 0;
    json_decref(string);
    return same;
}

/* Moves from an object's brace to the value of key; *line is the line of the key. */
static bool enter_member(cursor* c, const char* key, int32_t* line) {
    if (!skip_character(c, '{')) return false;
    while (more(c) && *c->at == '"') {
        const char* token = c->at;
        *line = c->line;
        skip_string(c);
        const bool found = token_is(token, (size_t)(c->at - token), key);
        skip_space(c);
        if (!skip_character(c, ':')) return false;
        if (found) return true;
        skip_value(c);
        if (!skip_character(c, ',')) return false;
    }
    return false;
}

/* Moves from an array's bracket to the value of element `index`; *line is its line. */
static bool enter_element(cursor* c, size_t index, int32_t* line) {
    if (!skip_character(c, '[')) return false;
    for (size_t i = 0; i < index; ++i) {
        skip_value(c);
        if (!skip_character(c, ',')) return false;
    }
    *line = c->line;
    return more(c) && *c->at != ']';
}

int32_t ty_json_line(const char* text, size_t length, const ty_json_path* path) {
    cursor c = {.at = text, .end = text + length, .line = 1};
    skip_space(&c);
    int32_t line = c.line;
    for (size_t i = 0; i < path->depth; ++i) {
        const ty_json_step* step = &path->steps[i];
        if (!(step->key != NULL ? enter_member(&c, step->key, &line) : enter_element(&c, step->index, &line))) return 0;
    }
    return line;
}
