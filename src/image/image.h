/* The insides of images. */
#ifndef TY_IMAGE_IMAGE_H
#define TY_IMAGE_IMAGE_H

#include <tyndall/image.h>

enum { TY_IMAGE_SIDE_MAX = 65536, TY_IMAGE_CHANNELS_MAX = 1024, TY_METADATA_KEY_MAX = 31 };

typedef struct ty_metadata {
    char key[TY_METADATA_KEY_MAX + 1];
    char* text;
    bool is_number;
    double number;
} ty_metadata;

struct ty_image {
    ty_context* context;
    int32_t width, height, channel_count;
    int32_t frame[4];    /* x, y, width, height, see ty_image_set_frame */
    size_t plane_stride; /* floats from one plane to the next: width*height, rounded up to 64 bytes */
    char** names;
    float* pixels;
    ty_metadata* metadata;
    size_t metadata_count, metadata_capacity;
};

/* Whether a key is well formed and not an attribute that OpenEXR itself writes. */
bool ty_metadata_key_allowed(const char* key);

/* The shortest decimal form that reads back as exactly value, with a point whatever the locale. */
enum { TY_NUMBER_TEXT_SIZE = 40 };
void ty_number_text(double value, char text[TY_NUMBER_TEXT_SIZE]);

#endif
