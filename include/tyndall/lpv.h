/// @file lpv.h
/// Light propagation volumes with scattering: fog in a scene of surfaces.
///
/// After Billeter, Sintorn, Assarsson: Real-Time Multiple Scattering using Light Propagation Volumes (2012); equation,
/// figure and table numbers are the paper's. docs/method/lpv.md explains the method, its accuracy, and the departures
/// from the paper. Results do not depend on the number of threads. Apache-2.0.
#ifndef TYNDALL_LPV_H
#define TYNDALL_LPV_H

#include <tyndall/base.h>
#include <tyndall/image.h>
#include <tyndall/rsm.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The form of blockers and of propagation steps.
typedef enum ty_lpv_mode {
    TY_LPV_MODE_LINKS =
        0, ///< In absolute units, and not in the paper: surfaces block the links between cells that
           ///< they cut, and reflect the blocked light; steps conserve momentum and diffuse as media do.
    TY_LPV_MODE_PUBLISHED = 1 ///< The paper's: fuzzy blockers as spherical harmonics that absorb light; steps by Eq. 3,
                              ///< with in-scattering that conserves energy.
} ty_lpv_mode;

/// The position of the lattice.
typedef enum ty_lpv_place {
    TY_LPV_PLACE_SCENE = 0, ///< Around media and surfaces.
    TY_LPV_PLACE_CAMERA = 1 ///< Cubes around the camera, which move by whole cells.
} ty_lpv_place;

/// The features of the method, as flags; the paper's comparisons (Fig. 5) leave some of them out.
typedef enum ty_lpv_feature {
    TY_LPV_REFLECTED = 1,  ///< Injection of light that surfaces reflect.
    TY_LPV_SCATTERED = 2,  ///< Injection of light that media scatter once.
    TY_LPV_SCATTERING = 4, ///< Media scatter and absorb the light of the lattice.
    TY_LPV_SURFACES = 8,   ///< The lattice lights surfaces.
    TY_LPV_MARCH = 16,     ///< Media show the light of the lattice.
    TY_LPV_SINGLE = 32,    ///< Media show light that they scatter once, with sharp shadows.
    TY_LPV_PLAIN = 1 + 8,  ///< Light propagation volumes without media.
    TY_LPV_ALL = 63        ///< All of the above.
} ty_lpv_feature;

/// Largest values of the fields of ty_lpv_def.
enum {
    TY_LPV_CELLS_MAX = 256,  ///< Largest resolution.
    TY_LPV_CASCADES_MAX = 6, ///< Largest number of cascades.
    TY_LPV_BANDS_MAX = 3     ///< Largest number of bands.
};

/// The surfaces that the camera sees, as engines store them: width x height pixels, row by row from the top, through
/// the centres of the pixels of the scene's camera. The arrays belong to the caller and are read during calls alone.
/// Create it with ty_default_lpv_view_def().
typedef struct ty_lpv_view_def {
    uint32_t cookie;       ///< Set by ty_default_lpv_view_def() and checked.
    uint32_t bytes;        ///< Set by ty_default_lpv_view_def() to the size of the structure, and checked.
    const float* distance; ///< Distance along the ray of each pixel, m; INFINITY without a surface; must be set.
    const float* normal;   ///< 3 per pixel, unit, on the camera's side; must be set.
    const float* albedo;   ///< 3 per pixel, 0..1; must be set.
    const float* emission; ///< 3 per pixel, radiance towards the camera, W m^-2 sr^-1; NULL (default): none.
} ty_lpv_view_def;

/// Sets the `bytes` bytes of a ty_lpv_view_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_lpv_view_def(void* def, size_t bytes);
/// A definition without arrays.
static inline ty_lpv_view_def ty_default_lpv_view_def(void) {
    ty_lpv_view_def def;
    ty_init_lpv_view_def(&def, sizeof def);
    return def;
}

