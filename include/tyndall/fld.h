/// @file fld.h
/// Flux-limited diffusion: multiple scattering in any volume, vacuum included.
///
/// After Koerner, Portsmouth, Sadlo, Ertl, Eberhardt: Flux-Limited Diffusion for Multiple Scattering in Participating
/// Media (2014); equation numbers are the paper's. docs/method/fld.md explains the method, its accuracy, and the
/// departures from the paper. Results do not depend on the number of threads. Apache-2.0.
#ifndef TYNDALL_FLD_H
#define TYNDALL_FLD_H

#include <tyndall/base.h>
#include <tyndall/image.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The flux limiter F(R) (Table 2).
typedef enum ty_fld_limiter {
    TY_FLD_LIMITER_NONE = 0,               ///< 1/3: classical diffusion (CDA).
    TY_FLD_LIMITER_SUM = 1,                ///< 1 / (3 + R).
    TY_FLD_LIMITER_MAX = 2,                ///< 1 / max(3, R).
    TY_FLD_LIMITER_KERSHAW = 3,            ///< 2 / (3 + sqrt(9 + 4 R^2)).
    TY_FLD_LIMITER_LARSEN = 4,             ///< (3^n + R^n)^(-1/n) with n = larsen_power.
    TY_FLD_LIMITER_LEVERMORE_POMRANING = 5 ///< (coth R - 1/R) / R.
} ty_fld_limiter;

/// The boundary condition on the six faces of the box around all media.
typedef enum ty_fld_boundary {
    TY_FLD_BOUNDARY_MARSHAK = 0,  ///< Vacuum outside: half of the fluence leaves as flux, and no light enters.
    TY_FLD_BOUNDARY_DIRICHLET = 1 ///< The paper's: no fluence on the faces.
} ty_fld_boundary;

/// The solver of the diffusion equation. All solvers agree within the tolerance.
typedef enum ty_fld_solver {
    TY_FLD_SOLVER_MULTIGRID = 0, ///< Multigrid, which is not in the paper.
    TY_FLD_SOLVER_SOR = 1,       ///< Successive over-relaxation (Algorithm 1) in double precision.
    TY_FLD_SOLVER_SOR_FLOAT = 2  ///< The same in single precision.
} ty_fld_solver;

/// The part of the light that counts as uncollided, and is not left to diffusion.
typedef enum ty_fld_beam {
    TY_FLD_BEAM_REDUCED = 0,  ///< Light that scatters nearly straight on stays with the beam: the reduced coefficient
                              ///< sigma_s (1 - g) scatters it isotropically.
    TY_FLD_BEAM_PUBLISHED = 1 ///< The paper's: sigma_s scatters it, and media are taken as isotropic.
} ty_fld_beam;

/// Largest number of cells along a side of the box.
enum { TY_FLD_CELLS_MAX = 1024 };

/// The options of a solve and of its images. Create it with ty_default_fld_def().
typedef struct ty_fld_def {
    uint32_t cookie; ///< Set by ty_default_fld_def() and checked.
    uint32_t bytes;  ///< Set by ty_default_fld_def() to the size of the structure, and checked.

    int32_t resolution; ///< Cells of uncollided light along the longest side of the box around all media, 4..1024.
                        ///< TY_AUTO (default): as fine as the finest voxels, at most 256; 64 for media without voxels.
    double ratio; ///< Cells of uncollided light per cell of diffusion, along each side, 1..64. TY_AUTO (default): 3,
                  ///< or 2 where 3 would leave fewer than 48 cells along the longest side. Above 3, diffuse
                  ///< light is relaxed and stored on cells half as large.
    ty_fld_beam beam;         ///< Default TY_FLD_BEAM_REDUCED.
    ty_fld_limiter limiter;   ///< Default TY_FLD_LIMITER_LEVERMORE_POMRANING.
    double larsen_power;      ///< n of Larsen's limiter, 1..100; default 2.
    double max_flux_fraction; ///< Largest ratio of flux to fluence, (0, 1], which limiters let R F(R) approach.
                              ///< TY_AUTO (default): 0.55, rising to 0.8 with the fraction of the light that comes from
                              ///< lights inside the media's box. 0.55 is about the ratio of light that leaves a thick
                              ///< medium for vacuum: 0.5 if all outward directions were alike, 1 / sqrt(3) in Milne's
                              ///< problem. 1: the paper's, which is right far from a source.
    ty_fld_boundary boundary; ///< Default TY_FLD_BOUNDARY_MARSHAK.
    double sigma_eps;         ///< Least extinction, 1/m, > 0; TY_AUTO (default): 1e-3 / longest side.
    ty_fld_solver solver;     ///< Default TY_FLD_SOLVER_MULTIGRID.
    double relaxation;        ///< omega of SOR, (0, 2); default 1.85.
    double tolerance;   ///< Bound of rms(residual) / rms(source), (0, 1); default 1e-3, which changes images by 3e-4
                        ///< at most. A solve with a limiter takes at least two iterations.
    int32_t iterations; ///< Largest number of iterations; TY_AUTO (default): the solver's own bound.

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
                                 ///< surfaces show only the scattered light that they reflect.

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
} ty_fld_def;

