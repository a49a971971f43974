/// @file denoise.h
/// Noise removal from path-traced images by regression on noise-free channels.
///
/// docs/denoise.md explains the method and measures it. Results do not depend on the number of threads. Apache-2.0.
#ifndef TYNDALL_DENOISE_H
#define TYNDALL_DENOISE_H

#include <tyndall/base.h>
#include <tyndall/image.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Flags of ty_aov with which ty_path_render() gives ty_denoise_image() all that it can use.
#define TY_DENOISE_AOVS                                                                                                \
    (TY_AOV_VARIANCE | TY_AOV_TRANSMITTANCE | TY_AOV_DEPTH | TY_AOV_NORMAL | TY_AOV_ALBEDO | TY_AOV_SINGLE |           \
     TY_AOV_MULTIPLE | TY_AOV_SURFACE_ALBEDO | TY_AOV_HALF)

/// The largest number of images in ty_denoise_def.features.
#define TY_DENOISE_FEATURES_MAX 4

/// The programs that remove noise.
typedef enum ty_denoiser {
    TY_DENOISER_REGRESSION = 0, ///< Tyndall's own first-order regression.
    TY_DENOISER_OIDN = 1        ///< Intel Open Image Denoise (https://www.openimagedenoise.org), versions 1 and 2: the
                                ///< shared library of the machine, loaded at run time. Tyndall does not come with it.
} ty_denoiser;

/// The options of denoising. Create it with ty_default_denoise_def().
typedef struct ty_denoise_def {
    uint32_t cookie; ///< Set by ty_default_denoise_def() and checked.
    uint32_t bytes;  ///< Set by ty_default_denoise_def() to the size of the structure, and checked.
    const ty_image* features[TY_DENOISE_FEATURES_MAX]; ///< Noise-free images of the same size whose R, G, B help to
                                                       ///< predict the light, such as that of a method without noise;
                                                       ///< default NULL: none.
    const ty_image* previous; ///< The image before it in a sequence, of the same size: denoised.R, .G, .B and
                              ///< denoised_error.R, .G, .B as ty_denoise_image() gives them, with the channels of first
                              ///< hits where `image` has them. Its light is used where both agree. Default NULL.
    const int32_t* charts;    ///< A number per pixel, row by row: only pixels of the same number are used for one
                           ///< another, and those of negative numbers are left as they are, for lightmaps whose charts
                           ///< are no neighbours on the surface. Default NULL: all pixels are of one chart.
    bool parts; ///< True (default): light that media scattered once and otherwise, and the rest, are denoised
                ///< apart where the image has these channels.
    ty_progress_fn progress; ///< Default NULL.
    void* progress_user;     ///< Passed on to `progress`; default NULL.
    ty_denoiser denoiser;    ///< Default TY_DENOISER_REGRESSION. TY_DENOISER_OIDN filters both halves with the image's
                             ///< albedo and normals; it knows neither `features` nor `parts`, and no `charts`.
} ty_denoise_def;

/// Sets the `bytes` bytes of a ty_denoise_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_denoise_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_denoise_def ty_default_denoise_def(void) {
    ty_denoise_def def;
    ty_init_denoise_def(&def, sizeof def);
    return def;
}

/// TY_OK if ty_denoise_image() can use a denoiser on this machine. Errors: TY_ERROR_UNSUPPORTED (its library is absent,
/// and the message says which), TY_ERROR_ARGUMENT.
TY_API ty_result ty_denoiser_is_available(ty_context* context, ty_denoiser denoiser);

/// Statistics of denoising. Create them with ty_default_denoise_stats().
typedef struct ty_denoise_stats {
    uint32_t cookie;  ///< Set by ty_default_denoise_stats() and checked.
    uint32_t bytes;   ///< Set by ty_default_denoise_stats() to the size of the structure.
    double seconds;   ///< Wall clock time, s.
    double error;     ///< Estimated relative error of the denoised image: root mean square error over mean. With
                      ///< ty_denoise_def.previous that without the previous image: what moved may leave traces
                      ///< that no estimate knows.
    double raw_error; ///< Estimated relative error of the image as it was, in the same way.
    int32_t parts;    ///< Number of parts that were denoised apart, 1 to 3.
    int32_t features; ///< Number of planes that light was regressed on.
    double previous;  ///< Mean weight of the previous image, 0..1.
    const char* isa;  ///< Instruction set of the kernels: "x86-64", "x86-64-v3", "x86-64-v4" or "generic".
} ty_denoise_stats;

/// Statistics with all fields 0.
static inline ty_denoise_stats ty_default_denoise_stats(void) {
    ty_denoise_stats stats;
    ty_init_stats(&stats, sizeof stats);
    return stats;
}

/// Removes noise from R, G, B of an image by first-order regression on its other channels. It needs the channels
/// half.R, .G, .B (TY_AOV_HALF), and uses single, multiple, transmittance, depth, normal, albedo and surface_albedo
/// with their halves where they are there, and `samples.N` or the metadata `tyndall.spp`, of which there must be 2 or
/// more. The result has the channels denoised.R, .G, .B and denoised_error.R, .G, .B, an estimate of the former's
/// standard error with bias, and the frame of the image, which stays as it is. Values that are not finite count as 0.
/// stats may be NULL. Errors: TY_ERROR_ARGUMENT (also images of other sizes, and previous without its channels),
/// TY_ERROR_INPUT (missing channels of image), TY_ERROR_MEMORY, TY_CANCELLED; of TY_DENOISER_OIDN TY_ERROR_UNSUPPORTED
/// without its library, and TY_ERROR_INTERNAL with its message.
TY_API ty_result ty_denoise_image(ty_context* context, const ty_image* image, const ty_denoise_def* def, ty_image** out,
                                  ty_denoise_stats* stats);

#ifdef __cplusplus
}
#endif
#endif
