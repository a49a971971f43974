/* Media in words: whatever the bytes, the reader must refuse them with a message, or give coefficients that a scene
 * takes. */
#include "fuzz_target.h"

#include <tyndall/io.h>

#include <string.h>

enum { TEXT_MAX = 512 };

static void check_taken(ty_context* context, ty_medium_def* medium) {
    medium->bounds = TY_BOUNDS_SPHERE;
    medium->sphere_radius = 1;
    ty_scene* scene = NULL;
    if (ty_scene_create(context, TY_AXIS_Y, &scene) != TY_OK || ty_scene_add_medium(scene, medium) != TY_OK) abort();
    ty_scene_destroy(scene);
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    if (size > TEXT_MAX) return 0;
    char text[TEXT_MAX + 1];
    memcpy(text, bytes, size);
    text[size] = '\0';
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    ty_medium_def medium = ty_default_medium_def();
    const ty_result result = ty_medium_parse(context, text, &medium);
    if ((result == TY_OK) != (ty_take_error(context)[0] == '\0')) abort();
    if (result == TY_OK) check_taken(context, &medium);
    fuzz_finish(context, &used);
    return 0;
}
