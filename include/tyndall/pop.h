/* Tyndall: principal-ordinates propagation, anisotropic and heterogeneous media under environment and local lights.
 * Apache-2.0.
 *
 * After Elek, Ritschel, Dachsbacher, Seidel: Principal-Ordinates Propagation for Real-Time Rendering of Participating
 * Media (2014); equation numbers are the paper's. docs/method/pop.md explains what is computed, how far it holds, and
 * where it departs. The result does not depend on the number of threads. */
#ifndef TYNDALL_POP_H
#define TYNDALL_POP_H

#include <tyndall/base.h>
#include <tyndall/image.h>
#include <tyndall/path.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* How ordinates pass light on. */
typedef enum ty_pop_mode {
    TY_POP_MODE_SPLIT = 0, /* ours, in absolute units: each ordinate carries its light as far as scattering leaves it
                              a direction, and hands the rest to flux-limited diffusion, one solve for all */
    TY_POP_MODE_PUBLISHED = 1, /* the paper to the letter: each ordinate's cells pass their light on to their
                                  neighbours, again and again */
    TY_POP_MODE_COLLIDED = 2 /* the same, starting from light that scatters for the first time, with the exact decay of
                                mean cosines, and uncollided light apart */
} ty_pop_mode;

enum {
    TY_POP_CELLS_MAX = 128,
    TY_POP_IMPORTANCE_WIDTH = 32, /* of the map of directions (Sec. 5.2), equirectangular as environments are */
    TY_POP_IMPORTANCE_HEIGHT = 16
};

/* What to solve and how; made by ty_default_pop_def. */
typedef struct ty_pop_def {
    uint32_t cookie;  /* set by ty_default_pop_def; checked */
    uint32_t bytes;   /* set by ty_default_pop_def: size of the def */
    ty_pop_mode mode; /* default TY_POP_MODE_SPLIT */

    int32_t resolution; /* cells of an ordinate's grid along each of its axes, 4..128; TY_AUTO (default): a third of the
                           cells of `direct`, 32..48, modes published and collided 32 (the paper: 20); split mode has
                           twice as many along the light */
    int32_t merged; /* cells of the grid that all ordinates are brought together in, along the longest side of the box
                       around all media, 4..512; TY_AUTO (default): one and a half of the resolution, but no more than
                       48 or the resolution; modes published and collided twice (Sec. 5.3) */
    bool sharp;     /* whether directional, point and spot lights (the first eight of them) go through cells as fine
                       as the medium's instead of grids of their own; default true; split mode alone */
    int32_t direct; /* these cells along the longest side, 4..1024; TY_AUTO (default): as the finest voxels, but 256 at
                       most; 64 where media have no voxels */

    int32_t ordinates; /* N, per environment light, 1..4096; default 64 */
    double prefilter; /* beta of Sec. 5.1, 0..16: a = (1 - w / N)^beta. Mode published: w / N is the share of the sphere
                         that the ordinate stands for; else 1 - w / N is the mean cosine of its light, whatever its
                         shape, which in an even environment is the same; so 1 (default) needs no tuning. Mode split:
                         light that scatters is moreover no brighter than that of a disc of such a mean
                         cosine. 0: none, a = 1 */
    bool importance;  /* whether ordinates are chosen by what the camera sees of their light, too; default true */
    float* history;   /* the importance of the frame before, TY_POP_IMPORTANCE_WIDTH x _HEIGHT, which a share of this
                         one's is mixed with; replaced by this frame's. All 0: there was none. NULL (default): none */

    int32_t surface_points; /* per area light and glowing sphere, 1..65536; default 16 */
    int32_t vpls;           /* virtual point lights (Sec. 6) that surfaces are taken for, 0 (none)..4096; default 64 */
    int32_t shadow_texels;  /* side of the reflective shadow maps that they are chosen from, 16..1024; default 128 */
    double clamp; /* of a VPL's 1 / r^2: r is at least this part of the box's longest side, 0..1; default 0.05 */

    bool keep_lobes; /* whether ordinates' light is kept, so that other cameras can see it, ty_pop_radiance works and
                        ty_pop_fluence knows the uncollided light; default false */

    /* Modes published and collided. */
    int32_t iterations; /* M, 1..10000; TY_AUTO (default): as many as the resolution, or m' of Eq. 10 if that is more */
    double residuum;    /* eps_a of Sec. 5.4: mean cosine below which light counts as isotropic and goes on in one grid
                           for all ordinates, 0..1; default 0.1; 0: never */
    int32_t residuum_iterations; /* at most, 1..10000; TY_AUTO (default): until a thousandth of what came in is left */

    /* Mode split: as in ty_fld_def, on the merged grid. */
    double streaming; /* TY_AUTO (default): 0.5, and up to 0.8 by lamps within the media's box */
    double tolerance; /* default 1e-2, which is 1e-3 of images at most */

    uint64_t seed; /* of where ordinates, points and VPLs lie; default 0 */

    /* Images. */
    int32_t width, height;       /* 0 (default): the camera's resolution. Both or neither */
    int32_t spp;                 /* rays per pixel, 1..64; default 1, through its middle */
    double step;                 /* of the march, in voxels, 0.05..8; default 1 */
    uint32_t aovs;               /* TY_AOV_TRANSMITTANCE, _SINGLE, _MULTIPLE, _DEPTH; default 0 */
    const ty_image* unscattered; /* as in ty_fld_def */

    ty_progress_fn progress; /* default NULL */
    void* progress_user;     /* passed on to progress; default NULL */
} ty_pop_def;

