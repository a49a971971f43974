/* Tyndall: impulse responses, what a homogeneous medium around a receiver makes of one emitter's light. Apache-2.0.
 *
 * After Dubouchet, Sloan, Jarosz, Nowrouzezahrai: Impulse Responses for Precomputing Light from Volumetric Media
 * (2019). docs/method/impulse.md explains what is tabled and how far it holds. */
#ifndef TYNDALL_IMPULSE_H
#define TYNDALL_IMPULSE_H

#include <tyndall/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What sends light, and what it is measured by. */
typedef enum ty_impulse_emitter {
    TY_IMPULSE_POINT = 0,       /* color: intensity, W sr^-1; distance: to it */
    TY_IMPULSE_DIRECTIONAL = 1, /* color: irradiance, W m^-2, where it enters; distance: to where it does */
    TY_IMPULSE_AREA = 2         /* a small Lambertian surface; color: radiance times area, W sr^-1 m^-2 m^2; distance:
                                   to it; cosine: between its normal and the way from it to the receiver, 0..1 */
} ty_impulse_emitter;

enum {
    TY_IMPULSE_TERMS = 11, /* zonal harmonics */
    TY_IMPULSE_DISTANCES = 256,
    TY_IMPULSE_ANGLES = 16,
    TY_IMPULSE_BOUNCES_MAX = 64
};

/* What tables hold; made by ty_default_impulse_def. */
typedef struct ty_impulse_def {
    uint32_t cookie;         /* set by ty_default_impulse_def; checked */
    uint32_t bytes;          /* set by ty_default_impulse_def: size of the def */
    int32_t bounces;         /* scatterings at most, 1..64; default 10 */
    double range;            /* optical distance that tables go to, 1..100; default 20 */
    const char* folder;      /* where tables are kept between runs; NULL (default): $XDG_CACHE_HOME/tyndall, or
                                $HOME/.cache/tyndall; "": nowhere */
    ty_progress_fn progress; /* default NULL */
    void* progress_user;     /* passed on to progress; default NULL */
} ty_impulse_def;

/* Fills in a ty_impulse_def of `bytes` bytes, as ty_init_context_def does. */
TY_API void ty_init_impulse_def(void* def, size_t bytes);
/* A def with every field at its default. */
static inline ty_impulse_def ty_default_impulse_def(void) {
    ty_impulse_def def;
    ty_init_impulse_def(&def, sizeof def);
    return def;
}

/* Tables of impulse responses; immutable. */
typedef struct ty_impulse ty_impulse;

/* How tables came. */
typedef struct ty_impulse_stats {
    bool built;      /* else they were read from the folder */
    double seconds;  /* wall clock */
    char path[1024]; /* of the file; "": none */
} ty_impulse_stats;

/* Tables for all emitters, built in under a minute, or read from the folder when they are there, whole, and of this
 * version and def; else they are built and written. A folder that cannot be written to is a warning. stats may be NULL.
 * Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED. */
TY_API ty_result ty_impulse_create(ty_context* context, const ty_impulse_def* def, ty_impulse** out,
                                   ty_impulse_stats* stats);
/* Frees tables; NULL is allowed. */
TY_API void ty_impulse_destroy(ty_impulse* tables);

/* What lies between an emitter and a receiver: means along the ray (Sec. 4.4). */
typedef struct ty_impulse_medium {
    float sigma_t, sigma_s; /* 1/m */
    float g;                /* clamped to -0.5..0.5 in single scattering, to -0.99..0.99 for similarity in the rest */
} ty_impulse_medium;

/* Radiance that arrives at the receiver, W m^-2 sr^-1 per unit of the emitter's color, scattered at least once: in
 * zonal harmonics (orthonormal y_l^0) of the angle between where it comes from and an axis. */
typedef struct ty_impulse_response {
    float single[TY_IMPULSE_TERMS];   /* scattered once */
    float multiple[TY_IMPULSE_TERMS]; /* and more often */
    float shift; /* sine of the angle by which the axis leans from the direction to the emitter, in the plane of that
                    and the emitter's normal, towards the side that the normal points to */
} ty_impulse_response;

/* bounces: scatterings that count, 1..def.bounces; more are as many as there are. distance: m; optical ones below 0.001
 * go by what light near an emitter does, those below 1e-6 count as that, and beyond the range light falls as exp(-d)
 * does (scattered once) or its root. Tens of nanoseconds for ten bounces; from any number of threads. */
TY_API void ty_impulse_look(const ty_impulse* tables, ty_impulse_emitter emitter, const ty_impulse_medium* medium,
                            float distance, float cosine, int32_t bounces, ty_impulse_response* out);
/* One scattering's own coefficients as tabled, at sigma_t 1/m and albedo 1: what `tyndall figure impulse-tables` draws.
 * bounce: 1..def.bounces; angle: 0..15 of areas, for cosines 0, 0.02, 0.05, 0.09, 0.14, 0.2, 0.27, 0.35, 0.44, 0.53,
 * 0.62, 0.71, 0.79, 0.87, 0.94, 1, else 0; g: -1, 0 or 1 for -0.5, 0, 0.5 (bounce 1 alone). *distance is that of the
 * bin. Errors: TY_ERROR_ARGUMENT. */
TY_API ty_result ty_impulse_bin(const ty_impulse* tables, ty_impulse_emitter emitter, int32_t bounce, int32_t g,
                                int32_t angle, int32_t bin, double* distance, float zonal[TY_IMPULSE_TERMS]);

/* Irradiance of a response on a surface whose normal is at that cosine to the response's axis: the cosine double
 * product of Appendix A. */
TY_API float ty_impulse_irradiance(const float zonal[TY_IMPULSE_TERMS], float cosine);

#ifdef __cplusplus
}
#endif
#endif
