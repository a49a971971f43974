/* Metadata of images that the command line writes and reads. */
#ifndef TY_CLI_SESSION_METADATA_H
#define TY_CLI_SESSION_METADATA_H

#include <tyndall/image.h>

/* The full vertical angle of view of the frame, degrees. */
extern const char* const cli_fov_key;

/* Reads a number from an image's metadata; false, with *out unchanged, if the key is missing. */
bool cli_metadata_number(const ty_image* image, const char* key, double* out);

#endif
