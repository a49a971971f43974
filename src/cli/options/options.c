/* Parsing the command line. */
#include "cli/options/options.h"
#include "cli/options/manual.h"
#include "cli/text/text.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <tyndall/base.h>

enum { WORD_MAX = 64, CANDIDATES_MAX = 64 };

int cli_usage_error(const char* command, const char* format, ...) {
    char text[1024], line[1152];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (cli_keeps_messages()) {
        cli_print_message(text);
        return CLI_USAGE;
    }
    snprintf(line, sizeof line, "%s (see 'tyndall %s%s--help')", text, command, command[0] == '\0' ? "" : " ");
    cli_print_message(line);
    return CLI_USAGE;
}

/* Optimal string alignment: insertions, deletions, substitutions and swaps of neighbours. */
static int edit_distance(const char* a, const char* b) {
    const int na = (int)strlen(a), nb = (int)strlen(b);
    if (na > WORD_MAX || nb > WORD_MAX) return WORD_MAX;
    int rows[3][WORD_MAX + 1];
    int *before = rows[0], *last = rows[1], *row = rows[2];
    for (int j = 0; j <= nb; ++j) last[j] = j;
    for (int i = 1; i <= na; ++i) {
        row[0] = i;
        for (int j = 1; j <= nb; ++j) {
            int best = last[j - 1] + (a[i - 1] != b[j - 1]);
            if (last[j] + 1 < best) best = last[j] + 1;
            if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] && before[j - 2] + 1 < best)
                best = before[j - 2] + 1;
            row[j] = best;
        }
        int* const reused = before;
        before = last;
        last = row;
        row = reused;
    }
    return last[nb];
}

const char* cli_nearest(const char* text, const char* const* words, int count) {
    int best_distance = (int)strlen(text) / 3;
    if (best_distance < 1) best_distance = 1;
    const char* best = NULL;
    for (int i = 0; i < count; ++i) {
        const int distance = edit_distance(text, words[i]);
        if (distance < best_distance || (distance == best_distance && best == NULL)) {
            best_distance = distance;
            best = words[i];
        }
    }
    return best;
}

static bool is_number_start(const char* text) {
    return (text[0] >= '0' && text[0] <= '9') || ((text[0] == '-' || text[0] == '.') && text[1] != '\0');
}

static bool parse_int(const char* text, int64_t* out) {
    if (!is_number_start(text) || text[0] == '.') return false;
    char* end = NULL;
    errno = 0;
    const long long value = strtoll(text, &end, 10);
    if (errno != 0 || *end != '\0') return false;
    *out = value;
    return true;
}

int cli_parse_part(const char* command, const char* text, int32_t part[2]) {
    char rest;
    int index, count;
    if (sscanf(text, "%9d/%9d%c", &index, &count, &rest) != 2 || count < 1 || index < 1 || index > count)
        return cli_usage_error(command, "--part: '%s' is not a part like 1/8, from 1/8 to 8/8", text);
    part[0] = index;
    part[1] = count;
    return CLI_GO;
}

bool cli_parse_real(const char* text, double* out) {
    if (!is_number_start(text) || strpbrk(text, "xX") != NULL) return false;
    char* end = NULL;
    const double value = strtod(text, &end);
    if (*end != '\0' || !isfinite(value)) return false;
    *out = value;
    return true;
}

bool cli_parse_seed(const char* text, uint64_t* out) {
    if (text[0] < '0' || text[0] > '9') return false;
    char* end = NULL;
    errno = 0;
    const unsigned long long value = strtoull(text, &end, 10);
    if (errno != 0 || *end != '\0') return false;
    *out = value;
    return true;
}

