/* Least squares conformal maps of charts. */
#ifndef TY_BAKE_UNWRAP_CONFORMAL_H
#define TY_BAKE_UNWRAP_CONFORMAL_H

#include "bake/unwrap/unwrap.h"

/* The surface that charts are parts of. */
typedef struct ty_unwrap_surface {
    const ty_unwrap_mesh* mesh;
    const ty_unwrap_face* faces;
    const uint32_t* welded; /* the first vertex at each vertex's position */
    int32_t* number;        /* one per vertex, all -1 between calls */
    uint8_t* member;        /* one per triangle, all 0 between calls */
} ty_unwrap_surface;

/* A triangle in its plane: corners at (0, 0), (local[0], 0), (local[1], local[2]), m. */
void ty_unwrap_local_triangle(const ty_unwrap_mesh* mesh, int64_t triangle, double local[3]);

/* The largest and the smallest ratio of lengths on the surface and in the map, of one triangle with corners at uv, m:
 * the singular values of the map from the plane to the surface. False: it has no area. */
bool ty_unwrap_stretch_of(const ty_unwrap_mesh* mesh, int64_t triangle, const float uv[6], double stretch[2]);

/* Maps connected triangles onto the plane, conformally and with the area of the surface: uv has 6 numbers for each in
 * order, m. *made: false where they are no disc, or some are turned over or have lengths outside of 1 / stretch ..
 * stretch. Overlaps are not looked for. Errors: TY_ERROR_MEMORY. */
ty_result ty_unwrap_conformal(ty_context* context, const ty_unwrap_surface* surface, const int32_t* triangles,
                              int64_t count, double stretch, float* uv, bool* made);

/* ---- join.c ---- */

/* Maps curved charts conformally, and joins them to neighbours where the stretch allows it, without overlaps and not
 * across creases. flat: 6 numbers a triangle, the map of its chart, m. Errors: TY_ERROR_MEMORY. */
ty_result ty_unwrap_join(ty_context* context, const ty_unwrap_surface* surface, const ty_unwrap_def* def,
                         ty_unwrap_face* faces, float* flat, int32_t* charts);

#endif
