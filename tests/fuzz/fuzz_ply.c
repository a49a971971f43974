/* PLY files from memory. */
#include "fuzz_model.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    uint8_t* text = fuzz_copy_text(bytes, size);
    ty_model model;
    const ty_result result = ty_read_ply(context, "fuzz.ply", text, size, TY_MODEL_ALL, &model);
    fuzz_finish_model(context, &used, result, &model);
    free(text);
    return 0;
}
