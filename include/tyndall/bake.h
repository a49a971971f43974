/* Tyndall: baking, light on surfaces and at points computed once and kept. Apache-2.0. docs/bake.md explains targets,
 * units and conventions; the result does not depend on the number of threads. */
#ifndef TYNDALL_BAKE_H
#define TYNDALL_BAKE_H

#include <tyndall/base.h>
#include <tyndall/image.h>
#include <tyndall/impulse.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What media do to light on its way. */
typedef enum ty_bake_method {
    TY_BAKE_CACHE = 0,       /* surfaces by paths, media by light that was gathered in cells of them before */
    TY_BAKE_IMPULSE = 1,     /* surfaces by paths, media by impulse responses */
    TY_BAKE_ATTENUATION = 2, /* media take light away, and scatter none */
    TY_BAKE_SURFACES = 3,    /* as if there were no media */
    TY_BAKE_PATH = 4         /* the truth: paths through media, too */
} ty_bake_method;

/* What light has done before it arrives; they add up to all of it. */
enum {
    TY_BAKE_DIRECT = 0,   /* came from a light, unhindered but for the media's extinction */
    TY_BAKE_INDIRECT = 1, /* surfaces alone reflected it */
    TY_BAKE_SINGLE = 2,   /* a medium scattered it once, and nothing else touched it */
    TY_BAKE_MULTIPLE = 3, /* all else */
    TY_BAKE_LAYERS = 4
};

enum { TY_BAKE_SH_TERMS = 25 };

/* A place that gathers light. normal (0, 0, 0): a probe, which gathers from all around. */
typedef struct ty_bake_receiver {
    float position[3]; /* m; on surfaces: on them */
    float normal[3];   /* unit, on the side that is lit */
    float face[3];     /* unit normal of the flat face on that side; light from behind it does not count */
    float margin;      /* m: rays start this far off along face */
} ty_bake_receiver;

/* What a receiver got, per layer. Surfaces: irradiance E (W m^-2) and the vector irradiance of light from the lit side
 * (the integral of radiance times the unit vector to where it comes from: x, y, z), of which L1 is made. Probes:
 * radiance in real spherical harmonics, without the Condon-Shortley phase, of where light comes from, in the order
 * l (l + 1) + m. */
typedef struct ty_bake_light {
    float irradiance[TY_BAKE_LAYERS][3]; /* [layer][channel], W m^-2 */
    float toward[TY_BAKE_LAYERS][3][3];  /* [layer][channel][axis] */
    float fluence[3];  /* the integral of radiance from the lit side, W m^-2, of all layers; 0: not measured */
    float variance[3]; /* of the sum of all layers' irradiance, or of the first harmonic */
    int32_t samples;   /* paths gathered; 0: none yet */
    float blocked; /* the fraction of first rays that met the back of a surface that is not double-sided: near 1 within
                      walls */
} ty_bake_light;

/* What a probe got: as ty_bake_light says. */
typedef struct ty_bake_probe {
    float sh[TY_BAKE_LAYERS][3][TY_BAKE_SH_TERMS]; /* [layer][channel][term], W m^-2 sr^-1 */
    float variance[3];                             /* of the first term, over all layers */
    int32_t samples;                               /* paths gathered; 0: none yet */
    float blocked; /* the fraction of rays that met the back of a surface: near 1 within walls */
} ty_bake_probe;

/* Light that arrives in the cells of a lattice over a scene's media: its mean over each cell, in all and apart for what
 * comes straight from lights, with its mean direction. */
typedef struct ty_bake_cache ty_bake_cache;

/* How to bake; made by ty_default_bake_def. */
typedef struct ty_bake_def {
    uint32_t cookie;       /* set by ty_default_bake_def; checked */
    uint32_t bytes;        /* set by ty_default_bake_def: size of the def */
    ty_bake_method method; /* default TY_BAKE_CACHE */
    int32_t spp;           /* paths per receiver at most, 1..2^20; default 64 */
    double error;    /* stop a receiver when its standard error is below this part of its irradiance (or of the mean of
                        all, where that is more), > 0; 0 (default): no bound */
    int32_t bounces; /* reflections and, for TY_BAKE_PATH, scatterings together at most; 0 (default): as many
                        as Russian roulette leaves */
    int32_t scatterings;        /* between two surfaces, or a light and a surface, at most, 1..tables' bounces; default
                                   10. TY_BAKE_PATH keeps to it, too */
    bool back_scattering;       /* whether light counts that surfaces behind a receiver send into the medium (Sec. 5.2);
                                   default true */
    const ty_impulse* tables;   /* method TY_BAKE_IMPULSE; NULL: made with defaults */
    const ty_bake_cache* cache; /* method TY_BAKE_CACHE, of the same scene; NULL: made of this def */
    int32_t cells;              /* of a cache along the longest side of its box, 1..512; default 32 */
    int32_t cell_paths;         /* of a cache, per cell, 1..2^20; default 64 */
    uint64_t seed;              /* any; default 0 */
    ty_progress_fn progress;    /* default NULL */
    void* progress_user;        /* passed on to progress; default NULL */
} ty_bake_def;

