#include "io/interchange/convert.h"

#include "base/context.h"
#include "io/file.h"
#include "io/interchange/mitsuba/mitsuba.h"
#include "io/interchange/pbrt/pbrt.h"
#include "io/volumes/volume_file.h"

#include <stdio.h>
#include <string.h>

ty_scene_language ty_scene_language_of(const char* path) {
    if (ty_volume_has_extension(path, ".pbrt") || ty_volume_has_extension(path, ".pbrt.gz")) return TY_LANGUAGE_PBRT;
    return ty_volume_has_extension(path, ".xml") ? TY_LANGUAGE_MITSUBA : TY_LANGUAGE_NONE;
}

static ty_result read_scene(ty_conversion* conversion, ty_scene_language language, const char* text, size_t size) {
    if (language == TY_LANGUAGE_PBRT) return ty_read_pbrt(conversion, text, size);
    return ty_read_mitsuba(conversion, text, size);
}

static void tell(const ty_conversion* conversion, ty_conversion_say_fn say, void* user) {
    for (size_t i = 0; i < conversion->note_count && say != NULL; ++i) {
        char line[640];
        ty_conversion_print_note(&conversion->notes[i], line, sizeof line);
        say(user, line);
    }
}

/* The name of a file within its folder. */
static const char* base_name(const char* path) {
    const char* slash = strrchr(path, '/');
    return slash == NULL ? path : slash + 1;
}

ty_result ty_convert_scene(ty_context* context, const char* input, const char* output, bool partial,
                           ty_conversion_say_fn say, void* user) {
    ty_conversion conversion;
    char *folder = ty_folder_of(context, input), *text = NULL;
    uint8_t* bytes = NULL;
    size_t size = 0;
    ty_result result = folder == NULL ? TY_ERROR_MEMORY : TY_OK;
    if (result == TY_OK) result = ty_conversion_open(&conversion, context, input, folder, output);
    if (result != TY_OK) {
        ty_free_text(context, folder);
        return result;
    }
    result = ty_conversion_read_file(&conversion, input, base_name(input), &bytes, &size);
    conversion.partial = partial;
    if (result == TY_OK) result = read_scene(&conversion, ty_scene_language_of(input), (const char*)bytes, size);
    if (bytes != NULL) ty_free_file(context, bytes, size);
    if (result == TY_OK) result = ty_conversion_finish(&conversion, &text);
    if (result == TY_OK) result = ty_write_file(context, output, text, strlen(text));
    if (result == TY_OK) tell(&conversion, say, user);
    ty_free_text(context, text);
    ty_conversion_close(&conversion);
    ty_free_text(context, folder);
    return result;
}

ty_result ty_convert_scene_text(ty_context* context, ty_scene_language language, const char* text, size_t size,
                                char** out) {
    ty_conversion conversion;
    *out = NULL;
    ty_result result = ty_conversion_open(&conversion, context, "scene", NULL, NULL);
    if (result == TY_OK) result = read_scene(&conversion, language, text, size);
    if (result == TY_OK) result = ty_conversion_finish(&conversion, out);
    ty_conversion_close(&conversion);
    return result;
}
