/* Scene text: whatever the bytes, the reader must refuse them with a message or build a scene, and leak nothing. No
 * files may be named, and memory is capped, so that a few bytes cannot ask for a giant volume or sky. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <tyndall/io.h>

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

enum { MEMORY_MAX = 1 << 20, TEXT_MAX = 1 << 14, ALIGNMENT = 64 };

static void* capped_alloc(void* user, size_t size) {
    size_t* used = user;
    if (size > MEMORY_MAX - *used) return NULL;
    void* pointer = aligned_alloc(ALIGNMENT, (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT);
    if (pointer != NULL) *used += size;
    return pointer;
}

static void capped_free(void* user, void* pointer, size_t size) {
    size_t* used = user;
    *used -= size;
    free(pointer);
}

/* An override may stand before the text, ended by a line feed, after an @. */
int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (size > TEXT_MAX) return 0;
    char override[128];
    const char* overrides[1] = {override};
    int32_t count = 0;
    const uint8_t* end = size > 0 && data[0] == '@' ? memchr(data, '\n', size) : NULL;
    if (end != NULL && (size_t)(end - data) <= sizeof override) {
        const size_t length = (size_t)(end - data) - 1;
        memcpy(override, data + 1, length);
        override[length] = '\0';
        size -= length + 2;
        data = end + 1;
        count = 1;
    }
    size_t used = 0;
    ty_context_def def = ty_default_context_def();
    def.threads = 1;
    def.alloc = capped_alloc;
    def.free = capped_free;
    def.alloc_user = &used;
    ty_context* context = NULL;
    if (ty_context_create(&def, &context) != TY_OK) return 0;
    ty_scene* scene = NULL;
    const ty_result result = ty_scene_parse(context, (const char*)data, size, "fuzz", NULL, overrides, count, &scene);
    if ((result == TY_OK) != (scene != NULL) || (result == TY_OK) != (ty_take_error(context)[0] == '\0')) abort();
    ty_scene_destroy(scene);
    ty_context_destroy(context);
    if (used != 0) abort();
    return 0;
}
