/* Tyndall: light propagation volumes with scattering, fog in a scene of surfaces. Apache-2.0.
 *
 * After Billeter, Sintorn, Assarsson: Real-Time Multiple Scattering using Light Propagation Volumes (2012); equation
 * numbers are the paper's. docs/method/lpv.md explains what is computed, how far it holds, and where it departs. The
 * result does not depend on the number of threads. */
#ifndef TYNDALL_LPV_H
#define TYNDALL_LPV_H

#include <tyndall/base.h>
#include <tyndall/image.h>
#include <tyndall/rsm.h>
#include <tyndall/path.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The model of blockers and of propagation steps. */
typedef enum ty_lpv_mode {
    TY_LPV_MODE_LINKS = 0,    /* ours, in absolute units: surfaces block the links between cells that they cut, and
                                 reflect what they stop; steps keep momentum and diffuse as media do */
    TY_LPV_MODE_PUBLISHED = 1 /* the paper's: fuzzy blockers as spherical harmonics that swallow light; each step as
                                 Eq. 3 has it, with in-scattering that conserves energy */
} ty_lpv_mode;

/* The placement of the lattice. */
typedef enum ty_lpv_place {
    TY_LPV_PLACE_SCENE = 0, /* around media and surfaces */
    TY_LPV_PLACE_CAMERA = 1 /* cubes about the camera, which move by whole cells */
} ty_lpv_place;

/* Features of the method; the paper's comparisons (Fig. 5) leave some of them out. */
enum {
    TY_LPV_REFLECTED = 1,  /* injection of light that surfaces reflect */
    TY_LPV_SCATTERED = 2,  /* injection of light that media scatter once */
    TY_LPV_SCATTERING = 4, /* media scatter and absorb what the lattice carries */
    TY_LPV_SURFACES = 8,   /* the lattice lights surfaces */
    TY_LPV_MARCH = 16,     /* media show the lattice's light */
    TY_LPV_SINGLE = 32,    /* media show light that they scatter once, with sharp shadows */
    TY_LPV_PLAIN = 1 + 8,  /* light propagation volumes without media */
    TY_LPV_ALL = 63
};

enum { TY_LPV_CELLS_MAX = 256, TY_LPV_CASCADES_MAX = 6, TY_LPV_BANDS_MAX = 3 };

/* The surfaces that the camera sees, as engines store them: width x height pixels, row by row, the top one first,
 * through the middles of the scene's camera's pixels. Arrays are the caller's. */
typedef struct ty_lpv_view_def {
    const float* distance; /* m, along each pixel's ray; INFINITY: no surface */
    const float* normal;   /* 3 a pixel, unit, towards the camera's side */
    const float* albedo;   /* 3 a pixel, 0..1 */
    const float* emission; /* 3 a pixel, radiance towards the camera; NULL: none */
} ty_lpv_view_def;

/* The options of a solve and of its images; made by ty_default_lpv_def. */
typedef struct ty_lpv_def {
    uint32_t cookie;  /* set by ty_default_lpv_def; checked */
    ty_lpv_mode mode; /* default TY_LPV_MODE_LINKS */
    uint32_t parts;   /* TY_LPV_... together; default TY_LPV_ALL */

    /* The lattice: cells are cubes. */
    int32_t resolution; /* cells along the longest side, 4..256; default 32 */
    ty_lpv_place place; /* default TY_LPV_PLACE_SCENE */
    double extent;      /* m, side of the cube about the camera, > 0; place camera alone; default 32 */
    int32_t cascades;   /* nested lattices of `resolution`, each twice as wide as the one within, the widest as `place`
                           says for scenes, the narrowest for cameras; 1..6; default 1 */
    int32_t bands;      /* of spherical harmonics: 2 (default, the paper's) or 3 */
    double window;      /* against ringing: how much less of band l is injected, 1 / (1 + window l^2 (l + 1)^2), 0..1;
                           default 0 with 2 bands; -1 (default): 0.01 with 3 */
    int32_t iterations; /* 1..4096; 0 (default): until a hundredth of what came in is under way; published: 8 */
    double tolerance;   /* that hundredth, (0, 1); default 0.01 */

    /* Injection. */
    int32_t map_side;   /* texels of reflective shadow maps, 16..4096; default 256 */
    int32_t samples;    /* on each ray from a light to a texel, at most, 1..64; default 8 */
    int32_t block_side; /* texels a cell, along a side, of the depth maps that find blockers, 1..16; default 3 */
    const ty_rsm* maps; /* one per light of the scene, in order of their addition; NULL (default): traced */
    int32_t map_count;  /* of maps; default 0 */

    /* Images. */
    const ty_lpv_view_def* view; /* NULL (default): traced */
    int32_t shadow_side;         /* texels of the shadow maps of single scattering, 16..4096; default 512 */
    bool shadow_rays; /* whether surfaces near edges of shadows ask by rays, default true; else maps alone decide */
    bool half;        /* whether media are marched at half of the resolution, and brought to full with regard to
                         depth; default true */
    double step;      /* of the march, in cells, 0.05..8; default 1 */
    int32_t width, height; /* 0 (default): the camera's resolution. Both or neither */
    int32_t spp;           /* rays per pixel, 1..64; default 1, through its middle; a traced view alone */
    uint32_t aovs;         /* TY_AOV_TRANSMITTANCE, _SINGLE, _MULTIPLE, _DEPTH, _NORMAL; default 0 */
    uint64_t seed;         /* of where samples lie; default 0 */

    ty_progress_fn progress; /* default NULL */
    void* progress_user;     /* passed on to progress; default NULL */
} ty_lpv_def;

