/* OBJ files from memory, and material files: what follows a line "#mtl" is one, and is read first. */
#define _GNU_SOURCE
#include "../model_check.h"
#include "fuzz_target.h"

#include "io/meshes/obj.h"

#include <string.h>

static char* copy_text(const uint8_t* bytes, size_t size) {
    char* text = malloc(size + 1);
    if (text == NULL) abort();
    if (size > 0) memcpy(text, bytes, size);
    text[size] = '\0'; /* as files that are read end */
    return text;
}

static void read_materials(ty_context* context, const uint8_t* bytes, size_t size) {
    char* text = copy_text(bytes, size);
    ty_model model = {.context = context};
    const ty_result result = ty_read_mtl(context, "fuzz.mtl", NULL, text, size, &model);
    if (result == TY_OK && !model_is_whole(&model)) abort();
    ty_model_free(&model);
    free(text);
    ty_take_error(context);
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    static const char mark[] = "#mtl\n";
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    const uint8_t* library = size == 0 ? NULL : memmem(bytes, size, mark, sizeof mark - 1);
    const size_t length = library == NULL ? size : (size_t)(library - bytes);
    if (library != NULL) read_materials(context, library, size - length);
    char* text = copy_text(bytes, length);
    ty_model model;
    const ty_result result = ty_read_obj(context, "fuzz.obj", NULL, (const uint8_t*)text, length, TY_MODEL_ALL, &model);
    if ((result == TY_OK) != (ty_take_error(context)[0] == '\0')) abort();
    if (result == TY_OK && !model_is_whole(&model)) abort();
    ty_model_free(&model);
    fuzz_finish(context, &used);
    free(text);
    return 0;
}
