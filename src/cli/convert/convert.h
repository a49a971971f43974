/* Image conversion of tyndall convert. */
#ifndef TY_CLI_CONVERT_CONVERT_H
#define TY_CLI_CONVERT_CONVERT_H

#include "cli/session/session.h"

typedef struct convert_image_options {
    const char *layer, *channel; /* NULL: all layers, and the first of them for formats with one */
    double exposure, scale;
    int curve;    /* 0 none, 1 filmic */
    int32_t bits; /* bits of a PNG: 8 (also for 0) or 16 */
} convert_image_options;

/* Returns an exit status. */
int cli_convert_image(cli_session* session, const convert_image_options* options, const char* input,
                      const char* output);

#endif
