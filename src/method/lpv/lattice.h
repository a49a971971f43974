/* The lattice: light on its way in cubic cells.
 *
 * Cells hold power (W) by direction, as spherical harmonics: what a cell holds at a time, integrated over directions,
 * is sqrt(4 pi) times its first coefficient. In one step all of it goes on to the 26 cells around, or meets what is in
 * between. Sums over all steps, times the length of a step, over a cell's volume, are radiance. */
#ifndef TY_METHOD_LPV_LATTICE_H
#define TY_METHOD_LPV_LATTICE_H

#include "base/sh.k.h"
#include "direct/media/grid_medium.h"
#include "scene/light.k.h"

#include <tyndall/lpv.h>

enum { TY_LPV_LINKS = 26, TY_LPV_HALF_LINKS = 13 };

/* Surfaces within a cell that its middle is behind, by where they look (+x, -x, +y ...): mean normal, and how far in
 * front of the middle they are, in cells; normal 0: none. */
enum { TY_FRONT_SIDES = 6 };
typedef struct ty_lattice_front {
    float plane[TY_FRONT_SIDES][4];
} ty_lattice_front;

typedef struct ty_lattice {
    ty_context* context;
    ty_grid_box box; /* of size[a] cells, cubes */
    float cell;      /* side, m */
    size_t cells;
    int32_t bands, terms;         /* terms = bands^2 */
    float* flow[3][TY_SH_TERMS];  /* per channel: power that was injected; once it has been propagated, the radiance of
                                     the part of it that light leaves out; x fastest */
    float* light[3][TY_SH_TERMS]; /* radiance, W m^-2 sr^-1, once propagated */
    /* How much of the light that goes along link k into a cell passes: 0: none .. 255: all. Where what is stopped
     * comes back (mode links) it is the same both ways, and the open of links that enter from outside is that of those
     * that leave. */
    uint8_t* open[TY_LPV_LINKS];
    float* albedo[3]; /* of surfaces around a cell, mean; 0: none */
    /* Cells whose middle is behind surfaces within them: the place of their planes; -1: others. What is in front of the
     * planes has the light of another cell. NULL: there are none. */
    int32_t* fronts;
    ty_lattice_front* front;
    size_t front_count;
    bool blocked;           /* whether any link is not fully open */
    ty_grid_medium* medium; /* on these cells; NULL: vacuum */
    float* spread;          /* 1/m: what turns light around near lamps at least, ty_lattice_spread; NULL: nothing */
} ty_lattice;

/* Dark, open, without medium. Errors: TY_ERROR_MEMORY. */
ty_result ty_lattice_create(ty_context* context, const ty_grid_box* box, int32_t bands, ty_lattice** out);
void ty_lattice_destroy(ty_lattice* lattice);

/* The lattices that def asks for, from the finest to the coarsest: where they lie, in cubes. */
ty_result ty_lattice_place(const ty_scene* scene, const ty_lpv_def* def, ty_grid_box boxes[TY_LPV_CASCADES_MAX],
                           int32_t* count);

/* Two bands in thin media would let light stand as high far from a lamp as near it: they have no light that spreads,
 * r^-2. Finds the extinction that makes them do so about the lamps among the lights (point, spot), which is less where
 * other lights are as bright; mode links. Errors: TY_ERROR_MEMORY. */
ty_result ty_lattice_spread(ty_lattice* lattice, const ty_light_view* lights, int32_t count);

/* Links: where light goes in one step, and as which function of direction: of the 26 directions to neighbours, link j
 * takes those that it is the nearest to, angles being taken in the planes of the axes. */
typedef struct ty_lpv_transfer {
    int32_t bands, terms;
    int32_t step[TY_LPV_LINKS][3];          /* -1, 0 or 1 each; link k + 13 is opposite to k for k < 13 */
    float shape[TY_LPV_LINKS][TY_SH_TERMS]; /* G_j: sum over j of G_j0^2 is 1 */
    double length;                          /* of a step, mean over directions, in cells */
    double slope;    /* beta: sum over j of G_j0 a_j |e_j| / 3, a_j the length of G_j's second band */
    double spread;   /* sum over j of G_j0^2 |e_j|^2 / 3 */
    double momentum; /* kappa: sum over j of a_j^2 / 3: 1 keeps momentum where pass[1] is 1 */
} ty_lpv_transfer;

