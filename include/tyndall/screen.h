/// @file screen.h
/// Screen-space scattering: fog or water over one HDR image and its distances.
///
/// After Elek, Ritschel, Seidel: Real-Time Screen-Space Scattering in Homogeneous Environments (2013); equation numbers
/// are the paper's. docs/method/screen.md explains the method, its accuracy, and the departures from the paper.
///
/// All memory belongs to the caller: input planes of colour and distance, output planes of colour, and optionally a
/// workspace. Nothing is kept after a call. Apache-2.0.
#ifndef TYNDALL_SCREEN_H
#define TYNDALL_SCREEN_H

#include <tyndall/base.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The filter that spreads light.
typedef enum ty_screen_variant {
    TY_SCREEN_SCATTER = 0,  ///< Not in the paper: the light of each pixel is spread by its own width, per channel, and
                            ///< none is lost.
    TY_SCREEN_GATHER = 1,   ///< The paper's: each pixel looks up a masked pyramid at the level of its own distance.
    TY_SCREEN_REFERENCE = 2 ///< The exact, spatially varying point spread function, pixel by pixel; slow.
} ty_screen_variant;

/// The point spread function.
typedef enum ty_screen_spread {
    TY_SCREEN_SPREAD_SMALL_ANGLE = 0, ///< Multiple small-angle scattering by the Henyey-Greenstein function, in closed
                                      ///< form: a sharp core with long tails, as path tracing shows
                                      ///< (docs/method/screen.md). It grows up to a scattering optical thickness of 76.
    TY_SCREEN_SPREAD_GAUSSIAN = 1     ///< The paper's Gaussian (Eq. 2).
} ty_screen_spread;

/// The mask that keeps light of near pixels from leaking into coarse levels (Eq. 7); TY_SCREEN_GATHER.
typedef enum ty_screen_mask {
    TY_SCREEN_MASK_NONE = 0,  ///< A plain pyramid: the naive method.
    TY_SCREEN_MASK_STEP = 1,  ///< A step at the threshold T.
    TY_SCREEN_MASK_SMOOTH = 2 ///< smoothstep from T to (1 + mask_width) T.
} ty_screen_mask;

/// The meaning of distances.
typedef enum ty_screen_distance_kind {
    TY_SCREEN_DISTANCE_RAY = 0, ///< Along the ray of each pixel.
    TY_SCREEN_DISTANCE_AXIS = 1 ///< Along the axis of the camera: a depth buffer.
} ty_screen_distance_kind;

/// A special value of ty_screen_def.levels, and its largest one.
enum {
    TY_SCREEN_LEVELS_ALL = -2, ///< As many as the largest spread needs.
    TY_SCREEN_LEVELS_MAX = 15  ///< Largest number of levels.
};