/* Fills in a ty_bake_def of `bytes` bytes, as ty_init_context_def does. */
TY_API void ty_init_bake_def(void* def, size_t bytes);
/* A def with every field at its default. */
static inline ty_bake_def ty_default_bake_def(void) {
    ty_bake_def def;
    ty_init_bake_def(&def, sizeof def);
    return def;
}

/* What a bake took. */
typedef struct ty_bake_stats {
    double seconds, table_seconds; /* wall clock, s: of all, and of making or reading the tables of impulse responses */
    double cache_seconds;          /* of the cache's making, if it was made for this bake */
    int64_t paths, rays;           /* segments and shadow rays */
    double ray_seconds;            /* estimate: rays at the speed of bare tracing; 0: not measured */
    double mean_samples;           /* paths per receiver */
} ty_bake_stats;

/* What a cache of light in cells is, or will be. */
typedef struct ty_bake_cache_info {
    int32_t size[3];     /* cells */
    double cell;         /* their side, m */
    int64_t filled;      /* those that light is known in: where media scatter, and around */
    int64_t paths, rays; /* that filled it: segments and shadow rays */
    double bytes;        /* of memory */
    double seconds;      /* that filling it took */
} ty_bake_cache_info;

/* What a cache will be: its size, the side of its cells and its bytes. Errors: TY_ERROR_ARGUMENT. */
TY_API ty_result ty_bake_cache_estimate(const ty_scene* scene, const ty_bake_def* def, ty_bake_cache_info* out);
/* Gathers the light in a committed scene's media, for any number of bakes of it with the same bounces and scatterings:
 * def's cells, cell_paths, bounces, scatterings, seed and progress count. Without media that scatter it has no cells.
 * Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY, TY_CANCELLED. */
TY_API ty_result ty_bake_cache_create(const ty_scene* scene, const ty_bake_def* def, ty_bake_cache** out);
/* Frees a cache; NULL is allowed. */
TY_API void ty_bake_cache_destroy(ty_bake_cache* cache);
/* Size, cells and what filling them took. */
TY_API ty_bake_cache_info ty_bake_cache_get_info(const ty_bake_cache* cache);

/* Light at receivers of a committed scene. On TY_CANCELLED what is there is valid with fewer samples (0: none yet).
 * stats may be NULL. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_bake_surfaces(const ty_scene* scene, const ty_bake_def* def, const ty_bake_receiver* receivers,
                                  int64_t count, ty_bake_light* light, ty_bake_stats* stats);
/* The same at points, from all around: positions has x, y, z of each, m. */
TY_API ty_result ty_bake_probes(const ty_scene* scene, const ty_bake_def* def, const float* positions, int64_t count,
                                ty_bake_probe* probes, ty_bake_stats* stats);

/* The receivers of a mesh's vertices, one each, on the fronts of its triangles: a vertex stands in the largest triangle
 * that has it, a hundredth of the way to that triangle's middle, so that walls it touches do not hide all light from
 * it; its normal is the mesh's, or the mean of its triangles' by area. Vertices without triangles look up where they
 * are. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_bake_vertices(const ty_scene* scene, int32_t mesh, ty_bake_receiver* receivers);

/* One pixel per receiver, row by row, width (1..65536) of them in a row; pixels past the last are 0. Channels as of
 * ty_atlas_image, but for coverage. What is not finite counts as 0. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_bake_light_image(ty_context* context, const ty_bake_light* light, int64_t count, int32_t width,
                                     ty_image** out);
/* Probes on a grid of size[0] x size[1] x size[2], x fastest: the slices of equal z one below the other, each size[1]
 * rows of size[0] pixels. terms: 9 or 25 of spherical harmonics are kept. R, G, B: mean radiance of all directions;
 * shT.R, .G, .B for T = 0..terms - 1: radiance; LAYER.shT.R ...: the same of direct, indirect, single and multiple, of
 * which shT is the sum; blocked.Z, samples.N, variance.R, .G, .B. Errors as above. */
