/* The commands: each gets the arguments after its name and returns an exit status. */
#ifndef TY_CLI_COMMANDS_H
#define TY_CLI_COMMANDS_H

int cli_render(int count, char** arguments);
int cli_info(int count, char** arguments);
int cli_diff(int count, char** arguments);
int cli_merge(int count, char** arguments);
int cli_compare(int count, char** arguments);
int cli_screen(int count, char** arguments);
int cli_convert(int count, char** arguments);
int cli_figure(int count, char** arguments);
int cli_bake(int count, char** arguments);
int cli_bench(int count, char** arguments);

#endif
