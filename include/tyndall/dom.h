/// @file dom.h
/// Discrete ordinates with a first-collision source, a fast and accurate method for any medium.
///
/// Uncollided light is found exactly for each light of the scene. The light that it scatters travels along a set of
/// directions through a grid of cells, with the forward peak of the phase function removed (delta-M).
/// docs/method/dom.md explains the method and its accuracy. Results do not depend on the number of threads. Apache-2.0.
#ifndef TYNDALL_DOM_H
#define TYNDALL_DOM_H

#include <tyndall/base.h>
#include <tyndall/image.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The acceleration of the source iteration.
typedef enum ty_dom_acceleration {
    TY_DOM_ACCELERATION_DIFFUSION = 0, ///< Diffusion synthetic acceleration with Anderson mixing: three to five sweeps
                                       ///< up to an optical thickness of 100.
    TY_DOM_ACCELERATION_NONE = 1       ///< Plain source iteration: one sweep per order of scattering.
} ty_dom_acceleration;

/// Largest values of the fields of ty_dom_def.
enum {
    TY_DOM_CELLS_MAX = 1024,      ///< Largest resolution.
    TY_DOM_DIRECTIONS_MAX = 1024, ///< Largest number of directions.
    TY_DOM_BANDS_MAX = 12         ///< Largest number of Legendre terms.
};

/// The light in a scene's media: solved once, and seen from any camera. It does not refer to the scene, which may be
/// destroyed before it.
typedef struct ty_dom ty_dom;

/// The options of a solve and of its images. Create it with ty_default_dom_def().
typedef struct ty_dom_def {
    uint32_t cookie; ///< Set by ty_default_dom_def() and checked.
    uint32_t bytes;  ///< Set by ty_default_dom_def() to the size of the structure, and checked.

    int32_t resolution; ///< Cells of the sweep along the longest side of the box around all media, 4..1024.
                        ///< TY_AUTO (default): a third of the voxels (of 64 without voxels), 24..64; up to twice as
                        ///< many, at most 64, where cells would be thicker than four mean free paths.
    int32_t
        direct; ///< Cells of uncollided light along that side, 4..1024. TY_AUTO (default): as fine as the finest
                ///< voxels, or twice as fine where transfer functions make edges, at most 256, of these 192
                ///< unless all lights shine from one direction or point; 64 for media without voxels. Voxels thicker
                ///< than 1.5 mean free paths under point lights are divided into up to 4 per side, up to 128 cells.
    int32_t directions;      ///< Number of ordinates, 8..1024; default 96.
    int32_t last_directions; ///< Number of ordinates of one more sweep at the end, 8..1024, against ray effects: 400
                             ///< here cost four sweeps of 96, and look like 400 throughout; 0 (default): no such sweep.
    int32_t bands; ///< L: Legendre terms of the delta-scaled phase function, 1..12; TY_AUTO (default): by the media's g
                   ///< and the number of directions.
    ty_dom_acceleration acceleration; ///< Default TY_DOM_ACCELERATION_DIFFUSION.
    double tolerance;                 ///< Bound of the estimated root mean square change of the fluence that iteration
                                      ///< would still make, relative, (0, 1); default 1e-3.
    int32_t iterations;  ///< Largest number of sweeps; TY_AUTO (default): 100, or 10000 without acceleration.
    const ty_dom* start; ///< Light of the same grid to start from, such as that of an animation's last frame: it saves
                         ///< sweeps, and changes the result within the tolerance. It may be destroyed after the solve.
                         ///< NULL (default): none.

    int32_t environment_beams; ///< Directions per environment light, 1..65536; default 64.
    int32_t surface_points;    ///< Points per area light and emitting sphere, 1..65536; default 16.
    uint64_t seed;             ///< Seed of these directions and points; default 0.

    int32_t width;               ///< Image width, pixels; 0 (default): that of the camera. Set with `height`.
    int32_t height;              ///< Image height, pixels; 0 (default): that of the camera.
    int32_t spp;                 ///< Rays per pixel, 1..64; default 1, through its centre.
    double step;                 ///< Step of the ray march, voxels, 0.05..8; default 1.
    uint32_t aovs;               ///< Flags TY_AOV_TRANSMITTANCE, _SINGLE, _MULTIPLE, _DEPTH; default 0.
    const ty_image* unscattered; ///< Light of surfaces through the media, as in ty_fld_def; default NULL.

    ty_progress_fn progress; ///< Default NULL.
    void* progress_user;     ///< Passed on to `progress`; default NULL.

    int32_t ray_spacing; ///< Pixels between camera rays along x and y, 1..8; above 1, pixels between rays are
                         ///< interpolated, except at edges: for fast previews; default 1.

    int32_t interior_resolution; ///< Cells along the longest side of each medium that fills a solid dielectric, 4..256.
                                 ///< TY_AUTO (default): as many as it is transport mean free paths long,
                                 ///< 32..48, and 32 from 96 on. The command line and the viewer use it.

    bool interreflection; ///< True (default): surfaces outside of the media's box light the media by all that they
                          ///< reflect, of lamps and of media, and one another by the light of media. False: the media
                          ///< light such surfaces alone, once.

    bool differentiable; ///< True: the light has a gradient (ty_dom_gradient()). Ordinates go through thick cells, too,
                         ///< which count as diffusive otherwise, and sources are at the centres of cells: so light
                         ///< differs where cells are thicker than a mean free path. Default false.
} ty_dom_def;

