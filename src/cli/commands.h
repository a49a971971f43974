/* The commands: each gets the arguments after its name and returns an exit status. */
#ifndef TY_CLI_COMMANDS_H
#define TY_CLI_COMMANDS_H

#include <stdbool.h>

int cli_render(int count, char** arguments);
int cli_info(int count, char** arguments);
int cli_diff(int count, char** arguments);
int cli_denoise(int count, char** arguments);
int cli_merge(int count, char** arguments);
int cli_compare(int count, char** arguments);
int cli_screen(int count, char** arguments);
int cli_convert(int count, char** arguments);
int cli_fluence(int count, char** arguments);
int cli_figure(int count, char** arguments);
int cli_flux(int count, char** arguments);
int cli_bake(int count, char** arguments);
int cli_export(int count, char** arguments);
int cli_unwrap(int count, char** arguments);
int cli_bench(int count, char** arguments);
int cli_view(int count, char** arguments);
int cli_help(int count, char** arguments);

typedef struct cli_command {
    const char* name;
    const char* summary;
    int (*run)(int count, char** arguments);
    bool is_tool;     /* a separate program, which replaces this process */
    bool distributed; /* under mpirun its work is that of all ranks; rank 0 alone runs the others */
} cli_command;

enum { CLI_COMMAND_COUNT = 17 };
extern const cli_command cli_commands[CLI_COMMAND_COUNT];

/* The command of a name; NULL, after a message that lists all commands, if there is none. asker: the name of the
 * calling command for the message, or "". */
const cli_command* cli_find_command(const char* asker, const char* name);
/* True if the program of a command that is a tool is installed. */
bool cli_has_tool(const char* command);
/* Prints the text of `tyndall --help`. */
int cli_print_overview(void);

#endif
