/* Tyndall: flux-limited diffusion, multiple scattering in any volume, vacuum included. Apache-2.0.
 *
 * After Koerner, Portsmouth, Sadlo, Ertl, Eberhardt: Flux-Limited Diffusion for Multiple Scattering in Participating
 * Media (2014); equation numbers are the paper's. docs/method/fld.md explains what is computed, how far it holds, and
 * where it departs. The result does not depend on the number of threads. */
#ifndef TYNDALL_FLD_H
#define TYNDALL_FLD_H

#include <tyndall/base.h>
#include <tyndall/image.h>
#include <tyndall/path.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* F(R) of Table 2. */
typedef enum ty_fld_limiter {
    TY_FLD_LIMITER_NONE = 0, /* 1/3: classical diffusion (CDA) */
    TY_FLD_LIMITER_SUM = 1,  /* 1 / (3 + R) */
    TY_FLD_LIMITER_MAX = 2,  /* 1 / max(3, R) */
    TY_FLD_LIMITER_KERSHAW = 3,
    TY_FLD_LIMITER_LARSEN = 4,             /* (3^n + R^n)^(-1/n), n: larsen_power */
    TY_FLD_LIMITER_LEVERMORE_POMRANING = 5 /* (coth R - 1/R) / R */
} ty_fld_limiter;

/* What the six faces of the box around all media do. */
typedef enum ty_fld_boundary {
    TY_FLD_BOUNDARY_MARSHAK = 0,  /* vacuum outside: half of the fluence leaves as flux, nothing comes in */
    TY_FLD_BOUNDARY_DIRICHLET = 1 /* the paper's: no fluence on the faces */
} ty_fld_boundary;

/* What solves the equation; they agree within the tolerance. */
typedef enum ty_fld_solver {
    TY_FLD_SOLVER_MULTIGRID = 0, /* ours */
    TY_FLD_SOLVER_SOR = 1,       /* Algorithm 1, in double precision */
    TY_FLD_SOLVER_SOR_FLOAT = 2  /* the same in single precision */
} ty_fld_solver;

/* Which of the light counts as uncollided. */
typedef enum ty_fld_beam {
    TY_FLD_BEAM_REDUCED = 0,  /* all that scattering sends nearly straight on stays with the beam: sigma_s (1 - g)
                                 scatters it, and what it scatters does so equally in all directions */
    TY_FLD_BEAM_PUBLISHED = 1 /* sigma_s scatters it, and media are taken as isotropic (the paper) */
} ty_fld_beam;

enum { TY_FLD_CELLS_MAX = 1024 };

/* What to solve and how; made by ty_default_fld_def. */
typedef struct ty_fld_def {
    uint32_t cookie; /* set by ty_default_fld_def; checked */
    uint32_t bytes;  /* set by ty_default_fld_def: size of the def */

    int32_t resolution; /* cells of direct light along the longest side of the box around all media, 4..1024; TY_AUTO
                           (default): as the finest voxels, but 256 at most; 64 where media have no voxels */
    double ratio; /* cells of direct light per cell of diffusion, along each side, 1..64; TY_AUTO (default): 3, but 2
                     where that leaves less than 48 cells along the longest side. Above 3 diffuse light is relaxed, and
                     kept, on cells half as large */
    ty_fld_beam beam; /* default TY_FLD_BEAM_REDUCED */

    ty_fld_limiter limiter; /* default TY_FLD_LIMITER_LEVERMORE_POMRANING */
    double larsen_power;    /* n, 1..100; default 2 */
    double streaming; /* the largest ratio of flux to fluence, (0, 1]: where limiters let R F(R) go; TY_AUTO (default):
                         0.55, and up to 0.8 as the share of light grows that comes from lamps within the media's box.
                         0.55 is about what light has where it leaves thick media for vacuum (0.5 if it left alike in
                         all outward directions, 1 / sqrt(3) in Milne's problem); 1: the paper's, true of light far from
                         its source */
    ty_fld_boundary boundary; /* default TY_FLD_BOUNDARY_MARSHAK */
    double sigma_eps;         /* least extinction, 1/m, > 0; TY_AUTO (default): 1e-3 / the longest side */
    ty_fld_solver solver;     /* default TY_FLD_SOLVER_MULTIGRID */
    double relaxation;        /* omega of SOR, (0, 2); default 1.85 */
    double tolerance;         /* of rms(residual) / rms(source), (0, 1); default 1e-3, which is 3e-4 of images at most;
                                 unless the limiter is none, there are two iterations at least */
    int32_t iterations;       /* at most; TY_AUTO (default): the solver's own bound */

    int32_t environment_beams; /* per environment light, 1..65536; default 64 */
    int32_t surface_points;    /* per area light and glowing sphere, 1..65536; default 16 */
    uint64_t seed;             /* of where these lie; default 0 */

    /* Images. */
    int32_t width, height;       /* 0 (default): the camera's resolution. Both or neither */
    int32_t spp;                 /* rays per pixel, 1..64; default 1, through its middle */
    double step;                 /* of the march, in voxels, 0.05..8; default 1 */
    uint32_t aovs;               /* TY_AOV_TRANSMITTANCE, _SINGLE, _MULTIPLE, _DEPTH; default 0 */
    const ty_image* unscattered; /* what surfaces send through the media, as ty_path_render with ty_path_def.unscattered
                                    makes it, in pixels of the same size; NULL (default): surfaces are black but for
                                    what scattered light they reflect */

    ty_progress_fn progress; /* default NULL */
    void* progress_user;     /* passed on to progress; default NULL */
} ty_fld_def;

