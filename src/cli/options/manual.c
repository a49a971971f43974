/* The texts of --help and of manual pages, as plain text, roff and Markdown. */
#include "cli/options/manual.h"
#include "cli/text/text.h"

#include <ctype.h>
#include <string.h>

#include <tyndall/base.h>

const char* const cli_exit_statuses =
    "0: done. 1: failed while running. 2: wrong usage or input. "
    "128 + N: interrupted by signal N (130: Ctrl-C, 143: SIGTERM, 129: SIGHUP); a valid partial result was written "
    "where there can be one, and a second signal ends at once. 141: nobody reads the output any more.";

/* Escapes text for roff: a dash stays the ASCII dash that options are typed with. */
static void print_roff(FILE* file, const char* text) {
    if (*text == '.' || *text == '\'') fputs("\\&", file);
    for (; *text != '\0'; ++text) {
        switch (*text) {
        case '\\': fputs("\\e", file); break;
        case '-': fputs("\\-", file); break;
        case '\'': fputs("\\(aq", file); break;
        case '"': fputs("\\(dq", file); break;
        case '^': fputs("\\(ha", file); break;
        case '~': fputs("\\(ti", file); break;
        case '`': fputs("\\(ga", file); break;
        default: putc(*text, file);
        }
    }
}

static void print_markdown(FILE* file, const char* text) {
    for (; *text != '\0'; ++text) {
        if (strchr("*<`", *text) != NULL) putc('\\', file);
        putc(*text, file);
    }
}

/* Calls print for every line of text, without its newline. */
static void for_lines(const char* text, void (*print)(void* user, const char* line), void* user) {
    char line[1024];
    while (*text != '\0') {
        const size_t length = strcspn(text, "\n");
        snprintf(line, sizeof line, "%.*s", (int)length, text);
        print(user, line);
        text += length + (text[length] == '\n');
    }
}

/* The destination of texts, and the flag for preformatted lines. */
typedef struct text_state {
    FILE* file;
    bool verbatim;
} text_state;

static void print_man_line(void* user, const char* line) {
    text_state* state = user;
    const bool verbatim = line[0] == ' ';
    if (verbatim != state->verbatim) fputs(verbatim ? ".nf\n" : ".fi\n", state->file);
    state->verbatim = verbatim;
    if (line[0] == '\0') {
        fputs(".PP\n", state->file);
        return;
    }
    print_roff(state->file, line);
    putc('\n', state->file);
}

void cli_print_man_text(FILE* file, const char* text) {
    text_state state = {file, false};
    for_lines(text, print_man_line, &state);
    if (state.verbatim) fputs(".fi\n", file);
}

static void print_markdown_line(void* user, const char* line) {
    text_state* state = user;
    const bool verbatim = line[0] == ' ';
    if (verbatim && !state->verbatim) putc('\n', state->file);
    state->verbatim = verbatim;
    if (verbatim)
        fprintf(state->file, "    %s", line);
    else
        print_markdown(state->file, line);
    putc('\n', state->file);
}

void cli_print_man_name(FILE* file, const char* page, const char* summary) {
    char title[64];
    snprintf(title, sizeof title, "tyndall%s%s", page != NULL ? "-" : "", page != NULL ? page : "");
    fputs(".TH ", file);
    for (const char* c = title; *c != '\0'; ++c) putc(toupper((unsigned char)*c), file);
    fprintf(file, " 1 \"\" \"tyndall %s\" \"Tyndall\"\n.SH NAME\n", ty_version());
    print_roff(file, title);
    fputs(" \\- ", file);
    char line[256];
    snprintf(line, sizeof line, "%s", summary);
    line[0] = (char)tolower((unsigned char)line[0]);
    const size_t length = strlen(line);
    if (length > 0 && line[length - 1] == '.') line[length - 1] = '\0';
    print_roff(file, line);
    putc('\n', file);
}

/* "-o, --output FILE" */
static void print_option_text(FILE* file, const cli_option* option) {
    enum { COLUMN = 32 };
    char left[128];
    int used = option->letter != 0 ? snprintf(left, sizeof left, "-%c, ", option->letter) : 0;
    used += snprintf(left + used, sizeof left - (size_t)used, "--%s", option->name);
    if (option->value != NULL) used += snprintf(left + used, sizeof left - (size_t)used, " %s", option->value);
    if (used > COLUMN)
        fprintf(file, "  %s\n  %*s %s\n", left, COLUMN, "", option->help);
    else
        fprintf(file, "  %-*s %s\n", COLUMN, left, option->help);
}

