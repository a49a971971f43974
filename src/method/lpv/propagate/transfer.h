/* Transfer functions of the links, and the scattering operator that media apply to each band of spherical harmonics. */
#ifndef TY_METHOD_LPV_TRANSFER_H
#define TY_METHOD_LPV_TRANSFER_H

#include "method/lpv/lattice/lattice.h"

/* The 26 links and their transfer functions: G_j is the projection of the directions that are nearest to link j, where
 * angles are measured in the coordinate planes. */
typedef struct ty_lpv_transfer {
    int32_t bands, terms;
    int32_t step[TY_LPV_LINKS][3];      /* e_j, each component -1, 0 or 1 */
    float G[TY_LPV_LINKS][TY_SH_TERMS]; /* G_j, normalised so that sum over j of G_j0^2 is 1 */
    double length;                      /* mean length of a step over all directions, in cells */
    double slope;                       /* beta: sum over j of G_j0 a_j |e_j| / 3, with a_j the norm of G_j's band 1 */
    double step_variance;               /* sum over j of G_j0^2 |e_j|^2 / 3 */
    double momentum; /* kappa: sum over j of a_j^2 / 3; momentum is kept where kappa scatter_factor[1] is 1 */
} ty_lpv_transfer;

/* keeps_momentum: whether band 1 is scaled so that kappa is 1. */
void ty_lpv_transfer_make(int32_t bands, bool keeps_momentum, ty_lpv_transfer* out);

/* The medium in one cell. */
typedef struct ty_lpv_cell_medium {
    float extinction, scattering, g; /* 1/m, 1/m, mean cosine */
    float extinction_floor;          /* as in ty_lattice, 1/m; 0: none */
} ty_lpv_cell_medium;

/* The medium in a cell of a lattice. */
ty_lpv_cell_medium ty_lattice_medium_in(const ty_lattice* lattice, int32_t channel, size_t cell);

/* The scattering operator of a cell. A step lasts as long as light stays in the cell on average, which in cells deeper
 * than a mean free path is longer than the flight through the cell. */
typedef struct ty_lpv_medium_step {
    float scatter_factor[TY_LPV_BANDS_MAX];    /* of each band: what extinction leaves plus what scattering returns */
    float length;                              /* m; (sum over steps) * length / volume is radiance */
    float flux_factor[TY_LPV_BANDS_MAX];       /* scales band 1 to the flux that moves from cell to cell */
    float injected_fraction[TY_LPV_BANDS_MAX]; /* fraction of injected light that counts in its own cell (mode links) */
} ty_lpv_medium_step;
ty_lpv_medium_step ty_lpv_step_in(const ty_lpv_transfer* transfer, ty_lpv_mode mode, float cell,
                                  const ty_lpv_cell_medium* medium);

/* Mode links evaluates the operator in two parts: the medium alone, then the extinction floor near light sources. */
typedef struct ty_lpv_links_step {
    double scatter_factor, momentum_factor, length; /* of band 0, of band 1; m */
    double band2_factor;
    double injected_fraction, injected_directed; /* of band 0, of the other bands */
} ty_lpv_links_step;
ty_lpv_links_step ty_lpv_links_step_in(const ty_lpv_transfer* transfer, float cell, const ty_lpv_cell_medium* medium);
ty_lpv_medium_step ty_lpv_links_step_about(const ty_lpv_transfer* transfer, float cell, const ty_lpv_links_step* step,
                                           float extinction_floor);

#endif
