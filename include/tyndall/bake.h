/// @file bake.h
/// Baking: light on surfaces and at probes, computed once and stored.
///
/// docs/bake.md explains targets, units and conventions. Results do not depend on the number of threads. Apache-2.0.
#ifndef TYNDALL_BAKE_H
#define TYNDALL_BAKE_H

#include <tyndall/base.h>
#include <tyndall/image.h>
#include <tyndall/impulse.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The treatment of media.
typedef enum ty_bake_method {
    TY_BAKE_CACHE = 0,       ///< Paths between surfaces; media scatter light that was gathered in cells before.
    TY_BAKE_IMPULSE = 1,     ///< Paths between surfaces; media scatter light by impulse responses.
    TY_BAKE_ATTENUATION = 2, ///< Media attenuate light, and scatter none.
    TY_BAKE_SURFACES = 3,    ///< The scene without media.
    TY_BAKE_PATH = 4         ///< Paths through media, too: the reference.
} ty_bake_method;

/// The composition of impulse responses at a receiver.
typedef enum ty_bake_composition {
    TY_BAKE_COLLISIONS = 0, ///< Responses at the receiver, corrected at collisions on its rays: shadows in media, edges
                            ///< of media and phase functions count there.
    TY_BAKE_PUBLISHED = 1   ///< Responses at the receiver to all emitters that it sees, as in the paper (Sec. 5).
} ty_bake_composition;

/// The history of light before it arrives. The layers add up to all light.
typedef enum ty_bake_layer {
    TY_BAKE_DIRECT = 0,   ///< Light straight from a light, with the extinction of media.
    TY_BAKE_INDIRECT = 1, ///< Light that only surfaces reflected.
    TY_BAKE_SINGLE = 2,   ///< Light that a medium scattered once, and that nothing else scattered or reflected.
    TY_BAKE_MULTIPLE = 3, ///< All other light.
    TY_BAKE_LAYERS = 4    ///< Number of layers.
} ty_bake_layer;

/// Number of real spherical harmonics of a probe: bands 0..4.
enum { TY_BAKE_SH_TERMS = 25 };

/// A point that gathers light. A normal of (0, 0, 0) makes it a probe, which gathers light from all directions.
typedef struct ty_bake_receiver {
    float position[3]; ///< m; on the surface.
    float normal[3];   ///< Unit normal on the lit side.
    float face[3];     ///< Unit normal of the flat face on that side. Light from behind the face does not count.
    float margin;      ///< Distance along `face` at which rays start, m.
} ty_bake_receiver;

/// The light at a receiver on a surface, per layer.
typedef struct ty_bake_light {
    float irradiance[TY_BAKE_LAYERS][3];           ///< Irradiance E, [layer][channel], W m^-2.
    float vector_irradiance[TY_BAKE_LAYERS][3][3]; ///< Integral over the lit side of radiance times the unit vector to
                                                   ///< its origin (wi), [layer][channel][axis], W m^-2.
    float fluence[3];  ///< Integral of radiance over the lit side, all layers, W m^-2; 0: not measured.
    float variance[3]; ///< Variance of the irradiance of all layers together.
    int32_t samples;   ///< Number of gathered paths; 0: none yet.
    float blocked; ///< Fraction of first rays that hit the back of a surface that is not double-sided; near 1 inside
                   ///< of walls.
} ty_bake_light;

/// The light at a probe, per layer: radiance as coefficients of real spherical harmonics in the direction to the
/// light's origin (wi), without the Condon-Shortley phase, in the order l (l + 1) + m.
typedef struct ty_bake_probe {
    float sh[TY_BAKE_LAYERS][3][TY_BAKE_SH_TERMS]; ///< [layer][channel][term], W m^-2 sr^-1.
    float variance[3];                             ///< Variance of the first term of all layers together.
    int32_t samples;                               ///< Number of gathered paths; 0: none yet.
    float blocked; ///< Fraction of rays that hit the back of a surface; near 1 inside of
                   ///< walls.
} ty_bake_probe;

/// The light that arrives in the cells of a lattice over a scene's media: the mean over each cell, with its mean
/// direction, for all light and for light straight from lights. It does not refer to the scene, which may be destroyed
/// before it, but is of use for that scene alone.
typedef struct ty_bake_cache ty_bake_cache;