static bool parse_size(const char* text, int32_t out[2]) {
    char width[8];
    const char* const x = strchr(text, 'x');
    if (x == NULL || x == text || (size_t)(x - text) >= sizeof width) return false;
    memcpy(width, text, (size_t)(x - text));
    width[x - text] = '\0';
    int64_t sides[2];
    if (!parse_int(width, &sides[0]) || !parse_int(x + 1, &sides[1])) return false;
    for (int i = 0; i < 2; ++i) {
        if (sides[i] < 1 || sides[i] > 65536) return false;
        out[i] = (int32_t)sides[i];
    }
    return true;
}

/* Parses "10,20,64x48": x, y, width, height. */
static bool parse_crop(const char* text, int32_t out[4]) {
    for (int i = 0; i < 2; ++i) {
        char number[8];
        const size_t length = strcspn(text, ",");
        int64_t value = 0;
        if (text[length] != ',' || length >= sizeof number) return false;
        memcpy(number, text, length);
        number[length] = '\0';
        if (!parse_int(number, &value) || value < 0 || value > 65536) return false;
        out[i] = (int32_t)value;
        text += length + 1;
    }
    return parse_size(text, out + 2);
}

int cli_find_choice(const char* choices, const char* text) {
    const size_t length = strlen(text);
    int index = 0;
    for (const char* word = choices; word != NULL; ++index) {
        const size_t size = strcspn(word, "|");
        if (size == length && memcmp(word, text, size) == 0) return index;
        word = word[size] == '|' ? word + size + 1 : NULL;
    }
    return -1;
}

int cli_set_option(const char* command, const cli_option* option, const char* text) {
    switch (option->kind) {
    case CLI_FLAG: *(bool*)option->target = true; break;
    case CLI_TEXT:
        if (text[0] == '\0') return cli_usage_error(command, "--%s needs a %s", option->name, option->value);
        *(const char**)option->target = text;
        break;
    case CLI_LIST: {
        cli_list* list = option->target;
        if (list->count == CLI_LIST_MAX)
            return cli_usage_error(command, "--%s is given more than %d times", option->name, CLI_LIST_MAX);
        list->items[list->count++] = text;
        break;
    }
    case CLI_INT: {
        int64_t value = 0;
        if (!parse_int(text, &value) || (double)value < option->lower || (double)value > option->upper)
            return cli_usage_error(command, "--%s: '%s' is not a whole number from %.0f to %.0f", option->name, text,
                                   option->lower, option->upper);
        *(int32_t*)option->target = (int32_t)value;
        break;
    }
    case CLI_SEED:
        if (!cli_parse_seed(text, option->target))
            return cli_usage_error(command, "--%s: '%s' is not a whole number from 0 to %" PRIu64, option->name, text,
                                   UINT64_MAX);
        break;
    case CLI_REAL: {
        double value = 0;
        if (!cli_parse_real(text, &value) || value < option->lower || value > option->upper)
            return cli_usage_error(command, "--%s: '%s' is not a number from %g to %g", option->name, text,
                                   option->lower, option->upper);
        *(double*)option->target = value;
        break;
    }
    case CLI_SIZE:
        if (!parse_size(text, option->target))
            return cli_usage_error(command, "--%s: '%s' is not a size like 800x600 (sides 1 to 65536)", option->name,
                                   text);
        break;
    case CLI_CROP:
        if (!parse_crop(text, option->target))
            return cli_usage_error(command, "--%s: '%s' is not a part of the frame like 10,20,64x48 (X,Y,WxH)",
                                   option->name, text);
        break;
    case CLI_CHOICE: {
        const int choice = cli_find_choice(option->value, text);
        if (choice < 0) return cli_usage_error(command, "--%s: '%s' is none of %s", option->name, text, option->value);
        *(int*)option->target = choice;
        break;
    }
    }
    if (option->given != NULL) *option->given = true;
    return CLI_GO;
}

/* A table of the options of a command and the common options. */
typedef struct table {
    const cli_option* own;
    int own_count;
    cli_option common[CLI_COMMON_COUNT];
} table;