/// Sets the `bytes` bytes of a ty_fld_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_fld_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_fld_def ty_default_fld_def(void) {
    ty_fld_def def;
    ty_init_fld_def(&def, sizeof def);
    return def;
}

/// Statistics of a solve and of an image, per channel where there are three numbers. Create them with
/// ty_default_fld_stats().
typedef struct ty_fld_stats {
    uint32_t cookie;           ///< Set by ty_default_fld_stats() and checked.
    uint32_t bytes;            ///< Set by ty_default_fld_stats() to the size of the structure.
    int32_t direct_size[3];    ///< Cells of uncollided light along x, y, z.
    int32_t diffusion_size[3]; ///< Cells of diffusion along x, y, z.
    int32_t planes;            ///< 1: all channels have the same coefficients, and one solve; 3.
    bool converged;            ///< True: all channels converged.
    int32_t iterations[3];     ///< Picard iterations, or sweeps of SOR.
    int32_t cycles[3];         ///< Multigrid cycles.
    double residual[3];        ///< rms(residual) / rms(source) at the end.
    double work[3];            ///< Passes over all cells.
    double emitted[3];         ///< Power of light that scattered for the first time, and of emission, W.
    double absorbed[3];        ///< Power that the medium absorbed, W.
    double leaving[3];         ///< Power that left the box, W.
    double seconds;            ///< Wall clock time of the whole, s.
    double medium_seconds;     ///< Time to sample the media, s.
    double direct_seconds;     ///< Time to find the uncollided light, s.
    double solve_seconds;      ///< Time to solve the diffusion equation, s.
    double march_seconds;      ///< Time of the image, s.
    double memory_bytes;       ///< Memory of the solve, with all channels that are solved side by side.
    const char* isa;           ///< Instruction set of the kernels, as in ty_path_stats.

    double
        absorbed_by_surfaces[3]; ///< Power that surfaces absorbed, W; `emitted` includes what they send into media
                                 ///< besides their reflection of diffuse light, as far as it scatters or is absorbed.

    int32_t
        solve_ranks; ///< Ranks of a command under mpirun that solved together, each for its part of the cells; 1: one.
} ty_fld_stats;

/// Statistics with all fields 0.
static inline ty_fld_stats ty_default_fld_stats(void) {
    ty_fld_stats stats;
    ty_init_stats(&stats, sizeof stats);
    return stats;
}

/// The light in a scene's media: solved once, and seen from any camera. It does not refer to the scene, which may be
/// destroyed before it.
typedef struct ty_fld ty_fld;

/// Samples the media of a committed scene, finds the uncollided light of all lights, and solves for the rest. stats may
/// be NULL. A solve that runs out of iterations returns TY_OK with stats->converged false. `*out` is destroyed with
/// ty_fld_destroy(), and is NULL after an error.
/// Errors: TY_ERROR_ARGUMENT (definition, a scene without media), TY_ERROR_MEMORY; TY_CANCELLED.
TY_API ty_result ty_fld_solve(const ty_scene* scene, const ty_fld_def* def, ty_fld** out, ty_fld_stats* stats);
/// Destroys the light; NULL is allowed.
TY_API void ty_fld_destroy(ty_fld* light);

/// Renders radiance through the pixels of the scene's camera: R, G, B and def->aovs. The scene must be the one that was
/// solved, or one like it, except for its camera. Of def, the options of images and the seed count. Several threads may
/// view one light at once. `*out` is NULL after an error.
/// Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED.
TY_API ty_result ty_fld_view(const ty_fld* light, const ty_scene* scene, const ty_fld_def* def, ty_image** out,
                             ty_fld_stats* stats);

/// Solves and renders: ty_fld_solve(), then ty_fld_view().
TY_API ty_result ty_fld_render(const ty_scene* scene, const ty_fld_def* def, ty_image** out, ty_fld_stats* stats);

/// Fluence, the integral of radiance over all directions (W m^-2), averaged over each cell of a box as by
/// ty_path_fluence(); 0 outside of the box around the media. fluence: all light, cells x 3, x fastest. uncollided:
/// light that diffusion did not have to find, cells x 3, or NULL; with TY_FLD_BEAM_REDUCED it includes light that
/// scattered nearly straight on. flux: net flux vector of all light, W m^-2, cells x 3 channels x 3 axes, or NULL.
/// Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_fld_fluence(const ty_fld* light, const double lower[3], const double upper[3],
                                const int32_t size[3], double* fluence, double* uncollided, double* flux);

#ifdef __cplusplus
}
#endif
#endif
