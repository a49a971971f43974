/// @file scene_editor.h
/// Scenes that change while a program shows them, and content that it gives them in memory.
///
/// An editor keeps the document of a scene file, the files that it names, and the scene made of them. A change makes
/// anew only what depends on it, and the scene is then as if ty_scene_load() had read the changed document: its hash
/// and its images are the same, bit for bit. Apache-2.0.
#ifndef TYNDALL_SCENE_EDITOR_H
#define TYNDALL_SCENE_EDITOR_H

#include <tyndall/base.h>
#include <tyndall/grid.h>
#include <tyndall/image.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// A scene with its document. One thread uses it at a time, and a change alters the scene in place: no call may be
/// using the scene meanwhile.
///
/// A file is looked at when a section that names it changes, and read again if its size or time of modification is
/// another. Content that the document does not name any more stays in memory up to 1 GiB. A change of geometry,
/// meters_per_unit or up_axis makes the whole scene anew; other changes keep its meshes.
typedef struct ty_scene_editor ty_scene_editor;

/// Opens a scene as ty_scene_load() does. The overrides stay in force until a change of the same values.
/// Errors: as ty_scene_load().
TY_API ty_result ty_scene_editor_open(ty_context* context, const char* path, const char* const* overrides,
                                      int32_t override_count, ty_scene_editor** out);
/// Opens a scene as ty_scene_parse() does. Errors: as ty_scene_parse().
TY_API ty_result ty_scene_editor_open_text(ty_context* context, const char* text, size_t length, const char* name,
                                           const char* folder, const char* const* overrides, int32_t override_count,
                                           ty_scene_editor** out);
/// Destroys an editor with its scene; NULL is allowed.
TY_API void ty_scene_editor_close(ty_scene_editor* editor);

/// The committed scene, until the next change.
TY_API const ty_scene* ty_scene_editor_scene(const ty_scene_editor* editor);
/// The document with overrides and changes, as compact JSON, until the next change.
TY_API const char* ty_scene_editor_text(const ty_scene_editor* editor);

/// A change of one value of the document.
typedef struct ty_scene_change {
    const char* path;  ///< Such as "media[0].g"; the index after the last appends an element to an array.
    const char* value; ///< JSON; NULL or "null" removes the member or element.
} ty_scene_change;

/// Parts of a scene that a change altered, as flags.
typedef enum ty_edit_flags {
    TY_EDIT_NOTHING = 0, ///< None.
    TY_EDIT_RENDER = 1,  ///< Method and options.
    TY_EDIT_CAMERA = 2,  ///< The camera.
    TY_EDIT_LIGHT = 4,   ///< Media or lights.
    TY_EDIT_GEOMETRY = 8 ///< Surfaces, area lights included; light depends on them, too.
} ty_edit_flags;

/// Applies all changes in their order, or none: after an error scene and document are as before. `*edited` receives
/// flags of ty_edit_flags; it may be NULL. A value that is the same number as before is no change. Without changes, the
/// call makes anew what content in memory was replaced.
/// Errors: TY_ERROR_INPUT, TY_ERROR_ARGUMENT (a malformed change), TY_ERROR_FILE, TY_ERROR_MEMORY; the message begins
/// with a path, "media[0].g: 1.2 is outside (-1, 1)".
TY_API ty_result ty_scene_editor_apply(ty_scene_editor* editor, const ty_scene_change* changes, int32_t count,
                                       uint32_t* edited);

/// Gives the scene a volume in memory: "memory:NAME" stands for it wherever the document may name a volume file. grids:
/// one of one value per voxel, or three of red, green and blue; they are retained, and placed as those of files are.
/// name: 1..64 letters, digits and _.-; an earlier volume, mesh or image of the name is replaced, which the scene shows
/// after the next ty_scene_editor_apply(). Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_scene_editor_set_volume(ty_scene_editor* editor, const char* name, ty_grid* const* grids,
                                            int32_t count);
/// Gives the scene a mesh, which is copied: "memory:NAME" stands for it wherever the document may name a mesh file. Its
/// material is that of the geometry that names it, or its own. Otherwise as ty_scene_editor_set_volume().
TY_API ty_result ty_scene_editor_set_mesh(ty_scene_editor* editor, const char* name, const ty_mesh_def* def);
/// Gives the scene an image, whose R, G, B, and A if there is one, are copied: "memory:NAME" stands for it as the map
/// of an environment light, or as a texture of a material, of 8 bits for 0..1, in sRGB of colours, as those of files.
/// Otherwise as ty_scene_editor_set_volume().
TY_API ty_result ty_scene_editor_set_image(ty_scene_editor* editor, const char* name, const ty_image* image);
/// Forgets the content of a name, if there is any. The scene keeps what it was made of until a change makes that anew.
TY_API void ty_scene_editor_drop(ty_scene_editor* editor, const char* name);

#ifdef __cplusplus
}
#endif
#endif
