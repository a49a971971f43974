/* Denoised layers of images, for `tyndall denoise` and `tyndall render --denoise`. */
#ifndef TY_CLI_DENOISE_DENOISED_H
#define TY_CLI_DENOISE_DENOISED_H

#include "cli/session/session.h"

/* Says that a denoiser, of which 0 is the default, is absent here: CLI_GO, or CLI_USAGE after a message. */
int cli_check_denoiser(cli_session* session, int denoiser);
/* Denoises an image and adds the layers to it. Of its own channels those that `keep` accepts stay; NULL: all. Results
 * as of ty_denoise_image; after an error *image is as it was. */
ty_result cli_add_denoised(cli_session* session, const ty_denoise_def* def, bool (*keep)(void* user, const char* name),
                           void* user, ty_image** image, ty_denoise_stats* stats);
/* Puts the estimated error into an image's metadata. */
ty_result cli_denoised_metadata(ty_image* image, const ty_denoise_stats* stats);
/* Prints the line about it. */
void cli_print_denoised(const ty_denoise_stats* stats);
/* Adds "denoise" to --stats. */
void cli_denoised_json(json_writer* json, const ty_denoise_stats* stats);
/* Writes the layer of denoised light as a PNG. */
ty_result cli_write_denoised_png(cli_session* session, const ty_image* image, double exposure, const char* path);

#endif
