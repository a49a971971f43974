/* The lattice of cubic cells that carries propagated light.
 *
 * A cell stores power (W) per direction as spherical harmonics; its integral over all directions is sqrt(4 pi) times
 * the first coefficient. In one iteration all of this power either moves on to one of the 26 neighbours or is
 * scattered, absorbed or blocked. The sum over all iterations, times the length of a step, over the volume of a cell,
 * is the radiance. */
#ifndef TY_METHOD_LPV_LATTICE_LATTICE_H
#define TY_METHOD_LPV_LATTICE_LATTICE_H

#include "base/sh.k.h"
#include "direct/media/grid_medium.h"
#include "method/lpv/lattice/link_directions.h"
#include "method/lpv/lattice/reduced_media.h"

#include <tyndall/lpv.h>

/* Surfaces inside a cell that lie in front of the cell's center, one mean plane per direction that they face (+x, -x,
 * +y ...): the mean normal, then the distance from the center to the plane, in cells. A zero normal marks no surface.
 */
enum { TY_SURFACE_SIDES = 6 };
typedef struct ty_surface_depths {
    float plane[TY_SURFACE_SIDES][4];
} ty_surface_depths;

/* Light about one direction, per channel: radiance integrated over all directions, and the same times the direction of
 * travel, W m^-2. */
enum { TY_BEAM_TERMS = 4 };

/* Mean cosine of directions from a point at a squared distance, m^2, to where a cell's light is interpolated: offsets
 * across are of variance side^2 / 6 along each of two axes. */
static inline float ty_beam_cosine(float side, float distance2) {
    return distance2 / (distance2 + side * side * (1.0f / 6.0f));
}

typedef struct ty_lattice {
    ty_context* context;
    ty_grid_box box; /* size[a] cubic cells along axis a */
    float cell;      /* side of a cell, m */
    size_t cells;
    int32_t bands, terms; /* terms = bands^2 */
    /* Injected power per channel, W, x fastest. Propagation replaces it by the radiance of its part that `light` does
     * not count. */
    float* propagated_sh[3][TY_SH_TERMS];
    float* light[3][TY_SH_TERMS]; /* propagated radiance, W m^-2 sr^-1 */
    /* Uncollided radiance of lights with extent at the cells' centers, W m^-2 sr^-1; NULL: none. */
    float* uncollided[3][TY_SH_TERMS_MAX];
    float* beam[3][TY_BEAM_TERMS]; /* with uncollided: light about one direction that is not in it */
    /* 1 - b of Eq. 2 (Billeter 2012) for light that enters a cell along link k: 0 is blocked, 255 is free. In mode
     * links it is symmetric, and the transmission of links that enter from outside is that of the links that leave. */
    uint8_t* transmission[TY_LPV_LINKS];
    float* albedo[3]; /* mean albedo of the surfaces around a cell; 0: no surfaces */
    /* Index into surface_depths of the cells whose center lies behind a surface inside the cell; -1: all other cells.
     * A point in front of such a surface takes the light of the cell in front of it. NULL: no such cell. */
    int32_t* surface_depth_index;
    ty_surface_depths* surface_depths;
    size_t surface_depth_count;
    bool blocked;            /* whether any transmission is below 255 */
    bool reduces;            /* whether forward peaks count as unscattered (reduced_media.h): mode links */
    ty_grid_medium* medium;  /* on the same cells; NULL: vacuum */
    float* extinction_floor; /* 1/m, of ty_lattice_find_extinction_floor; NULL: none */
    float* border_scale[3];  /* of ty_lattice_find_border_scale, per plane of the medium; NULL: 1 */
} ty_lattice;

/* A lattice without light, blockers or medium. Errors: TY_ERROR_MEMORY. */
ty_result ty_lattice_create(ty_context* context, const ty_grid_box* box, int32_t bands, ty_lattice** out);
void ty_lattice_destroy(ty_lattice* lattice);

/* Light enters and leaves a dense medium within a transport mean free path of its border, but a cell's light counts as
 * light at its center. This finds the factor on the coefficients of dense cells beside thinner ones with which their
 * centers are as close to the border; as albedo and g stay, so does the reflectance (similarity, van de Hulst 1980).
 * Mode links. Errors: TY_ERROR_MEMORY. */
ty_result ty_lattice_find_border_scale(ty_lattice* lattice);

/* Boxes of the lattices that def asks for, from the finest cascade to the coarsest. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_lattice_place(const ty_scene* scene, const ty_lpv_def* def, ty_grid_box boxes[TY_LPV_CASCADES_MAX],
                           int32_t* count);

/* A lattice for benchmarks: light in a few cells, and optionally walls across part of the links. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_lattice_create_sample(ty_context* context, int32_t side, int32_t bands, bool blocked, ty_lattice** out);

#endif