/// The options of a solve and of its images. Create it with ty_default_lpv_def().
typedef struct ty_lpv_def {
    uint32_t cookie;  ///< Set by ty_default_lpv_def() and checked.
    uint32_t bytes;   ///< Set by ty_default_lpv_def() to the size of the structure, and checked.
    ty_lpv_mode mode; ///< Default TY_LPV_MODE_LINKS.
    uint32_t parts;   ///< Flags of ty_lpv_feature; default TY_LPV_ALL.

    int32_t resolution; ///< Cells, which are cubes, along the longest side of the lattice, in landscapes along that of
                        ///< the media, 4..256; default 32.
    ty_lpv_place place; ///< Default TY_LPV_PLACE_SCENE.
    double extent;      ///< Side of the cube around the camera, m, > 0; TY_LPV_PLACE_CAMERA; default 32.
    int32_t
        cascades;  ///< Number of nested lattices of `resolution`, 1..6; each is twice as wide as the one inside it. At
                   ///< TY_LPV_PLACE_SCENE `place` sets the widest one, at TY_LPV_PLACE_CAMERA the narrowest; default 1.
    int32_t bands; ///< Bands of spherical harmonics: 2 (default, the paper's) or 3.
    double window; ///< Window against ringing, 0..1: the injected light of band l is multiplied by
                   ///< 1 / (1 + window l^2 (l + 1)^2). TY_AUTO (default): 0 with 2 bands, 0.01 with 3.
    int32_t iterations; ///< 1..4096. TY_AUTO (default): until `tolerance` of the injected light is still under way; 8
                        ///< in mode published.
    double tolerance;   ///< Fraction of the injected light, (0, 1); default 0.01.

    int32_t map_side;   ///< Texels along a side of reflective shadow maps, 16..4096; default 256.
    int32_t samples;    ///< Largest number of samples on a ray from a light to a texel, 1..64; default 8.
    int32_t block_side; ///< Texels per cell, along a side, of the depth maps that find blockers, 1..16; default 3.
    const ty_rsm* maps; ///< One map per light of the scene, in the order of their addition; those of area lights and
                        ///< environments are not read. NULL (default): maps are traced. The maps must outlive the
                        ///< solved light.
    int32_t map_count;  ///< Number of `maps`; default 0.

    const ty_lpv_view_def* view; ///< The surfaces that the camera sees; NULL (default): traced.
    int32_t shadow_side; ///< Texels along a side of the shadow maps of single scattering, 16..4096; default 512.
    bool shadow_rays;    ///< True: surfaces near the edges of shadows trace rays instead of trusting the maps alone;
                         ///< default true.
    bool half_resolution_march; ///< True: media are marched at half of the resolution, and upsampled by depth; default
                                ///< true.
    double step;                ///< Step of the ray march, cells, 0.05..8; default 1.
    int32_t width;              ///< Image width, pixels; 0 (default): that of the camera. Set with `height`.
    int32_t height;             ///< Image height, pixels; 0 (default): that of the camera.
    int32_t spp;                ///< Rays per pixel, 1..64; default 1, through its centre; without `view`.
    uint32_t aovs;              ///< Flags TY_AOV_TRANSMITTANCE, _SINGLE, _MULTIPLE, _DEPTH, _NORMAL; default 0.
    uint64_t seed;              ///< Seed of the positions of samples; default 0.

    ty_progress_fn progress; ///< Default NULL.
    void* progress_user;     ///< Passed on to `progress`; default NULL.

    int32_t light_samples; ///< Samples per pixel of each environment, and as many of area lights and emissive surfaces
                           ///< together, 1..256; blocks of 4 x 4 pixels on one surface share theirs; default 8.
} ty_lpv_def;

/// Sets the `bytes` bytes of a ty_lpv_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_lpv_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_lpv_def ty_default_lpv_def(void) {
    ty_lpv_def def;
    ty_init_lpv_def(&def, sizeof def);
    return def;
}

/// Statistics of a solve and of an image. Times are over all lights, channels and cascades. Create them with
/// ty_default_lpv_stats().
typedef struct ty_lpv_stats {
    uint32_t cookie;                      ///< Set by ty_default_lpv_stats() and checked.
    uint32_t bytes;                       ///< Set by ty_default_lpv_stats() to the size of the structure.
    int32_t size[TY_LPV_CASCADES_MAX][3]; ///< Cells of each cascade along x, y, z.
    double cell[TY_LPV_CASCADES_MAX];     ///< Side of a cell of each cascade, m.
    int32_t iterations;                   ///< Iterations of propagation.
    double reflected[3];                  ///< Injected power that surfaces reflected, W.
    double scattered[3];                  ///< Injected power that media scattered, W.
    double absorbed[3];                   ///< Power that media absorbed, W.
    double blocked[3];                    ///< Power that surfaces absorbed, W.
    double escaped[3];                    ///< Power that left the lattice, W.
    double left[3];                       ///< Power that is still under way, W.
    double seconds;                       ///< Wall clock time of the whole, s.
    double medium_seconds;                ///< Time to sample the media, s.
    double map_seconds;                   ///< Time of reflective shadow maps, s.
    double reflected_seconds;             ///< Time to inject light of surfaces, s.
    double scattered_seconds;             ///< Time to inject light of media, s.
    double blocker_seconds;               ///< Time to find blockers, s.
    double shadow_seconds;                ///< Time of the finer maps, which images alone need, s.
    double prepare_seconds;               ///< Time to prepare propagation (Table 1), s.
    double propagate_seconds;             ///< Time of propagation (Table 1), s.
    double gather_seconds;                ///< Time to gather the light of all steps (Table 1), s.
    double view_seconds;                  ///< Time to trace the camera's rays, s.
    double surface_seconds;               ///< Time to light surfaces, s.
    double march_seconds;                 ///< Time to march media, s.
    double single_seconds;                ///< Time of single scattering, s.
    double compose_seconds;               ///< Time to compose the image, s.
    int64_t rays;                         ///< Number of traced rays.
    int64_t marched;    ///< Number of rays through media in images, with those that half of the resolution leaves open.
    double ray_seconds; ///< Mean time to trace a ray, over all threads, s.
    const char* isa;    ///< Instruction set of the kernels, as in ty_path_stats.
    double emitted[3];  ///< Injected power that media emitted, W.
} ty_lpv_stats;

