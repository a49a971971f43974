/* Defaults, checks and texts of options. */
#include "option/option.h"

#include "base/context.h"
#include "base/number.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const ty_option* ty_option_find(const ty_option_table* table, const char* name) {
    for (int32_t i = 0; i < table->count; ++i)
        if (strcmp(table->options[i].name, name) == 0) return &table->options[i];
    return NULL;
}

static uint32_t word_value(const ty_option* option, int32_t index) {
    return option->values != NULL ? option->values[index] : (uint32_t)index;
}

const char* ty_option_word(const ty_option* option, uint32_t value) {
    for (int32_t i = 0; option->words[i] != NULL; ++i)
        if (word_value(option, i) == value) return option->words[i];
    return NULL;
}

void ty_option_text(const ty_option* option, double value, char text[TY_OPTION_TEXT_SIZE]) {
    const char* word = NULL;
    if (option->type == TY_OPTION_WORD) word = ty_option_word(option, (uint32_t)(int64_t)value);
    if (option->type == TY_OPTION_BOOL) word = value != 0 ? "true" : "false";
    if ((option->flags & TY_OPTION_AUTO) != 0 && value == TY_AUTO) word = "auto";
    if (word != NULL)
        snprintf(text, TY_OPTION_TEXT_SIZE, "%s", word);
    else
        ty_format_number(value, text, TY_OPTION_TEXT_SIZE);
}

/* ---- Fields ---- */

static double get_number(const ty_option* option, const char* field, int32_t element) {
    int32_t whole;
    float single;
    double number;
    switch (option->type) {
    case TY_OPTION_INT:
    case TY_OPTION_WORD: memcpy(&whole, field + (size_t)element * sizeof whole, sizeof whole); return whole;
    case TY_OPTION_FLOAT:
        memcpy(&single, field + (size_t)element * sizeof single, sizeof single);
        return (double)single;
    case TY_OPTION_DOUBLE: memcpy(&number, field + (size_t)element * sizeof number, sizeof number); return number;
    case TY_OPTION_BOOL: break;
    }
    return *(const bool*)field ? 1 : 0;
}

double ty_option_value(const ty_option* option, const void* def) {
    return get_number(option, (const char*)def + option->offset, 0);
}

bool ty_option_fits(const ty_option* option, const void* def) {
    return option->offset + option->size <= ty_def_bytes(def);
}

static void set_number(const ty_option* option, char* field, int32_t element, double value) {
    const int32_t whole = option->type == TY_OPTION_INT || option->type == TY_OPTION_WORD ? (int32_t)value : 0;
    const float single = (float)value;
    switch (option->type) {
    case TY_OPTION_INT:
    case TY_OPTION_WORD: memcpy(field + (size_t)element * sizeof whole, &whole, sizeof whole); return;
    case TY_OPTION_FLOAT: memcpy(field + (size_t)element * sizeof single, &single, sizeof single); return;
    case TY_OPTION_DOUBLE: memcpy(field + (size_t)element * sizeof value, &value, sizeof value); return;
    case TY_OPTION_BOOL: *(bool*)field = value != 0; return;
    }
}

static int32_t element_count(const ty_option* option) {
    return option->count > 0 ? option->count : 1;
}

void ty_options_init(const ty_option_table* table, void* def, size_t bytes) {
    memset(def, 0, bytes);
    for (int32_t i = 0; i < table->count; ++i) {
        const ty_option* option = &table->options[i];
        if (option->offset + option->size > bytes) continue; /* the caller's definition is older than the option */
        for (int32_t e = 0; e < element_count(option); ++e)
            set_number(option, (char*)def + option->offset, e, option->preset);
    }
    ty_mark_def(def, bytes);
}

/* ---- Checks ---- */

static bool is_multiple(const ty_option* option, double value) {
    return option->multiple == 0 || fmod(value, option->multiple) == 0;
}

static bool is_allowed(const ty_option* option, double value) {
    if ((option->flags & TY_OPTION_AUTO) != 0 && value == TY_AUTO) return true;
    if ((option->flags & TY_OPTION_OR_ZERO) != 0 && value == 0) return true;
    const bool above = (option->flags & TY_OPTION_OPEN_MIN) != 0 ? value > option->min : value >= option->min;
    const bool below = (option->flags & TY_OPTION_OPEN_MAX) != 0 ? value < option->max : value <= option->max;
    return above && below && is_multiple(option, value);
}