/* keeps_momentum: whether the second band is stretched so that kappa is 1. */
void ty_lpv_transfer_make(int32_t bands, bool keeps_momentum, ty_lpv_transfer* out);
/* The link along (dx, dy, dz), -1..1 each, not all 0. */
static inline int32_t ty_lpv_link(int32_t dx, int32_t dy, int32_t dz) {
    const int32_t place = (dx + 1) + 3 * (dy + 1) + 9 * (dz + 1);
    return place < TY_LPV_HALF_LINKS ? place : 3 * TY_LPV_HALF_LINKS - place;
}
/* The same the other way round. */
static inline void ty_lpv_link_step(int32_t link, int32_t step[3]) {
    const int32_t place = link < TY_LPV_HALF_LINKS ? link : 3 * TY_LPV_HALF_LINKS - link;
    step[0] = place % 3 - 1;
    step[1] = place / 3 % 3 - 1;
    step[2] = place / 9 - 1;
}

/* What media are in a cell. */
typedef struct ty_lpv_cell_medium {
    float extinction, scattering, g; /* 1/m, 1/m, mean cosine */
    float spread;                    /* as in ty_lattice; 0: none */
} ty_lpv_cell_medium;

/* What becomes of light in a cell before it goes on. A step is as long as light stays, on average: in cells that are
 * deeper than a free path longer than what it flies. */
typedef struct ty_lpv_medium_step {
    float pass[TY_LPV_BANDS_MAX];  /* of what goes on, by band: media's extinction and in-scattering */
    float length;                  /* m: sums over steps, times it, over a cell's volume, are radiance */
    float shown[TY_LPV_BANDS_MAX]; /* times these: so that the second band is the flux that does go from cell to cell */
    float seen[TY_LPV_BANDS_MAX];  /* how much of what is injected counts in its cell (mode links), by band */
} ty_lpv_medium_step;
ty_lpv_medium_step ty_lpv_step_in(const ty_lpv_transfer* transfer, ty_lpv_mode mode, float cell,
                                  const ty_lpv_cell_medium* medium);

/* The same in mode links in two steps: what a medium says, and what nearby lamps do to it. */
typedef struct ty_lpv_links_step {
    double pass, kept, length; /* kept: of the second band */
    double third;              /* of the third band */
    double seen, seen_way;     /* first band; others */
} ty_lpv_links_step;
ty_lpv_links_step ty_lpv_links_step_in(const ty_lpv_transfer* transfer, float cell, const ty_lpv_cell_medium* medium);
ty_lpv_medium_step ty_lpv_links_step_about(const ty_lpv_transfer* transfer, float cell, const ty_lpv_links_step* step,
                                           float spread);

/* The medium in a cell of a lattice. */
ty_lpv_cell_medium ty_lattice_medium_in(const ty_lattice* lattice, int32_t channel, size_t cell);

/* What became of the light, W per channel. What entered came with the flow or from the outer lattice. */
typedef struct ty_lattice_power {
    double entered[3], absorbed[3], blocked[3], escaped[3], left[3];
    int32_t iterations;
    double prepare_seconds, propagate_seconds, gather_seconds;
} ty_lattice_power;

/* Lets all that flows go on until def says that it is enough, and fills in light. seen[c]: what of the flow counts as
 * light in the cell where it was injected (mode published: reflected light alone; mode links: NULL, about half of all).
 * outer: a coarser lattice around this one that is done, whose light comes in through the faces; NULL: none. What was
 * injected within this lattice is in both: outer's counts here as far as it left and came back. progress: NULL, or told
 * of the iterations. Where waves of two bands overshoot, light is dark instead of less than that.
 * Errors: TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_lattice_propagate(ty_lattice* lattice, const ty_lpv_def* def, float* const seen[3][TY_SH_TERMS],
                               const ty_lattice* outer, ty_progress_fn progress, void* progress_user,
                               ty_lattice_power* power);

/* Multiply-adds that one cell takes in one step, all channels, no surfaces near. */
int32_t ty_lattice_step_operations(int32_t bands);
/* A lattice to measure with: light in a few cells, and surfaces through a part of the links. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_lattice_create_sample(ty_context* context, int32_t side, int32_t bands, bool blocked, ty_lattice** out);

#endif