/// The options of baking. Create it with ty_default_bake_def().
typedef struct ty_bake_def {
    uint32_t cookie;       ///< Set by ty_default_bake_def() and checked.
    uint32_t bytes;        ///< Set by ty_default_bake_def() to the size of the structure, and checked.
    ty_bake_method method; ///< Default TY_BAKE_CACHE.
    int32_t spp;           ///< Largest number of paths per receiver, 1..2^20; default 64.
    double error;          ///< Bound of the standard error, at which a receiver stops, relative to its irradiance or
                           ///< to the mean irradiance if that is larger, > 0; 0 (default): no bound.
    int32_t bounces;       ///< Largest number of reflections, and with TY_BAKE_PATH of scatterings, too; 0 (default):
                           ///< Russian roulette alone ends paths.
    int32_t scatterings;   ///< Largest number of scatterings between two surfaces, or a light and a surface, 1..the
                           ///< bounces of the tables; default 10. TY_BAKE_PATH keeps to it, too.
    bool back_scattering;  ///< True: light counts that surfaces behind a receiver send into the medium (Sec. 5.2);
                           ///< default true.
    const ty_impulse* tables;   ///< TY_BAKE_IMPULSE: the tables; NULL (default): created for the call.
    const ty_bake_cache* cache; ///< TY_BAKE_CACHE: the cache of the same scene; NULL (default): created for the call.
    int32_t cells;              ///< Cells of a cache along the longest side of its box, 1..512; default 32.
    int32_t cell_paths;         ///< Paths per cell of a cache, 1..2^20; default 64.
    uint64_t seed;              ///< Any number; default 0.
    ty_progress_fn progress;    ///< Default NULL.
    void* progress_user;        ///< Passed on to `progress`; default NULL.
    ty_bake_composition composition; ///< TY_BAKE_IMPULSE: default TY_BAKE_COLLISIONS.
    int64_t first; ///< Place of the call's first receiver among all of a bake in parts, 0..2^62; default 0. But for
                   ///< TY_BAKE_IMPULSE and an error bound, which look at all receivers, the light is then that of a
                   ///< bake of all.
} ty_bake_def;

/// Sets the `bytes` bytes of a ty_bake_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_bake_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_bake_def ty_default_bake_def(void) {
    ty_bake_def def;
    ty_init_bake_def(&def, sizeof def);
    return def;
}

/// Statistics of a bake. Create them with ty_default_bake_stats().
typedef struct ty_bake_stats {
    uint32_t cookie;      ///< Set by ty_default_bake_stats() and checked.
    uint32_t bytes;       ///< Set by ty_default_bake_stats() to the size of the structure.
    double seconds;       ///< Wall clock time of the whole, s.
    double table_seconds; ///< Time to compute or read the tables of impulse responses, s.
    double cache_seconds; ///< Time to fill the cache, if the call created it, s.
    int64_t paths;        ///< Number of paths.
    int64_t rays;         ///< Number of path segments and shadow rays.
    double ray_seconds;   ///< Estimated time to trace these rays alone, s; 0: not measured.
    double mean_samples;  ///< Mean number of paths per receiver.
} ty_bake_stats;

/// Statistics with all fields 0.
static inline ty_bake_stats ty_default_bake_stats(void) {
    ty_bake_stats stats;
    ty_init_stats(&stats, sizeof stats);
    return stats;
}

/// The properties of a cache.
typedef struct ty_bake_cache_info {
    int32_t size[3]; ///< Cells along x, y, z.
    double cell;     ///< Side of a cell, m.
    int64_t filled;  ///< Number of cells with known light: those where media scatter, and their neighbours.
    int64_t paths;   ///< Number of paths that filled it.
    int64_t rays;    ///< Number of path segments and shadow rays that filled it.
    double bytes;    ///< Memory.
    double seconds;  ///< Time to fill it, s.
} ty_bake_cache_info;

