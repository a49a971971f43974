/// @file impulse.h
/// Impulse responses: the light of one emitter that a homogeneous medium around a receiver scatters to it.
///
/// After Dubouchet, Sloan, Jarosz, Nowrouzezahrai: Impulse Responses for Precomputing Light from Volumetric Media
/// (2019); section numbers are the paper's. docs/method/impulse.md explains the content of the tables and their limits.
/// Apache-2.0.
#ifndef TYNDALL_IMPULSE_H
#define TYNDALL_IMPULSE_H

#include <tyndall/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The kind of an emitter, which sets the unit of its colour.
typedef enum ty_impulse_emitter {
    TY_IMPULSE_POINT = 0,       ///< Colour: intensity, W sr^-1. Distance: to the point.
    TY_IMPULSE_DIRECTIONAL = 1, ///< Colour: irradiance where the light enters the medium, W m^-2. Distance: to there.
    TY_IMPULSE_AREA = 2         ///< A small Lambertian surface. Colour: radiance times area, W sr^-1. Distance: to it.
                                ///< Cosine: between its normal and the direction from it to the receiver, 0..1.
} ty_impulse_emitter;

/// Sizes of the tables.
enum {
    TY_IMPULSE_TERMS = 11,      ///< Zonal harmonics.
    TY_IMPULSE_DISTANCES = 256, ///< Bins of optical distance.
    TY_IMPULSE_ANGLES = 16,     ///< Bins of the cosine at an area emitter.
    TY_IMPULSE_BOUNCES_MAX = 64 ///< Largest number of scatterings.
};

/// The options of the tables. Create it with ty_default_impulse_def().
typedef struct ty_impulse_def {
    uint32_t cookie;    ///< Set by ty_default_impulse_def() and checked.
    uint32_t bytes;     ///< Set by ty_default_impulse_def() to the size of the structure, and checked.
    int32_t bounces;    ///< Largest number of scatterings, 1..64; default 10.
    double range;       ///< Largest optical distance, 1..100; default 20.
    const char* folder; ///< Folder in which tables are kept between runs. NULL (default): $XDG_CACHE_HOME/tyndall, or
                        ///< $HOME/.cache/tyndall. "": tables are not kept.
    ty_progress_fn progress; ///< Default NULL.
    void* progress_user;     ///< Passed on to `progress`; default NULL.
} ty_impulse_def;

/// Sets the `bytes` bytes of a ty_impulse_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_impulse_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_impulse_def ty_default_impulse_def(void) {
    ty_impulse_def def;
    ty_init_impulse_def(&def, sizeof def);
    return def;
}

/// Immutable tables of impulse responses.
typedef struct ty_impulse ty_impulse;

/// The origin of tables. Create them with ty_default_impulse_stats().
typedef struct ty_impulse_stats {
    uint32_t cookie; ///< Set by ty_default_impulse_stats() and checked.
    uint32_t bytes;  ///< Set by ty_default_impulse_stats() to the size of the structure.
    bool built;      ///< True: the tables were computed. False: they were read from the folder.
    double seconds;  ///< Wall clock time, s.
    char path[1024]; ///< Path of the file; "" without one.
} ty_impulse_stats;

/// Statistics with all fields 0.
static inline ty_impulse_stats ty_default_impulse_stats(void) {
    ty_impulse_stats stats;
    ty_init_stats(&stats, sizeof stats);
    return stats;
}

/// Creates the tables for all kinds of emitters. They are read from the folder if a complete file of this version and
/// definition is there; otherwise they are computed in less than a minute and written to the folder. A folder that
/// cannot be written is a warning. stats may be NULL. The tables depend on nothing but the context.
/// Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED.
TY_API ty_result ty_impulse_create(ty_context* context, const ty_impulse_def* def, ty_impulse** out,
                                   ty_impulse_stats* stats);
/// Destroys tables; NULL is allowed.
TY_API void ty_impulse_destroy(ty_impulse* tables);

/// The medium between an emitter and a receiver: means along the ray (Sec. 4.4).
typedef struct ty_impulse_medium {
    float sigma_t; ///< Extinction coefficient, 1/m.
    float sigma_s; ///< Scattering coefficient, 1/m.
    float g;       ///< Mean cosine; clamped to -0.5..0.5 in single scattering, and to -0.99..0.99 for the similarity
                   ///< relation in multiple scattering.
} ty_impulse_medium;

/// Radiance that arrives at the receiver after at least one scattering, W m^-2 sr^-1 per unit of the emitter's colour:
/// coefficients of the orthonormal zonal harmonics y_l^0 in the angle between the direction to the light's origin (wi)
/// and an axis.
typedef struct ty_impulse_response {
    float single[TY_IMPULSE_TERMS];   ///< Light that scattered once.
    float multiple[TY_IMPULSE_TERMS]; ///< Light that scattered more often.
    float shift;                      ///< Sine of the angle between the axis and the direction to the emitter. The axis
                 ///< leans in the plane of that direction and the emitter's normal, towards the side
                 ///< that the normal points to.
} ty_impulse_response;

/// Looks up a response. bounces: number of scatterings to count, 1..def.bounces; a larger number counts all.
/// distance: m. Optical distances below 0.001 use the limit near an emitter, and those below 1e-6 count as 1e-6. Beyond
/// the range of the tables, light falls as exp(-d) (single scattering) or exp(-d / 2) (multiple scattering). A lookup
/// takes tens of nanoseconds for ten bounces. Any number of threads may call it at once.
TY_API void ty_impulse_look(const ty_impulse* tables, ty_impulse_emitter emitter, const ty_impulse_medium* medium,
                            float distance, float cosine, int32_t bounces, ty_impulse_response* out);
/// The tabulated coefficients of one order of scattering, at sigma_t = 1/m and albedo 1, as `tyndall figure
/// impulse-tables` draws them. bounce: 1..def.bounces. angle: 0..15 for area emitters, for the cosines 0, 0.02, 0.05,
/// 0.09, 0.14, 0.2, 0.27, 0.35, 0.44, 0.53, 0.62, 0.71, 0.79, 0.87, 0.94, 1; 0 otherwise. g: -1, 0 or 1 for -0.5, 0,
/// 0.5 (bounce 1), 0 otherwise. `*distance` is the optical distance of the bin. Errors: TY_ERROR_ARGUMENT.
TY_API ty_result ty_impulse_bin(const ty_impulse* tables, ty_impulse_emitter emitter, int32_t bounce, int32_t g,
                                int32_t angle, int32_t bin, double* distance, float zonal[TY_IMPULSE_TERMS]);

/// Irradiance of a response on a surface, W m^-2 per unit of the emitter's colour. cosine: between the surface's normal
/// and the axis of the response. This is the cosine double product of Appendix A.
TY_API float ty_impulse_irradiance(const float zonal[TY_IMPULSE_TERMS], float cosine);

#ifdef __cplusplus
}
#endif
#endif
