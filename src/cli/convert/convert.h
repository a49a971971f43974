/* Conversion of images and of volumes by tyndall convert. */
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

/* Both return an exit status. */
int cli_convert_volume(cli_session* session, convert_volume_options* options, const char* input, const char* output);
int cli_convert_image(cli_session* session, const convert_image_options* options, const char* input,
                      const char* output);

#endif
