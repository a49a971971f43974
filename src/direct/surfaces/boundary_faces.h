/* Surfaces as closed faces between the cells of a box. A face is closed where a surface crosses the line between the
 * centers of its two cells, so that no chain of open faces leads through a surface without holes, however thin it is.
 * Faces of the box itself are closed by surfaces within half a cell behind them. */
#ifndef TY_DIRECT_SURFACES_BOUNDARY_FACES_H
#define TY_DIRECT_SURFACES_BOUNDARY_FACES_H

#include "base/vector.k.h"
#include "direct/media/grid_medium.h"
#include "direct/lights/discrete_light.h"

/* One cell's side of a closed face, with its surface. */
typedef struct ty_boundary_side {
    ty_vec position; /* m, off the surface by the rounding error */
    ty_vec normal;   /* unit, towards the cell */
    float albedo[3];
    float emission[3];      /* radiance of surfaces that are no lights of the scene */
    float depth;            /* distance from the cell's center to the surface, in cells, 0..1 */
    float staircase_factor; /* total area of the faces over that of the slanted surface */
} ty_boundary_side;

typedef struct ty_boundary_faces {
    ty_context* context;
    int32_t size[3]; /* cells */
    int32_t count;   /* number of sides, sorted by row along x and by cell */
    int32_t* first;  /* first side of each row y + size[1] * z, then count */
    int32_t* x;      /* x of the side's cell */
    uint8_t* face;   /* face of the cell: 2 * axis, + 1 for the upper one */
    ty_boundary_side* sides;
    uint8_t* closed; /* per cell, bit `face` of its closed faces */
} ty_boundary_faces;

/* *out is NULL where no face is closed; freed with ty_boundary_faces_destroy. Errors: TY_ERROR_MEMORY. */
ty_result ty_boundary_faces_find(const ty_scene* scene, const ty_grid_medium* medium, ty_boundary_faces** out);
void ty_boundary_faces_destroy(ty_boundary_faces* faces);

/* True for points within half a cell of a medium's box, whose surfaces are closed faces. */
bool ty_boundary_contains(const ty_grid_medium* medium, ty_vec point);

/* Corrects for faces of a staircase that shade each other where the real surface does not: with this albedo, and
 * emission_factor times its emission, a staircase looks from afar as the surface does. */
void ty_staircase_albedo(const ty_boundary_side* side, float albedo, float* effective_albedo, float* emission_factor);

/* Adjusts the flux of a cell at a side, in the terms of a source field (isotropic, x, y, z), so that they give the
 * irradiance on it, W m^-2. */
void ty_side_match_irradiance(const ty_boundary_side* side, float irradiance, size_t cell, float* const terms[4]);

/* Adds the shadowed irradiance of uncollided light to irradiance[c], W m^-2, one number per side. extinction: scaled,
 * as many planes as the medium has. forward (NULL: not computed): the part that the medium's own extinction would
 * remove. */
void ty_boundary_irradiance_add(const ty_scene* scene, const ty_boundary_faces* faces, const ty_grid_medium* medium,
                                float* const extinction[3], const ty_discrete_light* sources, int32_t count,
                                float* const irradiance[3], float* const forward[3]);

/* Marks cells that no light reaches: connected regions of open faces without an open face of the box, without a point
 * light (VPLs aside) and without emission. unlit: one flag per cell. Errors: TY_ERROR_MEMORY. */
ty_result ty_unlit_cells_find(const ty_scene* scene, const ty_boundary_faces* faces, const ty_grid_medium* medium,
                              const ty_discrete_light* sources, int32_t count, uint8_t* unlit);

#endif
