/* Image options common to the methods, with one validation. */
#ifndef TY_IMAGE_OPTIONS_H
#define TY_IMAGE_OPTIONS_H

#include <tyndall/path.h>

typedef struct ty_image_options {
    int32_t width, height; /* pixels; both 0: the camera's */
    int32_t spp;
    uint64_t seed;
    double step;   /* as ty_march_def.step */
    uint32_t aovs; /* TY_AOV_... */
} ty_image_options;

/* method: prefix of field names in messages; known: all TY_AOV_... supported by the method. Errors: TY_ERROR_ARGUMENT.
 */
ty_result ty_check_image(ty_context* context, const char* method, const ty_image_options* options, uint32_t known);
/* Validates width and height only. */
ty_result ty_check_resolution(ty_context* context, const char* method, int32_t width, int32_t height);
/* Resolution of the image: that of the camera where the options leave it unset. */
void ty_image_resolution(const ty_scene* scene, int32_t width, int32_t height, int32_t size[2]);

#endif
