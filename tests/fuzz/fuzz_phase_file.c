/* Phase functions in text files, by every reading of their content. The bytes go through a file in memory. */
#include "fuzz_target.h"

#include <tyndall/io.h>

static void read_all(ty_context* context, const char* path) {
    static double cosines[TY_PHASE_NODES_MAX], values[TY_PHASE_NODES_MAX];
    for (int content = TY_PHASE_FILE_ANGLES; content <= TY_PHASE_FILE_SHDOM; ++content) {
        int32_t count = 0;
        const ty_result result = ty_phase_file_read(context, path, (ty_phase_content)content,
                                                    content == TY_PHASE_FILE_SHDOM ? 7 : 0, cosines, values, &count);
        if ((result == TY_OK) != (ty_take_error(context)[0] == '\0')) abort();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    return fuzz_read_bytes(bytes, size, read_all);
}
