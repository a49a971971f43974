/* Tyndall: images of named float channels. Apache-2.0.
 *
 * Channels are planes of width*height floats, row by row from the top left. Colour is linear Rec.709. */
#ifndef TYNDALL_IMAGE_H
#define TYNDALL_IMAGE_H

#include <tyndall/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Planes of floats with names, their place in a frame, and metadata. */
typedef struct ty_image ty_image;

/* names: channel_count names ("R", "G", "B", "depth.Z"), each 1..254 characters, no two alike. Pixels start at 0.
 * Sides 1..65536. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_image_create(ty_context* context, int32_t width, int32_t height, int32_t channel_count,
                                 const char* const* names, ty_image** out);
/* The same with the channels R, G, B. */
TY_API ty_result ty_image_create_rgb(ty_context* context, int32_t width, int32_t height, ty_image** out);
/* Frees an image; NULL is allowed. */
TY_API void ty_image_destroy(ty_image* image);

/* Pixels in a row. */
TY_API int32_t ty_image_width(const ty_image* image);
/* Rows. */
TY_API int32_t ty_image_height(const ty_image* image);
/* How many channels there are. */
TY_API int32_t ty_image_channel_count(const ty_image* image);
/* The name of a channel; valid as long as the image. */
TY_API const char* ty_image_channel_name(const ty_image* image, int32_t channel);
/* The index of a channel by name, -1 if there is none. */
TY_API int32_t ty_image_find_channel(const ty_image* image, const char* name);
/* The plane of a channel: width*height floats, valid as long as the image. */
TY_API float* ty_image_plane(ty_image* image, int32_t channel);
/* The same to read. */
TY_API const float* ty_image_plane_const(const ty_image* image, int32_t channel);
/* The planes of R, G and B; of one channel three times where there is only one, whatever its name, or a Y without an X.
 * Returns false when the image has neither. */
TY_API bool ty_image_rgb_planes(const ty_image* image, const float* planes[3]);

/* Where the pixels lie in a frame of width x height pixels (EXR: data window in display window), x to the right and y
 * down; they may reach beyond it. A new image fills its frame. All functions on pixels but ty_image_fill_frame and
 * ty_image_compare, and the PNG writers, see the pixels alone. Errors: TY_ERROR_ARGUMENT (a frame outside 1..65536, an
 * offset beyond 2^20 either way). */
TY_API ty_result ty_image_set_frame(ty_image* image, int32_t x, int32_t y, int32_t width, int32_t height);
/* frame: x, y, width, height as above. */
TY_API void ty_image_get_frame(const ty_image* image, int32_t frame[4]);
/* A copy that fills the frame: 0 where there were no pixels. Channels and metadata come along.
 * Errors: TY_ERROR_MEMORY. */
TY_API ty_result ty_image_fill_frame(ty_context* context, const ty_image* image, ty_image** out);

/* Sets metadata, written as EXR attributes and read back. key: 1..31 of [A-Za-z0-9_.]; setting again replaces.
 * Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_image_set_text(ty_image* image, const char* key, const char* value);
/* The same with a number. */
TY_API ty_result ty_image_set_number(ty_image* image, const char* key, double value);
/* How many keys there are. */
TY_API int32_t ty_image_metadata_count(const ty_image* image);
/* The key of an index, in the order of their setting; NULL past the end. */
TY_API const char* ty_image_metadata_key(const ty_image* image, int32_t index);
/* Whether the value is a number; false past the end. */
TY_API bool ty_image_metadata_is_number(const ty_image* image, int32_t index);
/* The value as text; numbers in the shortest form that reads back exactly. NULL if the key is absent. */
TY_API const char* ty_image_get_metadata(const ty_image* image, const char* key);

/* How an image differs from a reference, per channel (R, G, B) and over all three together ([3]). */
typedef struct ty_difference {
    double mean_ratio[4];    /* mean(a) / mean(b) */
    double rmse[4];          /* sqrt(mean((a - b)^2)) */
    double relative_rmse[4]; /* rmse / mean(b) */
    double rel_mse[4];       /* mean((a - b)^2 / (b^2 + 0.01 mean(b)^2)), robust to bright pixels */
    int64_t not_finite;      /* values of either image that were NaN or Inf and left out */
    int64_t differing;       /* values whose bits differ */
} ty_difference;

/* Images are compared where both have pixels; their frames must be of one size. block > 1 compares means over
 * block x block pixels (partial blocks at the edges are left out).
 * Errors: TY_ERROR_ARGUMENT (frames differ, no common pixel, no RGB, block larger than the common part). */
TY_API ty_result ty_image_compare(ty_context* context, const ty_image* a, const ty_image* b, int32_t block,
                                  ty_difference* out);

/* Display transform: 2^exposure, a filmic curve that keeps values below 0.5 nearly linear and maps infinity to 1, then
 * the sRGB curve. rgb8: width*height*3 bytes. curve false: clip at 1 instead of the curve.
 * Errors: TY_ERROR_ARGUMENT. */
TY_API ty_result ty_image_tonemap(ty_context* context, const ty_image* image, double exposure, bool curve,
                                  uint8_t* rgb8);

#ifdef __cplusplus
}
#endif
#endif
