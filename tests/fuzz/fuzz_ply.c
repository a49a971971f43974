/* PLY files from memory. */
#include "../model_check.h"
#include "fuzz_target.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    uint8_t* text = malloc(size + 1);
    if (text == NULL) abort();
    if (size > 0) memcpy(text, bytes, size);
    text[size] = 0; /* as files that are read end */
    ty_model model;
    const ty_result result = ty_read_ply(context, "fuzz.ply", text, size, TY_MODEL_ALL, &model);
    if ((result == TY_OK) != (ty_take_error(context)[0] == '\0')) abort();
    if (result == TY_OK && !model_is_whole(&model)) abort();
    ty_model_free(&model);
    fuzz_finish(context, &used);
    free(text);
    return 0;
}
