/// @file flux.h
/// Fluxes (irradiance) of horizontal levels, absorbed power and radiance, by columns of a scene.
///
/// docs/atmosphere.md explains them. Horizontal axes are x and y in scenes whose up axis is z, and x and z in others;
/// heights are coordinates along the up axis. Results do not depend on the number of threads. All functions only read
/// the scene, which must be committed and stay as it is during the call. Apache-2.0.
#ifndef TYNDALL_FLUX_H
#define TYNDALL_FLUX_H

#include <tyndall/base.h>
#include <tyndall/dom.h>
#include <tyndall/path.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Largest number of levels, and of views.
enum { TY_FLUX_LEVELS_MAX = 256 };

/// A direction in which radiance leaves the scene.
typedef struct ty_flux_view {
    double zenith;  ///< Angle between the direction and the up axis, degrees, 0..180, not 90. Below 90 it is the
                    ///< radiance of light that rises through the highest level, above 90 of light that sinks through
                    ///< the lowest.
    double azimuth; ///< Angle about the up axis, degrees, counter-clockwise seen from above, 0 towards +x.
} ty_flux_view;

/// The levels, columns and views of fluxes. Create it with ty_default_flux_def().
typedef struct ty_flux_def {
    uint32_t cookie;      ///< Set by ty_default_flux_def() and checked.
    uint32_t bytes;       ///< Set by ty_default_flux_def() to the size of the structure, and checked.
    const double* levels; ///< Heights, m, ascending. Fluxes are those just above them, so that a level may be that of
                          ///< the ground.
    int32_t level_count;  ///< 1..TY_FLUX_LEVELS_MAX.
    const ty_flux_view* views; ///< Default NULL.
    int32_t view_count;        ///< 0 (default) .. TY_FLUX_LEVELS_MAX.
    int32_t columns[2]; ///< Number of columns along the first and the second horizontal axis, 1..65536; default 1.
    double lower[2];    ///< Lower corner of all columns together along both axes, m.
    double upper[2];    ///< Upper corner, m. Along an axis where it is not above `lower` (default) the columns
                        ///< fill the cell of a periodic scene, or the box around the media.
} ty_flux_def;

/// Sets the `bytes` bytes of a ty_flux_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_flux_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_flux_def ty_default_flux_def(void) {
    ty_flux_def def;
    ty_init_flux_def(&def, sizeof def);
    return def;
}

/// The quantities of fluxes.
typedef enum ty_flux_quantity {
    TY_FLUX_UP = 0,           ///< Flux of all light that rises through a level, W m^-2.
    TY_FLUX_DOWN_DIFFUSE = 1, ///< Flux of light that sinks through a level and was scattered or reflected, or emitted
                              ///< by a medium, W m^-2.
    TY_FLUX_DOWN_DIRECT = 2,  ///< Flux of light of lights, environments among them, that sinks through a level and was
                              ///< neither scattered nor reflected, W m^-2.
    TY_FLUX_ABSORBED = 3,     ///< Power that the media of a column absorb, over its area, W m^-2.
    TY_FLUX_RADIANCE = 4      ///< Radiance of a view, W m^-2 sr^-1: also that of environments behind the media, but not
                              ///< that of directional lights, whose direct light has none.
} ty_flux_quantity;

/// Fluxes by columns.
typedef struct ty_flux ty_flux;

/// Estimates fluxes by path tracing, with def->path of samples for each number. Options of `path` for images have no
/// effect. stats may be NULL. Errors: TY_ERROR_ARGUMENT (also for scenes with dielectrics or panes), TY_ERROR_MEMORY;
/// after TY_CANCELLED there is no output.
TY_API ty_result ty_path_flux(const ty_scene* scene, const ty_path_def* path, const ty_flux_def* def, ty_flux** out,
                              ty_path_stats* stats);
/// Finds fluxes by discrete ordinates, of scenes that repeat along both horizontal axes, without surfaces and views;
/// the columns lie in the scene's cell. Numbers have no errors, and those of one run balance within dom->tolerance.
/// stats may be NULL. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED.
TY_API ty_result ty_dom_flux(const ty_scene* scene, const ty_dom_def* dom, const ty_flux_def* def, ty_flux** out,
                             ty_dom_stats* stats);
/// Destroys fluxes; NULL is allowed.
TY_API void ty_flux_destroy(ty_flux* flux);

/// The places of fluxes, with the corners of all columns together: `levels` and `views` belong to the fluxes.
TY_API void ty_flux_copy_def(const ty_flux* flux, void* out, size_t bytes);
/// The same as a structure.
static inline ty_flux_def ty_flux_places(const ty_flux* flux) {
    ty_flux_def def;
    ty_flux_copy_def(flux, &def, sizeof def);
    return def;
}
/// Values of a quantity at a level (`index`; 0 for TY_FLUX_ABSORBED) or of a view: 3 channels per column, columns of
/// the first axis fastest. NULL for an index past the end.
TY_API const double* ty_flux_values(const ty_flux* flux, ty_flux_quantity quantity, int32_t index);
/// Their standard errors.
TY_API const double* ty_flux_errors(const ty_flux* flux, ty_flux_quantity quantity, int32_t index);
/// Mean over all columns and its standard error, per channel; 0 for an index past the end.
TY_API void ty_flux_mean(const ty_flux* flux, ty_flux_quantity quantity, int32_t index, double mean[3],
                         double error[3]);

#ifdef __cplusplus
}
#endif
#endif
