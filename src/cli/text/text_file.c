/* Text printed into memory, and text files, which are written atomically. */
#define _GNU_SOURCE
#include "cli/text/text_file.h"

#include "io/file.h"

#include <stdlib.h>
#include <string.h>

static ssize_t append(void* user, const char* bytes, size_t size) {
    cli_text* text = user;
    if (size >= text->capacity - text->size) {
        const size_t capacity = 2 * (text->capacity + size);
        char* moved = text->failed ? NULL : realloc(text->bytes, capacity);
        text->failed |= moved == NULL;
        if (text->failed) return 0;
        text->bytes = moved;
        text->capacity = capacity;
    }
    memcpy(text->bytes + text->size, bytes, size);
    text->size += size;
    text->bytes[text->size] = '\0';
    return (ssize_t)size;
}

bool cli_text_open(cli_text* text) {
    enum { CAPACITY = 1024 };
    *text = (cli_text){.bytes = malloc(CAPACITY), .capacity = CAPACITY};
    if (text->bytes == NULL) return false;
    text->bytes[0] = '\0';
    text->file = fopencookie(text, "w", (cookie_io_functions_t){.write = append});
    if (text->file == NULL) free(text->bytes);
    return text->file != NULL;
}

char* cli_text_close(cli_text* text) {
    text->failed |= ferror(text->file) != 0;
    text->failed |= fclose(text->file) != 0;
    if (!text->failed) return text->bytes;
    free(text->bytes);
    return NULL;
}

static ssize_t write_output(void* user, const char* bytes, size_t size) {
    return ty_output_write(user, bytes, size) ? (ssize_t)size : 0;
}

ty_result cli_write_text_file(ty_context* context, const char* path, cli_print_fn print, const void* user) {
    ty_output output;
    ty_result result = ty_output_open(context, path, &output);
    if (result != TY_OK) return result;
    FILE* file = fopencookie(&output, "w", (cookie_io_functions_t){.write = write_output});
    result = file == NULL ? TY_ERROR_MEMORY : print(context, file, user);
    if (file != NULL) {
        const bool complete = ferror(file) == 0;
        if ((fclose(file) != 0 || !complete) && output.error == 0 && result == TY_OK) result = TY_ERROR_MEMORY;
    }
    if (result == TY_OK) return ty_output_commit(context, &output);
    ty_output_discard(context, &output);
    return result;
}
