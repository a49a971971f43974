/* Metadata of images that the command line writes and reads. */
#include "cli/session/metadata.h"
#include "cli/options/options.h"

const char* const cli_fov_key = "tyndall.camera.fov_y";

bool cli_metadata_number(const ty_image* image, const char* key, double* out) {
    const char* text = ty_image_get_metadata(image, key);
    double value = 0;
    if (text == NULL || !cli_parse_real(text, &value)) return false;
    *out = value;
    return true;
}
