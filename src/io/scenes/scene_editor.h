/* A scene that is edited while it is shown: the document of a scene file, what it names, and the scene made of them
 * stay in memory, and a change makes anew only what depends on it. The scene is then as if ty_scene_load had read the
 * edited document: its hash and its images are the same, bit by bit.
 *
 * A file is looked at when the section that names it changes, and read again if its size or time of modification is
 * another; buffers and images that a .gltf or .obj names count with it. Volumes, maps, closed meshes and noise that the
 * document does not name any more, such as the frame before, stay in memory up to the limits in asset_cache.h. A change
 * of geometry, meters_per_unit or up_axis makes the whole scene anew from them; other changes keep its meshes.
 *
 * One thread uses an editor at a time, and an edit changes the scene in place: no renderer may be using it. */
#ifndef TY_IO_SCENE_EDITOR_H
#define TY_IO_SCENE_EDITOR_H

#include <jansson.h>
#include <tyndall/io.h>

typedef struct ty_scene_editor ty_scene_editor;

/* Loads as ty_scene_load does. The overrides stay in force until a change of the same values. */
ty_result ty_scene_editor_open(ty_context* context, const char* path, const char* const* overrides,
                               int32_t override_count, ty_scene_editor** out);
/* NULL is allowed. */
void ty_scene_editor_close(ty_scene_editor* editor);

/* The committed scene, until the next edit that changes anything. */
const ty_scene* ty_scene_editor_scene(const ty_scene_editor* editor);
/* The document, overrides and edits included, as compact JSON, until the next edit that changes anything. */
const char* ty_scene_editor_text(const ty_scene_editor* editor);

typedef struct ty_scene_change {
    const char* path;  /* "media[0].g"; the index after the last appends an element to an array */
    const char* value; /* JSON; NULL or "null" removes the member or element */
} ty_scene_change;

/* Changes a document, without a check of what it holds then; on failure it may hold some of the objects on the way. */
ty_result ty_change_document(ty_context* context, json_t* root, const ty_scene_change* change);

/* Parts that an edit changed. */
typedef enum ty_edit_flags {
    TY_EDIT_NOTHING = 0,
    TY_EDIT_RENDER = 1, /* method and options */
    TY_EDIT_CAMERA = 2,
    TY_EDIT_LIGHT = 4,   /* media or lights */
    TY_EDIT_GEOMETRY = 8 /* surfaces, area lights included; light depends on them, too */
} ty_edit_flags;

/* Applies all changes in their order, or none: on failure scene and document are as before, and the message begins
 * with a path, "media[0].g: 1.2 is outside (-1, 1)". A value that is the same number as before is no change. */
ty_result ty_scene_editor_apply(ty_scene_editor* editor, const ty_scene_change* changes, int32_t count,
                                uint32_t* edited);

/* ---- changes since the file was opened, overrides included ---- */

/* The file's text with only the changed values replaced, inserted and removed: spaces, the order of keys and other
 * numbers are as in the file. *out is freed with ty_free_text. Errors: TY_ERROR_MEMORY. */
ty_result ty_scene_editor_save_text(const ty_scene_editor* editor, char** out);
/* The changes as overrides, "media[0].g=0.5", with which ty_scene_load makes the same scene of the file. They are freed
 * with ty_scene_editor_free_overrides. Errors: TY_ERROR_MEMORY. */
ty_result ty_scene_editor_overrides(const ty_scene_editor* editor, char*** out, int32_t* count);
void ty_scene_editor_free_overrides(const ty_scene_editor* editor, char** overrides, int32_t count);

#endif
