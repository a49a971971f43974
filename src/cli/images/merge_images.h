/* Merging renderings of one scene: means weighted by samples, and crops put back into their frame. */
#ifndef TY_CLI_IMAGES_MERGE_IMAGES_H
#define TY_CLI_IMAGES_MERGE_IMAGES_H

#include <tyndall/tyndall.h>

enum { CLI_MESSAGE_SIZE = 1024 };

typedef struct cli_piece {
    const char* path; /* for messages */
    const ty_image* image;
} cli_piece;

/* The weight of a pixel is samples.N, or tyndall.spp without such a channel. Channels are weighted means, depth.Z over
 * the inputs that hit a surface; variance.* are the variances of such means; normals have unit length. The result has
 * samples.N where weights differ between its pixels. Its metadata holds the summed costs of the inputs. On failure
 * message is one sentence, and the result is TY_ERROR_INPUT when inputs do not belong together. */
ty_result cli_merge_images(ty_context* context, int count, const cli_piece* pieces, ty_image** out,
                           char message[CLI_MESSAGE_SIZE]);

#endif
