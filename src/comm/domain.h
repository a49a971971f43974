/* A grid of cells cut into boxes, one a rank, and the exchange of the cells beside the cuts. */
#ifndef TY_COMM_DOMAIN_H
#define TY_COMM_DOMAIN_H

#include "comm/comm.h"

/* Axes that may be cut, as a mask. */
enum { TY_CUT_X = 1, TY_CUT_Y = 2, TY_CUT_Z = 4 };

typedef struct ty_domain {
    ty_comm* comm;            /* NULL: one rank */
    int32_t cells[3];         /* of the whole grid */
    int32_t unit[3];          /* boxes begin at multiples of it */
    int32_t ranks[3];         /* along each axis; a rank's number is that of its place, x fastest */
    int32_t at[3];            /* this rank's place */
    int32_t first[3], end[3]; /* this rank's cells */
    char* buffer;             /* of faces on their way */
    size_t capacity;
    ty_comm_traffic halos; /* messages sent and received for faces, and their bytes */
} ty_domain;

/* Cuts a grid among all ranks: of all ways to share the ranks among the axes of `cuts` (TY_CUT_*) the one whose largest
 * box is smallest, its cells beyond the cuts included; of equal ones that with more cuts along z, then y. Boxes begin
 * at multiples of `unit` cells, and have at least `min_cells` along an axis that is cut. False: there is no such way.
 */
bool ty_domain_create(ty_comm* comm, const int32_t cells[3], unsigned cuts, const int32_t unit[3], int32_t min_cells,
                      ty_domain* out);
void ty_domain_destroy(ty_domain* domain);

/* First cell of the boxes at place p along an axis, 0..ranks; at p = ranks the number of cells. */
int32_t ty_domain_first(const ty_domain* domain, int axis, int32_t p);
/* Place of a rank, and the rank at a place. */
void ty_domain_place(const ty_domain* domain, int32_t rank, int32_t at[3]);
int32_t ty_domain_rank(const ty_domain* domain, const int32_t at[3]);
/* The rank beyond a side of this rank's box (0: lower x, 1: upper x, 2: lower y, ...); -1: the end of the grid. */
int32_t ty_domain_neighbour(const ty_domain* domain, int side);
/* True if the grid is cut along an axis. */
bool ty_domain_is_cut(const ty_domain* domain, int axis);

/* Items around the cells of a rank's box, or of a coarser one of the same place. */
typedef struct ty_halo {
    void* origin;        /* cell (0, 0, 0) of the box; there is a layer of items around it where it is cut */
    size_t item;         /* bytes: 4 or 8 */
    ptrdiff_t stride[3]; /* in items */
} ty_halo;

/* Fills the layer beyond each cut by the neighbours' cells, one message a neighbour for all halos. size: the box's
 * cells. Axes follow one another, x first, each with the layers of those before, so that edges and corners arrive too.
 * False: a rank does not answer. */
bool ty_domain_exchange(ty_domain* domain, const int32_t size[3], const ty_halo* halos, int32_t count);

#endif
