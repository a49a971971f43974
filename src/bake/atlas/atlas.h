/* Lightmaps: the layout of texels on a mesh, and the steps from light at texels to an image.
 *
 *   raster    the triangle of each texel, and overlaps between charts
 *   charts    triangles that are also adjacent in the map, and edges that are adjacent only on the surface
 *   inpaint   texels inside walls take the light of their neighbours
 *   padding   the nearest valid texel for each texel around a chart
 *   seams     lookups along an edge shared by two charts are made equal
 */
#ifndef TY_BAKE_ATLAS_ATLAS_H
#define TY_BAKE_ATLAS_ATLAS_H

#include <tyndall/bake.h>

/* One surface edge at its two positions in the map, both written from the same end. */
typedef struct ty_seam {
    float from[2][2], to[2][2]; /* [side][x, y], texels */
    int32_t chart[2];
} ty_seam;

struct ty_atlas {
    ty_context* context;
    int32_t width, height, padding;
    int64_t count;     /* of valid texels */
    int32_t* texels;   /* per receiver: index of its texel, row by row */
    int32_t* charts;   /* per receiver */
    float* coverage;   /* per receiver: 1 where a triangle covers the texel center, else the covered fraction */
    int32_t* receiver; /* per texel; -1: invalid */
    ty_bake_receiver* receivers;
    size_t seam_count, seam_capacity;
    ty_seam* seams;
};

static inline size_t ty_atlas_texels(const ty_atlas* atlas) {
    return (size_t)atlas->width * (size_t)atlas->height;
}

/* False for texels without samples or inside of walls, of whose rays more than half hit back faces. */
static inline bool ty_atlas_is_lit(const ty_bake_light* light) {
    return light->samples > 0 && light->blocked <= 0.5f;
}

/* ---- raster ---- */

/* The triangle that owns a texel. */
typedef struct ty_texel {
    int32_t triangle; /* -1: none */
    float rank;       /* covered fraction of the texel; plus 1 if the center is covered, plus 2 if by a margin */
} ty_texel;

typedef struct ty_raster {
    int64_t centers;  /* texels whose center is covered by a margin */
    int64_t overlaps; /* of these, texels covered by triangles from different parts of the surface */
} ty_raster;

/* Corners of a triangle in the map, texels; false: its area is zero in the map or on the surface. */
bool ty_atlas_triangle(const ty_mesh_def* mesh, size_t triangle, int32_t width, int32_t height, double corners[3][2]);
/* texels: width * height of them. Among triangles of equal rank the first owns the texel. */
ty_result ty_atlas_rasterise(ty_context* context, const ty_mesh_def* mesh, int32_t width, int32_t height,
                             ty_texel* texels, ty_raster* out);
/* Barycentric coordinates of a texel's sample point: the texel center, or the point of the triangle nearest to it,
 * moved slightly off the edges, since another surface may begin there. */
void ty_atlas_texel_point(const double corners[3][2], const double center[2], double* b1, double* b2);

/* ---- charts ---- */

/* charts: per triangle, the index of one triangle of its chart. Edges closer than a hundredth of a texel count as one.
 * The caller frees *seams, capacity elements. */
ty_result ty_atlas_find_charts(ty_context* context, const ty_mesh_def* mesh, int32_t width, int32_t height,
                               int32_t* charts, ty_seam** seams, size_t* seam_count, size_t* capacity);

/* ---- images ---- */

enum { TY_ATLAS_CHANNELS = 29 };

/* Planes of the image in progress: light by layer, then the vector irradiance and the fluence of all layers. */
enum {
    TY_ATLAS_LAYERS = 0,
    TY_ATLAS_VECTOR_IRRADIANCE = 3 * TY_BAKE_LAYERS,
    TY_ATLAS_FLUENCE = TY_ATLAS_VECTOR_IRRADIANCE + 9,
    TY_ATLAS_PLANES = TY_ATLAS_FLUENCE + 3
};

/* valid: per receiver, true if its light is usable; an invalid receiver takes the mean of its valid neighbours on the
 * same chart, in waves outward from the valid ones, and becomes valid. */
ty_result ty_atlas_inpaint(const ty_atlas* atlas, bool* valid, float* const planes[TY_ATLAS_PLANES]);
/* source: per texel, its own index if it is valid, else the nearest valid texel within `reach` rows and columns, or -1.
 */
ty_result ty_atlas_pad(const ty_atlas* atlas, int32_t reach, int32_t* source);
/* Makes lookups on both sides of a seam equal in the least-squares sense by small changes of the texels they read.
 * Padding texels with a source take part: they start from the light of that source and are their own source afterwards.
 */
ty_result ty_atlas_close_seams(const ty_atlas* atlas, int32_t* source, float* const planes[TY_ATLAS_PLANES]);

#endif
