/* Signals and standard streams: interruption by the user, closed streams, and what a terminal or shell sends. */
#ifndef TY_CLI_SESSION_SIGNALS_H
#define TY_CLI_SESSION_SIGNALS_H

#include <stdbool.h>

/* Prepares a program, first of all: descriptors 0 to 2 that are closed are opened, so that no file gets their numbers
 * and progress text with it, in a way that makes printing fail. Writing to a closed pipe, or past the limit on the size
 * of files, becomes an error of the call instead of a signal. */
void cli_start_program(void);

/* Ends the program with status 2 and one line where a mapped file cannot be read any more, because it became shorter or
 * its disk failed (SIGBUS). */
void cli_catch_lost_files(void);

/* Installs handlers: SIGINT, SIGTERM and, unless it is ignored as under nohup, SIGHUP cancel the running work; a second
 * signal ends the program at once. The exit status is 128 + the signal's number. */
void cli_catch_interrupts(void);
/* True while there is nothing to keep, such as when inputs are read: the first signal ends the program at once, after
 * one line. The default is false. */
void cli_end_on_interrupt(bool at_once);
/* An end at once says nothing from here on: another process does. */
void cli_silence_interrupts(void);
bool cli_interrupted(void);

/* Name of the signal that interrupted, "SIGTERM", and the exit status that belongs to it; those of SIGINT without one.
 */
const char* cli_interrupt_name(void);
int cli_interrupt_status(void);

/* A file to remove if a signal ends the program at once; NULL: none. The text stays the caller's. */
void cli_remove_on_interrupt(const char* path);

#endif
