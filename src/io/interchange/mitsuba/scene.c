/* A whole scene: its elements in order. */
#include "io/interchange/mitsuba/mitsuba.h"

#include "base/context.h"

#include <string.h>

static ty_result read_element(ty_mitsuba* scene, int32_t node) {
    static const char* const inert[] = {"default", "path",  "include", "bsdf",    "medium", "texture", "phase",
                                        "volume",  "alias", "string",  "integer", "float",  "boolean", "ref"};
    const ty_affine identity = ty_affine_identity();
    if (ty_mitsuba_is(scene, node, "shape"))
        return strcmp(ty_mitsuba_type(scene, node), "shapegroup") == 0 ? TY_OK
                                                                       : ty_mitsuba_shape(scene, node, &identity);
    if (ty_mitsuba_is(scene, node, "emitter") && strcmp(ty_mitsuba_type(scene, node), "area") == 0)
        return TY_OK; /* shapes refer to it */
    if (ty_mitsuba_is(scene, node, "emitter")) return ty_mitsuba_emitter(scene, node);
    if (ty_mitsuba_is(scene, node, "sensor")) return ty_mitsuba_sensor(scene, node);
    if (ty_mitsuba_is(scene, node, "integrator")) return ty_mitsuba_integrator(scene, node);
    for (size_t i = 0; i < sizeof inert / sizeof inert[0]; ++i)
        if (ty_mitsuba_is(scene, node, inert[i])) return TY_OK;
    ty_conversion_leave_out(scene->conversion, "the element \"%.60s\"", scene->nodes[node].tag);
    return TY_OK;
}

ty_result ty_read_mitsuba(ty_conversion* conversion, const char* text, size_t size) {
    ty_mitsuba scene = {.conversion = conversion, .context = conversion->context};
    ty_result result = ty_mitsuba_parse(&scene, text, size);
    for (int32_t node = result == TY_OK ? scene.nodes[0].first_child : -1; node >= 0 && result == TY_OK;
         node = scene.nodes[node].next)
        result = read_element(&scene, node);
    ty_mitsuba_free(&scene);
    return result;
}
