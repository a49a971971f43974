/// @file method.h
/// Methods by name, and the options that scenes ask of them. Apache-2.0.
#ifndef TYNDALL_METHOD_H
#define TYNDALL_METHOD_H

#include <tyndall/base.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The name of a method that renders scenes ("path", "dom", ...) at an index; NULL past the last one.
TY_API const char* ty_method_name(int32_t index);

/// Sets the fields of a definition that the scene asks for, by render.METHOD of its file or by ty_scene_set_option().
/// Other fields stay as they are, so that the definition comes from the method's default function:
///
///     ty_dom_def def = ty_default_dom_def();
///     ty_result result = ty_method_options(scene, "dom", &def);
///
/// Errors: TY_ERROR_ARGUMENT (a method without a definition, an unknown key, a value out of range).
TY_API ty_result ty_method_options(const ty_scene* scene, const char* method, void* def);
/// The reverse: sets all options of a method, as ty_scene_set_option() does, to the fields of a definition.
/// Errors: TY_ERROR_ARGUMENT (a method without a definition, a wrong definition), TY_ERROR_MEMORY.
TY_API ty_result ty_method_set_options(ty_scene* scene, const char* method, const void* def);

#ifdef __cplusplus
}
#endif
#endif