static int table_count(const table* all) {
    return all->own_count + CLI_COMMON_COUNT;
}

static const cli_option* table_at(const table* all, int index) {
    return index < all->own_count ? &all->own[index] : &all->common[index - all->own_count];
}

static const cli_option* find_long(const table* all, const char* name, size_t length) {
    for (int i = 0; i < table_count(all); ++i) {
        const cli_option* option = table_at(all, i);
        if (strlen(option->name) == length && memcmp(option->name, name, length) == 0) return option;
    }
    return NULL;
}

static const cli_option* find_letter(const table* all, char letter) {
    for (int i = 0; i < table_count(all); ++i)
        if (table_at(all, i)->letter == letter) return table_at(all, i);
    return NULL;
}

static int unknown_option(const char* command, const table* all, const char* name, size_t length) {
    char word[WORD_MAX];
    const char* candidates[CANDIDATES_MAX];
    int count = 0;
    for (int i = 0; i < table_count(all) && count < CANDIDATES_MAX; ++i)
        if (table_at(all, i)->help != NULL) candidates[count++] = table_at(all, i)->name;
    snprintf(word, sizeof word, "%.*s", (int)(length < sizeof word ? length : sizeof word - 1), name);
    const char* nearest = cli_nearest(word, candidates, count);
    if (nearest != NULL) return cli_usage_error(command, "unknown option --%s; did you mean --%s?", word, nearest);
    return cli_usage_error(command, "unknown option --%s", word);
}

/* Parses one option at arguments[*index], with its value there or in the next argument. */
static int parse_option(const char* command, const table* all, int count, char** arguments, int* index) {
    const char* text = arguments[*index];
    const cli_option* option = NULL;
    const char* value = NULL;
    if (text[1] == '-') {
        const size_t length = strcspn(text + 2, "=");
        option = find_long(all, text + 2, length);
        if (option == NULL) return unknown_option(command, all, text + 2, length);
        if (text[2 + length] == '=') value = text + 3 + length;
        if (option->kind == CLI_FLAG && value != NULL)
            return cli_usage_error(command, "--%s takes no value", option->name);
    } else {
        option = find_letter(all, text[1]);
        if (option == NULL) return cli_usage_error(command, "unknown option -%c", text[1]);
        if (text[2] != '\0') value = text + 2;
        if (option->kind == CLI_FLAG && value != NULL) return cli_usage_error(command, "unknown option %s", text);
    }
    if (option->kind != CLI_FLAG && value == NULL) {
        if (*index + 1 >= count) return cli_usage_error(command, "--%s needs a %s", option->name, option->value);
        value = arguments[++*index];
    }
    return cli_set_option(command, option, value);
}

int cli_parse(const cli_syntax* syntax, int count, char** arguments, cli_arguments* out) {
    *out = (cli_arguments){0};
    table all = {.own = syntax->options, .own_count = syntax->option_count};
    cli_common_options(&out->common, all.common);
    bool only_positional = false;
    for (int i = 0; i < count; ++i) {
        const char* text = arguments[i];
        if (!only_positional && strcmp(text, "--") == 0) {
            only_positional = true;
        } else if (!only_positional && text[0] == '-' && text[1] != '\0') {
            const int status = parse_option(syntax->command, &all, count, arguments, &i);
            if (status != CLI_GO) return status;
        } else {
            if (out->positional_count == syntax->positional_most)
                return cli_usage_error(syntax->command, "'%s' is one argument too many", text);
            out->positional[out->positional_count++] = text;
        }
    }
    if (out->common.help) return cli_print_help(syntax, out->common.help_as, out->common.help_to);
    if (out->common.version) {
        printf("tyndall %s\n", ty_version());
        return CLI_DONE;
    }
    if (out->positional_count < syntax->positional_least)
        return cli_usage_error(syntax->command, "expected: tyndall %s %s", syntax->command, syntax->usage);
    return CLI_GO;
}
