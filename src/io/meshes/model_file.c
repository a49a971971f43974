/* Reading mesh files of any supported format. */
#include "base/context.h"
#include "io/file.h"
#include "io/meshes/model.h"

#include <string.h>
#include <strings.h>

static const size_t file_size_max = (size_t)1 << 36;

static bool begins(const uint8_t* bytes, size_t size, const char* text) {
    const size_t length = strlen(text);
    return size >= length && memcmp(bytes, text, length) == 0;
}

/* True if the first non-blank character opens a JSON object. */
static bool is_json(const uint8_t* bytes, size_t size) {
    size_t at = begins(bytes, size, "\xef\xbb\xbf") ? 3 : 0;
    while (at < size && (bytes[at] == ' ' || bytes[at] == '\t' || bytes[at] == '\n' || bytes[at] == '\r')) ++at;
    return at < size && bytes[at] == '{';
}

static ty_result read_bytes(ty_context* context, const char* path, const char* folder, const uint8_t* bytes,
                            size_t size, unsigned want, ty_model* model) {
    const char* extension = strrchr(path, '.');
    if (begins(bytes, size, "glTF") || is_json(bytes, size))
        return ty_read_gltf(context, path, folder, bytes, size, want, model);
    if (begins(bytes, size, "ply\n") || begins(bytes, size, "ply\r"))
        return ty_read_ply(context, path, bytes, size, want, model);
    if (extension != NULL && strcasecmp(extension, ".obj") == 0)
        return ty_read_obj(context, path, folder, bytes, size, want, model);
    return ty_fail(context, TY_ERROR_INPUT, "%s: neither a glTF, an OBJ nor a PLY file", path);
}

ty_result ty_read_model(ty_context* context, const char* path, unsigned want, ty_model* model) {
    *model = (ty_model){.context = context};
    uint8_t* bytes = NULL;
    size_t size = 0;
    ty_result result = ty_read_file(context, path, file_size_max, &bytes, &size);
    if (result != TY_OK) return result;
    char* folder = ty_folder_of(context, path);
    result = folder == NULL ? TY_ERROR_MEMORY : read_bytes(context, path, folder, bytes, size, want, model);
    ty_free_text(context, folder);
    ty_free_file(context, bytes, size);
    return result;
}
