/* Text files, generated in memory and written atomically. */
#ifndef TY_CLI_TEXT_FILE_H
#define TY_CLI_TEXT_FILE_H

#include <stdio.h>
#include <tyndall/base.h>

/* Prints to a stream; user is as in cli_write_text_file. */
typedef ty_result (*cli_print_fn)(ty_context* context, FILE* file, const void* user);

/* Writes the output of print atomically. Errors: those of print, TY_ERROR_FILE, TY_ERROR_MEMORY. */
ty_result cli_write_text_file(ty_context* context, const char* path, cli_print_fn print, const void* user);

#endif
