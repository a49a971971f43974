/// @file choose.h
/// The choice of a method for a scene.
///
/// The choice is the method of the least expected cost, error times the root of time, by a few features of the scene as
/// its camera sees it. docs/method/auto.md explains the model, and what its wrong choices cost. Apache-2.0.
#ifndef TYNDALL_CHOOSE_H
#define TYNDALL_CHOOSE_H

#include <tyndall/base.h>
#include <tyndall/image.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Requests that path tracing alone can meet, as flags.
typedef enum ty_ask {
    TY_ASK_CROP = 1,    ///< A part of the frame.
    TY_ASK_TIME = 2,    ///< The best image within a given time.
    TY_ASK_ERROR = 4,   ///< A render that goes on until its error is below a bound.
    TY_ASK_RESUME = 8,  ///< A render that can be resumed later.
    TY_ASK_SAMPLES = 16 ///< A given number of samples per pixel; other methods apply it to surfaces alone.
} ty_ask;

/// The requests for a picture. Create it with ty_default_choose_def().
typedef struct ty_choose_def {
    uint32_t cookie; ///< Set by ty_default_choose_def() and checked.
    uint32_t bytes;  ///< Set by ty_default_choose_def() to the size of the structure, and checked.
    uint32_t asks;   ///< Flags of ty_ask; default 0.
    uint32_t aovs;   ///< Flags of ty_aov, the requested channels; default 0.
    int32_t width;   ///< Image width, pixels; 0 (default): that of the camera. Set with `height`.
    int32_t height;  ///< Image height, pixels; 0 (default): that of the camera.
    int32_t spp;     ///< Samples per pixel, of path and of surfaces; 0 (default): those of the scene.
    bool trials; ///< True (default): methods are tried by coarse solves, which takes some tenths of a second. False:
                 ///< they are judged by the other features, which is several times as fast and wrong more often.
} ty_choose_def;

/// Largest number of methods that ty_choose_method() chooses among.
enum { TY_TRIALS_MAX = 8 };

/// Features of the camera's view, found by a few hundred rays from the camera and as many from the media in its view, a
/// few thousand paths, and coarse solves. A feature is 0 where there is nothing to measure it on.
typedef struct ty_scene_features {
    double media;     ///< Fraction of the frame with media.
    double thickness; ///< Largest optical thickness along a ray; mean of the channels.
    double opacity;   ///< Fraction of the light from behind that media remove; mean over the frame.
    double g;         ///< Mean cosine of the scattering that the camera sees; mean of the channels.
    double albedo;    ///< Albedo of the media that the camera sees; mean of the channels.
    double cell; ///< Optical thickness, at the first scattering, of 1/40 of the longest side of the media's box, which
                 ///< is about a cell of the grid methods; mean over the view.
    double surfaces; ///< Fraction of the frame with surfaces.
    double enclosed; ///< Fraction of the directions around scattering points that meet a surface within the length of
                     ///< the media's box.
    bool heterogeneous;   ///< True: media are heterogeneous.
    bool emissive_media;  ///< True: media emit light.
    bool inside;          ///< True: the camera is in a medium.
    uint32_t lights;      ///< 1 << ty_light_kind for each kind of light; emitting surfaces count as area lights.
    double voxels;        ///< Cells of a grid as fine as the finest of media; 64 along its longest side without grids.
    int32_t light_count;  ///< Number of lights; an environment counts as one, and each emitting triangle.
    double span;          ///< Optical thickness of the media's box: mean of its three axes, and of the channels.
    double noise;         ///< Standard deviation of a pixel by one path, root mean square over the mean of the picture.
    double vertices;      ///< Mean number of scatterings and reflections of a path.
    double multiple;      ///< Fraction of the light in view that media scattered, and that was scattered or reflected
                          ///< more than once.
    double unscattered;   ///< Fraction of the light in view that no medium scattered or emitted.
    double surface_noise; ///< `noise` of that light, over the mean of the whole picture.
    double surface_vertices; ///< `vertices` of paths that do not scatter in media.
    double trial_noise;      ///< Noise that `trials` have, relative to the mean of the picture; 0: nothing was tried.
    double trials[TY_TRIALS_MAX]; ///< Relative RMSE of means over a twelfth of the picture by coarse solves, against
                                  ///< paths, in the order of ty_choice_method_name(); 0: not tried.
} ty_scene_features;

/// A chosen method.
typedef struct ty_choice {
    const char* method;         ///< The name of a method that takes the scene.
    char reason[256];           ///< The reason as one sentence without its full stop, such as "uneven media ...".
    ty_scene_features features; ///< The features of the view.
    double error;               ///< Expected relative RMSE of means over 4 x 4 pixels; of `path` for all its samples.
    double seconds;             ///< Expected processor time of one thread, s, on the machine of docs/method/auto.md.
} ty_choice;

/// Sets the `bytes` bytes of a ty_choose_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_choose_def(void* def, size_t bytes);
/// A definition without any request but a picture.
static inline ty_choose_def ty_default_choose_def(void) {
    ty_choose_def def;
    ty_init_choose_def(&def, sizeof def);
    return def;
}

/// The name of a method that ty_choose_method() chooses among; NULL past the last one.
TY_API const char* ty_choice_method_name(int32_t index);

/// Chooses a method for a committed scene as its camera sees it. The chosen method accepts the scene. The choice
/// depends on the scene and the definition alone. Errors: TY_ERROR_ARGUMENT (definition, scene not committed),
/// TY_ERROR_MEMORY.
TY_API ty_result ty_choose_method(const ty_scene* scene, const ty_choose_def* def, ty_choice* out);

#ifdef __cplusplus
}
#endif
#endif
