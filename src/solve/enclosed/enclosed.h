/* Light in scattering media that fill smooth dielectrics, on cells of each interior: light enters through Fresnel's
 * interface, travels uncollided along refracted rays, and scatters by discrete ordinates or diffusion whose boundary
 * reflects as the interface does. */
#ifndef TY_SOLVE_ENCLOSED_ENCLOSED_H
#define TY_SOLVE_ENCLOSED_ENCLOSED_H

#include "direct/single/enclosed_field.k.h"

#include <tyndall/scene.h>

typedef struct ty_enclosed ty_enclosed;

/* Radiance, W m^-2 sr^-1, that arrives at the ends of `count` rays, six numbers each: the end, m, and the direction in
 * which the light travels. fields: of interiors, as in ty_enclosed_fields, all of them dark at first. radiance: three
 * per ray. */
typedef ty_result (*ty_enclosed_radiance_fn)(void* user, const ty_enclosed_field* fields, const double* rays,
                                             int64_t count, double* radiance);

typedef struct ty_enclosed_def {
    bool diffusion;                   /* default false: ordinates */
    int32_t cells;                    /* along the longest side of an interior, 4..256; TY_AUTO (default): as many
                                         as it is transport mean free paths long, 32..48, and 32 from 96 on */
    int32_t directions;               /* ordinates, 8..1024; default 96 */
    int32_t environment_beams;        /* directions per environment light; default 64 */
    int32_t surface_points;           /* points per area light; default 16 */
    int32_t rays;                     /* to other surfaces, per face of a cell; default 16 */
    int32_t rounds;                   /* of light that surfaces return to the medium; default 2 */
    uint64_t seed;                    /* default 0 */
    ty_enclosed_radiance_fn radiance; /* of other surfaces; NULL (default): none */
    void* user;
    ty_progress_fn progress; /* between the parts of the work, at a fraction of 0; default NULL */
    void* progress_user;
} ty_enclosed_def;

ty_enclosed_def ty_default_enclosed_def(void);
/* The def of a solve of some tens of milliseconds, while a scene changes. */
ty_enclosed_def ty_coarse_enclosed_def(void);

/* Power per channel, W, over all interiors. */
typedef struct ty_enclosed_stats {
    int32_t interiors, sides, rays, sweeps;
    bool converged;
    double entering[3], absorbed[3], leaving[3];
    double seconds, entering_seconds, solve_seconds;
} ty_enclosed_stats;

/* True if a smooth dielectric of the committed scene holds a medium that scatters and whose bounds are its surface. */
bool ty_enclosed_exists(const ty_scene* scene);
/* True if a medium of the scene, by its number, is such. */
bool ty_enclosed_fills(const ty_scene* scene, int32_t medium);
/* True if all media of the scene are such. */
bool ty_enclosed_has_all_media(const ty_scene* scene);
/* Solves for all such interiors; *out is NULL without any. Independent of the number of threads. stats may be NULL.
 * Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_enclosed_solve(const ty_scene* scene, const ty_enclosed_def* def, ty_enclosed** out,
                            ty_enclosed_stats* stats);
void ty_enclosed_destroy(ty_enclosed* enclosed);
/* One field per interior of the scene view; valid as long as `enclosed`. NULL for NULL. */
const ty_enclosed_field* ty_enclosed_fields(const ty_enclosed* enclosed);

#endif
