/* Internal representation of images. */
#ifndef TY_IMAGE_IMAGE_H
#define TY_IMAGE_IMAGE_H

#include <tyndall/image.h>

enum {
    TY_IMAGE_SIDE_MAX = 65536,
    TY_IMAGE_OFFSET_MAX = 1 << 20,
    TY_IMAGE_CHANNELS_MAX = 1024,
    TY_IMAGE_NAME_MAX = 254,
    TY_METADATA_KEY_MAX = 31
};

typedef struct ty_metadata {
    char key[TY_METADATA_KEY_MAX + 1];
    char* text;
    bool is_number;
    double number;
} ty_metadata;

struct ty_image {
    ty_context* context;
    int32_t width, height, channel_count;
    int32_t frame[4];    /* x, y, width, height: see ty_image_set_frame */
    size_t plane_stride; /* floats from one plane to the next: width*height, rounded up to 64 bytes */
    char** names;
    float* pixels;
    ty_metadata* metadata;
    size_t metadata_count, metadata_capacity;
};

/* Creates an image of another size with the same channels and metadata, but its own frame. */
ty_result ty_image_create_like(ty_context* context, const ty_image* image, int32_t width, int32_t height,
                               ty_image** out);
ty_result ty_image_copy_metadata(const ty_image* from, ty_image* to);

/* Takes a channel out of an image, if it has it; metadata stays behind. */
ty_result ty_image_drop_channel(ty_context* context, ty_image** image, const char* name);

/* Creates an image of the named channels, each from the second image if it has it, else from the first, which must.
 * Both have the same size; frame and metadata are the first's. Errors: TY_ERROR_MEMORY. */
ty_result ty_image_select(ty_context* context, const ty_image* first, const ty_image* second, int32_t count,
                          const char* const* names, ty_image** out);

/* A rectangle of pixels in a frame: x0 <= x < x1, y0 <= y < y1; empty when x0 >= x1 or y0 >= y1. */
typedef struct ty_window {
    int32_t x0, y0, x1, y1;
} ty_window;

/* The window of an image's pixels in its frame. */
ty_window ty_image_window(const ty_image* image);
/* The intersection of two windows. */
ty_window ty_window_intersection(ty_window a, ty_window b);
/* The index in a plane of the pixel at (x, y) of the frame. */
size_t ty_image_index(const ty_image* image, int32_t x, int32_t y);

/* True if a key is well formed and not an attribute written by OpenEXR itself. */
bool ty_metadata_key_allowed(const char* key);

/* IEC 61966-2-1, display to linear, for x in 0..1. */
float ty_linear_from_srgb(float x);
/* The display transform of one value: times scale, the curve, sRGB. 0 for NaN. */
uint8_t ty_tone_byte(float value, float scale, ty_tone_curve curve);

/* The shortest decimal form that reads back as exactly value, with a point whatever the locale. */
enum { TY_NUMBER_TEXT_SIZE = 40 };
void ty_number_text(double value, char text[TY_NUMBER_TEXT_SIZE]);

#endif
