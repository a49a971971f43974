/* Scene text: whatever the bytes, the reader must refuse them with a message or build a scene, and leak nothing. No
 * files may be named, and memory is capped, so that a few bytes cannot ask for a giant volume or sky. */
#define FUZZ_MEMORY (1 << 20)
#include "fuzz_target.h"

#include <tyndall/io.h>

enum { TEXT_MAX = 1 << 14 };

/* An override may stand before the text, ended by a line feed, after an @. */
int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    if (size > TEXT_MAX) return 0;
    char override[128];
    const char* overrides[1] = {override};
    int32_t count = 0;
    const uint8_t* end = size > 0 && bytes[0] == '@' ? memchr(bytes, '\n', size) : NULL;
    if (end != NULL && (size_t)(end - bytes) <= sizeof override) {
        const size_t length = (size_t)(end - bytes) - 1;
        memcpy(override, bytes + 1, length);
        override[length] = '\0';
        size -= length + 2;
        bytes = end + 1;
        count = 1;
    }
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    ty_scene* scene = NULL;
    const ty_result result = ty_scene_parse(context, (const char*)bytes, size, "fuzz", NULL, overrides, count, &scene);
    if ((result == TY_OK) != (scene != NULL) || (result == TY_OK) != (ty_take_error(context)[0] == '\0')) abort();
    ty_scene_destroy(scene);
    fuzz_finish(context, &used);
    return 0;
}