static void print_option_man(FILE* file, const cli_option* option) {
    fputs(".TP\n", file);
    if (option->letter != 0) fprintf(file, "\\fB\\-%c\\fR, ", option->letter);
    fputs("\\fB\\-\\-", file);
    print_roff(file, option->name);
    fputs("\\fR", file);
    if (option->value != NULL) {
        fputs(" \\fI", file);
        print_roff(file, option->value);
        fputs("\\fR", file);
    }
    putc('\n', file);
    print_roff(file, option->help);
    putc('\n', file);
}

static void print_option_markdown(FILE* file, const cli_option* option) {
    fputs("- ", file);
    if (option->letter != 0) fprintf(file, "`-%c`, ", option->letter);
    fprintf(file, "`--%s%s%s`: ", option->name, option->value != NULL ? " " : "",
            option->value != NULL ? option->value : "");
    print_markdown(file, option->help);
    putc('\n', file);
}

void cli_print_options(FILE* file, cli_help_form form, const cli_option* options, int count) {
    static void (*const print[])(FILE*, const cli_option*) = {print_option_text, print_option_man,
                                                              print_option_markdown};
    for (int i = 0; i < count; ++i)
        if (options[i].help != NULL) print[form](file, &options[i]);
}

void cli_print_common_options(FILE* file, cli_help_form form) {
    cli_common common;
    cli_option options[CLI_COMMON_COUNT];
    cli_common_options(&common, options);
    cli_print_options(file, form, options, CLI_COMMON_COUNT);
}

static void print_text(FILE* file, const cli_syntax* syntax) {
    fprintf(file, "usage: tyndall %s %s\n\n%s\n", syntax->command, syntax->usage, syntax->summary);
    if (syntax->details != NULL) fprintf(file, "\n%s\n", syntax->details);
    if (syntax->option_count > 0) fputs("\noptions:\n", file);
    cli_print_options(file, CLI_HELP_TEXT, syntax->options, syntax->option_count);
    fputs("\noptions of all commands:\n", file);
    cli_print_common_options(file, CLI_HELP_TEXT);
}

static void print_man(FILE* file, const cli_syntax* syntax) {
    cli_print_man_name(file, syntax->command, syntax->summary);
    fprintf(file, ".SH SYNOPSIS\n.B tyndall %s\n", syntax->command);
    print_roff(file, syntax->usage);
    fputs("\n.SH DESCRIPTION\n", file);
    cli_print_man_text(file, syntax->summary);
    if (syntax->details != NULL) {
        fputs(".PP\n", file);
        cli_print_man_text(file, syntax->details);
    }
    if (syntax->option_count > 0) fputs(".SH OPTIONS\n", file);
    cli_print_options(file, CLI_HELP_MAN, syntax->options, syntax->option_count);
    fputs(".SH OPTIONS OF ALL COMMANDS\n", file);
    cli_print_common_options(file, CLI_HELP_MAN);
    fputs(".SH EXIT STATUS\n", file);
    cli_print_man_text(file, cli_exit_statuses);
    fputs(".SH SEE ALSO\n.BR tyndall (1)\n", file);
}

/* The common options appear once on the page, and not here. */
static void print_section(FILE* file, const cli_syntax* syntax) {
    fprintf(file, "\n## tyndall %s\n\n", syntax->command);
    print_markdown(file, syntax->summary);
    fprintf(file, "\n\n    tyndall %s %s\n", syntax->command, syntax->usage);
    if (syntax->details != NULL) {
        putc('\n', file);
        text_state state = {file, false};
        for_lines(syntax->details, print_markdown_line, &state);
    }
    if (syntax->option_count > 0) putc('\n', file);
    cli_print_options(file, CLI_HELP_MARKDOWN, syntax->options, syntax->option_count);
}

typedef struct page {
    const cli_syntax* syntax;
    cli_help_form form;
} page;

static ty_result print_page(ty_context* context, FILE* file, const void* user) {
    static void (*const print[])(FILE*, const cli_syntax*) = {print_text, print_man, print_section,
                                                              cli_print_completion};
    (void)context;
    const page* what = user;
    print[what->form](file, what->syntax);
    return TY_OK;
}

int cli_write_page(const char* path, cli_print_fn print, const void* user) {
    const ty_context_def def = ty_default_context_def();
    ty_context* context = NULL;
    if (path == NULL) {
        print(NULL, stdout, user); // the end of the program checks stdout for errors
        return CLI_DONE;
    }
    ty_result result = ty_context_create(&def, &context);
    if (result == TY_OK) result = cli_write_text_file(context, path, print, user);
    const char* message = ty_take_error(context);
    if (result != TY_OK) cli_print_message(message[0] != '\0' ? message : ty_result_text(result));
    ty_context_destroy(context);
    return result == TY_OK ? CLI_DONE : CLI_FAILED;
}

int cli_print_help(const cli_syntax* syntax, cli_help_form form, const char* path) {
    const page what = {syntax, form};
    return cli_write_page(path, print_page, &what);
}
