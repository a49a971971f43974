/* The program tyndall, for what runs it as a process of its own. */
#ifndef TY_BENCH_COMMAND_H
#define TY_BENCH_COMMAND_H

enum { BENCH_COMMAND_SIZE = 4096 };

/* The path of the program beside this one, as in a build, or where an installation has it; else its name. */
void bench_find_command(char out[BENCH_COMMAND_SIZE]);

#endif