/// Stores the size, the side of cells and the memory that a cache will have. Errors: TY_ERROR_ARGUMENT.
TY_API ty_result ty_bake_cache_estimate(const ty_scene* scene, const ty_bake_def* def, ty_bake_cache_info* out);
/// Gathers the light in the media of a committed scene, for any number of bakes of that scene with the same bounces and
/// scatterings. Of def, cells, cell_paths, bounces, scatterings, seed and progress count. A scene without media that
/// scatter gives a cache without cells. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED.
TY_API ty_result ty_bake_cache_create(const ty_scene* scene, const ty_bake_def* def, ty_bake_cache** out);
/// Destroys a cache; NULL is allowed.
TY_API void ty_bake_cache_destroy(ty_bake_cache* cache);
/// Size, cells and cost of a cache.
TY_API ty_bake_cache_info ty_bake_cache_get_info(const ty_bake_cache* cache);

/// Gathers light at `count` receivers of a committed scene. After TY_CANCELLED the light is valid, with fewer samples
/// or none. stats may be NULL. Nothing is kept after the call. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_bake_surfaces(const ty_scene* scene, const ty_bake_def* def, const ty_bake_receiver* receivers,
                                  int64_t count, ty_bake_light* light, ty_bake_stats* stats);
/// Gathers light from all directions at `count` points. positions: count x 3, m. Otherwise as ty_bake_surfaces().
TY_API ty_result ty_bake_probes(const ty_scene* scene, const ty_bake_def* def, const float* positions, int64_t count,
                                ty_bake_probe* probes, ty_bake_stats* stats);

/// Stores one receiver per vertex of a mesh, on the front of its triangles. A vertex gathers light in its largest
/// triangle, moved by a hundredth towards the triangle's centre, so that adjacent walls do not hide all light. Its
/// normal is that of the mesh, or the area-weighted mean of its triangles' normals. A vertex without triangles faces
/// up. receivers: as many as the mesh has vertices. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_bake_vertices(const ty_scene* scene, int32_t mesh, ty_bake_receiver* receivers);

/// Creates an image of one pixel per receiver, row by row, `width` (1..65536) of them in a row; pixels past the last
/// are 0. It has the channels of ty_atlas_create_image() but for coverage. Values that are not finite count as 0.
/// Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_bake_create_light_image(ty_context* context, const ty_bake_light* light, int64_t count,
                                            int32_t width, ty_image** out);
/// Creates an image of probes on a grid of size[0] x size[1] x size[2], x fastest: slices of equal z, one below the
/// other, each of size[1] rows of size[0] pixels. terms: number of spherical harmonics to keep, 9 or 25. Channels: R,
/// G, B: mean radiance over all directions. shT.R, .G, .B for T = 0..terms - 1: radiance. LAYER.shT.R and so on: the
/// same for direct, indirect, single and multiple, of which shT is the sum. blocked.Z, samples.N, variance.R, .G, .B.
/// Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_bake_create_probe_image(ty_context* context, const ty_bake_probe* probes, const int32_t size[3],
                                            int32_t terms, ty_image** out);
/// Stores the sum of the layers of a probe: sh[channel][term].
TY_API void ty_bake_probe_sum(const ty_bake_probe* probe, float sh[3][TY_BAKE_SH_TERMS]);

/// The resolution of a lightmap. Create it with ty_default_atlas_def().
typedef struct ty_atlas_def {
    uint32_t cookie;  ///< Set by ty_default_atlas_def() and checked.
    uint32_t bytes;   ///< Set by ty_default_atlas_def() to the size of the structure, and checked.
    int32_t width;    ///< Texels along u, 4..16384; 0 (default): by `density`.
    int32_t height;   ///< Texels along v, 4..16384; 0 (default): by `density`.
    double density;   ///< Texels per metre, > 0; default 8. It gives at most 4096 texels a side.
    int32_t padding;  ///< Texels around charts that are filled, 0..64; default 4.
    bool close_seams; ///< True: both sides of an edge that charts share on the surface, but not in the map, are made
                      ///< alike; default true.
} ty_atlas_def;

/// Sets the `bytes` bytes of a ty_atlas_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_atlas_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_atlas_def ty_default_atlas_def(void) {
    ty_atlas_def def;
    ty_init_atlas_def(&def, sizeof def);
    return def;
}

