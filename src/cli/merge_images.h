/* Merging renderings of one scene: means weighted by samples, and crops put back into their frame. */
#ifndef TY_CLI_MERGE_IMAGES_H
#define TY_CLI_MERGE_IMAGES_H

#include <tyndall/tyndall.h>

enum { CLI_MESSAGE_SIZE = 1024 };

typedef struct cli_piece {
    const char* path; /* for messages */
    const ty_image* image;
} cli_piece;

/* Pixels weigh what samples.N says, or tyndall.spp where there is no such channel. Channels are weighted means, of
 * depth.Z over the pieces that see a surface; variance.* are the variances of such means; normals have unit length.
 * Where weights differ between pixels of the result, it has samples.N. Its metadata adds up what the pieces took.
 * On failure message is one sentence, and the result is TY_ERROR_INPUT when pieces do not belong together. */
ty_result cli_merge_images(ty_context* context, int count, const cli_piece* pieces, ty_image** out,
                           char message[CLI_MESSAGE_SIZE]);

#endif
