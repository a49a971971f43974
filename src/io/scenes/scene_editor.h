/* Calls of scene editors that the viewer alone uses: changes since a scene was opened, for saving. */
#ifndef TY_IO_SCENE_EDITOR_H
#define TY_IO_SCENE_EDITOR_H

#include <jansson.h>
#include <tyndall/io.h>
#include <tyndall/scene_editor.h>

/* Changes a document, without a check of what it holds then; on failure it may hold some of the objects on the way. */
ty_result ty_change_document(ty_context* context, json_t* root, const ty_scene_change* change);

/* Makes the scene of another editor's document, which that one has of the same file (ty_scene_editor_text). Errors: as
 * ty_scene_editor_apply. */
ty_result ty_scene_editor_follow(ty_scene_editor* editor, const char* text);

/* ---- changes since the file was opened, overrides included ---- */

/* The file's text with only the changed values replaced, inserted and removed: spaces, the order of keys and other
 * numbers are as in the file. *out is freed with ty_free_text. Errors: TY_ERROR_MEMORY. */
ty_result ty_scene_editor_save_text(const ty_scene_editor* editor, char** out);
/* The changes as overrides, "media[0].g=0.5", with which ty_scene_load makes the same scene of the file. They are freed
 * with ty_scene_editor_free_overrides. Errors: TY_ERROR_MEMORY. */
ty_result ty_scene_editor_overrides(const ty_scene_editor* editor, char*** out, int32_t* count);
void ty_scene_editor_free_overrides(const ty_scene_editor* editor, char** overrides, int32_t count);

#endif
