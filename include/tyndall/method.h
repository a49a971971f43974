/// @file method.h
/// Methods by name, and the options that scenes ask of them. Apache-2.0.
#ifndef TYNDALL_METHOD_H
#define TYNDALL_METHOD_H

#include <tyndall/base.h>
#include <tyndall/image.h>
#include <tyndall/path.h>
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

/// Receives one measurement of a rendering: its name, such as "march_seconds" or "sweeps", and `count` numbers, or the
/// text where that is not NULL; all are valid during the call.
typedef void (*ty_measurement_fn)(void* user, const char* name, const double* numbers, int32_t count, const char* text);

/// A request for an image by a method with a name. Create it with ty_default_render_def().
typedef struct ty_render_def {
    uint32_t cookie;                    ///< Set by ty_default_render_def() and checked.
    uint32_t bytes;                     ///< Set by ty_default_render_def() to the size of the structure, and checked.
    const ty_render_settings* settings; ///< Method, samples per pixel (of methods other than path: of the surfaces) and
                                        ///< seed; NULL (default): those of the scene. The method "auto" is refused:
                                        ///< ty_choose_method() chooses.
    double seconds;                     ///< Time after which `path` stops, as in ty_path_def; default 0: no bound.
    double error;               ///< Relative error at which `path` stops, as in ty_path_def; default 0: no bound.
    int32_t width;              ///< Image width, pixels; 0 (default): that of the camera. Set with `height`.
    int32_t height;             ///< Image height, pixels; 0 (default): that of the camera.
    int32_t crop[4];            ///< x, y, width, height of the part to render; default 0: the whole frame. Only `path`.
    uint32_t aovs;              ///< Flags of ty_aov that the method has; default 0.
    ty_progress_fn progress;    ///< Default NULL.
    void* progress_user;        ///< Passed on to `progress`; default NULL.
    ty_path_partial_fn partial; ///< Receives images so far of `path`, as in ty_path_def; default NULL.
    void* partial_user;         ///< Passed on to `partial`; default NULL.
    ty_measurement_fn measurement; ///< Receives measurements at the end, on the calling thread; default NULL.
    void* measurement_user;        ///< Passed on to `measurement`; default NULL.
    ty_path_state_fn state;        ///< Receives states of `path`, as in ty_path_def; default NULL.
    void* state_user;              ///< Passed on to `state`; default NULL.
    double state_seconds;          ///< Time between two states, s, as in ty_path_def; default TY_AUTO.
    const void* resume;            ///< A state of `path` to go on from, as in ty_path_def; default NULL.
    size_t resume_size;            ///< Size of `resume`, bytes; default 0.
} ty_render_def;

/// Sets the `bytes` bytes of a ty_render_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_render_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_render_def ty_default_render_def(void) {
    ty_render_def def;
    ty_init_render_def(&def, sizeof def);
    return def;
}

/// Renders a committed scene by a method with the scene's options, as `tyndall render` does: media that fill
/// dielectrics, and surfaces in the light of media, are in the image whatever the method. `*out` is NULL after an
/// error. After TY_CANCELLED it is a valid image with fewer samples where the method is path or screen, else NULL.
/// Errors: TY_ERROR_ARGUMENT (an unknown method; a channel, a crop, states or a scene that it does not take),
/// TY_ERROR_INPUT (def->resume), TY_ERROR_MEMORY.
TY_API ty_result ty_render(const ty_scene* scene, const ty_render_def* def, ty_image** out);

#ifdef __cplusplus
}
#endif
#endif