TY_API ty_result ty_bake_probe_image(ty_context* context, const ty_bake_probe* probes, const int32_t size[3],
                                     int32_t terms, ty_image** out);
/* The sum of a probe's layers: sh[channel][term]. */
TY_API void ty_bake_probe_sum(const ty_bake_probe* probe, float sh[3][TY_BAKE_SH_TERMS]);

/* ---- Lightmaps ---- */

/* How many texels a lightmap has; made by ty_default_atlas_def. */
typedef struct ty_atlas_def {
    uint32_t cookie;       /* set by ty_default_atlas_def; checked */
    uint32_t bytes;        /* set by ty_default_atlas_def: size of the def */
    int32_t width, height; /* texels of one map, 4..16384; 0 (default): from density */
    double density;        /* texels per metre, > 0; default 8; at most 4096 texels a side come of it */
    int32_t padding;       /* texels around charts that are filled, 0..64; default 4 */
    bool close_seams; /* whether both sides of an edge that charts share on the surface, but not in the map, are made
                         alike; default true */
} ty_atlas_def;

/* Fills in a ty_atlas_def of `bytes` bytes, as ty_init_context_def does. */
TY_API void ty_init_atlas_def(void* def, size_t bytes);
/* A def with every field at its default. */
static inline ty_atlas_def ty_default_atlas_def(void) {
    ty_atlas_def def;
    ty_init_atlas_def(&def, sizeof def);
    return def;
}

/* Where the texels of a mesh's second texture coordinates lie on it. */
typedef struct ty_atlas ty_atlas;

/* What an atlas will be. */
typedef struct ty_atlas_size {
    int32_t width, height; /* texels */
    double texels;         /* about how many will count */
    double bytes; /* of the atlas, light at its receivers, and an image of it together, at most, but for seams */
} ty_atlas_size;

/* Before anything is allocated; errors as ty_atlas_create, but for charts that overlap, which is not looked at. */
TY_API ty_result ty_atlas_estimate(const ty_scene* scene, int32_t mesh, const char* name, const ty_atlas_def* def,
                                   ty_atlas_size* out);
/* Of one mesh (an index as of ty_scene_get_mesh). Texels count that triangles cover the middle of, or touch, in which
 * case they take the nearest place on the triangle. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY, and TY_ERROR_INPUT when
 * the mesh has no second texture coordinates, or they leave 0..1, or charts overlap: the message says which, how much,
 * and what to do. name: of the mesh, for messages. */
TY_API ty_result ty_atlas_create(const ty_scene* scene, int32_t mesh, const char* name, const ty_atlas_def* def,
                                 ty_atlas** out);
/* Frees an atlas and its receivers; NULL is allowed. */
TY_API void ty_atlas_destroy(ty_atlas* atlas);
/* Texels along u. */
TY_API int32_t ty_atlas_width(const ty_atlas* atlas);
/* Texels along v. */
TY_API int32_t ty_atlas_height(const ty_atlas* atlas);
/* The atlas' receivers, one per texel that counts; *count of them; they last as long as it. */
TY_API const ty_bake_receiver* ty_atlas_receivers(const ty_atlas* atlas, int64_t* count);
/* An image of what they got (light[i] is the i-th receiver's), row 0 at v = 0.
 *
 * - R, G, B: irradiance, the sum of its layers direct.R .. multiple.B, W m^-2.
 * - L1.RX .. L1.BZ: the vector irradiance over the integral of radiance, no longer than 1: where light comes from, and
 *   how much from there alone. On another unit normal m than the surface's n, irradiance is about
 *   R max(0, 1 + 2 L1 . m) / (1 + 2 L1 . n). A unit vector where fluence was not measured.
 * - coverage.A: 1 where a triangle covers the texel's middle, else the fraction that the texel's triangle covers, 0
 *   around charts.
 * - samples.N: paths; 0 where light is not the texel's own.
 * - variance.R, .G, .B: of R, G, B as sampled; 0 where samples.N is.
 *
 * Texels within walls (blocked > 1/2), not sampled or not finite take the light of neighbours on their chart, from the
 * nearest on; a chart where all are keeps what it has. Then bilinear lookups along edges that smooth surfaces share are
 * made alike by the least change of the texels that they meet. Then texels around charts take the light of the nearest
 * that counts, `padding` rows and columns far: bilinear lookups need 1, those in mip level m 2^m.
 * Errors: TY_ERROR_MEMORY. */
TY_API ty_result ty_atlas_image(const ty_atlas* atlas, const ty_bake_light* light, ty_image** out);

#ifdef __cplusplus
}
#endif
#endif
