/* Shell completion of the command line, generated from the tables of options. */
#include "cli/options/manual.h"

#include <tyndall/base.h>

#include <string.h>

/* The candidates for an option's value, or with name NULL for an argument. */
typedef enum values { VALUES_NONE, VALUES_FILES, VALUES_WORDS } values;

static values print_choices(FILE* file, const char* choices) {
    for (const char* c = choices; *c != '\0'; ++c) putc(*c == '|' ? ' ' : *c, file);
    return VALUES_WORDS;
}

static values print_values(FILE* file, const cli_syntax* syntax, const cli_option* option) {
    if (option->kind == CLI_CHOICE) return print_choices(file, option->value);
    if (strcmp(option->name, "device") == 0) return print_choices(file, "cpu|host|cuda:0|auto");
    if (option->kind != CLI_TEXT && option->kind != CLI_LIST) return VALUES_NONE;
    const bool words = syntax->print_words != NULL && syntax->print_words(file, option->name);
    return words ? VALUES_WORDS : VALUES_FILES;
}

/* A case of the shell function behind _tyndall: the candidates after an option. */
static void print_option(FILE* file, const cli_syntax* syntax, const cli_option* option) {
    if (option->kind == CLI_FLAG || option->help == NULL) return;
    fputs("    ", file);
    if (option->letter != 0) fprintf(file, "-%c | ", option->letter);
    fprintf(file, "--%s) words='", option->name);
    const values kind = print_values(file, syntax, option);
    fprintf(file, "'%s ;;\n", kind == VALUES_FILES ? " files=yes" : "");
}

static void print_names(FILE* file, const cli_option* options, int count) {
    for (int i = 0; i < count; ++i) {
        if (options[i].help == NULL) continue;
        if (options[i].letter != 0) fprintf(file, "-%c ", options[i].letter);
        fprintf(file, "--%s ", options[i].name);
    }
}

void cli_print_completion(FILE* file, const cli_syntax* syntax) {
    cli_common common;
    cli_option shared[CLI_COMMON_COUNT];
    cli_common_options(&common, shared);
    fprintf(file, "\n_tyndall_%s() {\n    case $1 in\n    options) words='", syntax->command);
    print_names(file, syntax->options, syntax->option_count);
    print_names(file, shared, CLI_COMMON_COUNT);
    fputs("' ;;\n    arguments) words='", file);
    const bool words = syntax->print_words != NULL && syntax->print_words(file, NULL);
    fprintf(file, "'%s ;;\n", words ? "" : " files=yes");
    for (int i = 0; i < syntax->option_count; ++i) print_option(file, syntax, &syntax->options[i]);
    for (int i = 0; i < CLI_COMMON_COUNT; ++i) print_option(file, syntax, &shared[i]);
    fputs("    *) return 1 ;;\n    esac\n}\n", file);
}

void cli_print_completion_start(FILE* file) {
    fprintf(file, "# bash completion of tyndall %s, made by 'tyndall help --completion bash'\n", ty_version());
}

void cli_print_completion_end(FILE* file, cli_words_fn print_commands) {
    fputs("\n"
          "_tyndall() {\n"
          "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} words='' files=''\n"
          "    # The shell takes --name=value for three words.\n"
          "    if [[ $word == = ]]; then\n"
          "        word=''\n"
          "    elif [[ $before == = ]]; then\n"
          "        before=${COMP_WORDS[COMP_CWORD - 2]}\n"
          "    fi\n"
          "    COMPREPLY=()\n"
          "    if ((COMP_CWORD == 1)); then\n"
          "        words='",
          file);
    print_commands(file, NULL);
    fputs("--help --version'\n"
          "    else\n"
          "        local of=_tyndall_${COMP_WORDS[1]}\n"
          "        declare -F \"$of\" > /dev/null || return 0\n"
          "        if [[ $before != -* ]] || ! \"$of\" \"$before\"; then\n"
          "            if [[ $word == -* ]]; then \"$of\" options; else \"$of\" arguments; fi\n"
          "        fi\n"
          "    fi\n"
          "    mapfile -t COMPREPLY < <(\n"
          "        compgen -W \"$words\" -- \"$word\"\n"
          "        [[ -z $files ]] || compgen -f -- \"$word\"\n"
          "    )\n"
          "    [[ -z $files ]] || compopt -o filenames 2> /dev/null\n"
          "    return 0\n"
          "}\n"
          "complete -F _tyndall tyndall\n",
          file);
}
