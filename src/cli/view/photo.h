/* A photograph through tyndall screen, for the viewer: options, which are a document that changes, and images. */
#ifndef TY_CLI_VIEW_PHOTO_H
#define TY_CLI_VIEW_PHOTO_H

#include "cli/screen/screen_options.h"
#include "io/scenes/scene_editor.h"

typedef struct view_photo view_photo;

typedef struct view_photo_def {
    screen_options* options;
    const char *image, *distance; /* paths; distance NULL: a channel of the image */
} view_photo_def;

/* Reads the files. CLI_GO, or an exit status after a message. */
int view_photo_open(cli_session* session, const view_photo_def* def, view_photo** out);
/* NULL is allowed. */
void view_photo_close(view_photo* photo);

typedef enum view_photo_edit {
    VIEW_PHOTO_MEDIUM = 1, /* what is cheap: medium, light around */
    VIEW_PHOTO_FILTER = 2  /* all else */
} view_photo_edit;

/* Applies all changes, or none, as ty_scene_editor_apply does; *edited: view_photo_edit. */
ty_result view_photo_apply(view_photo* photo, const ty_scene_change* changes, int32_t count, uint32_t* edited);
/* The document as compact JSON, until the next change. */
const char* view_photo_text_of(const view_photo* photo);
/* Its schema, borrowed; does not change. */
const json_t* view_photo_schema_of(const view_photo* photo);
/* The medium as JSON text, as --medium takes it, freed with free(); NULL without memory. */
char* view_photo_medium(const view_photo* photo);
/* The command that writes the image to out.exr, freed with free(); NULL without memory. */
char* view_photo_command(const view_photo* photo);

int32_t view_photo_width(const view_photo* photo);
int32_t view_photo_height(const view_photo* photo);
/* True for the variant that takes a time quadratic in the number of pixels. */
bool view_photo_is_quadratic(const view_photo* photo);
/* The photograph itself, 3 values per pixel. */
void view_photo_pixels(const view_photo* photo, float* rgb);
/* The image seen through the medium, its sides divided: at 1 that of tyndall screen. stats: with all fields 0. Errors:
 * those of ty_screen_apply. */
ty_result view_photo_render(view_photo* photo, int32_t divisor, ty_progress_fn progress, void* user, ty_image** out,
                            ty_screen_stats* stats);

#endif
