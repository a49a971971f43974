/* tyndall: the command line tool. */
#include "cli/commands.h"
#include "cli/options/options.h"
#include "cli/session/ranks.h"

#include <stdio.h>
#include <string.h>

#include <tyndall/base.h>

static int run(int count, char** arguments, bool helps) {
    if (count < 2) {
        if (!helps) cli_print_overview();
        return CLI_USAGE;
    }
    const char* name = arguments[1];
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0) return helps ? CLI_DONE : cli_print_overview();
    if (strcmp(name, "--version") == 0) {
        printf("tyndall %s\n", ty_version());
        return CLI_DONE;
    }
    const cli_command* command = cli_find_command("", name);
    if (command == NULL) return CLI_USAGE;
    return helps && !command->distributed ? CLI_DONE : command->run(count - 2, arguments + 2);
}

int main(int count, char** arguments) {
    cli_start_program();
    const bool helps = cli_ranks_start();
    const int status = run(count, arguments, helps);
    return cli_finish(helps ? cli_ranks_end(status) : status);
}
