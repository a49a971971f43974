/// @file pop.h
/// Principal-ordinates propagation: anisotropic, heterogeneous media under environment and local lights.
///
/// After Elek, Ritschel, Dachsbacher, Seidel: Principal-Ordinates Propagation for Real-Time Rendering of Participating
/// Media (2014); equation and section numbers are the paper's. docs/method/pop.md explains the method, its accuracy,
/// and the departures from the paper. Results do not depend on the number of threads. Apache-2.0.
#ifndef TYNDALL_POP_H
#define TYNDALL_POP_H

#include <tyndall/base.h>
#include <tyndall/image.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The propagation of light along ordinates.
typedef enum ty_pop_mode {
    TY_POP_MODE_SPLIT = 0,     ///< In absolute units, and not in the paper: each ordinate carries its light as long as
                               ///< scattering keeps its direction, and leaves the rest to one flux-limited diffusion.
    TY_POP_MODE_PUBLISHED = 1, ///< The paper's: the cells of each ordinate pass their light to their neighbours, again
                               ///< and again.
    TY_POP_MODE_COLLIDED = 2   ///< The same, from light that scatters for the first time, with the exact decay of mean
                               ///< cosines; uncollided light is treated apart.
} ty_pop_mode;

/// Sizes of grids and maps.
enum {
    TY_POP_CELLS_MAX = 128,       ///< Largest number of cells along an axis of an ordinate's grid.
    TY_POP_IMPORTANCE_WIDTH = 32, ///< Width of the equirectangular map of importance (Sec. 5.2), pixels.
    TY_POP_IMPORTANCE_HEIGHT = 16 ///< Height of that map, pixels.
};

/// The options of a solve and of its images. Create it with ty_default_pop_def().
typedef struct ty_pop_def {
    uint32_t cookie;  ///< Set by ty_default_pop_def() and checked.
    uint32_t bytes;   ///< Set by ty_default_pop_def() to the size of the structure, and checked.
    ty_pop_mode mode; ///< Default TY_POP_MODE_SPLIT.

    int32_t resolution; ///< Cells along each axis of an ordinate's grid, 4..128; mode split takes twice as many along
                        ///< the light. TY_AUTO (default): a third of the cells of `direct`, 32..48; 32 in the other
                        ///< modes (the paper: 20).
    int32_t merged; ///< Cells of the grid that joins all ordinates, along the longest side of the box around all media,
                    ///< 4..512. TY_AUTO (default): 1.5 times the resolution, at most 48 or the resolution; twice the
                    ///< resolution in the other modes (Sec. 5.3).
    bool fine_lights; ///< True: the first eight directional, point and spot lights are propagated through cells as fine
                      ///< as the medium's instead of grids of their own; default true; mode split.
    int32_t direct; ///< Cells of these lights along the longest side, 4..1024. TY_AUTO (default): as fine as the finest
                    ///< voxels, at most 256; 64 for media without voxels.

    int32_t ordinates; ///< N: ordinates per environment light, 1..4096; default 64.
    double prefilter;  ///< beta of Sec. 5.1, 0..16: a = (1 - w / N)^beta. In mode published, w / N is the fraction of
                       ///< the sphere that an ordinate stands for; otherwise 1 - w / N is the mean cosine of its light,
    ///< whatever its shape, which is the same for a uniform environment and makes tuning unnecessary.
    ///< In mode split, scattered light is also no brighter than that of a disc with that mean cosine.
    ///< Default 1; 0: no prefiltering, a = 1.
    bool importance; ///< True: the choice of ordinates also weighs how much of their light the camera sees; default
                     ///< true.
    float* history;  ///< In and out: the map of importance of the frame before, TY_POP_IMPORTANCE_WIDTH x _HEIGHT. A
                     ///< fraction of it is mixed with this frame's map, which replaces it. All 0: there was no frame
                     ///< before. NULL (default): no history.

    int32_t surface_points;  ///< Points per area light and emitting sphere, 1..65536; default 16.
    int32_t vpls;            ///< Number of virtual point lights (Sec. 6) that stand for reflecting surfaces, 0..4096;
                             ///< default 64.
    int32_t shadow_texels;   ///< Side of the reflective shadow maps from which these are chosen, 16..1024; default 128.
    double vpl_min_distance; ///< Least distance r in 1 / r^2 of a virtual point light, as a fraction of the box's
                             ///< longest side, 0..1; default 0.05.

    bool keep_lobes; ///< True: the light of each ordinate is kept, which other camera positions, ty_pop_radiance()
                     ///< and the uncollided light of ty_pop_fluence() need; default false.

    int32_t iterations; ///< M, modes published and collided, 1..10000. TY_AUTO (default): the resolution, or m' of Eq.
                        ///< 10 if that is larger.
    double residuum; ///< eps_a of Sec. 5.4, modes published and collided, 0..1: light with a smaller mean cosine counts
                     ///< as isotropic and goes on in one grid for all ordinates; default 0.1; 0: never.
    int32_t residuum_iterations; ///< Largest number of iterations in that grid, 1..10000; TY_AUTO (default): until a
                                 ///< thousandth of the light is left.

    double max_flux_fraction; ///< Largest ratio of flux to fluence in mode split, as in ty_fld_def. TY_AUTO (default):
                              ///< 0.5, rising to 0.8 with lights inside the media's box.
    double tolerance; ///< Tolerance of the diffusion in mode split, as in ty_fld_def; default 1e-2, which changes
                      ///< images by 1e-3 at most.

    uint64_t seed; ///< Seed of the positions of ordinates, points and virtual point lights; default 0.

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

    bool interreflection; ///< True (default): surfaces outside of the media's box light the media by all that they
                          ///< reflect, of lamps and of media, and one another by the light of media. False: the media
                          ///< light such surfaces alone, once.
} ty_pop_def;

