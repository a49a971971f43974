/* glTF files, GLB or JSON, from memory; no other files may be named, base64 may. */
#include "../model_check.h"
#include "fuzz_target.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    ty_model model;
    const ty_result result = ty_read_gltf(context, "fuzz.glb", NULL, bytes, size, TY_MODEL_ALL, &model);
    if ((result == TY_OK) != (ty_take_error(context)[0] == '\0')) abort();
    if (result == TY_OK && !model_is_whole(&model)) abort();
    ty_model_free(&model);
    fuzz_finish(context, &used);
    return 0;
}
