/* Lightmaps: where texels lie on a mesh, and the steps from light at them to an image.
 *
 *   raster    which triangle each texel belongs to, and whether charts overlap
 *   charts    triangles that are neighbours in the map, too, and edges that are neighbours on the surface alone
 *   mend      texels within walls take their neighbours' light
 *   padding   the nearest texel that counts, for those around charts
 *   seams     lookups along edges that charts share on the surface are made alike
 */
#ifndef TY_BAKE_ATLAS_H
#define TY_BAKE_ATLAS_H

#include <tyndall/bake.h>

/* One edge of the surface at two places of the map, both written from the same end. */
typedef struct ty_seam {
    float from[2][2], to[2][2]; /* [side][x, y], texels */
    int32_t chart[2];
} ty_seam;

struct ty_atlas {
    ty_context* context;
    int32_t width, height, padding;
    int64_t count;     /* of texels that count */
    int32_t* texels;   /* per receiver: where it is, row by row */
    int32_t* charts;   /* per receiver */
    float* coverage;   /* per receiver: 1 where a triangle covers the texel's middle, else the fraction it covers */
    int32_t* receiver; /* per texel; -1: does not count */
    ty_bake_receiver* receivers;
    size_t seam_count, seam_capacity;
    ty_seam* seams;
};

static inline size_t ty_atlas_texels(const ty_atlas* atlas) {
    return (size_t)atlas->width * (size_t)atlas->height;
}

/* ---- raster ---- */

/* Whom a texel belongs to. */
typedef struct ty_texel {
    int32_t triangle; /* -1: nobody */
    float claim;      /* what it covers of the texel; 1 more if it covers the middle, 2 more if by a margin */
} ty_texel;

typedef struct ty_raster {
    int64_t middles;  /* texels whose middle triangles cover by a margin */
    int64_t overlaps; /* those for which triangles from different places do */
} ty_raster;

/* A triangle in the map, texels; false: it has no area there or on the surface. */
bool ty_atlas_triangle(const ty_mesh_def* mesh, size_t triangle, int32_t width, int32_t height, double corners[3][2]);
/* texels: width * height of them. Of triangles with equal claims the first has the texel. */
ty_result ty_atlas_rasterise(ty_context* context, const ty_mesh_def* mesh, int32_t width, int32_t height,
                             ty_texel* texels, ty_raster* out);
/* The place on a triangle that stands for a texel: its middle, or the nearest to it, and a little off the triangle's
 * edges, where another surface may begin. */
void ty_atlas_place(const double corners[3][2], const double middle[2], double* b1, double* b2);

/* ---- charts ---- */

/* charts: per triangle, the number of one of its chart's. Edges that differ by less than a hundredth of a texel count
 * as one. *seams is to be freed, capacity elements. */
ty_result ty_atlas_find_charts(ty_context* context, const ty_mesh_def* mesh, int32_t width, int32_t height,
                               int32_t* charts, ty_seam** seams, size_t* seam_count, size_t* capacity);

/* ---- images ---- */

enum { TY_ATLAS_CHANNELS = 29 };

/* Planes of an image in work: light by layers, then the vector irradiance and the integral of radiance of them all. */
enum {
    TY_ATLAS_LAYERS = 0,
    TY_ATLAS_TOWARD = 3 * TY_BAKE_LAYERS,
    TY_ATLAS_FLUENCE = TY_ATLAS_TOWARD + 9,
    TY_ATLAS_PLANES = TY_ATLAS_FLUENCE + 3
};

/* valid: per receiver, whether its light is good; what is not takes the mean of its neighbours on its chart, from those
 * nearest to good texels on, and becomes valid. */
ty_result ty_atlas_mend(const ty_atlas* atlas, bool* valid, float* const planes[TY_ATLAS_PLANES]);
/* source: per texel, itself where it counts, the nearest texel that counts within `reach` rows and columns, or -1. */
ty_result ty_atlas_pad(const ty_atlas* atlas, int32_t reach, int32_t* source);
/* Lookups along seams are made alike, in the sense of least squares, by small changes of the texels that they meet; of
 * texels around charts, those with a source take part: they take its light first, and are their own source then. */
ty_result ty_atlas_close_seams(const ty_atlas* atlas, int32_t* source, float* const planes[TY_ATLAS_PLANES]);

#endif
