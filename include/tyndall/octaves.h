/// @file octaves.h
/// Multiple-scattering octaves, the approximation of game engines. Apache-2.0.
///
/// After Wrenninge, Kulla and Lundqvist, "Oz: The Great and Volumetric" (2013), as in Hillaire, "Physically Based Sky,
/// Atmosphere and Cloud Rendering in Frostbite" (2016): multiple scattering is a sum of single scattering in media
/// whose scattering, extinction and anisotropy are scaled down with each octave. The sum does not solve the radiative
/// transfer equation; docs/method/octaves.md gives its errors. The result does not depend on the number of threads.
#ifndef TYNDALL_OCTAVES_H
#define TYNDALL_OCTAVES_H

#include <tyndall/base.h>
#include <tyndall/image.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The extinction between the camera and the point of scattering.
typedef enum ty_octaves_view_extinction {
    TY_OCTAVES_VIEW_UNSCALED = 0, ///< sigma_t in every octave, as in engines.
    TY_OCTAVES_VIEW_SCALED = 1    ///< b^i sigma_t: octave i is single scattering in a medium of its own.
} ty_octaves_view_extinction;

/// Largest values of the fields of ty_octaves_def.
enum {
    TY_OCTAVES_COUNT_MAX = 8 ///< Largest number of octaves.
};

/// The options of a solve and of its images. Create it with ty_default_octaves_def().
typedef struct ty_octaves_def {
    uint32_t cookie; ///< Set by ty_default_octaves_def() and checked.
    uint32_t bytes;  ///< Set by ty_default_octaves_def(): size of the definition.

    int32_t count;     ///< Number of octaves N, single scattering included, 1..8; default 6; engines use 2 or 3.
    double scattering; ///< a, 0..1: octave i scatters a^i sigma_s; default 0.5.
    double extinction; ///< b, 0..1: b^i sigma_t attenuates the light of octave i; default 0.5.
    double anisotropy; ///< c, 0..1: c^i g is the mean cosine of octave i; default 0.5.
    ty_octaves_view_extinction view_extinction; ///< Default TY_OCTAVES_VIEW_UNSCALED. With TY_OCTAVES_VIEW_SCALED, a
                                                ///< must not exceed b, or octaves would grow as (a / b)^i.

    int32_t resolution;        ///< Cells of light along the longest side of the box around all media, 4..1024. TY_AUTO
                               ///< (default): that of the finest voxels, 256 at most; 64 for media without voxels.
    int32_t environment_beams; ///< Directions per environment light, 1..65536; default 64.
    int32_t surface_points;    ///< Points per area light and emitting sphere, 1..65536; default 16.
    uint64_t seed;             ///< Seed of these directions and points; default 0.

    int32_t width;               ///< Image width, pixels; 0 (default): that of the camera. Set with `height`.
    int32_t height;              ///< Image height, pixels; 0 (default): that of the camera.
    int32_t spp;                 ///< Rays per pixel, 1..64; default 1, through its centre.
    double step;                 ///< Step of the ray march, voxels, 0.05..8; default 1.
    uint32_t aovs;               ///< Flags TY_AOV_TRANSMITTANCE, _SINGLE, _MULTIPLE, _DEPTH; default 0.
    const ty_image* unscattered; ///< Light of surfaces through the media, as ty_path_render() with
                                 ///< ty_path_def.unscattered makes it, in pixels of the same size. NULL (default):
                                 ///< surfaces are black.

    ty_progress_fn progress; ///< Default NULL.
    void* progress_user;     ///< Passed on to `progress`; default NULL.

    int32_t ray_spacing; ///< Pixels between camera rays along x and y, 1..8; above 1, pixels between rays are
                         ///< interpolated, except at edges: for fast previews; default 1.

    int32_t
        froxels; ///< Columns of froxels, 4..1024: voxels of the camera's frustum, as deep as the media in view, that
                 ///< hold the scattered light up to them, and from which pixels are interpolated, as in engines;
                 ///< `spp` rays go through each column and each pixel, and `step` and `ray_spacing` have no effect.
                 ///< 0 (default): none, rays march through the media. Engines have 160. Rows: as high as wide.
    int32_t froxel_slices; ///< Slices of froxels in depth, 1..1024; default 64, as in engines.
} ty_octaves_def;

/// Sets the `bytes` bytes of a ty_octaves_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_octaves_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_octaves_def ty_default_octaves_def(void) {
    ty_octaves_def def;
    ty_init_octaves_def(&def, sizeof def);
    return def;
}

/// Statistics of a solve and of an image. Create them with ty_default_octaves_stats().
typedef struct ty_octaves_stats {
    uint32_t cookie;     ///< Set by ty_default_octaves_stats() and checked.
    uint32_t bytes;      ///< Set by ty_default_octaves_stats() to the size of the structure.
    int32_t size[3];     ///< Cells of light along x, y, z.
    int32_t planes;      ///< 1: all channels have the same coefficients; 3.
    int32_t lights;      ///< Fields of light per octave: one per light with one direction or point, one of all others.
    double memory_bytes; ///< Memory of the fields of all octaves.
    double seconds;      ///< Wall clock time of the whole, s.
    double medium_seconds; ///< Time to sample the media, s.
    double direct_seconds; ///< Time to attenuate the light of all octaves, s.
    double march_seconds;  ///< Time of the image, s.
    const char* isa;       ///< Instruction set of the kernels, as in ty_path_stats.
} ty_octaves_stats;

/// Statistics with all fields 0.
static inline ty_octaves_stats ty_default_octaves_stats(void) {
    ty_octaves_stats stats;
    ty_init_stats(&stats, sizeof stats);
    return stats;
}

/// The light in a scene's media: solved once, and seen from any camera. It does not refer to the scene, which may be
/// destroyed before it.
typedef struct ty_octaves ty_octaves;

/// Samples the media of a committed scene and attenuates the light of all its lights once per octave. stats may be
/// NULL. `*out` is destroyed with ty_octaves_destroy(), and NULL after an error. Errors: TY_ERROR_ARGUMENT (the
/// definition, a scene without media), TY_ERROR_MEMORY; TY_CANCELLED.
TY_API ty_result ty_octaves_solve(const ty_scene* scene, const ty_octaves_def* def, ty_octaves** out,
                                  ty_octaves_stats* stats);
/// Destroys the light; NULL is allowed.
TY_API void ty_octaves_destroy(ty_octaves* light);

/// Radiance through the pixels of the scene's camera: R, G, B and def->aovs. Octave 0 is the layer `single`, all others
/// are `multiple`. The scene is the one that was solved, except for its camera; of the definition, the options of
/// images and the seed are read. stats may be NULL. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED; after any
/// of them `*out` is NULL.
TY_API ty_result ty_octaves_view(const ty_octaves* light, const ty_scene* scene, const ty_octaves_def* def,
                                 ty_image** out, ty_octaves_stats* stats);

/// Solves and renders: ty_octaves_solve(), then ty_octaves_view().
TY_API ty_result ty_octaves_render(const ty_scene* scene, const ty_octaves_def* def, ty_image** out,
                                   ty_octaves_stats* stats);

#ifdef __cplusplus
}
#endif
#endif
