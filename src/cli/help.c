/* tyndall help: help of commands as text, manual pages or one page of Markdown, and shell completion, all generated
 * from the tables of options. */
#define _POSIX_C_SOURCE 200809L
#include "cli/commands.h"
#include "cli/options/manual.h"
#include "cli/methods/method_help.h"
#include "cli/session/session.h"

#include <errno.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static const char* const summary = "light in fog, smoke, clouds, milk and water";

static ty_result print_overview(ty_context* context, FILE* file, const void* user) {
    (void)context;
    (void)user;
    fprintf(file, "tyndall %s: %s\n\nusage: tyndall COMMAND ...\n\ncommands:\n", ty_version(), summary);
    for (int i = 0; i < CLI_COMMAND_COUNT; ++i)
        fprintf(file, "  %-10s %s\n", cli_commands[i].name, cli_commands[i].summary);
    fputs("\noptions of all commands:\n", file);
    cli_print_common_options(file, CLI_HELP_TEXT);
    fputs("\nTo begin: 'tyndall render builtin:demo -o demo.png'. 'tyndall help COMMAND' tells more.\n"
          "Exit status: 0 done, 1 failed while running, 2 wrong usage or input, 128 + N interrupted\n"
          "by signal N, 130 by Ctrl-C (a valid partial result was written).\n",
          file);
    return TY_OK;
}

int cli_print_overview(void) {
    return cli_write_page(NULL, print_overview, NULL);
}

/* Pages and completion leave out a tool that is not installed. */
static bool is_listed(const cli_command* command) {
    return !command->is_tool || cli_has_tool(command->name);
}

static ty_result print_man(ty_context* context, FILE* file, const void* user) {
    (void)context;
    (void)user;
    cli_print_man_name(file, NULL, summary);
    fputs(".SH SYNOPSIS\n.B tyndall\n\\fICOMMAND\\fR [\\fIARGUMENT\\fR ...]\n.SH COMMANDS\n", file);
    for (int i = 0; i < CLI_COMMAND_COUNT; ++i) {
        if (!is_listed(&cli_commands[i])) continue;
        fprintf(file, ".TP\n.BR tyndall\\-%s (1)\n", cli_commands[i].name);
        cli_print_man_text(file, cli_commands[i].summary);
    }
    fputs(".SH OPTIONS OF ALL COMMANDS\n", file);
    cli_print_common_options(file, CLI_HELP_MAN);
    fputs(".SH ENVIRONMENT\n.TP\n.B TYNDALL_DATA\n", file);
    cli_print_man_text(file, "The folder of third-party data that 'figure' and 'bench' read, without --data.");
    fputs(".TP\n.B XDG_CACHE_HOME\n", file);
    cli_print_man_text(file, "Where 'bake' keeps tables between runs, in a folder tyndall; else ~/.cache.");
    cli_print_man_options(file);
    fputs(".SH EXIT STATUS\n", file);
    cli_print_man_text(file, cli_exit_statuses);
    return TY_OK;
}

/* Runs a command in a child process, because a tool replaces its process. */
static int run_in_child(const cli_command* command, int count, char** arguments) {
    int status = 0;
    fflush(stdout);
    const pid_t child = fork();
    if (child == 0) _exit(command->run(count, arguments));
    if (child < 0 || waitpid(child, &status, 0) != child || !WIFEXITED(status))
        return cli_fail(CLI_FAILED, "cannot run tyndall-%s: %s", command->name, strerror(errno));
    return WEXITSTATUS(status);
}

/* A command's own help, in a form, to a file or to stdout. */
static int help_of(const cli_command* command, const char* form, const char* path) {
    char help[] = "--help", as[] = "--help-as", word[16], to[] = "--help-to";
    snprintf(word, sizeof word, "%s", form);
    char* list[] = {help, as, word, to, (char*)path};
    const int count = path != NULL ? 5 : 3;
    return command->is_tool ? run_in_child(command, count, list) : command->run(count, list);
}

static int write_man_pages(const char* folder) {
    char path[4096];
    int status = cli_make_folder("help", folder);
    if (status != CLI_GO) return status;
    if (strlen(folder) > sizeof path - 64) return cli_usage_error("help", "--man: the folder's name is too long");
    snprintf(path, sizeof path, "%s/tyndall.1", folder);
    status = cli_write_page(path, print_man, NULL);
    for (int i = 0; status == CLI_DONE && i < CLI_COMMAND_COUNT; ++i) {
        if (!is_listed(&cli_commands[i])) continue;
        snprintf(path, sizeof path, "%s/tyndall-%s.1", folder, cli_commands[i].name);
        status = help_of(&cli_commands[i], "man", path);
    }
    return status;
}

