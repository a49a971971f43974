/// @file path.h
/// Unbiased volumetric path tracing, the reference of all other methods.
///
/// docs/method/path.md explains the method. Results do not depend on the number of threads. All functions only read the
/// scene, which must be committed and stay as it is during the call. Apache-2.0.
#ifndef TYNDALL_PATH_H
#define TYNDALL_PATH_H

#include <tyndall/base.h>
#include <tyndall/grid.h>
#include <tyndall/image.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Receives the state of a render: bytes that ty_path_def.resume understands, valid during the call. A return value of
/// false cancels the work. It is called from any thread, never twice at a time nor while the progress function runs;
/// other threads go on meanwhile.
typedef bool (*ty_path_state_fn)(void* user, const void* state, size_t size);

/// Receives the image of the samples so far, valid during the call; pixels without a sample yet are 0. A return value
/// of false cancels the work. It is called like ty_path_state_fn.
typedef bool (*ty_path_partial_fn)(void* user, const ty_image* image);

/// The guides of paths to the light.
typedef enum ty_path_guide_kind {
    TY_PATH_GUIDE_AUTO = TY_AUTO, ///< The one of less noise in the same time, by a pilot; none for short work.
    TY_PATH_GUIDE_NONE = 0,       ///< Nothing but the lights themselves.
    TY_PATH_GUIDE_DOM = 1         ///< A coarse solve by discrete ordinates (docs/method/path.md, "Guided by dom").
} ty_path_guide_kind;

/// The options of path tracing. Create it with ty_default_path_def().
typedef struct ty_path_def {
    uint32_t cookie;        ///< Set by ty_default_path_def() and checked.
    uint32_t bytes;         ///< Set by ty_default_path_def() to the size of the structure, and checked.
    int32_t spp;            ///< Largest number of samples per pixel, ray or cell, 1..2^24; default 64.
    uint64_t seed;          ///< Any number; images of different seeds are independent; default 0.
    int32_t max_depth;      ///< Largest number of scatterings and reflections; 0 (default): unlimited, with Russian
                            ///< roulette.
    bool ignore_media;      ///< True: the result is that of the scene without media, bit for bit; default false.
    bool unscattered;       ///< True: the result holds light that no medium scattered or emitted. Lights, the sky and
                            ///< surfaces, with reflections between these, are seen through the extinction of the media:
                            ///< R, G, B less single, multiple and emission. The channels single and multiple are 0.
                            ///< It changes nothing without media or with `ignore_media`; default false.
    double seconds;         ///< Time after which the work stops, s, > 0; 0 (default): no bound.
    double error;           ///< Relative error below which the work stops, > 0; 0 (default): no bound. The error is the
                            ///< root mean square standard error of the pixels over their mean. The work stops where it
                            ///< is that small with twice its own standard deviation added to its square.
    int32_t width;          ///< Image width, pixels; 0 (default): that of the camera. Set with `height`.
    int32_t height;         ///< Image height, pixels; 0 (default): that of the camera.
    uint32_t aovs;          ///< Images: flags of ty_aov; default TY_AOV_VARIANCE.
    int32_t crop[4];        ///< Images: x, y, width, height of the part of the frame to render. Its pixels are those of
                            ///< the whole frame, bit for bit. Default 0: the whole frame.
    ty_path_state_fn state; ///< Images: receives the state of the work every `state_seconds` and at the end; default
                            ///< NULL. It takes 56 bytes a pixel, 216 with aovs other than variance and samples, 400
                            ///< with TY_AOV_HALF, and the work itself takes the same.
    void* state_user;       ///< Passed on to `state`; default NULL.
    double state_seconds;   ///< Time between two states, s, 0..1e9. TY_AUTO (default): 2, or 50 times the time that a
                            ///< state takes from the threads, if that is longer, so that states take at most 2% of it;
                            ///< with `state_change` always 2.
    const void*
        resume; ///< Images: a state to go on from, with any changes of it behind it; default NULL. A resumed render
                ///< gives the same image, bit for bit, as an uninterrupted one, if spp, seed, size, crop, aovs,
                ///< max_depth, ignore_media, unscattered, guide, the scene and the instruction set (ty_path_stats.isa)
                ///< are the same; spp may also be larger. The time of earlier runs counts for `seconds` and in
                ///< ty_path_stats. TY_ERROR_INPUT: the state is damaged, or belongs to another render.
    size_t resume_size;      ///< Size of `resume`, bytes; default 0.
    ty_progress_fn progress; ///< Default NULL.
    void* progress_user;     ///< Passed on to `progress`; default NULL.
    /// Images: receives the changes since the last call of `state` or of itself, in place of most states, because
    /// changes are cheaper to keep; default NULL. A state followed by all its changes is a state. A return value of
    /// false asks for a whole state next, as comes by itself once changes are twice as large as one, and at the end.
    ty_path_state_fn state_change;
    bool point_light_directions; ///< True (default): vertices sample directions about point and spot lights in media,
                                 ///< and rays sample distances by the light that these scatter into them. False:
                                 ///< equiangular sampling alone, the same mean with far more noise, for comparison.
    bool energy_compensation;    ///< True (default): surfaces return the light that their microfacets scatter several
                                 ///< times (docs/materials.md). False: single scattering, which loses it.
    ty_path_partial_fn partial;  ///< Images: receives the image so far at most once a second, and so seldom that this
                                 ///< takes at most 2% of the threads' time; default NULL.
    void* partial_user;          ///< Passed on to `partial`; default NULL.
    const struct ty_enclosed_field* enclosed; ///< Light in media inside dielectrics, at whose first collision paths
                                              ///< end, as methods of the library solve it; default NULL.
    ty_path_guide_kind guide; ///< The guide of sampled directions and distances, beside the lights. The mean stays the
                              ///< same. Its time counts as that of the work. TY_PATH_GUIDE_AUTO (default): images of
                              ///< at least 2^23 paths in all, and 10 s where `seconds` bounds them, have that of the
                              ///< less noise in a pilot, which ty_path_stats.guide tells; other work has none. Scenes
                              ///< without media, periodic scenes, and renders on a device, have none.
} ty_path_def;

