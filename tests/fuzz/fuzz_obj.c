/* OBJ files from memory, and material files: what follows a line "#mtl" is one, and is read first. */
#include "fuzz_model.h"

#include "io/meshes/obj.h"

static void read_materials(ty_context* context, const uint8_t* bytes, size_t size) {
    uint8_t* text = fuzz_copy_text(bytes, size);
    ty_model model = {.context = context};
    const ty_result result = ty_read_mtl(context, "fuzz.mtl", NULL, (const char*)text, size, &model);
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
    uint8_t* text = fuzz_copy_text(bytes, length);
    ty_model model;
    const ty_result result = ty_read_obj(context, "fuzz.obj", NULL, text, length, TY_MODEL_ALL, &model);
    fuzz_finish_model(context, &used, result, &model);
    free(text);
    return 0;
}
