/* What the command line keeps in the metadata of images, and reads back. */
#ifndef TY_CLI_METADATA_H
#define TY_CLI_METADATA_H

#include <tyndall/image.h>

/* The full vertical angle of view of the frame, degrees. */
extern const char* const cli_fov_key;

/* A number in an image's metadata; false if there is none under this key, and then *out stays as it is. */
bool cli_metadata_number(const ty_image* image, const char* key, double* out);

#endif
