/* glTF files, GLB or JSON, from memory; no other files may be named, base64 may. */
#include "fuzz_model.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    ty_model model;
    const ty_result result = ty_read_gltf(context, "fuzz.glb", NULL, bytes, size, TY_MODEL_ALL, &model);
    fuzz_finish_model(context, &used, result, &model);
    return 0;
}
