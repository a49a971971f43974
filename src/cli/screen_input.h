/* What goes into tyndall screen: an image, the distances of its pixels, a camera, and the light around. */
#ifndef TY_CLI_SCREEN_INPUT_H
#define TY_CLI_SCREEN_INPUT_H

#include "cli/screen_options.h"

typedef struct screen_input {
    const char *image_path, *distance_path; /* one and the same where the image has the distances */
    ty_image* image;
    ty_image* distances; /* NULL: the image has them */
    const float* color[3];
    float* distance; /* in one of the images */
    int32_t width, height;
    int64_t filled; /* distances by --sky fill */
} screen_input;

/* Reads the files; distance_path NULL: a channel of the image. An exit status; closing is for the caller either way. */
int screen_open_input(cli_session* session, const screen_options* options, const char* image_path,
                      const char* distance_path, screen_input* out);
void screen_close_input(screen_input* input);

/* Makes metres of the distances as they were read, in place, and fills holes if that is asked for. */
int screen_prepare_distances(cli_session* session, const screen_options* options, screen_input* input);

/* Focal length and principal point, from the options or the image. */
int screen_set_camera(const screen_options* options, const screen_input* input, ty_screen_def* def);
/* The light around, and what --balance makes of it. */
int screen_set_environment(cli_session* session, const screen_options* options, ty_screen_def* def);

#endif
