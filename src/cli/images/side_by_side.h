/* Images in a row, with a label above each. */
#ifndef TY_CLI_IMAGES_SIDE_BY_SIDE_H
#define TY_CLI_IMAGES_SIDE_BY_SIDE_H

#include <tyndall/tyndall.h>

typedef struct cli_panel {
    const ty_image* image; /* shown in its frame; all frames are of one size */
    const char* label;     /* truncated where too long; shown in capitals */
} cli_panel;

/* Writes a PNG of all panels at one exposure. */
ty_result cli_write_side_by_side(ty_context* context, const cli_panel* panels, int count, double exposure,
                                 const char* path);

#endif
