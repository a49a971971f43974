/* Help texts of the methods' options. */
#include "cli/methods/method_help.h"
#include "cli/options/manual.h"
#include "cli/methods/methods.h"

#include <stdint.h>
#include <string.h>

/* Calls print for every table of options once. */
static void for_tables(FILE* file, void (*print)(FILE* file, const ty_option_table* table)) {
    const char* method;
    const ty_option_table* before = NULL;
    for (int32_t i = 0;; ++i) {
        const ty_option_table* table = ty_method_options_at(i, &method);
        if (method == NULL) return;
        if (table != NULL && table != before) print(file, table);
        before = table;
    }
}

/* "8..1024", "between 0 and 1", "at least 1". */
static void print_range(FILE* file, const ty_option* option) {
    char min[TY_OPTION_TEXT_SIZE], max[TY_OPTION_TEXT_SIZE];
    const uint32_t open = option->flags & TY_OPTION_OPEN;
    ty_option_text(option, option->min, min);
    ty_option_text(option, option->max, max);
    if (option->max >= INT32_MAX)
        fprintf(file, "%s %s", open != 0 ? "above" : "at least", min);
    else if (open == TY_OPTION_OPEN)
        fprintf(file, "between %s and %s", min, max);
    else if (open == TY_OPTION_OPEN_MIN)
        fprintf(file, "above %s, at most %s", min, max);
    else if (option->multiple != 0)
        for (double value = option->min; value <= option->max; value += option->multiple)
            fprintf(file, "%s%g", value > option->min ? ", " : "", value);
    else
        fprintf(file, "%s..%s", min, max);
}

/* mark: the text around words, which Markdown sets as code. */
static void print_values(FILE* file, const ty_option* option, const char* mark) {
    if (option->type == TY_OPTION_BOOL) fprintf(file, "%strue%s, %sfalse%s", mark, mark, mark, mark);
    if (option->type == TY_OPTION_WORD)
        for (int32_t i = 0; option->words[i] != NULL; ++i)
            fprintf(file, "%s%s\"%s\"%s", i > 0 ? ", " : "", mark, option->words[i], mark);
    if (option->type == TY_OPTION_BOOL || option->type == TY_OPTION_WORD) return;
    if ((option->flags & TY_OPTION_AUTO) != 0) fprintf(file, "%s\"auto\"%s, ", mark, mark);
    if ((option->flags & TY_OPTION_OR_ZERO) != 0) fputs("0, ", file);
    print_range(file, option);
    if (option->unit != NULL) fprintf(file, " %s", option->unit);
}

static void print_default(FILE* file, const ty_option* option, const char* mark) {
    char text[TY_OPTION_TEXT_SIZE];
    ty_option_text(option, option->preset, text);
    const bool quoted = option->type == TY_OPTION_WORD || strcmp(text, "auto") == 0;
    const bool marked = quoted || option->type == TY_OPTION_BOOL;
    fprintf(file, "%s%s%s%s%s", marked ? mark : "", quoted ? "\"" : "", text, quoted ? "\"" : "", marked ? mark : "");
}

static bool is_key(const ty_option* option) {
    return (option->flags & TY_OPTION_CALLS_ONLY) == 0;
}

static void print_man_table(FILE* file, const ty_option_table* table) {
    for (int32_t i = 0; i < table->count; ++i) {
        const ty_option* option = &table->options[i];
        if (!is_key(option)) continue;
        fprintf(file, ".TP\n.B render.%s.%s\n", table->name, option->name);
        cli_print_man_text(file, option->doc);
        fputs("Values: ", file);
        print_values(file, option, "");
        fputs("; default ", file);
        print_default(file, option, "");
        fputs(".\n", file);
    }
}

void cli_print_man_options(FILE* file) {
    fputs(".SH OPTIONS OF METHODS\n", file);
    cli_print_man_text(file, "Keys of scene files, which -D of 'tyndall render' and other commands sets, too.");
    for_tables(file, print_man_table);
}

static void print_keys(FILE* file, const ty_option_table* table) {
    for (int32_t i = 0; i < table->count; ++i)
        if (is_key(&table->options[i])) fprintf(file, "render.%s.%s ", table->name, table->options[i].name);
}

void cli_print_option_keys(FILE* file) {
    for_tables(file, print_keys);
}

int cli_print_option_table(const char* name) {
    const ty_method* method = cli_find_method("help", name);
    if (method == NULL) return CLI_USAGE;
    if (method->options == NULL) return cli_usage_error("help", "the method %s has no options", name);
    const ty_option_table* table = method->options;
    printf("| key of `render.%s` | values | default | |\n|---|---|---|---|\n", table->name);
    for (int32_t i = 0; i < table->count; ++i) {
        const ty_option* option = &table->options[i];
        if (!is_key(option)) continue;
        printf("| `%s` | ", option->name);
        print_values(stdout, option, "`");
        fputs(" | ", stdout);
        print_default(stdout, option, "`");
        printf(" | %s |\n", option->doc);
    }
    return CLI_DONE;
}
