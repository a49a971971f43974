/* What lattices start from: blockers, light that surfaces reflect, light that media scatter once. */
#ifndef TY_METHOD_LPV_INJECT_H
#define TY_METHOD_LPV_INJECT_H

#include "direct/shadow/light_map.h"
#include "method/lpv/lattice.h"

/* Points of surfaces, each for some area: from depth maps that see through all layers along three axes, or from what
 * lights and the camera see. */
typedef struct ty_surfel {
    ty_vec position, normal; /* m; unit, of the front */
    float area;              /* m^2 */
    float albedo[3];
} ty_surfel;

/* All layers of the scene's surfaces within a box and half a cell around it, where links that lead out of the box are,
 * along three axes, `side` rays a cell of the box each way; areas are such that all three axes together count each
 * surface once. counter: NULL, or is added to. Errors: TY_ERROR_MEMORY. Freed with ty_free_array of *capacity. */
ty_result ty_surfels_trace(const ty_scene* scene, const ty_grid_box* box, int32_t side, ty_surfel** out, size_t* count,
                           size_t* capacity, ty_ray_counter* counter);

/* Mode links: closes links that surfaces cut, and finds the albedo around cells. Mode published: the same arrays from
 * fuzzy blockers, B in two bands in cells half a cell off, as <B | G_j>. */
ty_result ty_lattice_block(ty_lattice* lattice, ty_lpv_mode mode, const ty_surfel* surfels, size_t count);

/* Mode links, after ty_lattice_block, where there is a mesh: closes every link that a surface crosses on the straight
 * way from cell to cell, which areas alone do not where surfaces are slanted. Links near closed ones are looked at.
 * Errors: TY_ERROR_MEMORY. */
ty_result ty_lattice_cross(ty_lattice* lattice, const ty_scene* scene, ty_ray_counter* counter);

/* A light and its map. */
typedef struct ty_lpv_lamp {
    const ty_light_view* light;
    const ty_light_map* map;
} ty_lpv_lamp;

/* What band l of what is injected is multiplied by (ty_lpv_def.window). */
float ty_lpv_window(const ty_lpv_def* def, int32_t l);

/* Light that surfaces reflect, lobes about normals, extinction on the way included (TY_LPV_SCATTERING), in cells on the
 * lit side; power: W per channel is added to. medium: as fine as extinction on the way is to be found, NULL: vacuum. */
ty_result ty_lattice_inject_reflected(ty_lattice* lattice, const ty_lpv_def* def, const ty_lpv_lamp* lamp,
                                      const ty_grid_medium* medium, double power[3]);
/* Light that media scatter for the first time, by Henyey-Greenstein's bands. */
ty_result ty_lattice_inject_scattered(ty_lattice* lattice, const ty_lpv_def* def, const ty_lpv_lamp* lamp,
                                      const ty_grid_medium* medium, double power[3]);

#endif
