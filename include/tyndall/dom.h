/* Tyndall: discrete ordinates with a first-collision source, the fast truth. Apache-2.0.
 *
 * Light that has not scattered yet is found exactly, lights one by one; what scatters of it goes along a set of
 * directions through a grid of cells, the phase function without its forward peak (delta-M). docs/method/dom.md
 * explains what is computed and how far it holds. The result does not depend on the number of threads. */
#ifndef TYNDALL_DOM_H
#define TYNDALL_DOM_H

#include <tyndall/base.h>
#include <tyndall/image.h>
#include <tyndall/path.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* How sweeps are made to converge. */
typedef enum ty_dom_acceleration {
    TY_DOM_ACCELERATION_DIFFUSION = 0, /* diffusion synthetic acceleration and mixtures of iterates (Anderson): three to
                                          five sweeps up to an optical thickness of 100 */
    TY_DOM_ACCELERATION_NONE = 1       /* source iteration: a sweep per order of scattering */
} ty_dom_acceleration;

enum { TY_DOM_CELLS_MAX = 512, TY_DOM_DIRECTIONS_MAX = 1024, TY_DOM_BANDS_MAX = 12 };

/* Light in a scene's media: solved once, seen from anywhere. It keeps nothing of the scene. */
typedef struct ty_dom ty_dom;

/* What to solve and how; made by ty_default_dom_def. */
typedef struct ty_dom_def {
    uint32_t cookie; /* set by ty_default_dom_def; checked */
    uint32_t bytes;  /* set by ty_default_dom_def: size of the def */

    int32_t resolution; /* cells that ordinates go through along the longest side of the box around all media, 4..512;
                           TY_AUTO (default): a third of the voxels (of 64 where there are none), 24..64; where these
                           would be thicker than four mean free paths, up to twice as many, but 64 */
    int32_t direct; /* cells of uncollided light along that side, 4..1024; TY_AUTO (default): as the finest voxels, or
                       twice as many where transfer functions make edges, but 256 at most (of these 192 where not
                       all lights shine from one direction or place); 64 where media have no voxels */
    int32_t directions;      /* ordinates, 8..1024; default 96 */
    int32_t last_directions; /* of one more sweep at the end, 8..1024, so that few do not show as rays: 400 there cost
                                as much as four sweeps of 96 and look like 400 all along; 0 (default): none */
    int32_t bands; /* L: Legendre terms that the scaled phase function keeps, 1..12; TY_AUTO (default): from the media's
                      g and the number of directions */
    ty_dom_acceleration acceleration; /* default TY_DOM_ACCELERATION_DIFFUSION */
    double tolerance;                 /* of the fluence: relative change in the root mean square that is still to come,
                                         (0, 1); default 1e-3 */
    int32_t iterations;               /* sweeps at most; TY_AUTO (default): 100, and 10000 without acceleration */
    const ty_dom* start;              /* light of the same grid to start from, as of an animation's last frame: it saves
                                         sweeps and changes the result within the tolerance. NULL (default): none */

    int32_t environment_beams; /* per environment light, 1..65536; default 64 */
    int32_t surface_points;    /* per area light and glowing sphere, 1..65536; default 16 */
    uint64_t seed;             /* of where these lie; default 0 */

    /* Images. */
    int32_t width, height;       /* 0 (default): the camera's resolution. Both or neither */
    int32_t spp;                 /* rays per pixel, 1..64; default 1, through its middle */
    double step;                 /* of the march, in voxels, 0.05..8; default 1 */
    uint32_t aovs;               /* TY_AOV_TRANSMITTANCE, _SINGLE, _MULTIPLE, _DEPTH; default 0 */
    const ty_image* unscattered; /* as in ty_fld_def */

    ty_progress_fn progress; /* default NULL */
    void* progress_user;     /* passed on to progress; default NULL */
} ty_dom_def;

/* Fills in a ty_dom_def of `bytes` bytes, as ty_init_context_def does. */
TY_API void ty_init_dom_def(void* def, size_t bytes);
/* A def with every field at its default. */
static inline ty_dom_def ty_default_dom_def(void) {
    ty_dom_def def;
    ty_init_dom_def(&def, sizeof def);
    return def;
}

/* What a solve, and a view after it, did. Per channel where there are three. */
typedef struct ty_dom_stats {
    int32_t direct_size[3], size[3]; /* cells */
    int32_t planes;                  /* 1: one solve for all channels; 3 */
    /* What was used of both. */
    int32_t directions, bands;
    bool converged;    /* all channels */
    int32_t sweeps[3]; /* of all directions over all cells */
    int32_t cycles[3]; /* of multigrid */
    double change[3];  /* what is still to come, of the fluence, estimated */
    /* W: light that scattered for the first time, emission, and what surfaces between cells sent of environments and
       area lights; what the medium absorbed of it, and surfaces; what left. */
    double emitted[3], absorbed[3], absorbed_by_surfaces[3], leaving[3];
    /* Wall clock, s: of all, and of its parts. */
    double seconds, medium_seconds, direct_seconds, source_seconds, wall_seconds, solve_seconds, march_seconds;
    double sweep_seconds; /* of solve_seconds, in sweeps alone */
    double bytes;         /* that the solve works in */
    const char* isa;      /* which build of the kernels ran, as in ty_path_stats */
} ty_dom_stats;

/* Samples the media of a committed scene, finds the uncollided light of all its lights and solves for the rest.
 * stats may be NULL. *out is freed with ty_dom_destroy; NULL after an error. A solve that runs out of sweeps is
 * TY_OK with stats->converged false. Errors: TY_ERROR_ARGUMENT (def, a scene without media, start of another grid),
 * TY_ERROR_MEMORY; TY_CANCELLED. */
TY_API ty_result ty_dom_solve(const ty_scene* scene, const ty_dom_def* def, ty_dom** out, ty_dom_stats* stats);
/* Frees the light; NULL is allowed. */
TY_API void ty_dom_destroy(ty_dom* light);

/* Radiance through the pixels of the scene's camera: R, G, B and def->aovs. The scene is the one that was solved, but
 * for its camera; of def, the options of images and the seed count. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY;
 * TY_CANCELLED. After any *out is NULL. */
TY_API ty_result ty_dom_view(const ty_dom* light, const ty_scene* scene, const ty_dom_def* def, ty_image** out,
                             ty_dom_stats* stats);

/* ty_dom_solve and ty_dom_view. */
TY_API ty_result ty_dom_render(const ty_scene* scene, const ty_dom_def* def, ty_image** out, ty_dom_stats* stats);

/* Fluence as ty_path_fluence gives it (integral of radiance over all directions, W m^-2), means over the cells of a
 * box; outside of the box around the media it is 0. uncollided: what of it has not scattered, since lights or since
 * surfaces sent it (in the scaled problem: with what scattering sends nearly straight on); may be NULL. Cells x 3. A
 * box without extent along an axis gives that plane, line or point. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_dom_fluence(const ty_dom* light, const double lower[3], const double upper[3],
                                const int32_t size[3], double* fluence, double* uncollided);

/* Radiance at a point, W m^-2 sr^-1, of light that travels along each of `count` unit vectors (x, y, z after one
 * another) and has scattered at least once: 3 a direction, as the stored moments say, which may be below 0 where light
 * comes from few directions. Errors: TY_ERROR_ARGUMENT. */
TY_API ty_result ty_dom_radiance(const ty_dom* light, const double point[3], const float* directions, int32_t count,
                                 float* radiance);

#ifdef __cplusplus
}
#endif
#endif