/// Sets the `bytes` bytes of a ty_path_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_path_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_path_def ty_default_path_def(void) {
    ty_path_def def;
    ty_init_path_def(&def, sizeof def);
    return def;
}

/// Statistics of a render, including the runs that it resumed. Create them with ty_default_path_stats().
typedef struct ty_path_stats {
    uint32_t cookie;    ///< Set by ty_default_path_stats() and checked.
    uint32_t bytes;     ///< Set by ty_default_path_stats() to the size of the structure.
    double seconds;     ///< Wall clock time, s.
    double cpu_seconds; ///< Processor time over all threads, s.
    double spp;         ///< Mean number of samples per pixel.
    double error;       ///< Estimated relative error, as in ty_path_def.
    uint64_t paths;     ///< Number of paths.
    uint64_t vertices;  ///< Number of scatterings and reflections.
    const char* isa;    ///< Instruction set of the kernel: "x86-64", "x86-64-v3", "x86-64-v4" or "generic"; on a device
                        ///< its kind, "host" or "cuda".
    double error_pixels; ///< Pixels that `error` rests on: (sum v)^2 / sum v^2 for the variances v of the pixels; 0
                         ///< without an error. Below 10 a few samples make most of the error: images of other seeds
                         ///< may have several times more or less of it.
    ty_path_guide_kind guide; ///< The guide that paths had.
} ty_path_stats;

/// Statistics with all fields 0.
static inline ty_path_stats ty_default_path_stats(void) {
    ty_path_stats stats;
    ty_init_stats(&stats, sizeof stats);
    return stats;
}

/// Renders radiance through the pixels of the scene's camera: R, G, B, and the channels of def->aovs. After
/// TY_CANCELLED, `*out` is a valid image with fewer samples. stats may be NULL. The image does not refer to the scene.
/// Errors: TY_ERROR_ARGUMENT, TY_ERROR_INPUT (def->resume), TY_ERROR_MEMORY.
TY_API ty_result ty_path_render(const ty_scene* scene, const ty_path_def* def, ty_image** out, ty_path_stats* stats);

/// Estimates the radiance of all light, W m^-2 sr^-1, at points and along directions. rays: count x 6 numbers, a point
/// (m) and the direction in which the light travels (any length). radiance: count x 3, means over def->spp samples.
/// variance: count x 3, the variance of these means, or NULL. A camera that looks along w receives light of direction
/// -w. A surface with TY_ALPHA_BLEND is met by all samples of a ray or by none.
/// Errors: TY_ERROR_ARGUMENT (also for count < 1), TY_ERROR_MEMORY; TY_CANCELLED leaves the outputs undefined.
TY_API ty_result ty_path_radiance(const ty_scene* scene, const ty_path_def* def, const double* rays, int64_t count,
                                  double* radiance, double* variance);

/// Estimates fluence, the integral of radiance over all directions (W m^-2), averaged over each cell of a box of
/// size[0] x size[1] x size[2] cells from lower to upper (m). A box without extent along an axis gives the fluence on
/// that plane, line or point. All outputs have cells x 3 numbers, x fastest. fluence: all light. uncollided: light that
/// neither a medium nor a surface scattered; may be NULL. variance: variance of fluence; may be NULL. Errors:
/// TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED leaves the outputs undefined.
TY_API ty_result ty_path_fluence(const ty_scene* scene, const ty_path_def* def, const double lower[3],
                                 const double upper[3], const int32_t size[3], double* fluence, double* uncollided,
                                 double* variance);

/// Estimates the transmittance exp(-optical depth) of the media between two points (m), per channel, without surfaces:
/// the mean of def->spp ratio-tracked estimates, exact where media are homogeneous. Periodic boundaries do not count.
/// Errors: TY_ERROR_ARGUMENT.
TY_API ty_result ty_path_transmittance(const ty_scene* scene, const ty_path_def* def, const double from[3],
                                       const double to[3], double transmittance[3]);

#ifdef __cplusplus
}
#endif
#endif
