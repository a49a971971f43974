/* Text files, generated in memory and written atomically. */
#ifndef TY_CLI_TEXT_TEXT_FILE_H
#define TY_CLI_TEXT_TEXT_FILE_H

#include <stdio.h>
#include <tyndall/base.h>

/* Text that is printed into memory, in place of open_memstream, which loses text silently where memory runs out. */
typedef struct cli_text {
    char* bytes; /* ends in a zero byte */
    size_t size, capacity;
    bool failed;
    FILE* file; /* to print to */
} cli_text;

/* False: no memory. A successful open is followed by exactly one close. */
bool cli_text_open(cli_text* text);
/* The text, of text->size bytes, which the caller frees; NULL if any of it was lost. */
char* cli_text_close(cli_text* text);

/* Prints to a stream; user is as in cli_write_text_file. */
typedef ty_result (*cli_print_fn)(ty_context* context, FILE* file, const void* user);

/* Writes the output of print atomically. Errors: those of print, TY_ERROR_FILE, TY_ERROR_MEMORY. */
ty_result cli_write_text_file(ty_context* context, const char* path, cli_print_fn print, const void* user);

#endif