/// The medium, the camera and the filter. Create it with ty_default_screen_def().
typedef struct ty_screen_def {
    uint32_t cookie; ///< Set by ty_default_screen_def() and checked.
    uint32_t bytes;  ///< Set by ty_default_screen_def() to the size of the structure, and checked.

    float sigma_s[3]; ///< Scattering coefficient of the medium, which fills all space in view, 1/m, >= 0; default 0.
    float sigma_a[3]; ///< Absorption coefficient, 1/m, >= 0; default 0.
    float g[3];       ///< Mean cosine of the phase function, (-1, 1); default 0.

    float environment[3]; ///< Radiance that arrives at the medium from all directions, W m^-2 sr^-1, >= 0; default 0.
                          ///< The part that one scattering sends to the camera is added: environment * sigma_s /
                          ///< sigma_t * (1 - exp(-sigma_t D)). ty_screen_balance() sets it together with `forward`.
    float forward[3]; ///< Fraction of the image's scattered light that still arrives, 0..1; default 1, as in the paper.

    double focal[2];  ///< Focal length along x and y, pixels, > 0; must be set (ty_screen_focal()).
    double center[2]; ///< Principal point, pixels from the left and top edge; default -1, -1: the centre. For a part of
                      ///< a frame it may lie outside.
    ty_screen_distance_kind distance_kind; ///< Default TY_SCREEN_DISTANCE_RAY.
    float missing_depth; ///< Distance of pixels without one (0, negative, infinite, NaN), such as sky, m, > 0; default
                         ///< 1e6.

    ty_screen_variant variant; ///< Default TY_SCREEN_SCATTER.
    ty_screen_spread spread;   ///< TY_SCREEN_SCATTER and TY_SCREEN_REFERENCE; TY_SCREEN_GATHER is Gaussian. Default
                               ///< TY_SCREEN_SPREAD_SMALL_ANGLE.
    int32_t filter;            ///< Taps along x and y from one level to the next: 2, 4 or 6; default 4.
    int32_t levels; ///< K, 1..TY_SCREEN_LEVELS_MAX or TY_SCREEN_LEVELS_ALL. TY_AUTO (default): as many as the largest
                    ///< spread needs, with a Gaussian at most 6, as in the paper. Wider spreads are clamped to those
                    ///< that K levels hold. A side of one pixel ends the pyramid.

    ty_screen_mask mask; ///< TY_SCREEN_GATHER, as are the fields up to level_scale; default TY_SCREEN_MASK_SMOOTH. The
                         ///< defaults are the paper's method with normalised masks.
    float mask_width;    ///< epsilon of Eq. 7, > 0; default 0.5.
    bool luminance_weights; ///< True: Y of Eq. 8 is luminance, instead of 1; default true.
    bool blurred_distance;  ///< True: levels come from a distance map that is blurred by its own level (Eq. 11);
                            ///< default true.
    bool normalise;    ///< True: sums are divided by the filtered mask, so that masks remove no light; default true.
    float level_scale; ///< c of Eq. 7 and 10, pixels, > 0; default 0.8.

    int32_t window; ///< TY_SCREEN_REFERENCE: pixels along x and y that the light of a pixel reaches, 1..65536; 0
                    ///< (default): all that single precision can tell from 0 (6 standard deviations).

    ty_progress_fn progress; ///< TY_SCREEN_REFERENCE; default NULL.
    void* progress_user;     ///< Passed on to `progress`; default NULL.
} ty_screen_def;

/// Sets the `bytes` bytes of a ty_screen_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_screen_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_screen_def ty_default_screen_def(void) {
    ty_screen_def def;
    ty_init_screen_def(&def, sizeof def);
    return def;
}
/// Makes a definition TY_SCREEN_GATHER without masks, weights and blurred distances: the baseline that leaks.
TY_API void ty_screen_naive_def(ty_screen_def* def);
/// Makes a definition TY_SCREEN_GATHER exactly as published: its masks remove light.
TY_API void ty_screen_published_def(ty_screen_def* def);
/// The focal length, in pixels, of a picture that is `height` pixels high with a full vertical angle of view in
/// degrees.
TY_API double ty_screen_focal(int32_t height, double fov_y);
/// Sets `forward` to the fraction of light that the phase function scatters into the forward hemisphere, and
/// `environment` to the remaining fraction of the given radiance, so that a white furnace stays one.
TY_API void ty_screen_balance(ty_screen_def* def, const float radiance[3]);

/// Planes of pixels: channel c of pixel (x, y) is data[c][y * row + x * step].
typedef struct ty_screen_planes {
    float* data[3]; ///< R, G, B.
    ptrdiff_t step; ///< Floats from pixel to pixel: 1 for planes, 4 for interleaved RGBA.
    ptrdiff_t row;  ///< Floats from row to row: the width for planes, 4 * width for interleaved RGBA.
} ty_screen_planes;

/// The input and output of a call. Create it with ty_default_screen_image().
typedef struct ty_screen_image {
    uint32_t cookie;        ///< Set by ty_default_screen_image() and checked.
    uint32_t bytes;         ///< Set by ty_default_screen_image() to the size of the structure, and checked.
    int32_t width;          ///< Pixels in a row, 1..65536; must be set.
    int32_t height;         ///< Rows, 1..65536; must be set.
    ty_screen_planes color; ///< I: radiance, linear Rec.709, read alone; step default 1, the rest must be set. Negative
                            ///< values and NaN count as 0, and +Inf as the largest half, 65504; where there is a
                            ///< medium, values above 1e29 do, too.
    const float* distance;  ///< D, m; must be set.
    ptrdiff_t distance_step; ///< Floats from pixel to pixel; default 1.
    ptrdiff_t distance_row;  ///< Floats from row to row; must be set.
    ty_screen_planes out; ///< J: the result; step default 1, the rest must be set. It may have the planes of `color`.
} ty_screen_image;

