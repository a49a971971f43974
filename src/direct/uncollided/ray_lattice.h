/* The lattice of rays of one length of one of a lamp's six pyramids, about a cell apart at its far end. It keeps the
 * mean extinction from where each ray enters the box: unlike the optical depth it is even between rays, however they
 * enter.
 */
#ifndef TY_DIRECT_UNCOLLIDED_RAY_LATTICE_H
#define TY_DIRECT_UNCOLLIDED_RAY_LATTICE_H

#include "direct/uncollided/kernel.h"
#include "direct/uncollided/near_cells.h"

/* p and q are tangents along the axes u and v. */
typedef struct ty_ray_lattice {
    const ty_point_light_job* job;
    int32_t axis[3];        /* u, v, w */
    bool backwards;         /* along w */
    int32_t slabs, begin;   /* of the length; the first, counted along w */
    double near, far;       /* m along w from the lamp */
    double low[2], step[2]; /* of p and q */
    int32_t count[2];
    double entry;   /* m along w: where the box begins */
    float* mean[3]; /* extinction up to the near side of each slab, and the far side of the last: (slabs + 1) x count */
    float* hit;     /* per ray: how far along w a surface is, m; NULL: there are none */
} ty_ray_lattice;

/* Places the next length from slab `begin` on; distances double within it. False: the pyramid has nothing of the box
 * there, but for l->slabs slabs to leave out. */
bool ty_ray_lattice_place(ty_ray_lattice* l, int32_t begin);
/* Takes memory and follows the rays; before: the length nearer to the lamp, whose slabs are 0 if there is none.
 * Whatever becomes of it, ty_ray_lattice_end may follow. Errors: TY_ERROR_MEMORY. */
ty_result ty_ray_lattice_trace(ty_ray_lattice* l, const ty_ray_lattice* before);
void ty_ray_lattice_end(ty_ray_lattice* l);

/* Floats of scratch that a worker needs for any row of rays of this lamp. */
size_t ty_ray_lattice_scratch(const ty_point_light_job* lamp);
/* Rays of one slab and row, and of a whole slab. */
size_t ty_ray_lattice_rays(const ty_ray_lattice* l);
/* The near side of a slab, m along w from the lamp. */
double ty_ray_lattice_plane(const ty_ray_lattice* l, int32_t slab);
/* The cell along w that a slab is. */
int32_t ty_ray_lattice_cell(const ty_ray_lattice* l, int32_t slab);
/* Where a tangent is along u (0) or v (1): between ray *i and the next, at the returned share of the next. */
float ty_ray_lattice_locate(const ty_ray_lattice* l, int32_t along, double tangent, int32_t* i);

#endif