/// Statistics with all fields 0.
static inline ty_lpv_stats ty_default_lpv_stats(void) {
    ty_lpv_stats stats;
    ty_init_stats(&stats, sizeof stats);
    return stats;
}

/// The light in a scene's media and between its surfaces: solved once, and seen from any camera. It does not refer to
/// the scene, which may be destroyed before it, but it does refer to the maps of its definition.
typedef struct ty_lpv ty_lpv;

/// Injects the light of a committed scene into a lattice and propagates it. Without media it is plain light
/// propagation. stats may be NULL. `*out` is destroyed with ty_lpv_destroy(), and is NULL after an error.
/// Errors: TY_ERROR_ARGUMENT (definition, maps, a scene without media and surfaces), TY_ERROR_MEMORY; TY_CANCELLED.
TY_API ty_result ty_lpv_solve(const ty_scene* scene, const ty_lpv_def* def, ty_lpv** out, ty_lpv_stats* stats);
/// Destroys the light; NULL is allowed.
TY_API void ty_lpv_destroy(ty_lpv* light);

/// Renders radiance through the pixels of the scene's camera: R, G, B and def->aovs. single: light that media scatter
/// once, and nothing else scatters or reflects. multiple: other light that media scatter towards the camera, without
/// the light that they scatter onto surfaces. The scene must be the one that was solved, or one like it, except for its
/// camera. Of def, the options of images count. Several threads may view one light at once. `*out` is NULL after an
/// error. Errors: as ty_lpv_solve().
TY_API ty_result ty_lpv_view(const ty_lpv* light, const ty_scene* scene, const ty_lpv_def* def, ty_image** out,
                             ty_lpv_stats* stats);
/// Solves and renders: ty_lpv_solve(), then ty_lpv_view().
TY_API ty_result ty_lpv_render(const ty_scene* scene, const ty_lpv_def* def, ty_image** out, ty_lpv_stats* stats);

/// Fluence of the light of the lattice, the integral of radiance over all directions (W m^-2), averaged over each cell
/// of a box as by ty_path_fluence(); 0 outside of the lattice. fluence: light that was scattered or reflected at least
/// once, cells x 3, x fastest. The lattice does not hold uncollided light, which the other methods' fluence includes.
/// Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_lpv_fluence(const ty_lpv* light, const double lower[3], const double upper[3],
                                const int32_t size[3], double* fluence);

/// Irradiance of the light of the lattice on surfaces, W m^-2. points: count x 3, m. normals: count x 3, unit.
/// irradiance: count x 3. Errors: TY_ERROR_ARGUMENT.
TY_API ty_result ty_lpv_irradiance(const ty_lpv* light, const float* points, const float* normals, int64_t count,
                                   float* irradiance);

/// One lattice for lookups in an engine. The radiance of light that travels along a unit vector w is the sum over i <
/// bands^2 of coefficients[c][i] Y_i(w), with real spherical harmonics Y_i in the order l (l + 1) + m, without the
/// Condon-Shortley phase. The arrays belong to the light.
typedef struct ty_lpv_lattice {
    double lower[3];                                                   ///< Lower corner, m.
    double cell;                                                       ///< Side of a cell, m.
    int32_t size[3];                                                   ///< Cells along x, y, z.
    int32_t bands;                                                     ///< 2 or 3.
    const float* coefficients[3][TY_LPV_BANDS_MAX * TY_LPV_BANDS_MAX]; ///< [channel][i], x fastest, W m^-2 sr^-1.
} ty_lpv_lattice;
/// Stores the lattice of a cascade, of which 0 is the narrowest. Returns false when there is none.
TY_API bool ty_lpv_get_lattice(const ty_lpv* light, int32_t cascade, ty_lpv_lattice* out);

#ifdef __cplusplus
}
#endif
#endif
