/* Shared by the fuzz targets of other renderers' scenes. */
#ifndef TY_TESTS_FUZZ_LANGUAGE_H
#define TY_TESTS_FUZZ_LANGUAGE_H

#include "fuzz_target.h"

#include "base/context.h"
#include "io/interchange/convert.h"

enum { FUZZ_TEXT_MAX = 1 << 14 };

static inline int fuzz_language(ty_scene_language language, const uint8_t* bytes, size_t size) {
    if (size > FUZZ_TEXT_MAX) return 0;
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    uint8_t* text = fuzz_copy_text(bytes, size);
    char* scene = NULL;
    const ty_result result = ty_convert_scene_text(context, language, (const char*)text, size, &scene);
    if ((result == TY_OK) != (scene != NULL) || (result == TY_OK) != (ty_take_error(context)[0] == '\0')) abort();
    ty_free_text(context, scene);
    free(text);
    fuzz_finish(context, &used);
    return 0;
}

#endif
