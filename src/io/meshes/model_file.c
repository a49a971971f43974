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

static ty_result fail_unknown(ty_context* context, const char* path) {
    return ty_fail(context, TY_ERROR_INPUT, "%s: neither a glTF, an OBJ nor a PLY file", path);
}

static bool is_obj(const char* path) {
    const char* extension = strrchr(path, '.');
    return extension != NULL && strcasecmp(extension, ".obj") == 0;
}

static bool is_ply(const uint8_t* bytes, size_t size) {
    return begins(bytes, size, "ply\n") || begins(bytes, size, "ply\r");
}

ty_result ty_inspect_model(ty_context* context, const char* path, uint8_t* head, size_t size, ty_file_form* form) {
    enum { GLB_SIZE = 8, GLB_HEAD = 12 };
    if (begins(head, size, "glTF") && size >= GLB_HEAD) {
        uint32_t stated;
        memcpy(&stated, head + GLB_SIZE, sizeof stated);
        form->longest = stated + TY_FILE_SLACK;
    } else if (is_ply(head, size)) {
        return ty_inspect_ply(context, path, head, size, form);
    } else if (is_json(head, size) || is_obj(path)) {
        form->text = true;
    } else {
        return fail_unknown(context, path);
    }
    return TY_OK;
}

static ty_result read_bytes(ty_context* context, const char* path, const char* folder, const uint8_t* bytes,
                            size_t size, unsigned want, ty_model* model) {
    if (begins(bytes, size, "glTF") || is_json(bytes, size))
        return ty_read_gltf(context, path, folder, bytes, size, want, model);
    if (is_ply(bytes, size)) return ty_read_ply(context, path, bytes, size, want, model);
    if (is_obj(path)) return ty_read_obj(context, path, folder, bytes, size, want, model);
    return fail_unknown(context, path);
}

ty_result ty_read_model(ty_context* context, const char* path, unsigned want, ty_model* model) {
    *model = (ty_model){.context = context};
    uint8_t* bytes = NULL;
    size_t size = 0;
    ty_result result = ty_read_inspected_file(context, path, file_size_max, ty_inspect_model, &bytes, &size);
    if (result != TY_OK) return result;
    char* folder = ty_folder_of(context, path);
    result = folder == NULL ? TY_ERROR_MEMORY : read_bytes(context, path, folder, bytes, size, want, model);
    ty_free_text(context, folder);
    ty_free_file(context, bytes, size);
    return result;
}