/// Sets the `bytes` bytes of a ty_dom_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_dom_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_dom_def ty_default_dom_def(void) {
    ty_dom_def def;
    ty_init_dom_def(&def, sizeof def);
    return def;
}

/// Statistics of a solve and of an image, per channel where there are three numbers. Create them with
/// ty_default_dom_stats().
typedef struct ty_dom_stats {
    uint32_t cookie;                ///< Set by ty_default_dom_stats() and checked.
    uint32_t bytes;                 ///< Set by ty_default_dom_stats() to the size of the structure.
    int32_t direct_size[3];         ///< Cells of uncollided light along x, y, z.
    int32_t size[3];                ///< Cells of the sweep along x, y, z.
    int32_t planes;                 ///< 1: one solve for all channels; 3.
    int32_t directions;             ///< Number of ordinates.
    int32_t bands;                  ///< Number of Legendre terms.
    bool converged;                 ///< True: all channels converged.
    int32_t sweeps[3];              ///< Sweeps of all directions over all cells.
    int32_t cycles[3];              ///< Multigrid cycles.
    double change[3];               ///< Estimated relative change of the fluence that is still to come.
    double emitted[3];              ///< Power of light that scattered for the first time, of emission, and of light of
                                    ///< environments and area lights that surfaces between cells reflected, W.
    double absorbed[3];             ///< Power that the medium absorbed, W.
    double absorbed_by_surfaces[3]; ///< Power that surfaces absorbed, W.
    double leaving[3];              ///< Power that left the box, W.
    double seconds;                 ///< Wall clock time of the whole, s.
    double medium_seconds;          ///< Time to sample the media, s.
    double direct_seconds;          ///< Time to find the uncollided light, s.
    double source_seconds;          ///< Time to find the first-collision source, s.
    double wall_seconds;            ///< Time to find the surfaces between cells, s.
    double solve_seconds;           ///< Time to solve, s.
    double march_seconds;           ///< Time of the image, s.
    double sweep_seconds;           ///< Time of sweeps alone, a part of solve_seconds, s.
    double memory_bytes;            ///< Memory of the solve.
    const char* isa;                ///< Instruction set of the kernels, as in ty_path_stats.
} ty_dom_stats;

/// Statistics with all fields 0.
static inline ty_dom_stats ty_default_dom_stats(void) {
    ty_dom_stats stats;
    ty_init_stats(&stats, sizeof stats);
    return stats;
}

/// Samples the media of a committed scene, finds the uncollided light of all lights, and solves for the rest. stats may
/// be NULL. A solve that runs out of sweeps returns TY_OK with stats->converged false. `*out` is destroyed with
/// ty_dom_destroy(), and is NULL after an error.
/// Errors: TY_ERROR_ARGUMENT (definition, a scene without media, a start of another grid), TY_ERROR_MEMORY;
/// TY_CANCELLED.
TY_API ty_result ty_dom_solve(const ty_scene* scene, const ty_dom_def* def, ty_dom** out, ty_dom_stats* stats);
/// Destroys the light; NULL is allowed.
TY_API void ty_dom_destroy(ty_dom* light);

/// Renders radiance through the pixels of the scene's camera: R, G, B and def->aovs. The scene must be the one that was
/// solved, or one like it, except for its camera. Of def, the options of images and the seed count. Several threads may
/// view one light at once. `*out` is NULL after an error.
/// Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED.
TY_API ty_result ty_dom_view(const ty_dom* light, const ty_scene* scene, const ty_dom_def* def, ty_image** out,
                             ty_dom_stats* stats);

/// Solves and renders: ty_dom_solve(), then ty_dom_view().
TY_API ty_result ty_dom_render(const ty_scene* scene, const ty_dom_def* def, ty_image** out, ty_dom_stats* stats);

/// Fluence, the integral of radiance over all directions (W m^-2), averaged over each cell of a box as by
/// ty_path_fluence(); 0 outside of the box around the media. fluence: all light, cells x 3, x fastest. uncollided:
/// light that did not scatter since a light or a surface sent it, cells x 3, or NULL; it includes light that scattered
/// nearly straight on (delta scaling). Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_dom_fluence(const ty_dom* light, const double lower[3], const double upper[3],
                                const int32_t size[3], double* fluence, double* uncollided);

/// Radiance of light that scattered at least once, W m^-2 sr^-1, at points and along directions. rays: count x 6
/// numbers, a point (m) and the direction in which the light travels (any length), as in ty_path_radiance(). radiance:
/// count x 3. It is the sum of the stored harmonics, so it can be negative where light comes from few directions; 0
/// outside of the box. Errors: TY_ERROR_ARGUMENT (also for count < 1).
TY_API ty_result ty_dom_radiance(const ty_dom* light, const double* rays, int64_t count, double* radiance);

#ifdef __cplusplus
}
#endif
#endif
