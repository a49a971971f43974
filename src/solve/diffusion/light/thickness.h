/* Largest extinction of cells of diffusion. */
#ifndef TY_SOLVE_DIFFUSION_LIGHT_THICKNESS_H
#define TY_SOLVE_DIFFUSION_LIGHT_THICKNESS_H

#include "direct/media/grid_medium.h"
#include "solve/diffusion/light/diffuse_surfaces.h"

#include <math.h>

/* Maximum thickness of a cell, transport mean free paths. Light entering a very thick cell scatters near its surface
 * and mostly leaves again, but in the discrete equations its source is at the cell's center and accumulates: the
 * fluence would grow with thickness, without bound. The light a thick medium reflects depends on its albedo only, so
 * thicker cells are scaled down to these values. Their fluence is then that of a surface; the (small) transmission of a
 * medium of such cells is overestimated. The effect is strongest at the faces of the box; inside, vacuum beside a thick
 * cell takes up the light. */
#define TY_MAX_THICKNESS_INSIDE 2.5
#define TY_MAX_THICKNESS_AT_FACES 1.5

typedef struct ty_max_extinction {
    const ty_grid_box* box;
    const ty_diffuse_surfaces* surfaces; /* NULL: none */
    float inside, at_faces;              /* 1/m */
} ty_max_extinction;

static inline ty_max_extinction ty_max_extinction_of(const ty_grid_medium* medium,
                                                     const ty_diffuse_surfaces* surfaces) {
    const double side = fmin(medium->cell[0], fmin(medium->cell[1], medium->cell[2]));
    return (ty_max_extinction){.box = &medium->box,
                               .surfaces = surfaces,
                               .inside = (float)(TY_MAX_THICKNESS_INSIDE / side),
                               .at_faces = (float)(TY_MAX_THICKNESS_AT_FACES / side)};
}

static inline float ty_max_extinction_at(const ty_max_extinction* max, size_t cell) {
    if (max->surfaces != NULL && max->surfaces->faces->closed[cell] != 0) return max->at_faces;
    for (int a = 0; a < 3; ++a) {
        const size_t size = (size_t)max->box->size[a], at = cell % size;
        if (at == 0 || at + 1 == size) return max->at_faces;
        cell /= size;
    }
    return max->inside;
}

#endif
