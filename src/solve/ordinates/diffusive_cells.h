/* Cells of discrete ordinates so optically thick that the diffusion approximation holds within them: their selection,
 * and the flow through their faces.
 *
 * Along a face's axis a cell's fluence phi and its outflow J through the face follow P1 with the Marshak condition,
 *
 *     J = c (phi - phi_f) + k,   c = 2 D' / h,   phi_f / 4 - J / 2 = J_in (Marshak),
 *
 * with D' = D (1 - (1 - sqrt(3) / 2) sigma_a / sigma_tr) F(u), u = h / 2 over the diffusion length. Between two
 * diffusive cells F = u coth u; at other faces F = u / (1 - (1 - e^-2u) / 2u), for a cell-mean phi that decays towards
 * the face as e^-2ux/h. Both are 1 for a long diffusion length. A black cell emits as a black body. k is the part of a
 * source nearer to one face than to the other that leaves there before it fills the cell. */
#ifndef TY_SOLVE_ORDINATES_DIFFUSIVE_CELLS_H
#define TY_SOLVE_ORDINATES_DIFFUSIVE_CELLS_H

#include "solve/ordinates/ordinates.h"
#include "solve/ordinates/sweep.h"

#include <math.h>

/* Neighbour of a diffusive cell at a face: another diffusive cell; at most TY_LINK_BOUNDARY_FACE: boundary face
 * TY_LINK_BOUNDARY_FACE - link; otherwise the index of an interface. */
enum { TY_LINK_DIFFUSIVE = -1, TY_LINK_BOUNDARY_FACE = -2 };

/* Face between a diffusive cell and a transport cell or the box's outside. */
typedef struct ty_interface_face {
    int32_t cell; /* index among diffusive cells */
    int32_t face; /* 2 * axis + (1 for the upper face) */
    bool outer;   /* on a face of the box */
} ty_interface_face;

typedef struct ty_diffusive_cell {
    int32_t index;             /* in the box */
    int32_t link[6];           /* per face */
    float interface_source[6]; /* k, over sqrt(4 pi) */
    float d, edge_d;           /* D' between diffusive cells, and at other faces */
    float p1_weight;           /* weight of P1's slope in the radiance leaving the cell: 1 - sqrt(sigma_a / sigma_tr) */
} ty_diffusive_cell;

typedef struct ty_diffusive_cells {
    ty_context* context;
    int32_t count; /* number of diffusive cells; 0: all else is unset */
    ty_diffusive_cell* cells;
    int32_t* slots; /* index among diffusive cells for each cell of the box; -1: transport cell */
    int32_t* first; /* first diffusive cell of each plane of cells across z; the last entry is count */
    int32_t interface_count;
    ty_interface_face* interfaces;
    /* Faces for the sweep: sides of boundary faces and of transport cells at interfaces; the sides of diffusive cells
     * emit nothing. */
    ty_sweep_faces sides;
    int32_t* source; /* per side: index of the boundary face, or TY_LINK_BOUNDARY_FACE - interface; TY_LINK_DIFFUSIVE:
                        none */
    float *radiance, *radiance_slope;
    void *memory, *side_memory;
    size_t bytes, side_bytes;
} ty_diffusive_cells;

/* Finds diffusive cells. extinction: sigma*; reduced, absorption: sigma* - s_1 and sigma_a; `reduced` becomes 1 / (3
 * D') in diffusive cells. Errors: TY_ERROR_MEMORY. */
ty_result ty_diffusive_cells_find(ty_context* context, const ty_ordinates_def* def, const float* extinction,
                                  float* reduced, const float* absorption, ty_diffusive_cells* out);
void ty_diffusive_cells_free(ty_diffusive_cells* diffusive);

/* c of a cell at a face. edges: cell edges, m. */
static inline float ty_diffusive_conductance(const ty_diffusive_cell* cell, const double edges[3], int face) {
    return 2 * (cell->link[face] == TY_LINK_DIFFUSIVE ? cell->d : cell->edge_d) / (float)edges[face / 2];
}

/* Partial current J_out through a face with incident partial current `in`, W m^-2; the reflected part is at least 0. */
static inline float ty_outgoing_partial_current(float c, float phi, float interface_source, float in) {
    return (c * phi + interface_source + fmaxf(1 - 2 * c, 0) * in) / (1 + 2 * c);
}

#endif
