/// @file gradient.h
/// Gradients of a loss on solved light by the media and lights of a scene, by adjoint solves.
///
/// A loss L is any differentiable number made from the fluence of cells, as ty_fld_fluence() and ty_dom_fluence() give
/// it. The caller hands in its derivative by that fluence, and gets its derivatives by the density of each voxel, by
/// the coefficients of media and by the strength of lights, for the cost of one more solve or two, however many
/// parameters there are. docs/gradients.md has the formulas and tells what is differentiated. Results do not depend on
/// the number of threads. Apache-2.0.
#ifndef TYNDALL_GRADIENT_H
#define TYNDALL_GRADIENT_H

#include <tyndall/base.h>
#include <tyndall/dom.h>
#include <tyndall/fld.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The derivatives of a loss. It does not refer to the scene, which may be destroyed before it.
typedef struct ty_gradient ty_gradient;

/// Statistics of a gradient. Create them with ty_default_gradient_stats().
typedef struct ty_gradient_stats {
    uint32_t cookie;       ///< Set by ty_default_gradient_stats() and checked.
    uint32_t bytes;        ///< Set by ty_default_gradient_stats() to the size of the structure.
    bool converged;        ///< True: all adjoint solves converged.
    int32_t iterations;    ///< Linear solves of all channels; by dom sweeps.
    double residual;       ///< rms(residual) of the adjoint equation relative to the rms of its source; by dom the
                           ///< estimated remaining error of adjoint light.
    double imbalance;      ///< rms(residual) / rms(source) of the light's own equation: the error of the light that the
                           ///< gradient takes as the solution; by dom its change by one more sweep.
    double seconds;        ///< Wall clock time of the whole, s.
    double direct_seconds; ///< Of this, uncollided light and its adjoint, s.
    double solve_seconds;  ///< Of this, the adjoint of diffusion or of ordinates, s.
} ty_gradient_stats;

/// Statistics with all fields 0.
static inline ty_gradient_stats ty_default_gradient_stats(void) {
    ty_gradient_stats stats;
    ty_init_stats(&stats, sizeof stats);
    return stats;
}

/// The gradient of a loss on the fluence of flux-limited or classical diffusion, exact for the discrete equations.
///
/// light: ty_fld_solve() of this scene with this def, of which a tolerance of 1e-5 gives the gradient four digits.
/// lower, upper, size: cells as of ty_fld_fluence(). weights: dL/dfluence of each cell, size[0] * size[1] * size[2] x 3
/// channels. The def's progress function is called with
/// the stage "adjoint". stats may be NULL. `*out` is destroyed with ty_gradient_destroy(), and is NULL after an error.
/// Errors: TY_ERROR_ARGUMENT (scenes with surfaces, area lights or spheres, media that emit, fld.ratio above 3, light
/// of another scene or that did not converge), TY_ERROR_MEMORY; TY_CANCELLED.
TY_API ty_result ty_fld_gradient(const ty_fld* light, const ty_scene* scene, const ty_fld_def* def,
                                 const double lower[3], const double upper[3], const int32_t size[3],
                                 const double* weights, ty_gradient** out, ty_gradient_stats* stats);
/// The gradient of a loss on the fluence of discrete ordinates, exact for the discrete equations, the set-to-zero
/// fix-ups of the sweeps included.
///
/// light: ty_dom_solve() of this scene with this def, which is `differentiable`. A tolerance of 1e-5 gives the gradient
/// four digits. Parameters as of ty_fld_gradient().
/// Errors: TY_ERROR_ARGUMENT (scenes with surfaces, lights that are neither directional nor environments, media that
/// emit, dom.last_directions, light that is not differentiable, that did not converge or is of another scene),
/// TY_ERROR_MEMORY; TY_CANCELLED.
TY_API ty_result ty_dom_gradient(const ty_dom* light, const ty_scene* scene, const ty_dom_def* def,
                                 const double lower[3], const double upper[3], const int32_t size[3],
                                 const double* weights, ty_gradient** out, ty_gradient_stats* stats);
/// Destroys a gradient; NULL is allowed.
TY_API void ty_gradient_destroy(ty_gradient* gradient);

/// The number of planes of derivatives by coefficients: 3, one per channel; 1 where all media are gray: then they are
/// those by the value that all channels have in common.
TY_API int32_t ty_gradient_planes(const ty_gradient* gradient);
/// The box, m, and cells of ty_gradient_cells(): those of uncollided light.
TY_API void ty_gradient_box(const ty_gradient* gradient, double lower[3], double upper[3], int32_t size[3]);

/// Coefficients of cells by which there are derivatives.
typedef enum ty_gradient_coefficient {
    TY_GRADIENT_EXTINCTION = 0, ///< sigma_t, m: at constant albedo and g.
    TY_GRADIENT_ALBEDO = 1,     ///< sigma_s / sigma_t, at constant extinction and g.
    TY_GRADIENT_G = 2           ///< Mean cosine g of the phase function.
} ty_gradient_coefficient;

/// Derivatives by a coefficient of each cell, x fastest: values has room for all cells. plane: 0..planes - 1. Of media
/// that scatter all light (albedo 1) derivatives are those from below.
/// Errors: TY_ERROR_ARGUMENT.
TY_API ty_result ty_gradient_cells(const ty_gradient* gradient, ty_gradient_coefficient coefficient, int32_t plane,
                                   double* values);
/// Voxels along x, y, z of the density grid of a medium of the scene; 0 without voxels.
/// Errors: TY_ERROR_ARGUMENT (no such medium, a scene that is not committed).
TY_API ty_result ty_gradient_density_size(const ty_scene* scene, int32_t medium, int32_t size[3]);
/// Derivatives by the voxels of the density grid of a medium of the scene, x fastest: voxels has room for all of them.
/// scene: that of the gradient.
/// Errors: TY_ERROR_ARGUMENT (no such medium; media without voxels, with a rotated grid, a transfer function, negative
/// voxels, or fields of albedo or g), TY_ERROR_MEMORY.
TY_API ty_result ty_gradient_density(const ty_gradient* gradient, const ty_scene* scene, int32_t medium,
                                     double* voxels);
/// Derivatives by sigma_s and sigma_a of ty_medium_def, each at a constant other one, m, and by g: one number per
/// plane. scene: that of the gradient. Errors: TY_ERROR_ARGUMENT (no such medium; media with fields of albedo or g),
/// TY_ERROR_MEMORY.
TY_API ty_result ty_gradient_medium(const ty_gradient* gradient, const ty_scene* scene, int32_t medium,
                                    double sigma_s[3], double sigma_a[3], double g[3]);
/// Derivatives by a factor of a light's radiance in each channel, at 1. Errors: TY_ERROR_ARGUMENT (no such light).
TY_API ty_result ty_gradient_light(const ty_gradient* gradient, int32_t light, double factor[3]);

#ifdef __cplusplus
}
#endif
#endif
