/* Conversion of images, volumes and scenes by tyndall convert. */
#ifndef TY_CLI_CONVERT_CONVERT_H
#define TY_CLI_CONVERT_CONVERT_H

#include "cli/session/session.h"

typedef struct convert_image_options {
    const char *layer, *channel; /* NULL: all layers, and the first of them for formats with one */
    double exposure, scale;
    int curve;    /* 0 none, 1 filmic */
    int32_t bits; /* bits of a PNG: 8 (also for 0) or 16 */
    int texels;   /* a ty_texel_format; -1: that of the file */
    int32_t slices, zstd;
    bool mipmaps;
    double range; /* of rgbm; 0: the image's */
} convert_image_options;

typedef struct convert_volume_options {
    ty_volume_def def;
    const char *grid, *codec; /* NULL: by the file, and that of the format */
    bool half, vector;
} convert_volume_options;

/* Checks the codec of a volume by the extension of its file; NULL becomes the format's first one. */
int cli_check_codec(const char* command, const char** codec, const char* output);

/* All return an exit status. */
int cli_convert_volume(cli_session* session, convert_volume_options* options, const char* input, const char* output);
int cli_convert_image(cli_session* session, const convert_image_options* options, const char* input,
                      const char* output);
/* partial: files that are missing are left out. */
int cli_convert_scene(cli_session* session, bool partial, const char* input, const char* output);

#endif
