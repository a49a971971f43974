/* Text files, generated in memory and written atomically. */
#define _POSIX_C_SOURCE 200809L
#include "cli/text_file.h"

#include <stdlib.h>
#include <tyndall/io.h>

ty_result cli_write_text_file(ty_context* context, const char* path, cli_print_fn print, const void* user) {
    char* text = NULL;
    size_t size = 0;
    FILE* file = open_memstream(&text, &size);
    if (file == NULL) return TY_ERROR_MEMORY;
    ty_result result = print(context, file, user);
    const bool complete = ferror(file) == 0;
    if ((fclose(file) != 0 || !complete) && result == TY_OK) result = TY_ERROR_MEMORY;
    if (result == TY_OK) result = ty_bytes_write(context, path, text, size);
    free(text);
    return result;
}