/* Fails for a number outside the range; automatic is the caller's notation of TY_AUTO. */
static ty_result fail_range(ty_context* context, const char* field, const ty_option* option, double value,
                            const char* automatic) {
    char number[TY_OPTION_TEXT_SIZE], min[TY_OPTION_TEXT_SIZE], max[TY_OPTION_TEXT_SIZE], hint[64] = "";
    ty_format_number(value, number, sizeof number);
    ty_format_number(option->min, min, sizeof min);
    ty_format_number(option->max, max, sizeof max);
    if ((option->flags & TY_OPTION_OR_ZERO) != 0) snprintf(hint, sizeof hint, "; 0 means none");
    if ((option->flags & TY_OPTION_AUTO) != 0)
        snprintf(hint, sizeof hint, "; write %s for the default choice", automatic);
    if (!is_multiple(option, value))
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: %s is not a multiple of %g in [%s, %s]", field, number,
                       option->multiple, min, max);
    return ty_fail(context, TY_ERROR_ARGUMENT, "%s: %s is outside %c%s, %s%c%s", field, number,
                   (option->flags & TY_OPTION_OPEN_MIN) != 0 ? '(' : '[', min, max,
                   (option->flags & TY_OPTION_OPEN_MAX) != 0 ? ')' : ']', hint);
}

static ty_result check_option(ty_context* context, const ty_option_table* table, const ty_option* option,
                              const void* def) {
    char field[TY_OPTION_TEXT_SIZE];
    if (option->type == TY_OPTION_BOOL) return TY_OK;
    for (int32_t e = 0; e < element_count(option); ++e) {
        const double value = get_number(option, (const char*)def + option->offset, e);
        if (option->count > 0)
            snprintf(field, sizeof field, "%s.%s[%d]", table->name, option->name, (int)e);
        else
            snprintf(field, sizeof field, "%s.%s", table->name, option->name);
        if ((option->flags & TY_OPTION_BITS) != 0) {
            if (((uint32_t)(int32_t)value & ~(uint32_t)option->max) != 0)
                return ty_fail(context, TY_ERROR_ARGUMENT, "%s: 0x%x has bits that do not exist", field,
                               (unsigned)(int32_t)value);
        } else if (option->type == TY_OPTION_WORD) {
            if (ty_option_word(option, (uint32_t)(int32_t)value) == NULL)
                return ty_fail(context, TY_ERROR_ARGUMENT, "%s: there is none with number %d", field, (int)value);
        } else if (!is_allowed(option, value)) {
            return fail_range(context, field, option, value, "TY_AUTO");
        }
    }
    return TY_OK;
}

ty_result ty_options_take(ty_context* context, const ty_option_table* table, const void* def, void* own) {
    ty_options_init(table, own, table->bytes);
    ty_result result = ty_take_def(context, def, table->default_function, own, table->bytes);
    for (int32_t i = 0; i < table->count && result == TY_OK; ++i)
        result = check_option(context, table, &table->options[i], own);
    return result;
}

/* ---- Texts ---- */

static bool parse_word(const ty_option* option, const char* text, double* value) {
    for (int32_t i = 0; option->words[i] != NULL; ++i)
        if (strcmp(option->words[i], text) == 0) {
            *value = (int32_t)word_value(option, i);
            return true;
        }
    return false;
}

static bool parse_value(const ty_option* option, const char* text, double* value) {
    if (option->type == TY_OPTION_WORD) return parse_word(option, text, value);
    if (option->type == TY_OPTION_BOOL) {
        *value = strcmp(text, "true") == 0 ? 1 : 0;
        return *value != 0 || strcmp(text, "false") == 0;
    }
    if ((option->flags & TY_OPTION_AUTO) != 0 && strcmp(text, "auto") == 0) {
        *value = TY_AUTO;
        return true;
    }
    const char* end;
    *value = ty_parse_number(text, &end);
    return end != text && *end == '\0' && (option->type != TY_OPTION_INT || *value == floor(*value));
}

/* The present name of an option that was renamed; NULL if there is none. */
static const char* find_renamed(const ty_option_table* table, const char* name) {
    for (int32_t i = 0; i < table->count; ++i)
        if (table->options[i].formerly != NULL && strcmp(table->options[i].formerly, name) == 0)
            return table->options[i].name;
    return NULL;
}

ty_result ty_options_set(ty_context* context, const ty_option_table* table, void* def, const char* key,
                         const char* value) {
    char field[TY_OPTION_TEXT_SIZE];
    snprintf(field, sizeof field, "render.%s.%s", table->name, key);
    const ty_option* option = ty_option_find(table, key);
    const char* renamed = option == NULL ? find_renamed(table, key) : NULL;
    if (renamed != NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: there is no such option; did you mean \"%s\"?", field, renamed);
    if (option == NULL || (option->flags & TY_OPTION_CALLS_ONLY) != 0)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: there is no such option", field);
    if (!ty_option_fits(option, def))
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: the program's def is older than this option", field);
    double number = 0;
    if (!parse_value(option, value, &number))
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: \"%s\" is not one of its values", field, value);
    const bool ranged = option->type != TY_OPTION_WORD && option->type != TY_OPTION_BOOL;
    const bool disguised = (option->flags & TY_OPTION_AUTO) != 0 && number == TY_AUTO && strcmp(value, "auto") != 0;
    if (ranged && (disguised || !is_allowed(option, number)))
        return fail_range(context, field, option, number, "\"auto\"");
    set_number(option, (char*)def + option->offset, 0, number);
    return TY_OK;
}
