/* The registry of methods. */
#include "method/registry.h"

#include "base/context.h"
#include "scene/scene.h"

#include <string.h>

#define TY_METHOD_ENTRY(name) &ty_method_##name,
const ty_method* const ty_methods[] = {TY_METHOD_LIST(TY_METHOD_ENTRY) NULL};
#undef TY_METHOD_ENTRY

const ty_method* ty_method_find(const char* name) {
    for (int32_t i = 0; ty_methods[i] != NULL; ++i)
        if (strcmp(ty_methods[i]->name, name) == 0) return ty_methods[i];
    return NULL;
}

const char* ty_method_of_interiors(const ty_method* method, const ty_scene* scene) {
    if (scene->view.interior_count < 2 || (method->takes_surfaces && ty_enclosed_has_all_media(scene))) return NULL;
    return method->of_interiors;
}

/* True for a valid method index. */
static bool has_method(int32_t index) {
    return index >= 0 && index < (int32_t)(sizeof ty_methods / sizeof ty_methods[0]) - 1;
}

const char* ty_method_name(int32_t index) {
    return has_method(index) ? ty_methods[index]->name : NULL;
}

const ty_option_table* ty_method_options_at(int32_t index, const char** method) {
    *method = ty_method_name(index);
    return has_method(index) ? ty_methods[index]->options : NULL;
}

/* The options of a method; NULL after a message. */
static const ty_option_table* find_options(const ty_scene* scene, const char* method) {
    const ty_method* known = ty_method_find(method);
    if (known != NULL && known->options != NULL) return known->options;
    ty_fail(scene->context, TY_ERROR_ARGUMENT, "there is no method %.32s with options", method);
    return NULL;
}

/* Fails for defs of another method; defs of older programs can be smaller. */
static ty_result check_def(const ty_scene* scene, const ty_option_table* table, const void* def) {
    if (table == NULL) return TY_ERROR_ARGUMENT;
    const ty_result result = ty_check_def(scene->context, def, table->default_function);
    if (result != TY_OK || ty_def_bytes(def) <= table->bytes) return result;
    return ty_fail(scene->context, TY_ERROR_ARGUMENT, "render.%s: the def has %zu bytes, and that of %s() has %zu",
                   table->name, ty_def_bytes(def), table->default_function, table->bytes);
}

ty_result ty_method_options(const ty_scene* scene, const char* method, void* def) {
    const ty_option_table* table = find_options(scene, method);
    ty_result result = check_def(scene, table, def);
    for (size_t i = 0; i < scene->option_count && result == TY_OK; ++i) {
        const ty_scene_option* option = &scene->options[i];
        if (strcmp(option->method, table->name) == 0)
            result = ty_options_set(scene->context, table, def, option->key, option->value);
    }
    return result;
}

ty_result ty_method_set_options(ty_scene* scene, const char* method, const void* def) {
    const ty_option_table* table = find_options(scene, method);
    ty_result result = check_def(scene, table, def);
    for (int32_t i = 0; result == TY_OK && i < table->count; ++i) {
        char text[TY_OPTION_TEXT_SIZE];
        const ty_option* option = &table->options[i];
        if ((option->flags & TY_OPTION_CALLS_ONLY) != 0 || !ty_option_fits(option, def)) continue;
        ty_option_text(option, ty_option_value(option, def), text);
        result = ty_scene_set_option(scene, table->name, option->name, text);
    }
    return result;
}
