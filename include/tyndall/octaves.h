/* Tyndall: multiple scattering octaves, the approximation of game engines. Apache-2.0.
 *
 * After Wrenninge, Kulla, Lundqvist: Oz: The Great and Volumetric (2013), as Hillaire: Physically Based Sky, Atmosphere
 * and Cloud Rendering in Frostbite (2016) and engines since have it: multiple scattering is a sum of single scattering
 * in media that scatter less, attenuate less and scatter more evenly with every octave. It is no solution of the
 * radiative transfer equation: docs/method/octaves.md says how far off it is. The result does not depend on the number
 * of threads. */
#ifndef TYNDALL_OCTAVES_H
#define TYNDALL_OCTAVES_H

#include <tyndall/base.h>
#include <tyndall/image.h>
#include <tyndall/path.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The extinction between the camera and the place where light scatters. */
typedef enum ty_octaves_view_extinction {
    TY_OCTAVES_VIEW_UNSCALED = 0, /* sigma_t in every octave, as engines have it */
    TY_OCTAVES_VIEW_SCALED = 1    /* b^i sigma_t: octave i is single scattering in a medium of its own */
} ty_octaves_view_extinction;

enum { TY_OCTAVES_COUNT_MAX = 8 };

/* The options of a solve and a view; made by ty_default_octaves_def. */
typedef struct ty_octaves_def {
    uint32_t cookie; /* set by ty_default_octaves_def; checked */
    uint32_t bytes;  /* set by ty_default_octaves_def: size of the def */

    int32_t count;     /* N: octaves, single scattering included, 1..8; default 6; engines have 2 or 3 */
    double scattering; /* a, 0..1: octave i scatters a^i sigma_s; default 0.5 */
    double extinction; /* b, 0..1: b^i sigma_t attenuates the light of octave i; default 0.5 */
    double anisotropy; /* c, 0..1: c^i g is the mean cosine of octave i; default 0.5 */
    ty_octaves_view_extinction view_extinction; /* default TY_OCTAVES_VIEW_UNSCALED; with TY_OCTAVES_VIEW_SCALED a must
                                                   not exceed b, or octaves grow as (a / b)^i */

    int32_t resolution;        /* cells of light along the longest side of the box around all media, 4..1024; TY_AUTO
                                  (default): as the finest voxels, but 256 at most; 64 where media have no voxels */
    int32_t environment_beams; /* directions per environment light, 1..65536; default 64 */
    int32_t surface_points;    /* points per area light and glowing sphere, 1..65536; default 16 */
    uint64_t seed;             /* of the sample sets of both; default 0 */

    /* Images. */
    int32_t width, height;       /* 0 (default): the camera's resolution. Both or neither */
    int32_t spp;                 /* rays per pixel, 1..64; default 1, through its centre */
    double step;                 /* of the ray march, in voxels, 0.05..8; default 1 */
    uint32_t aovs;               /* TY_AOV_TRANSMITTANCE, _SINGLE, _MULTIPLE, _DEPTH; default 0 */
    const ty_image* unscattered; /* radiance of surfaces through the media, as ty_path_render with
                                    ty_path_def.unscattered makes it, in pixels of the same size; NULL (default):
                                    surfaces are black */

    ty_progress_fn progress; /* default NULL */
    void* progress_user;     /* passed on to progress; default NULL */
} ty_octaves_def;

/* Fills in a ty_octaves_def of `bytes` bytes, as ty_init_context_def does. */
TY_API void ty_init_octaves_def(void* def, size_t bytes);
/* A def with every field at its default. */
static inline ty_octaves_def ty_default_octaves_def(void) {
    ty_octaves_def def;
    ty_init_octaves_def(&def, sizeof def);
    return def;
}

/* Figures of a solve and of a view after it. */
typedef struct ty_octaves_stats {
    int32_t size[3]; /* cells of light */
    int32_t planes;  /* 1: coefficients alike in all channels; 3 */
    int32_t lights;  /* fields of light per octave: lights that are seen from one direction or point, and one of all
                        others */
    double bytes;    /* of the fields of all octaves */
    /* Wall clock, s: of all, and of its parts. */
    double seconds, medium_seconds, direct_seconds, march_seconds;
    const char* isa; /* the build of the kernels that ran, as in ty_path_stats */
} ty_octaves_stats;

/* Light in a scene's media: solved once, seen from anywhere. It keeps nothing of the scene. */
typedef struct ty_octaves ty_octaves;

/* Samples the media of a committed scene and attenuates the light of all its lights once per octave. stats may be NULL.
 * *out is freed with ty_octaves_destroy; NULL after an error. Errors: TY_ERROR_ARGUMENT (def, a scene without media),
 * TY_ERROR_MEMORY; TY_CANCELLED. */
TY_API ty_result ty_octaves_solve(const ty_scene* scene, const ty_octaves_def* def, ty_octaves** out,
                                  ty_octaves_stats* stats);
/* Frees the light; NULL is allowed. */
TY_API void ty_octaves_destroy(ty_octaves* light);

/* Radiance through the pixels of the scene's camera: R, G, B and def->aovs; octave 0 is the layer `single`, the others
 * are `multiple`. The scene is the one that was solved, but for its camera; of def, the options of images and the seed
 * count. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED. After any *out is NULL. */
TY_API ty_result ty_octaves_view(const ty_octaves* light, const ty_scene* scene, const ty_octaves_def* def,
                                 ty_image** out, ty_octaves_stats* stats);

/* ty_octaves_solve and ty_octaves_view. */
TY_API ty_result ty_octaves_render(const ty_scene* scene, const ty_octaves_def* def, ty_image** out,
                                   ty_octaves_stats* stats);

#ifdef __cplusplus
}
#endif
#endif
