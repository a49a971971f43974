/* Conversion of scenes of other renderers to scene files: pbrt (.pbrt, .pbrt.gz) and Mitsuba (.xml). */
#ifndef TY_IO_INTERCHANGE_CONVERT_H
#define TY_IO_INTERCHANGE_CONVERT_H

#include <tyndall/base.h>

typedef enum ty_scene_language { TY_LANGUAGE_NONE, TY_LANGUAGE_PBRT, TY_LANGUAGE_MITSUBA } ty_scene_language;

/* By the extension. */
ty_scene_language ty_scene_language_of(const char* path);

/* Receives one note about what was left out or approximated. */
typedef void (*ty_conversion_say_fn)(void* user, const char* note);

/* Writes the scene file at `output`, and meshes, volumes and images in a folder beside it. partial: files that are
 * missing are left out, with a note. Errors: TY_ERROR_INPUT (with file and line), TY_ERROR_FILE, TY_ERROR_MEMORY. */
ty_result ty_convert_scene(ty_context* context, const char* input, const char* output, bool partial,
                           ty_conversion_say_fn say, void* user);
/* Converts text that names no files, and writes nothing; *out is the scene file, freed with ty_free_text. text is
 * followed by a zero byte. */
ty_result ty_convert_scene_text(ty_context* context, ty_scene_language language, const char* text, size_t size,
                                char** out);

#endif