/* Fills in a ty_fld_def of `bytes` bytes, as ty_init_context_def does. */
TY_API void ty_init_fld_def(void* def, size_t bytes);
/* A def with every field at its default. */
static inline ty_fld_def ty_default_fld_def(void) {
    ty_fld_def def;
    ty_init_fld_def(&def, sizeof def);
    return def;
}

/* What a solve, and a view after it, did. Per channel where there are three. */
typedef struct ty_fld_stats {
    int32_t direct_size[3], diffusion_size[3]; /* cells */
    int32_t planes;                            /* 1: coefficients alike in all channels; 3 */
    bool converged;                            /* all channels */
    int32_t iterations[3];                     /* Picard iterations, or sweeps of SOR */
    int32_t cycles[3];                         /* of multigrid */
    double residual[3];                        /* rms(residual) / rms(source) at the end */
    double work[3];                            /* passes over all cells */
    /* W: light that scattered for the first time and emission, what the medium absorbed of it, what left. */
    double emitted[3], absorbed[3], leaving[3];
    /* Wall clock, s: of all, and of its parts. */
    double seconds, medium_seconds, direct_seconds, solve_seconds, march_seconds;
    double bytes;    /* that the solver works in, with all channels that are solved side by side */
    const char* isa; /* which build of the kernels ran, as in ty_path_stats */
} ty_fld_stats;

/* Light in a scene's media: solved once, seen from anywhere. It keeps nothing of the scene. */
typedef struct ty_fld ty_fld;

/* Samples the media of a committed scene, finds the uncollided light of all its lights and solves for the rest.
 * stats may be NULL. *out is freed with ty_fld_destroy; NULL after an error. A solve that runs out of iterations is
 * TY_OK with stats->converged false. Errors: TY_ERROR_ARGUMENT (def, a scene without media), TY_ERROR_MEMORY;
 * TY_CANCELLED. */
TY_API ty_result ty_fld_solve(const ty_scene* scene, const ty_fld_def* def, ty_fld** out, ty_fld_stats* stats);
/* Frees the light; NULL is allowed. */
TY_API void ty_fld_destroy(ty_fld* light);

/* Radiance through the pixels of the scene's camera: R, G, B and def->aovs. The scene is the one that was solved, but
 * for its camera; of def, the options of images and the seed count. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY;
 * TY_CANCELLED. After any *out is NULL. */
TY_API ty_result ty_fld_view(const ty_fld* light, const ty_scene* scene, const ty_fld_def* def, ty_image** out,
                             ty_fld_stats* stats);

/* ty_fld_solve and ty_fld_view. */
TY_API ty_result ty_fld_render(const ty_scene* scene, const ty_fld_def* def, ty_image** out, ty_fld_stats* stats);

/* Fluence as ty_path_fluence gives it (integral of radiance over all directions, W m^-2), means over the cells of a
 * box; outside of the box around the media it is 0. beam: what of it the diffusion did not have to find: uncollided
 * light, with TY_FLD_BEAM_REDUCED also what scattering sent nearly straight on; may be NULL. flux: the net flux vector
 * of all light, x, y and z per cell and channel, W m^-2; may be NULL. fluence, beam: cells x 3, flux: cells x 3
 * channels x 3 axes. A box without extent along an axis gives that plane, line or point. Errors: TY_ERROR_ARGUMENT,
 * TY_ERROR_MEMORY. */
TY_API ty_result ty_fld_fluence(const ty_fld* light, const double lower[3], const double upper[3],
                                const int32_t size[3], double* fluence, double* beam, double* flux);

#ifdef __cplusplus
}
#endif
#endif