static int print_markdown(void) {
    fputs("# Commands\n\n"
          "The text of `tyndall help COMMAND` for each, from the tables that options are parsed by. Made by\n"
          "`tyndall help --markdown > docs/commands.md`; `ctest -R test_cli_help` fails where it is not what the "
          "program says.\n\n"
          "## Options of all commands\n\n",
          stdout);
    cli_print_common_options(stdout, CLI_HELP_MARKDOWN);
    printf("\nExit status: %s\n", cli_exit_statuses);
    int status = CLI_DONE;
    for (int i = 0; status == CLI_DONE && i < CLI_COMMAND_COUNT; ++i)
        if (is_listed(&cli_commands[i])) status = help_of(&cli_commands[i], "markdown", NULL);
    return status;
}

static bool print_words(FILE* file, const char* option) {
    if (option != NULL && strcmp(option, "options") == 0) {
        for (int i = 0; ty_method_name(i) != NULL; ++i) fprintf(file, "%s ", ty_method_name(i));
        return true;
    }
    if (option != NULL) return false;
    for (int i = 0; i < CLI_COMMAND_COUNT; ++i) fprintf(file, "%s ", cli_commands[i].name);
    return true;
}

static int print_completion(void) {
    int status = CLI_DONE;
    cli_print_completion_start(stdout);
    for (int i = 0; status == CLI_DONE && i < CLI_COMMAND_COUNT; ++i)
        if (is_listed(&cli_commands[i])) status = help_of(&cli_commands[i], "completion", NULL);
    cli_print_completion_end(stdout, print_words);
    return status;
}

static int print_schema(void) {
    const char* text = ty_scene_schema();
    if (text == NULL) return cli_fail(CLI_FAILED, "not enough memory");
    puts(text);
    return CLI_DONE;
}

int cli_help(int count, char** arguments) {
    const char *man = NULL, *options = NULL;
    bool markdown = false, completion = false, schema = false;
    int shell = 0;
    const cli_option table[] = {
        {"man", 0, CLI_TEXT, "DIR", "write manual pages, tyndall.1 and one a command, into this folder", &man, 0, 0,
         NULL},
        {"markdown", 0, CLI_FLAG, NULL, "print all commands as one page of Markdown", &markdown, 0, 0, NULL},
        {"completion", 0, CLI_CHOICE, "bash", "print a script that completes commands and options in this shell",
         &shell, 0, 0, &completion},
        {"schema", 0, CLI_FLAG, NULL, "print the JSON Schema of scene files, for editors", &schema, 0, 0, NULL},
        {"options", 0, CLI_TEXT, "METHOD", "print the options of a method as a table of Markdown", &options, 0, 0,
         NULL},
    };
    const cli_syntax syntax = {
        "help",
        "[COMMAND] | --man DIR | --markdown | --completion bash | --schema | --options METHOD",
        "Tells what a command does.",
        "Without arguments it lists the commands. 'tyndall COMMAND --help' is the same as\n"
        "'tyndall help COMMAND'. 'source <(tyndall help --completion bash)' makes a shell complete what is typed.",
        table,
        sizeof table / sizeof table[0],
        0,
        1,
        print_words};
    cli_arguments given;
    const int status = cli_parse(&syntax, count, arguments, &given);
    if (status != CLI_GO) return status;
    const int forms = (man != NULL) + (options != NULL) + (markdown ? 1 : 0) + (completion ? 1 : 0) + (schema ? 1 : 0);
    if (forms + given.positional_count > 1)
        return cli_usage_error("help",
                               "give a command, --man, --markdown, --completion, --schema or --options, one of them");
    if (man != NULL) return write_man_pages(man);
    if (markdown) return print_markdown();
    if (completion) return print_completion();
    if (schema) return print_schema();
    if (options != NULL) return cli_print_option_table(options);
    if (given.positional_count == 0) return cli_print_overview();
    const cli_command* command = cli_find_command("help", given.positional[0]);
    return command != NULL ? help_of(command, "text", NULL) : CLI_USAGE;
}