/* A def with every field at its default. */
TY_API ty_lpv_def ty_default_lpv_def(void);
/* The options of a scene file's render.lpv (ty_scene_render_settings), and the defaults of all that it cannot say.
 * Words that are none of a setting's count as the first of them. */
TY_API ty_lpv_def ty_lpv_def_of(const ty_lpv_settings* settings);

/* Statistics of a solve, and of a view after it. Seconds of all lights, channels and cascades together. */
typedef struct ty_lpv_stats {
    int32_t size[TY_LPV_CASCADES_MAX][3]; /* cells */
    double cell[TY_LPV_CASCADES_MAX];     /* side, m */
    int32_t iterations;                   /* of propagation */
    /* W: injected by reflection and by scattering, absorbed by media, by surfaces, gone out, still under way. */
    double reflected[3], scattered[3], absorbed[3], blocked[3], escaped[3], left[3];
    double seconds; /* all of it; its parts: */
    double medium_seconds, map_seconds, reflected_seconds, scattered_seconds, blocker_seconds; /* before propagation */
    double shadow_seconds;                                     /* of the finer maps, which images alone need */
    double prepare_seconds, propagate_seconds, gather_seconds; /* propagation, Table 1 */
    double view_seconds, surface_seconds, march_seconds, single_seconds, compose_seconds; /* images */
    int64_t rays;                                                                         /* traced */
    int64_t marched;    /* rays through media: of images, with those that half of the resolution does not tell */
    double ray_seconds; /* of tracing them, of all threads, over their number */
    const char* isa;    /* which build of the kernels ran, as in ty_path_stats */
} ty_lpv_stats;

/* Light in a scene's media and between its surfaces: solved once, seen from anywhere. */
typedef struct ty_lpv ty_lpv;

/* Checks before any work that the method takes a scene's lights: directional, point and spot ones, and not light of
 * surfaces that glow alone. Errors: TY_ERROR_ARGUMENT (a light of another kind, named by its place, or only surfaces
 * that glow). */
TY_API ty_result ty_lpv_check_scene(const ty_scene* scene);

/* Other lights than those of ty_lpv_check_scene are not for this method. Without media it is plain light propagation.
 * stats may be NULL. *out is freed with ty_lpv_destroy; NULL after an error. Errors: TY_ERROR_ARGUMENT (def, maps, a
 * light of another kind, named by its place, only surfaces that glow), TY_ERROR_MEMORY; TY_CANCELLED. */
TY_API ty_result ty_lpv_solve(const ty_scene* scene, const ty_lpv_def* def, ty_lpv** out, ty_lpv_stats* stats);
/* Frees the light; NULL is allowed. */
TY_API void ty_lpv_destroy(ty_lpv* light);

/* Radiance through the pixels of the scene's camera: R, G, B and def->aovs (single: light that media scatter once and
 * nothing else touches; multiple: other light that media scatter towards the camera, but not what they scatter onto
 * surfaces). The scene is the one that was solved, but for its camera; of def, the options of images count. Errors: as
 * ty_lpv_solve. After any *out is NULL. */
TY_API ty_result ty_lpv_view(const ty_lpv* light, const ty_scene* scene, const ty_lpv_def* def, ty_image** out,
                             ty_lpv_stats* stats);
/* ty_lpv_solve and ty_lpv_view. */
TY_API ty_result ty_lpv_render(const ty_scene* scene, const ty_lpv_def* def, ty_image** out, ty_lpv_stats* stats);

/* Fluence of the light that the lattice carries (scattered or reflected at least once), W m^-2, means over the cells of
 * a box: cells x 3, x fastest; outside of the lattice 0. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_lpv_fluence(const ty_lpv* light, const double lower[3], const double upper[3],
                                const int32_t size[3], double* fluence);

/* Irradiance by the same light, W m^-2, on surfaces at `count` points with unit normals (x, y, z after one another): 3
 * a point. Errors: TY_ERROR_ARGUMENT. */
TY_API ty_result ty_lpv_irradiance(const ty_lpv* light, const float* points, const float* normals, int64_t count,
                                   float* irradiance);

/* One lattice as it is, for an engine to look up. The radiance that travels along a unit vector w is the sum over
 * i < bands^2 of coefficients[c][i] * Y_i(w), real spherical harmonics in the order l (l + 1) + m without the
 * Condon-Shortley phase. The arrays are the light's own. */
typedef struct ty_lpv_lattice {
    double lower[3], cell;                                             /* its lower corner and the side of a cell, m */
    int32_t size[3];                                                   /* cells along x, y, z */
    int32_t bands;                                                     /* 2 or 3 */
    const float* coefficients[3][TY_LPV_BANDS_MAX * TY_LPV_BANDS_MAX]; /* x fastest, W m^-2 sr^-1 */
} ty_lpv_lattice;
/* The lattice of a cascade, 0 being the narrowest; false: there is none. */
TY_API bool ty_lpv_get_lattice(const ty_lpv* light, int32_t cascade, ty_lpv_lattice* out);

#ifdef __cplusplus
}
#endif
#endif
