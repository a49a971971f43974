/* Surfaces as walls between the cells of a box: a face between two cells is closed where a surface crosses the straight
 * way between their middles, so that no way from cell to cell leads through a surface that has no holes, however thin
 * it is. Faces of the box itself are closed where surfaces are within half a cell behind them. */
#ifndef TY_DIRECT_SURFACES_BOUNDARY_FACES_H
#define TY_DIRECT_SURFACES_BOUNDARY_FACES_H

#include "base/vector.k.h"
#include "direct/media/grid_medium.h"
#include "direct/lights/discrete_light.h"

/* One cell's side of a closed face, and the surface that closes it. */
typedef struct ty_boundary_side {
    ty_vec position; /* m, off the surface by as much as rounding needs */
    ty_vec normal;   /* unit, towards the cell */
    float albedo[3];
    float emission[3];      /* radiance of surfaces that no light of the scene stands for */
    float depth;            /* from the cell's middle to the surface, in cells, 0..1 */
    float staircase_factor; /* area of the faces that a slanted surface makes, to its own */
} ty_boundary_side;

typedef struct ty_boundary_faces {
    ty_context* context;
    int32_t size[3]; /* cells */
    int32_t count;   /* of sides: those of a row along x after one another, by cells */
    int32_t* first;  /* of each row, y + size[1] * z, and count */
    int32_t* x;      /* the cell of the row that a side is of */
    uint8_t* face;   /* of the cell: 2 * axis, and 1 more for the upper one */
    ty_boundary_side* sides;
    uint8_t* closed; /* of each cell, bit `face` of those that are */
} ty_boundary_faces;

/* *out is NULL where there are none; freed with ty_boundary_faces_destroy. Errors: TY_ERROR_MEMORY. */
ty_result ty_boundary_faces_find(const ty_scene* scene, const ty_grid_medium* medium, ty_boundary_faces** out);
void ty_boundary_faces_destroy(ty_boundary_faces* walls);

/* Stairs shade each other where the surface that they stand for does not. With this albedo, and `share` of what the
 * surface sends by itself, they look from afar as it does. */
void ty_staircase_albedo(const ty_boundary_side* wall, float albedo, float* effective_albedo, float* emission_factor);

/* Adds to irradiance[c], W m^-2, one number a side, what sources bring to walls, with shadows; extinction: less than
 * the medium's own, as many planes as it has. forward (NULL: not asked for): the part of it that the medium's own would
 * not leave. */
void ty_boundary_irradiance_add(const ty_scene* scene, const ty_boundary_faces* walls, const ty_grid_medium* medium,
                                float* const extinction[3], const ty_discrete_light* sources, int32_t count,
                                float* const irradiance[3], float* const forward[3]);

/* Marks cells that no light can get to: of those that open faces join, all where none has a face in the box's own that
 * is open, a lamp (of the scene, not a stand-in) beside it, or emission. dark: one a cell. Errors: TY_ERROR_MEMORY. */
ty_result ty_unlit_cells_find(const ty_scene* scene, const ty_boundary_faces* walls, const ty_grid_medium* medium,
                              const ty_discrete_light* sources, int32_t count, uint8_t* unlit);

#endif
