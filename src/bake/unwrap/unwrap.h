/* Texture coordinates for lightmaps: charts of triangles, projected onto planes or mapped conformally, packed into one
 * map. */
#ifndef TY_BAKE_UNWRAP_UNWRAP_H
#define TY_BAKE_UNWRAP_UNWRAP_H

#include <tyndall/base.h>

/* Triangles that share a map. */
typedef struct ty_unwrap_mesh {
    const float* positions;  /* 3 per vertex, m */
    const uint32_t* indices; /* 3 per triangle */
    int64_t vertex_count, triangle_count;
} ty_unwrap_mesh;

typedef struct ty_unwrap_def {
    double density;  /* texels per metre */
    double stretch;  /* largest ratio of lengths on the surface and in the map, > 1 */
    int32_t padding; /* texels between charts */
} ty_unwrap_def;

typedef struct ty_unwrap {
    float* uv;      /* 2 per corner of each triangle, 0..1 */
    int32_t* chart; /* per triangle */
    int64_t triangle_count;
    int32_t charts, width, height; /* of the map, texels at the density */
    double density;                /* that of the map: less where it would be larger than TY_UNWRAP_SIDE_MAX */
    double fill;                   /* fraction of the map that triangles cover */
    double stretch, mean_stretch;  /* L-infinity and L2 (Sander et al. 2001): of lengths on the surface over those in
                                      the map, the largest and the root of the mean square */
} ty_unwrap;

enum { TY_UNWRAP_SIDE_MAX = 4096 };

/* Errors: TY_ERROR_MEMORY. *out is to be freed after an error, too. */
ty_result ty_unwrap_mesh_create(ty_context* context, const ty_unwrap_mesh* mesh, const ty_unwrap_def* def,
                                ty_unwrap* out);
void ty_unwrap_free(ty_context* context, ty_unwrap* unwrap);

/* ---- charts.c ---- */

typedef struct ty_unwrap_face {
    float normal[3];      /* unit; 0 for triangles without area */
    float area;           /* m^2 */
    int32_t neighbour[3]; /* triangle across each edge; -1: none, or several */
    int32_t chart;
} ty_unwrap_face;

/* Neighbours of a chart, at most so many, and the number of edges to each. */
enum { TY_UNWRAP_NEIGHBOURS_MAX = 32 };
typedef struct ty_unwrap_borders {
    int count;
    int32_t chart[TY_UNWRAP_NEIGHBOURS_MAX], edges[TY_UNWRAP_NEIGHBOURS_MAX];
} ty_unwrap_borders;

/* Counts an edge to a chart. */
static inline void ty_unwrap_count_edge(ty_unwrap_borders* borders, int32_t chart) {
    int k = 0;
    while (k < borders->count && borders->chart[k] != chart) ++k;
    if (k == TY_UNWRAP_NEIGHBOURS_MAX) return;
    if (k == borders->count) {
        borders->chart[k] = chart;
        borders->edges[k] = 0;
        ++borders->count;
    }
    ++borders->edges[k];
}

/* Normals, areas and neighbours: triangles are neighbours where two alone share an edge between equal positions.
 * welded: for each vertex the first one at its position. Errors: TY_ERROR_MEMORY. */
ty_result ty_unwrap_find_faces(ty_context* context, const ty_unwrap_mesh* mesh, ty_unwrap_face* faces,
                               uint32_t* welded);
/* Grows charts of faces whose chart is -1: from the largest, over neighbours of normals within the stretch. Numbers
 * them from *charts on. order: all faces by falling area; queue: room for one per face. */
void ty_unwrap_grow(ty_unwrap_face* faces, int64_t count, const int32_t* order, double stretch, int32_t* queue,
                    int32_t* charts);

/* ---- merge.c ---- */

/* Joins charts to neighbours where the stretch allows it, from the smallest on, and numbers them anew. by_chart: all
 * faces, chart by chart. Errors: TY_ERROR_MEMORY. */
ty_result ty_unwrap_merge(ty_context* context, ty_unwrap_face* faces, int64_t count, const int32_t* by_chart,
                          double stretch, int32_t* charts);

/* ---- overlaps.c ---- */

/* Marks the points of a raster that are within a triangle, unless another triangle was there: then true. */
bool ty_unwrap_cover(float p[3][2], int32_t width, int32_t height, uint8_t* owned);

/* ---- pack.c ---- */

typedef struct ty_unwrap_chart {
    const int32_t* triangles;
    int64_t count;
    float low[2], high[2]; /* box of its map, m */
    int32_t turns, x, y;   /* quarter turns, counterclockwise, and the texel where it begins with its margin */
} ty_unwrap_chart;

/* Places charts into a map that is nearly square. flat: 6 numbers a triangle, m. The texels within half a texel of the
 * triangles of two charts are at least `padding` texels apart. Errors: TY_ERROR_MEMORY. */
ty_result ty_unwrap_pack(ty_context* context, const float* flat, ty_unwrap_chart* charts, int32_t count, double density,
                         int32_t padding, int32_t* width, int32_t* height);
/* A point of a chart's map in its box after some quarter turns, texels. */
void ty_unwrap_turn(const ty_unwrap_chart* chart, int32_t turns, double density, const float at[2], double out[2]);

#endif
