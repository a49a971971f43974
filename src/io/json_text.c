#include "io/json_text.h"

#include "base/context.h"
#include "base/number.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { START_SIZE = 256 };

json_t* ty_json_number(double value) {
    return value == floor(value) && fabs(value) < 1e15 ? json_integer((json_int_t)value) : json_real(value);
}

/* Room for `more` bytes and a zero byte. */
static bool make_room(ty_text* text, size_t more) {
    const size_t needed = text->length + more + 1;
    if (text->failed || needed <= text->capacity) return !text->failed;
    size_t capacity = text->capacity > 0 ? text->capacity : START_SIZE;
    while (capacity < needed) capacity *= 2;
    char* grown = ty_alloc_array(text->context, capacity, 1, false);
    if (grown == NULL) {
        text->failed = true;
        return false;
    }
    if (text->length > 0) memcpy(grown, text->at, text->length);
    ty_free_array(text->context, text->at, text->capacity, 1);
    text->at = grown;
    text->capacity = capacity;
    return true;
}

void ty_text_add(ty_text* text, const char* bytes, size_t length) {
    if (length == 0 || !make_room(text, length)) return;
    memcpy(text->at + text->length, bytes, length);
    text->length += length;
}

void ty_text_add_word(ty_text* text, const char* word) {
    ty_text_add(text, word, strlen(word));
}

static void add_real(ty_text* text, double value) {
    char number[40];
    ty_format_number(value, number, sizeof number);
    ty_text_add_word(text, number);
    if (strpbrk(number, ".en") == NULL) ty_text_add_word(text, ".0");
}

void ty_text_add_scalar(ty_text* text, const json_t* scalar) {
    if (json_is_real(scalar)) {
        add_real(text, json_real_value(scalar));
        return;
    }
    char* dump = json_dumps(scalar, JSON_ENCODE_ANY | JSON_COMPACT);
    if (dump == NULL)
        text->failed = true;
    else
        ty_text_add_word(text, dump);
    free(dump);
}

static void add_key(ty_text* text, const char* key) {
    json_t* string = json_string(key);
    if (string == NULL)
        text->failed = true;
    else
        ty_text_add_scalar(text, string);
    json_decref(string);
}

static void add_members(ty_text* text, const json_t* object) {
    const char* key;
    json_t* member;
    const char* comma = "";
    ty_text_add_word(text, "{");
    json_object_foreach((json_t*)object, key, member) {
        ty_text_add_word(text, comma);
        add_key(text, key);
        ty_text_add_word(text, ":");
        ty_text_add_compact(text, member);
        comma = ",";
    }
    ty_text_add_word(text, "}");
}

void ty_text_add_compact(ty_text* text, const json_t* value) {
    if (json_is_object(value)) {
        add_members(text, value);
    } else if (json_is_array(value)) {
        ty_text_add_word(text, "[");
        for (size_t i = 0; i < json_array_size(value); ++i) {
            if (i > 0) ty_text_add_word(text, ",");
            ty_text_add_compact(text, json_array_get(value, i));
        }
        ty_text_add_word(text, "]");
    } else {
        ty_text_add_scalar(text, value);
    }
}

char* ty_text_finish(ty_text* text) {
    char* result = NULL;
    if (text->failed) {
        ty_fail(text->context, TY_ERROR_MEMORY, "not enough memory for the text of a scene");
    } else if (make_room(text, 0)) {
        text->at[text->length] = '\0';
        result = ty_copy_text(text->context, text->at);
    }
    ty_free_array(text->context, text->at, text->capacity, 1);
    *text = (ty_text){.context = text->context};
    return result;
}
