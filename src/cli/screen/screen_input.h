/* Inputs of tyndall screen: an image, the distances of its pixels, a camera, and the ambient light. */
#ifndef TY_CLI_SCREEN_SCREEN_INPUT_H
#define TY_CLI_SCREEN_SCREEN_INPUT_H

#include "cli/screen/screen_options.h"

typedef struct screen_input {
    const char *image_path, *distance_path; /* the same image where it has the distances */
    ty_image* image;
    ty_image* distances; /* NULL: the image has the distances */
    const float* color[3];
    float* distance; /* channel of one of the images */
    int32_t width, height;
    int64_t filled; /* number of distances set by --sky fill */
} screen_input;

/* Reads the files; distance_path NULL: a channel of the image. Returns an exit status; the caller closes in any case.
 */
int screen_open_input(cli_session* session, const screen_options* options, const char* image_path,
                      const char* distance_path, screen_input* out);
void screen_close_input(screen_input* input);

/* Converts the distances to metres in place, and fills holes on request. */
int screen_prepare_distances(cli_session* session, const screen_options* options, screen_input* input);

/* The radiance around, of --environment. */
int screen_read_environment(cli_session* session, const screen_options* options, float out[3]);
/* Sets all fields of the def but for its progress; the camera comes from the options or the image. */
int screen_make_def(const screen_options* options, const screen_input* input, const ty_medium_def* medium,
                    const float around[3], ty_screen_def* def);
/* The call's images: out has planes of the input's size. */
ty_screen_image screen_describe_image(const screen_input* input, float* const out[3]);

#endif