/// The texels of a mesh's second texture coordinates and their positions on the mesh. It does not refer to the scene,
/// which may be destroyed before it.
typedef struct ty_atlas ty_atlas;

/// The estimated size of an atlas.
typedef struct ty_atlas_size {
    int32_t width;  ///< Texels along u.
    int32_t height; ///< Texels along v.
    double texels;  ///< Estimated number of texels that count.
    double
        bytes; ///< Bound of the memory of the atlas, of light at its receivers, and of an image of it, without seams.
} ty_atlas_size;

/// Estimates the size of an atlas, without allocating it. Errors: as ty_atlas_create(), but overlapping charts are not
/// noticed.
TY_API ty_result ty_atlas_estimate(const ty_scene* scene, int32_t mesh, const char* name, const ty_atlas_def* def,
                                   ty_atlas_size* out);
/// Creates the atlas of one mesh, an index as in ty_scene_get_mesh(). A texel counts if a triangle covers its centre,
/// or touches it; it then takes the nearest point of the triangle. name: name of the mesh for messages. Errors:
/// TY_ERROR_ARGUMENT, TY_ERROR_MEMORY, and TY_ERROR_INPUT when the mesh has no second texture coordinates, when they
/// leave 0..1, or when charts overlap; the message tells which, by how much, and a remedy.
TY_API ty_result ty_atlas_create(const ty_scene* scene, int32_t mesh, const char* name, const ty_atlas_def* def,
                                 ty_atlas** out);
/// Destroys an atlas with its receivers; NULL is allowed.
TY_API void ty_atlas_destroy(ty_atlas* atlas);
/// Texels along u.
TY_API int32_t ty_atlas_width(const ty_atlas* atlas);
/// Texels along v.
TY_API int32_t ty_atlas_height(const ty_atlas* atlas);
/// The receivers of an atlas, one per texel that counts, and their number in `*count`; valid as long as the atlas.
TY_API const ty_bake_receiver* ty_atlas_receivers(const ty_atlas* atlas, int64_t* count);
/// Creates an image of the light at the receivers of an atlas, row 0 at v = 0. light[i] belongs to the i-th receiver.
///
/// - R, G, B: irradiance, the sum of its layers direct.R .. multiple.B, W m^-2.
/// - L1.RX .. L1.BZ: vector irradiance over the integral of radiance, of length at most 1: the mean direction to the
///   light's origin (wi), and the degree to which light comes from there alone. For another unit normal m than the
///   surface's n, irradiance is about R max(0, 1 + 2 L1 . m) / (1 + 2 L1 . n). A unit vector where fluence was not
///   measured.
/// - coverage.A: 1 where a triangle covers the centre of the texel, else the covered fraction of the texel; 0 around
///   charts.
/// - samples.N: number of paths; 0 where the light is not the texel's own.
/// - variance.R, .G, .B: variance of R, G, B as sampled; 0 where samples.N is 0.
///
/// A texel inside of a wall (blocked > 1/2), without samples or with a value that is not finite takes the light of its
/// nearest neighbours on the chart; a chart of such texels alone stays as it is. Then bilinear lookups along both sides
/// of a seam on a smooth surface are made equal by the least change of texels. Then texels around charts take the light
/// of the nearest one that counts, `padding` rows and columns far: bilinear lookups need 1, those in mip level m 2^m.
/// Errors: TY_ERROR_MEMORY.
TY_API ty_result ty_atlas_create_image(const ty_atlas* atlas, const ty_bake_light* light, ty_image** out);
/// Removes noise from the light at the receivers of an atlas, for ty_atlas_create_image(), by regression on the texels'
/// positions and normals within their chart (ty_denoise_image()). even and odd: two bakes of the receivers with
/// different seeds and as many paths each; out: as many, and none of both. Irradiance is denoised layer by layer; its
/// variance becomes the estimated square error, bias included. Vector irradiance and fluence are means of both bakes.
/// Texels inside of walls, and those without samples, stay as they are. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_atlas_denoise(const ty_atlas* atlas, const ty_bake_light* even, const ty_bake_light* odd,
                                  ty_bake_light* out);

#ifdef __cplusplus
}
#endif
#endif
