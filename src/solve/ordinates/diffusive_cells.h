/* Cells of discrete ordinates so thick that diffusion is their light: which they are, and what flows out of their
 * faces.
 *
 * Along a face's axis a cell's fluence phi and what flows out of the face, J, are those of P1,
 *
 *     J = c (phi - phi_f) + k,   c = 2 D' / h,   phi_f / 4 - J / 2 = J_in (Marshak),
 *
 * with D' = D (1 - (1 - sqrt(3) / 2) sigma_a / sigma_tr) F(u), u = h / 2 over the diffusion length. Between two thick
 * cells F = u coth u; at other faces F = u / (1 - (1 - e^-2u) / 2u), of phi that is a cell's mean and falls towards the
 * face as e^-2ux/h. Both are 1 where the diffusion length is long. A black cell sends what a black body does. k is what
 * of a source that lies nearer to one face than to the other leaves there before it fills the cell. */
#ifndef TY_SOLVE_ORDINATES_DIFFUSIVE_CELLS_H
#define TY_SOLVE_ORDINATES_DIFFUSIVE_CELLS_H

#include "solve/ordinates/ordinates.h"
#include "solve/ordinates/sweep.h"

#include <math.h>

/* What is behind a face of a thick cell: another one; below it, a wall, TY_LINK_BOUNDARY_FACE - its side; else a skin.
 */
enum { TY_LINK_DIFFUSIVE = -1, TY_LINK_BOUNDARY_FACE = -2 };

/* A face between a thick cell and another cell or the box's outside. */
typedef struct ty_interface_face {
    int32_t cell; /* of thick ones */
    int32_t face; /* 2 * axis, and 1 more for the upper one */
    bool outer;   /* whether it is the box's */
} ty_interface_face;

typedef struct ty_diffusive_cell {
    int32_t index;   /* in the box */
    int32_t link[6]; /* of each face */
    float push[6];   /* k, over sqrt(4 pi) */
    float d, edge_d; /* D', between thick cells and at other faces */
    float lean;      /* of P1's part along the normal, how much light that leaves has: 1 - sqrt(sigma_a / sigma_tr) */
} ty_diffusive_cell;

typedef struct ty_diffusive_cells {
    ty_context* context;
    int32_t count; /* of thick cells; 0: nothing else is there */
    ty_diffusive_cell* cells;
    int32_t* slots; /* of each cell of the box, its number among these; -1: it is none */
    int32_t* first; /* of each plane of cells across z, and count */
    int32_t skin_count;
    ty_interface_face* skins;
    /* What sweeps see: sides of walls and of skins' thin cells; those of thick cells are dark. */
    ty_sweep_faces sides;
    int32_t* source; /* of each side, the wall's, or TY_LINK_BOUNDARY_FACE - skin; TY_LINK_DIFFUSIVE: none */
    float *sent, *tilt;
    void *memory, *side_memory;
    size_t bytes, side_bytes;
} ty_diffusive_cells;

/* Finds them. extinction: sigma*; reduced, absorption: sigma* - s_1 and sigma_a, of which the former becomes 1 / (3 D')
 * in thick cells. Errors: TY_ERROR_MEMORY. */
ty_result ty_diffusive_cells_find(ty_context* context, const ty_ordinates_def* def, const float* extinction,
                                  float* reduced, const float* absorption, ty_diffusive_cells* out);
void ty_diffusive_cells_free(ty_diffusive_cells* thick);

/* c of a cell at a face. edges: of cells, m. */
static inline float ty_diffusive_conductance(const ty_diffusive_cell* cell, const double edges[3], int face) {
    return 2 * (cell->link[face] == TY_LINK_DIFFUSIVE ? cell->d : cell->edge_d) / (float)edges[face / 2];
}

/* What leaves through a face that is `in` W m^-2 bright from outside: J_out of the above, at least 0 of what comes in.
 */
static inline float ty_outgoing_partial_current(float c, float phi, float push, float in) {
    return (c * phi + push + fmaxf(1 - 2 * c, 0) * in) / (1 + 2 * c);
}

#endif
