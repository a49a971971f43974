/// @file image.h
/// Images of named float channels.
///
/// A channel is a plane of width * height floats, row by row from the top left. Colour is linear Rec.709. Apache-2.0.
#ifndef TYNDALL_IMAGE_H
#define TYNDALL_IMAGE_H

#include <tyndall/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Named planes of floats, a frame that they lie in, and metadata.
typedef struct ty_image ty_image;

/// The channels that renderers write beside R, G and B, as flags. All are means over the samples of a pixel.
typedef enum ty_aov {
    TY_AOV_VARIANCE = 1,      ///< variance.R, .G, .B: variance of the pixel's mean.
    TY_AOV_TRANSMITTANCE = 2, ///< transmittance.R, .G, .B: of the media up to the first surface.
    TY_AOV_DEPTH = 4,     ///< depth.Z: distance from the camera along the ray to the first surface, m; the mean over
                          ///< the samples that hit one, 0 where none did.
    TY_AOV_NORMAL = 8,    ///< normal.X, .Y, .Z: unit normal of the first surface, facing the camera; 0 without one.
    TY_AOV_ALBEDO = 16,   ///< albedo.R, .G, .B: fraction of the light that media scatter before the first surface.
                          ///< 1 - transmittance - albedo is absorbed, and albedo / (1 - transmittance) is the volume
                          ///< albedo that the camera sees.
    TY_AOV_SINGLE = 32,   ///< single.R, .G, .B: radiance of light that a medium scattered once, and that nothing else
                          ///< scattered or reflected.
    TY_AOV_MULTIPLE = 64, ///< multiple.R, .G, .B: all other radiance that a medium scattered. The remainder of R, G, B
                          ///< never scattered in a medium: emission and surfaces.
    TY_AOV_SAMPLES = 128, ///< samples.N: number of samples; it varies over a partial result only.
    TY_AOV_SURFACE_ALBEDO = 512, ///< surface_albedo.R, .G, .B: albedo of the first surface (of glossy ones their
                                 ///< directional albedo towards the camera) times the transmittance of the media up to
                                 ///< it; 0 without one.
    TY_AOV_ALL = 255 | 512,      ///< All of the above.
    TY_AOV_HALF = 256 ///< half.R, .G, .B, and half.single.R and so on for each of the channels above but variance and
                      ///< samples that the image has: means over the even half of the samples, which is
                      ///< independent of the odd half. Their difference tells noise (ty_denoise_image()).
} ty_aov;

/// Creates an image with pixels of 0. names: channel_count names such as "R" or "depth.Z", each of 1..254 characters,
/// no two alike. Sides are 1..65536. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_image_create(ty_context* context, int32_t width, int32_t height, int32_t channel_count,
                                 const char* const* names, ty_image** out);
/// Creates an image with the channels R, G, B. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_image_create_rgb(ty_context* context, int32_t width, int32_t height, ty_image** out);
/// Destroys an image; NULL is allowed.
TY_API void ty_image_destroy(ty_image* image);

/// Number of pixels in a row.
TY_API int32_t ty_image_width(const ty_image* image);
/// Number of rows.
TY_API int32_t ty_image_height(const ty_image* image);
/// Number of channels.
TY_API int32_t ty_image_channel_count(const ty_image* image);
/// Name of a channel; valid as long as the image.
TY_API const char* ty_image_channel_name(const ty_image* image, int32_t channel);
/// Index of the channel with a name; -1 without one.
TY_API int32_t ty_image_find_channel(const ty_image* image, const char* name);
/// Plane of a channel: width * height floats, valid as long as the image.
TY_API float* ty_image_plane(ty_image* image, int32_t channel);
/// Plane of a channel, for reading.
TY_API const float* ty_image_plane_const(const ty_image* image, int32_t channel);
/// Stores the planes of R, G and B. An image with a single channel gives that plane three times, as does one with a Y
/// but no X. Returns false when the image has no such channels.
TY_API bool ty_image_rgb_planes(const ty_image* image, const float* planes[3]);

/// Places the pixels in a frame of width x height pixels, at (x, y) from its top left corner: the data window in the
/// display window of EXR files. The pixels may reach beyond the frame. A new image fills its frame. Of the functions on
/// pixels, ty_image_create_full_frame(), ty_image_compare() and the PNG writers alone look at the frame.
/// Errors: TY_ERROR_ARGUMENT (a frame outside 1..65536, an offset beyond 2^20 either way).
TY_API ty_result ty_image_set_frame(ty_image* image, int32_t x, int32_t y, int32_t width, int32_t height);
/// Stores the frame: x, y, width, height.
TY_API void ty_image_get_frame(const ty_image* image, int32_t frame[4]);
/// Creates a copy that fills the frame, with 0 where the image has no pixels, and the same channels and metadata.
/// Errors: TY_ERROR_MEMORY.
TY_API ty_result ty_image_create_full_frame(ty_context* context, const ty_image* image, ty_image** out);

/// Sets a text in the metadata, which are attributes in EXR files. key: 1..31 of [A-Za-z0-9_.]. An earlier value of the
/// key is replaced. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_image_set_text(ty_image* image, const char* key, const char* value);
/// Sets a number in the metadata; otherwise as ty_image_set_text().
TY_API ty_result ty_image_set_number(ty_image* image, const char* key, double value);
/// Number of keys in the metadata.
TY_API int32_t ty_image_metadata_count(const ty_image* image);
/// Key at an index, in the order in which keys were set; NULL past the end.
TY_API const char* ty_image_metadata_key(const ty_image* image, int32_t index);
/// Tells whether the value at an index is a number; false past the end.
TY_API bool ty_image_metadata_is_number(const ty_image* image, int32_t index);
/// Value of a key as text, numbers in the shortest form that reads back exactly; NULL without the key.
TY_API const char* ty_image_get_metadata(const ty_image* image, const char* key);

/// The difference of an image a from a reference b, per channel R, G, B and over all three ([3]).
typedef struct ty_difference {
    double mean_ratio[4];    ///< mean(a) / mean(b).
    double rmse[4];          ///< sqrt(mean((a - b)^2)).
    double relative_rmse[4]; ///< rmse / mean(b).
    double rel_mse[4];       ///< mean((a - b)^2 / (b^2 + 0.01 mean(b)^2)), which is robust to bright pixels.
    int64_t not_finite;      ///< Number of values of either image that are NaN or infinite; they are left out.
    int64_t differing;       ///< Number of values whose bits differ.
} ty_difference;

/// Compares two images where both have pixels; their frames must have the same size. With block > 1, means over blocks
/// of block x block pixels are compared, without the partial blocks at the edges.
/// Errors: TY_ERROR_ARGUMENT (frames of different sizes, no common pixel, no RGB, a block larger than the common part).
TY_API ty_result ty_image_compare(ty_context* context, const ty_image* a, const ty_image* b, int32_t block,
                                  ty_difference* out);

/// The curve that a display transform applies before the sRGB curve.
typedef enum ty_tone_curve {
    TY_TONE_CLIP = 0,  ///< Values above 1 are clipped.
    TY_TONE_FILMIC = 1 ///< A filmic curve that keeps values below 0.5 nearly linear and maps infinity to 1.
} ty_tone_curve;

/// Converts an image for display: it multiplies by 2^exposure, then applies the tone curve, then the sRGB curve.
/// rgb8: width * height * 3 bytes. Errors: TY_ERROR_ARGUMENT.
TY_API ty_result ty_image_tonemap(ty_context* context, const ty_image* image, double exposure, ty_tone_curve curve,
                                  uint8_t* rgb8);

#ifdef __cplusplus
}
#endif
#endif
