/* tyndall help: what commands do, as text, manual pages or one page of Markdown, and what completes them in a shell,
 * all from the tables that options are parsed by. */
#define _POSIX_C_SOURCE 200809L
#include "cli/commands.h"
#include "cli/manual.h"
#include "cli/session.h"

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
          "Exit status: 0 done, 1 failed while running, 2 wrong usage or input, 130 interrupted (a valid\n"
          "partial result was written).\n",
          file);
    return TY_OK;
}

int cli_print_overview(void) {
    return cli_write_page(NULL, print_overview, NULL);
}

/* Pages and completion leave out a tool that is not installed. */
static bool is_told(const cli_command* command) {
    return !command->is_tool || cli_has_tool(command->name);
}

static ty_result print_man(ty_context* context, FILE* file, const void* user) {
    (void)context;
    (void)user;
    cli_print_man_name(file, NULL, summary);
    fputs(".SH SYNOPSIS\n.B tyndall\n\\fICOMMAND\\fR [\\fIARGUMENT\\fR ...]\n.SH COMMANDS\n", file);
    for (int i = 0; i < CLI_COMMAND_COUNT; ++i) {
        if (!is_told(&cli_commands[i])) continue;
        fprintf(file, ".TP\n.BR tyndall\\-%s (1)\n", cli_commands[i].name);
        cli_print_man_text(file, cli_commands[i].summary);
    }
    fputs(".SH OPTIONS OF ALL COMMANDS\n", file);
    cli_print_common_options(file, CLI_HELP_MAN);
    fputs(".SH ENVIRONMENT\n.TP\n.B TYNDALL_DATA\n", file);
    cli_print_man_text(file, "The folder of third-party data that 'figure' and 'bench' read, without --data.");
    fputs(".TP\n.B XDG_CACHE_HOME\n", file);
    cli_print_man_text(file, "Where 'bake' keeps tables between runs, in a folder tyndall; else ~/.cache.");
    fputs(".SH EXIT STATUS\n", file);
    cli_print_man_text(file, cli_exit_statuses);
    return TY_OK;
}

/* Runs a command in a process of its own, since a tool takes the place of this one. */
static int run_apart(const cli_command* command, int count, char** arguments) {
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
    return command->is_tool ? run_apart(command, count, list) : command->run(count, list);
}

static int write_man_pages(const char* folder) {
    char path[4096];
    int status = cli_make_folder("help", folder);
    if (status != CLI_GO) return status;
    if (strlen(folder) > sizeof path - 64) return cli_usage_error("help", "--man: the folder's name is too long");
    snprintf(path, sizeof path, "%s/tyndall.1", folder);
    status = cli_write_page(path, print_man, NULL);
    for (int i = 0; status == CLI_DONE && i < CLI_COMMAND_COUNT; ++i) {
        if (!is_told(&cli_commands[i])) continue;
        snprintf(path, sizeof path, "%s/tyndall-%s.1", folder, cli_commands[i].name);
        status = help_of(&cli_commands[i], "man", path);
    }
    return status;
}

static int print_markdown(void) {
    fputs("# Commands\n\n"
          "What `tyndall help COMMAND` says of each, from the tables that options are parsed by. Made by\n"
          "`tyndall help --markdown > docs/commands.md`; `ctest -R test_cli_help` fails where it is not what the "
          "program says.\n\n"
          "## Options of all commands\n\n",
          stdout);
    cli_print_common_options(stdout, CLI_HELP_MARKDOWN);
    printf("\nExit status: %s\n", cli_exit_statuses);
    int status = CLI_DONE;
    for (int i = 0; status == CLI_DONE && i < CLI_COMMAND_COUNT; ++i)
        if (is_told(&cli_commands[i])) status = help_of(&cli_commands[i], "markdown", NULL);
    return status;
}

static bool print_words(FILE* file, const char* option) {
    if (option != NULL) return false;
    for (int i = 0; i < CLI_COMMAND_COUNT; ++i) fprintf(file, "%s ", cli_commands[i].name);
    return true;
}

static int print_completion(void) {
    int status = CLI_DONE;
    cli_print_completion_start(stdout);
    for (int i = 0; status == CLI_DONE && i < CLI_COMMAND_COUNT; ++i)
        if (is_told(&cli_commands[i])) status = help_of(&cli_commands[i], "completion", NULL);
    cli_print_completion_end(stdout, print_words);
    return status;
}

int cli_help(int count, char** arguments) {
    const char* man = NULL;
    bool markdown = false, completion = false;
    int shell = 0;
    const cli_option table[] = {
        {"man", 0, CLI_TEXT, "DIR", "write manual pages, tyndall.1 and one a command, into this folder", &man, 0, 0,
         NULL},
        {"markdown", 0, CLI_FLAG, NULL, "print all commands as one page of Markdown", &markdown, 0, 0, NULL},
        {"completion", 0, CLI_CHOICE, "bash", "print a script that completes commands and options in this shell",
         &shell, 0, 0, &completion},
    };
    const cli_syntax syntax = {
        "help",
        "[COMMAND] | --man DIR | --markdown | --completion bash",
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
    if ((man != NULL) + (markdown ? 1 : 0) + (completion ? 1 : 0) + given.positional_count > 1)
        return cli_usage_error("help", "give a command, --man, --markdown or --completion, one of them");
    if (man != NULL) return write_man_pages(man);
    if (markdown) return print_markdown();
    if (completion) return print_completion();
    if (given.positional_count == 0) return cli_print_overview();
    const cli_command* command = cli_find_command("help", given.positional[0]);
    return command != NULL ? help_of(command, "text", NULL) : CLI_USAGE;
}