/// Sets the `bytes` bytes of a ty_pop_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_pop_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_pop_def ty_default_pop_def(void) {
    ty_pop_def def;
    ty_init_pop_def(&def, sizeof def);
    return def;
}

/// Statistics of a solve and of an image. Create them with ty_default_pop_stats().
typedef struct ty_pop_stats {
    uint32_t cookie;             ///< Set by ty_default_pop_stats() and checked.
    uint32_t bytes;              ///< Set by ty_default_pop_stats() to the size of the structure.
    int32_t ordinates;           ///< Number of grids: of environments, lights and virtual point lights.
    int32_t vpls;                ///< Number of these that are virtual point lights.
    int32_t size[3];             ///< Cells of an ordinate's grid along its axes.
    int32_t merged_size[3];      ///< Cells of the joint grid along x, y, z.
    int32_t planes;              ///< 1: all channels have the same coefficients; 3.
    int32_t iterations;          ///< Iterations of propagation; mode split: of diffusion, the largest of all channels.
    int32_t residuum_iterations; ///< Iterations of isotropic light in one grid.
    bool converged;              ///< True: diffusion converged (mode split), or little light was left (other modes).
    double left;                 ///< Modes published and collided: fraction of the light that was not yet propagated.
    double seconds;              ///< Wall clock time of the whole, s.
    double medium_seconds;       ///< Time to sample the media, s.
    double importance_seconds;   ///< Time to find the map of importance, s.
    double ordinate_seconds;     ///< Time to choose ordinates, s.
    double vpl_seconds;          ///< Time to find virtual point lights, s.
    double direct_seconds;       ///< Time of the lights of `fine_lights`, s.
    double initial_seconds;      ///< Time to sample media on the ordinates' grids, and the light that enters them, s.
    double propagation_seconds;  ///< Time of propagation, s; mode split: 0.
    double residuum_seconds;     ///< Time of isotropic light in one grid, s; mode split: of diffusion.
    double merge_seconds;        ///< Time to join ordinates in one grid, s.
    double march_seconds;        ///< Time of the image, s.
    double memory_bytes;         ///< Memory of the ordinates' grids.
    const char* isa;             ///< Instruction set of the kernels, as in ty_path_stats.
} ty_pop_stats;

/// Statistics with all fields 0.
static inline ty_pop_stats ty_default_pop_stats(void) {
    ty_pop_stats stats;
    ty_init_stats(&stats, sizeof stats);
    return stats;
}

/// The light in a scene's media: solved once, and seen from the camera position of the solve, or with keep_lobes from
/// any. It does not refer to the scene, which may be destroyed before it.
typedef struct ty_pop ty_pop;

/// Samples the media of a committed scene and propagates the light of all lights through it. stats may be NULL. `*out`
/// is destroyed with ty_pop_destroy(), and is NULL after an error.
/// Errors: TY_ERROR_ARGUMENT (definition, a scene without media), TY_ERROR_MEMORY; TY_CANCELLED.
TY_API ty_result ty_pop_solve(const ty_scene* scene, const ty_pop_def* def, ty_pop** out, ty_pop_stats* stats);
/// Destroys the light; NULL is allowed.
TY_API void ty_pop_destroy(ty_pop* light);

/// Renders radiance through the pixels of the scene's camera: R, G, B and def->aovs. The scene must be the one that was
/// solved, or one like it, except for its camera. Of def, the options of images and the seed count. Several threads may
/// view one light at once; a camera position other than the solve's takes time and memory for a joint grid of its own.
/// `*out` is NULL after an error.
/// Errors: TY_ERROR_ARGUMENT (another camera position without keep_lobes), TY_ERROR_MEMORY; TY_CANCELLED.
TY_API ty_result ty_pop_view(const ty_pop* light, const ty_scene* scene, const ty_pop_def* def, ty_image** out,
                             ty_pop_stats* stats);
/// Solves and renders: ty_pop_solve(), then ty_pop_view().
TY_API ty_result ty_pop_render(const ty_scene* scene, const ty_pop_def* def, ty_image** out, ty_pop_stats* stats);

/// Fluence, the integral of radiance over all directions (W m^-2), averaged over each cell of a box as by
/// ty_path_fluence(); 0 outside of the box around the media. fluence: all light, cells x 3, x fastest. uncollided:
/// light that did not scatter, cells x 3, for which lobes must have been kept, or NULL. Errors: TY_ERROR_ARGUMENT,
/// TY_ERROR_MEMORY.
TY_API ty_result ty_pop_fluence(const ty_pop* light, const double lower[3], const double upper[3],
                                const int32_t size[3], double* fluence, double* uncollided);

/// Radiance of light that scattered at least once, W m^-2 sr^-1, at points and along directions. rays: count x 6
/// numbers, a point (m) and the direction in which the light travels (any length), as in ty_path_radiance(). radiance:
/// count x 3, >= 0. Lobes must have been kept. Errors: TY_ERROR_ARGUMENT (also for count < 1).
TY_API ty_result ty_pop_radiance(const ty_pop* light, const double* rays, int64_t count, double* radiance);

/// Stores the map of importance (Sec. 5.2): the fraction of the light from each direction that the camera sees,
/// relative to the mean over all directions. map: TY_POP_IMPORTANCE_WIDTH x _HEIGHT, row by row. Errors:
/// TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_pop_importance(const ty_scene* scene, const ty_pop_def* def, float* map);

#ifdef __cplusplus
}
#endif
#endif