/* Fills in a ty_pop_def of `bytes` bytes, as ty_init_context_def does. */
TY_API void ty_init_pop_def(void* def, size_t bytes);
/* A def with every field at its default. */
static inline ty_pop_def ty_default_pop_def(void) {
    ty_pop_def def;
    ty_init_pop_def(&def, sizeof def);
    return def;
}

/* What a solve, and a view after it, did. */
typedef struct ty_pop_stats {
    int32_t ordinates;           /* grids: of environments, lights and VPLs together */
    int32_t vpls;                /* of these */
    int32_t size[3];             /* cells of an ordinate's grid */
    int32_t merged_size[3];      /* cells */
    int32_t planes;              /* 1: coefficients alike in all channels; 3 */
    int32_t iterations;          /* of propagation; split mode: of diffusion, the most of any channel */
    int32_t residuum_iterations; /* of isotropic light in one grid */
    bool converged;              /* split mode: diffusion; else whether little enough was left */
    double left;                 /* modes published and collided: light not yet propagated, of what came in */
    double seconds;              /* all of it; its parts: */
    double medium_seconds, importance_seconds, ordinate_seconds, vpl_seconds; /* what comes before light is passed on */
    double direct_seconds;                                                    /* sharp lights */
    double initial_seconds;              /* media on ordinates' grids, and light entering them */
    double propagation_seconds;          /* passing light on; split mode: none */
    double residuum_seconds;             /* isotropic light in one grid; split mode: diffusion */
    double merge_seconds, march_seconds; /* bringing ordinates together in one grid; the image */
    double bytes;                        /* of ordinates' grids */
    const char* isa;                     /* which build of the kernels ran, as in ty_path_stats */
} ty_pop_stats;

/* Light in a scene's media: solved once, seen from where the scene's camera was, or with keep_lobes from anywhere. */
typedef struct ty_pop ty_pop;

/* As ty_fld_solve. Errors: TY_ERROR_ARGUMENT (def, a scene without media), TY_ERROR_MEMORY; TY_CANCELLED. */
TY_API ty_result ty_pop_solve(const ty_scene* scene, const ty_pop_def* def, ty_pop** out, ty_pop_stats* stats);
/* Frees the light; NULL is allowed. */
TY_API void ty_pop_destroy(ty_pop* light);

/* As ty_fld_view. Errors: TY_ERROR_ARGUMENT (a camera elsewhere, and lobes were not kept), TY_ERROR_MEMORY;
 * TY_CANCELLED. */
TY_API ty_result ty_pop_view(ty_pop* light, const ty_scene* scene, const ty_pop_def* def, ty_image** out,
                             ty_pop_stats* stats);
/* ty_pop_solve and ty_pop_view. */
TY_API ty_result ty_pop_render(const ty_scene* scene, const ty_pop_def* def, ty_image** out, ty_pop_stats* stats);

/* Fluence as ty_fld_fluence gives it, W m^-2, means over the cells of a box. uncollided: light that has not scattered;
 * NULL: not asked for, else lobes must have been kept. */
TY_API ty_result ty_pop_fluence(const ty_pop* light, const double lower[3], const double upper[3],
                                const int32_t size[3], double* fluence, double* uncollided);

/* Radiance at a point, W m^-2 sr^-1, of light that travels along each of `count` unit vectors (x, y, z after one
 * another) and has scattered at least once: 3 a direction. Lobes must have been kept. Errors: TY_ERROR_ARGUMENT. */
TY_API ty_result ty_pop_radiance(const ty_pop* light, const double point[3], const float* directions, int32_t count,
                                 float* radiance);

/* How much the camera sees of light that comes from each direction (Sec. 5.2), relative to the mean of all: row by row,
 * TY_POP_IMPORTANCE_WIDTH x _HEIGHT. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_pop_importance(const ty_scene* scene, const ty_pop_def* def, float* map);

#ifdef __cplusplus
}
#endif
#endif
