/* Mitsuba's .serialized meshes from memory: the first two shapes. */
#include "fuzz_target.h"

#include "io/interchange/mitsuba/serialized.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    for (int32_t index = 0; index < 2; ++index) {
        ty_model_mesh mesh;
        const ty_result result = ty_read_serialized(context, "fuzz", bytes, size, index, &mesh);
        if ((result == TY_OK) != (ty_take_error(context)[0] == '\0')) abort();
        for (size_t i = 0; result == TY_OK && i < 3 * mesh.triangle_count; ++i)
            if (mesh.indices[i] >= mesh.vertex_count) abort();
        if (result == TY_OK) ty_model_free_mesh(context, &mesh);
    }
    fuzz_finish(context, &used);
    return 0;
}