/// Sets the `bytes` bytes of a ty_screen_image to the defaults, as ty_init_context_def() does.
TY_API void ty_init_screen_image(void* def, size_t bytes);
/// An image without size and planes, with steps of 1.
static inline ty_screen_image ty_default_screen_image(void) {
    ty_screen_image def;
    ty_init_screen_image(&def, sizeof def);
    return def;
}

/// Statistics of a call. Create them with ty_default_screen_stats().
typedef struct ty_screen_stats {
    uint32_t cookie;        ///< Set by ty_default_screen_stats() and checked.
    uint32_t bytes;         ///< Set by ty_default_screen_stats() to the size of the structure.
    double seconds;         ///< Wall clock time of the call, s.
    double step_seconds[3]; ///< Time of attenuation (Eq. 3-5), filtering (Eq. 6-9) and composition (Eq. 10-12), s.
    int32_t levels;         ///< K that was used.
    double spread;          ///< Largest radius that holds half of a pixel's scattered light, before clamping, pixels.
    double max_spread;      ///< Largest such radius that K levels hold, pixels; it doubles with each level.
    int64_t oversized; ///< Number of pixels whose spread was clamped: by variance (Gaussian), or for more than half of
                       ///< the light (small angles).
    int64_t nonfinite_fixed; ///< Number of pixels with a negative or non-finite value that was replaced.
    int64_t missing_depth;   ///< Number of pixels without a distance.
    double memory_bytes;     ///< Memory that the passes read and wrote, each plane counted once a pass.
    const char* isa;         ///< Instruction set of the kernels, as in ty_path_stats.
} ty_screen_stats;

/// Statistics with all fields 0.
static inline ty_screen_stats ty_default_screen_stats(void) {
    ty_screen_stats stats;
    ty_init_stats(&stats, sizeof stats);
    return stats;
}

/// Size of the workspace that a call needs, bytes; 0 if the size of the image, or a field that it depends on, is wrong.
TY_API size_t ty_screen_workspace(const ty_context* context, const ty_screen_def* def, int32_t width, int32_t height);

/// Computes J of Eq. 12. workspace: at least ty_screen_workspace() bytes, aligned to 64, and then the processor
/// allocates nothing; NULL: it is allocated for the call. Without a medium and environment, valid pixels are returned
/// bit for bit. stats may be NULL. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED (reference) leaves the
/// output undefined.
TY_API ty_result ty_screen_apply(ty_context* context, const ty_screen_def* def, const ty_screen_image* image,
                                 void* workspace, size_t workspace_size, ty_screen_stats* stats);

/// Computes the input of the filter, in planes laid out as image->out, each of which may be NULL; image->out is not
/// written. attenuated: I' (Eq. 3), with the light of the environment. scattered: I0 (Eq. 4). spread: radius that holds
/// half of a pixel's scattered light, per channel, pixels (Eq. 5: 1.18 standard deviations).
/// Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_screen_split(ty_context* context, const ty_screen_def* def, const ty_screen_image* image,
                                 float* const attenuated[3], float* const scattered[3], float* const spread[3]);

/// Fills pixels without a distance from known ones around them, the near ones first (push-pull pyramid): for depth
/// sensors, whose holes are not sky. distance: width * height floats, changed in place. `*filled` is the number of
/// filled pixels, 0 when no distance is known. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_screen_fill_distance(ty_context* context, int32_t width, int32_t height, float* distance,
                                         int64_t* filled);

/// Sets the medium, focal length, principal point and distance kind of a committed scene, for pictures of its camera
/// that are `height` pixels high (0: the camera's own resolution). Coefficients of media add up, and g is their mean
/// weighted by sigma_s. Emission of media is ignored with a warning. Errors: TY_ERROR_ARGUMENT (a heterogeneous
/// medium).
TY_API ty_result ty_screen_set_scene(const ty_scene* scene, int32_t height, ty_screen_def* def);
/// Replaces distances from the camera to surfaces (m, along the rays through pixel centres; 0: no surface) by the
/// length of that segment inside of the scene's media, weighted so that several media keep the optical depth. A camera
/// outside of a medium, and media that fill different spaces, are warnings. distance: width * height floats, changed in
/// place. Errors: TY_ERROR_ARGUMENT.
TY_API ty_result ty_screen_scene_distance(const ty_scene* scene, int32_t width, int32_t height, float* distance);

#ifdef __cplusplus
}
#endif
#endif
